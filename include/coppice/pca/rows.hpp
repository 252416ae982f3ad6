// A matrix of floats, row by row.
#pragma once

#include <coppice/core/config.hpp>
#include <cstddef>
#include <span>
#include <vector>

namespace coppice {

/// Rows of equal width, one after the other: element (i, k) is values[i · width + k].
struct Rows {
  std::size_t width = 0;
  std::vector<float> values;

  Rows() = default;
  Rows(std::size_t count, std::size_t row_width) : width(row_width), values(count * row_width, 0.0f) {}

  std::size_t count() const { return width == 0 ? 0 : values.size() / width; }
  std::span<float> operator[](std::size_t i) { return std::span(values).subspan(i * width, width); }
  std::span<const float> operator[](std::size_t i) const {
    return std::span(values).subspan(i * width, width);
  }
};

}  // namespace coppice
