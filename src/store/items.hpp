// Counts, lists and rows: what the contents of all kinds of store are encoded to, and decoded from.
#pragma once

#include <algorithm>
#include <cmath>
#include <coppice/core/math.hpp>
#include <coppice/store/settings.hpp>
#include <coppice/tree/light_tree.hpp>

#include "hdf5_file.hpp"
#include "refusal.hpp"

namespace coppice::store {

inline constexpr std::size_t block_of_elements = 16384;  ///< of arrays that are no receivers'

class Encoder {
 public:
  void count(const char* name, std::uint64_t value) { contents.counts.push_back({name, value}); }

  template <class T>
  Array& list(const char* name, const std::vector<T>& values, std::size_t block_rows = block_of_elements) {
    contents.arrays.push_back(array_of(name, {values.size()}, block_rows, std::span<const T>(values)));
    return contents.arrays.back();
  }

  /// Vectors as rows.
  template <glm::length_t n, class T>
  void rows(const char* name, const std::vector<glm::vec<n, T>>& values,
            std::size_t block_rows = block_of_elements) {
    const T* first = values.empty() ? nullptr : &values[0].x;
    contents.arrays.push_back(
        array_of(name, {values.size(), n}, block_rows, std::span<const T>(first, n * values.size())));
  }

  /// Rows that lie one after the other; about block_of_elements in a block.
  template <class T>
  void table(const char* name, std::size_t count, std::size_t width, const std::vector<T>& values) {
    const std::size_t block = std::max<std::size_t>(1, block_of_elements / std::max<std::size_t>(1, width));
    contents.arrays.push_back(array_of(name, {count, width}, block, std::span<const T>(values)));
  }

  Contents contents;
};

template <class T, class Range, class Member>
std::vector<T> gather(const Range& range, Member&& member) {
  std::vector<T> values;
  values.reserve(range.size());
  for (const auto& element : range) values.push_back(member(element));
  return values;
}

inline void add_settings(Encoder& e, const Settings& settings) {
  std::vector<std::uint8_t> text;
  const auto add = [&](const std::string& part) {
    if (part.find('\0') != std::string::npos)
      throw Refusal("cannot hold a setting with a NUL in it", "leave it out of keys and values");
    text.insert(text.end(), part.begin(), part.end());
    text.push_back(0);
  };
  for (const Setting& setting : settings) add(setting.key), add(setting.value);
  e.count("setting_bytes", text.size());
  e.list("settings", text);
}

inline bool all_finite(std::span<const float> values) {
  return std::ranges::all_of(values, [](float v) { return std::isfinite(v); });
}

/// Of what is to be written.
inline void require_finite(const Array& array) {
  if (array.element != Element::f32) return;
  std::vector<float> values(array.data.size() / sizeof(float));
  if (!values.empty()) std::memcpy(values.data(), array.data.data(), array.data.size());
  if (!all_finite(values))
    throw Refusal("cannot be written: " + array.name + " has values that are not finite", "leave them out");
}

inline void require(bool condition, const std::string& problem) {
  if (!condition) throw Refusal(problem);
}

/// Of what was read.
inline void require_finite(const char* name, std::span<const float> values) {
  require(all_finite(values), "dataset " + std::string(name) + " has values that are not finite");
}

/// A count that must fit into 32 bits, as all indices do.
inline std::uint32_t small_count(const Hdf5Reader& reader, const char* name) {
  const std::uint64_t count = reader.count(name);
  if (count >= no_light)
    throw Refusal("attribute " + std::string(name) + " is " + std::to_string(count) + ": too many");
  return std::uint32_t(count);
}

template <class T>
std::vector<T> list(Hdf5Reader& reader, const char* name, std::uint64_t rows) {
  auto values = reader.array<T>(name, {rows});
  if constexpr (std::is_same_v<T, float>) require_finite(name, values);
  return values;
}

/// Rows as vectors.
template <glm::length_t n, class T>
std::vector<glm::vec<n, T>> rows(Hdf5Reader& reader, const char* name, std::uint64_t count) {
  const auto values = reader.array<T>(name, {count, n});
  if constexpr (std::is_same_v<T, float>) require_finite(name, values);
  std::vector<glm::vec<n, T>> vectors(count);
  if (count > 0) std::memcpy(&vectors[0].x, values.data(), values.size() * sizeof(T));
  return vectors;
}

/// Rows that lie one after the other.
template <class T>
std::vector<T> table(Hdf5Reader& reader, const char* name, std::uint64_t count, std::uint64_t width) {
  auto values = reader.array<T>(name, {count, width});
  if constexpr (std::is_same_v<T, float>) require_finite(name, values);
  return values;
}

}  // namespace coppice::store
