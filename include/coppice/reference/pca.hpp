// The slow, obvious twin of pca(): a singular value decomposition by one-sided Jacobi rotations.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <vector>

namespace coppice::reference {

/// A matrix in double, row by row.
using DoubleRows = std::vector<std::vector<double>>;

/// Singular values of a matrix, descending, and its right singular vectors in the same order.
struct SingularVectors {
  std::vector<double> values;
  DoubleRows vectors;  ///< a unit row for each value that is not 0
};

/// The mean of the rows. Precondition: at least one row.
inline std::vector<double> mean_of(const DoubleRows& rows) {
  std::vector<double> mean(rows[0].size(), 0.0);
  for (const auto& row : rows)
    for (std::size_t k = 0; k < mean.size(); ++k) mean[k] += row[k] / double(rows.size());
  return mean;
}

inline double dot(const std::vector<double>& a, const std::vector<double>& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

/// Turns two rows within their plane until they are orthogonal. Returns whether they were not, products of
/// at most `least` counting as 0.
inline bool make_orthogonal(std::vector<double>& a, std::vector<double>& b, double least) {
  const double aa = dot(a, a), bb = dot(b, b), ab = dot(a, b);
  if (std::abs(ab) <= std::max(1e-14 * std::sqrt(aa * bb), least)) return false;
  const double tau = (bb - aa) / (2 * ab);
  const double tangent = (tau < 0 ? -1 : 1) / (std::abs(tau) + std::sqrt(1 + tau * tau));
  const double cosine = 1 / std::sqrt(1 + tangent * tangent), sine = cosine * tangent;
  for (std::size_t k = 0; k < a.size(); ++k) {
    const double x = a[k], y = b[k];
    a[k] = cosine * x - sine * y;
    b[k] = sine * x + cosine * y;
  }
  return true;
}

/// The singular values and right vectors of the rows: rotations among the rows, from the left, until all are
/// orthogonal (Hestenes 1958); their lengths are the values. Error: 1e-20 of the energy. Cost: about ten
/// times rows² · columns.
inline SingularVectors singular_vectors(DoubleRows rows) {
  double energy = 0;
  for (const auto& row : rows) energy += dot(row, row);
  for (bool turned = true; turned;) {
    turned = false;
    for (std::size_t i = 0; i < rows.size(); ++i)
      for (std::size_t j = i + 1; j < rows.size(); ++j)
        turned |= make_orthogonal(rows[i], rows[j], 1e-22 * energy);
  }
  std::sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) { return dot(a, a) > dot(b, b); });
  SingularVectors result;
  for (auto& row : rows) {
    result.values.push_back(std::sqrt(dot(row, row)));
    if (!(result.values.back() > 0)) continue;
    for (double& x : row) x /= result.values.back();
    result.vectors.push_back(std::move(row));
  }
  return result;
}

}  // namespace coppice::reference
