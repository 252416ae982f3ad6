// A matrix as the product of a tall and a wide one.
#pragma once

#include <coppice/pca/basis.hpp>
#include <utility>

namespace coppice {

/// Row i of a matrix is about Σ_j left[i][j] right[j].
struct LowRank {
  Rows left;        ///< a row for each row of the matrix, `rank` wide
  Rows right;       ///< `rank` orthonormal rows
  double loss = 0;  ///< share of the (weighted) squared entries that is lost, in [0, 1]

  std::size_t rank() const { return left.width; }
};

}  // namespace coppice

namespace coppice::inline HWY_NAMESPACE {

/// The product nearest to a matrix by the sum of squares of the difference (Eckart and Young 1936), each
/// row's times its weight. Rank, loss, solver and weights are those of `options`, which is taken as
/// uncentred. Bytes: rank · (rows + columns) floats in place of rows · columns. Cost and errors: as pca().
/// Throws InputError where a value is not finite.
inline LowRank low_rank(const Rows& matrix, PcaOptions options) {
  options.centred = false;
  PcaBasis basis = pca(matrix, options);
  const double loss = basis.loss();
  Rows left = project(basis, matrix);
  return {std::move(left), std::move(basis.vectors), loss};
}

/// Row i of the product. Precondition: `to` is as wide as the matrix was.
inline void reconstruct(const LowRank& product, std::size_t i, std::span<float> to) {
  std::fill(to.begin(), to.end(), 0.0f);
  for (std::size_t j = 0; j < product.rank(); ++j) add_scaled(product.left[i][j], product.right[j], to);
}

}  // namespace coppice::inline HWY_NAMESPACE
