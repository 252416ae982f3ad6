// Rows that the tests of pca/ share, and what they ask of a basis.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <algorithm>
#include <cmath>
#include <coppice/core/random.hpp>
#include <coppice/pca/basis.hpp>
#include <coppice/reference/pca.hpp>

namespace test_support {

/// Independent entries in [-1, 1) · scale.
inline coppice::Rows random_rows(coppice::Random& random, std::size_t count, std::size_t width,
                                 float scale = 1) {
  coppice::Rows rows(count, width);
  for (float& x : rows.values) x = scale * (2 * random.uniform() - 1);
  return rows;
}

/// Rows of `rank` directions, each `decay` times as strong as the one before, not centred at 0.
inline coppice::Rows rows_of_rank(coppice::Random& random, std::size_t count, std::size_t width,
                                  std::size_t rank, float decay = 0.7f) {
  const coppice::Rows left = random_rows(random, count, rank), right = random_rows(random, rank, width);
  coppice::Rows rows(count, width);
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t k = 0; k < width; ++k) {
      double sum = 0;
      for (std::size_t j = 0; j < rank; ++j)
        sum += std::pow(double(decay), double(j)) * double(left[i][j] + 0.3f) * double(right[j][k]);
      rows[i][k] = float(sum);
    }
  return rows;
}

inline coppice::reference::DoubleRows in_double(const coppice::Rows& rows) {
  coppice::reference::DoubleRows result;
  for (std::size_t i = 0; i < rows.count(); ++i) result.emplace_back(rows[i].begin(), rows[i].end());
  return result;
}

/// The rows less their mean.
inline coppice::reference::DoubleRows centred(const coppice::Rows& rows) {
  auto result = in_double(rows);
  const std::vector<double> mean = coppice::reference::mean_of(result);
  for (auto& row : result)
    for (std::size_t k = 0; k < mean.size(); ++k) row[k] -= mean[k];
  return result;
}

/// The largest |vᵢ·vⱼ - δᵢⱼ|.
inline double orthonormality_error(const coppice::Rows& vectors) {
  const auto rows = in_double(vectors);
  double worst = 0;
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t j = 0; j <= i; ++j)
      worst = std::max(worst, std::abs(coppice::reference::dot(rows[i], rows[j]) - (i == j ? 1.0 : 0.0)));
  return worst;
}

/// Σ squared differences of the rows and their reconstructions.
inline double squared_error(const coppice::Rows& a, const coppice::Rows& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.values.size(); ++i)
    sum += (double(a.values[i]) - double(b.values[i])) * (double(a.values[i]) - double(b.values[i]));
  return sum;
}

}  // namespace test_support
