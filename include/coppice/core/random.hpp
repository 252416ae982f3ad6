// Random numbers that do not depend on the standard library's distributions or on the order of threads.
#pragma once

#include <coppice/core/math.hpp>
#include <cstdint>

namespace coppice {

/// SplitMix64 (Steele et al., OOPSLA 2014): the same sequence for the same seed everywhere.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t bits() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  /// Uniform in [0, 1).
  float uniform() { return float(bits() >> 40) * 0x1p-24f; }
  /// Uniform in [0, count). Precondition: count > 0.
  std::uint32_t below(std::uint32_t count) { return std::uint32_t(((bits() >> 32) * count) >> 32); }
  /// Uniform on the unit sphere.
  vec3 direction() {
    const float z = 1 - 2 * uniform(), phi = 2 * pi * uniform(), r = std::sqrt(std::fmax(0.0f, 1 - z * z));
    return {r * std::cos(phi), r * std::sin(phi), z};
  }

 private:
  std::uint64_t state_;
};

}  // namespace coppice
