// A short text that tells whether data are the same as last time.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>

namespace coppice {

/// 128 bits over all that was added, in order and with its lengths: equal data give equal texts on every
/// machine of the same byte order, and others differ but for chance (2^-64 for a million scenes). Against
/// mistakes, not against forgers. Two multiplications for 8 bytes: several GB/s.
class Fingerprint {
 public:
  Fingerprint& add(std::span<const std::byte> bytes) {
    for (; bytes.size() >= 8; bytes = bytes.subspan(8)) mix(word(bytes.first(8)));
    mix(word(bytes));
    mix(length_ += bytes.size() + 1);
    return *this;
  }

  /// The bytes of plain values. Precondition: T has no padding, whose bytes are left to chance.
  template <class T>
  Fingerprint& add_values(std::span<const T> values) {
    static_assert(std::is_trivially_copyable_v<T>);
    mix(values.size());
    return add(std::as_bytes(values));
  }

  /// 32 hexadecimal digits.
  std::string text() const {
    constexpr const char* digits = "0123456789abcdef";
    std::string result;
    for (const std::uint64_t lane : {finish(lanes_[0] ^ std::rotl(lanes_[1], 32)), finish(lanes_[1])})
      for (int shift = 60; shift >= 0; shift -= 4) result += digits[lane >> shift & 15];
    return result;
  }

 private:
  static std::uint64_t word(std::span<const std::byte> bytes) {
    std::uint64_t value = 0;
    if (!bytes.empty()) std::memcpy(&value, bytes.data(), bytes.size());
    return value;
  }

  void mix(std::uint64_t value) {
    lanes_[0] = std::rotl((lanes_[0] ^ value) * 0x9e3779b97f4a7c15u, 29);
    lanes_[1] = std::rotl((lanes_[1] + value) * 0xd6e8feb86659fd93u, 37) ^ lanes_[0];
  }

  /// The finaliser of SplitMix64.
  static std::uint64_t finish(std::uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
  }

  std::array<std::uint64_t, 2> lanes_{0x243f6a8885a308d3u, 0x13198a2e03707344u};
  std::uint64_t length_ = 0;
};

}  // namespace coppice
