// A matrix of yes and no, how its columns mix features, and how it is to be fitted.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace coppice {

/// Entries of +1 (yes), -1 (no) and 0 (anything is right), row by row, rows padded with zeros.
struct DecisionMatrix {
  static constexpr std::size_t tile = 512;  ///< entries that a row is padded to a multiple of

  std::size_t rows = 0, columns = 0, stride = 0;
  std::vector<std::int8_t> values;  ///< (i, t) at i · stride + t

  DecisionMatrix() = default;
  DecisionMatrix(std::size_t row_count, std::size_t column_count)
      : rows(row_count),
        columns(column_count),
        stride((column_count + tile - 1) / tile * tile),
        values(rows * stride, 0) {}
  std::int8_t* row(std::size_t i) { return values.data() + i * stride; }
  const std::int8_t* row(std::size_t i) const { return values.data() + i * stride; }
};

/// A column's features are a weighted sum of up to eight feature rows.
struct FeatureMix {
  std::array<std::uint32_t, 8> rows{};
  std::array<float, 8> weights{};
  std::uint32_t count = 0;
};

/// How a product is fitted to a matrix of decisions.
struct DecisionOptions {
  std::size_t rank = 40;  ///< components beyond what the matrix can have are zero
  std::size_t rounds = 8;
  /// How far a product may go beyond ±1 on its own side without loss: 1 fits ±1 itself (a plain low-rank
  /// factorisation); infinity leaves it free.
  float cap = std::numeric_limits<float>::infinity();
  /// The factor on each round's step; below 2.
  float relaxation = 1.9f;
  std::uint64_t seed = 1;
};

}  // namespace coppice
