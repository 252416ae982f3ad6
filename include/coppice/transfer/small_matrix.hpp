// Small symmetric matrices in double: what least squares over a few components needs.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace coppice::detail {

/// A small square matrix of doubles, row by row.
struct SmallMatrix {
  std::size_t size = 0;
  std::vector<double> values;
  explicit SmallMatrix(std::size_t n) : size(n), values(n * n, 0.0) {}
  double& operator()(std::size_t i, std::size_t k) { return values[i * size + k]; }
  double operator()(std::size_t i, std::size_t k) const { return values[i * size + k]; }
};

/// AᵀA + ridge · mean of the diagonal on it, of a component-major matrix: component k at k · stride.
inline SmallMatrix gram_of(const float* columns, std::size_t stride, std::size_t count, std::size_t rank,
                           double ridge) {
  SmallMatrix gram(rank);
  double trace = 0;
  for (std::size_t i = 0; i < rank; ++i)
    for (std::size_t k = 0; k <= i; ++k) {
      double sum = 0;
      for (std::size_t begin = 0; begin < count; begin += 512) {
        float part = 0;
        for (std::size_t t = begin; t < std::min(begin + 512, count); ++t)
          part += columns[i * stride + t] * columns[k * stride + t];
        sum += double(part);
      }
      gram(i, k) = gram(k, i) = sum;
      if (i == k) trace += sum;
    }
  for (std::size_t i = 0; i < rank; ++i) gram(i, i) += ridge * trace / double(rank) + 1e-30;
  return gram;
}

/// The lower Cholesky factor in place. Precondition: positive definite; tiny pivots are raised.
inline void cholesky(SmallMatrix& a) {
  for (std::size_t i = 0; i < a.size; ++i)
    for (std::size_t k = 0; k <= i; ++k) {
      double sum = a(i, k);
      for (std::size_t m = 0; m < k; ++m) sum -= a(i, m) * a(k, m);
      a(i, k) = i == k ? std::sqrt(std::max(sum, 1e-30)) : sum / a(k, k);
    }
}

/// x ← (L Lᵀ)⁻¹ x.
inline void solve(const SmallMatrix& lower, double* x) {
  for (std::size_t i = 0; i < lower.size; ++i) {
    for (std::size_t k = 0; k < i; ++k) x[i] -= lower(i, k) * x[k];
    x[i] /= lower(i, i);
  }
  for (std::size_t i = lower.size; i-- > 0;) {
    for (std::size_t k = i + 1; k < lower.size; ++k) x[i] -= lower(k, i) * x[k];
    x[i] /= lower(i, i);
  }
}

/// Eigenvectors of a symmetric matrix as columns, the largest eigenvalue first (cyclic Jacobi).
inline SmallMatrix eigenvectors(SmallMatrix a) {
  const std::size_t n = a.size;
  SmallMatrix v(n);
  for (std::size_t i = 0; i < n; ++i) v(i, i) = 1;
  for (int sweep = 0; sweep < 12; ++sweep)
    for (std::size_t p = 0; p < n; ++p)
      for (std::size_t q = p + 1; q < n; ++q) {
        if (std::abs(a(p, q)) <= 1e-15 * std::sqrt(std::abs(a(p, p) * a(q, q)))) continue;
        const double theta = (a(q, q) - a(p, p)) / (2 * a(p, q));
        const double t = (theta < 0 ? -1 : 1) / (std::abs(theta) + std::sqrt(theta * theta + 1));
        const double c = 1 / std::sqrt(t * t + 1), s = t * c;
        const auto turn = [c, s](double& x, double& y) {
          const double old = x;
          x = c * old - s * y, y = s * old + c * y;
        };
        for (std::size_t k = 0; k < n; ++k) turn(a(k, p), a(k, q));
        for (std::size_t k = 0; k < n; ++k) turn(a(p, k), a(q, k));
        for (std::size_t k = 0; k < n; ++k) turn(v(k, p), v(k, q));
      }
  std::vector<std::size_t> order(n);
  for (std::size_t i = 0; i < n; ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t i, std::size_t k) { return a(i, i) > a(k, k); });
  SmallMatrix sorted(n);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 0; k < n; ++k) sorted(i, k) = v(i, order[k]);
  return sorted;
}

/// Applies `change(row of doubles)` to each of `count` rows; (row t, component k) is at k · across + t ·
/// along.
template <class Change>
void change_rows(float* values, std::size_t across, std::size_t along, std::size_t count, std::size_t rank,
                 Change&& change) {
  std::vector<double> row(rank);
  for (std::size_t t = 0; t < count; ++t) {
    for (std::size_t k = 0; k < rank; ++k) row[k] = double(values[k * across + t * along]);
    change(row.data());
    for (std::size_t k = 0; k < rank; ++k) values[k * across + t * along] = float(row[k]);
  }
}

}  // namespace coppice::detail
