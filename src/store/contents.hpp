// A store between its meaning and its bytes: named numbers and named arrays.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace coppice::store {

using Bytes = std::vector<std::byte>;

enum class Element { u8, u16, u32, f32, i8, i16 };

inline std::size_t size_of(Element element) {
  switch (element) {
    case Element::u8:
    case Element::i8:
      return 1;
    case Element::u16:
    case Element::i16:
      return 2;
    case Element::u32:
    case Element::f32:
      break;
  }
  return 4;
}

template <class T>
inline constexpr Element element_of = std::is_same_v<T, std::uint8_t>    ? Element::u8
                                      : std::is_same_v<T, std::uint16_t> ? Element::u16
                                      : std::is_same_v<T, std::uint32_t> ? Element::u32
                                      : std::is_same_v<T, std::int8_t>   ? Element::i8
                                      : std::is_same_v<T, std::int16_t>  ? Element::i16
                                                                         : Element::f32;

struct Count {
  std::string name;
  std::uint64_t value = 0;
};

struct Array {
  std::string name;  ///< "group/name", or "name"
  Element element = Element::u8;
  std::vector<std::uint64_t> extents;  ///< one or two
  std::size_t block_rows = 1;          ///< rows that are compressed together
  bool shuffled = true;                ///< before: the first bytes of all elements, then the second ones
  Bytes data;                          ///< row by row
};

struct Contents {
  std::vector<Count> counts;
  std::vector<Array> arrays;
};

inline std::uint64_t element_count(std::span<const std::uint64_t> extents) {
  std::uint64_t product = 1;
  for (const std::uint64_t extent : extents) product *= extent;
  return product;
}

template <class T>
Array array_of(std::string name, std::vector<std::uint64_t> extents, std::size_t block_rows,
               std::span<const T> values) {
  static_assert(std::is_arithmetic_v<T>);
  Array array{std::move(name), element_of<T>, std::move(extents),
              block_rows,      true,          Bytes(values.size_bytes())};
  if (!values.empty()) std::memcpy(array.data.data(), values.data(), values.size_bytes());
  return array;
}

}  // namespace coppice::store
