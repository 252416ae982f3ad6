// The principal components of rows of data: a mean and an orthonormal basis.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <coppice/pca/rows.hpp>
#include <cstdint>
#include <limits>
#include <vector>

namespace coppice {

/// How the basis is found. All give the same basis, to rounding where energies are well apart.
enum class PcaSolver : std::uint8_t {
  automatic,   ///< subspace where rank is at most 1/16 of the shorter side, else gram or covariance
  gram,        ///< all eigenvectors of rows · rowsᵀ; for fewer rows than columns
  covariance,  ///< all eigenvectors of rowsᵀ · rows; for fewer columns than rows
  subspace,    ///< the leading eigenvectors of the smaller of the two, by block Krylov iteration
};

struct PcaOptions {
  bool centred = true;  ///< subtracts the mean row, as the paper does (PCA Eq. 7)
  std::size_t rank = std::numeric_limits<std::size_t>::max();  ///< at most so many vectors
  double loss =
      0;  ///< share of the energy that may be lost, in [0, 1]: the least rank that does; 0 sets none
  PcaSolver solver = PcaSolver::automatic;
  std::vector<float> weights = {};  ///< a row: it counts as so many rows, >= 0; empty: all 1
  std::uint64_t seed = 1;           ///< of the random start of PcaSolver::subspace
};

/// The space that lies nearest to rows of data. Row i is about mean + Σ_j c_ij vectors[j].
struct PcaBasis {
  std::vector<float> mean;       ///< zeros where the data was not centred
  Rows vectors;                  ///< orthonormal to 1e-6, the largest entry of each positive
  std::vector<double> energies;  ///< a vector: squared singular value, descending, of the (weighted) rows
  double total_energy = 0;       ///< sum of all squared entries, less the mean, (weighted)

  std::size_t width() const { return mean.size(); }
  std::size_t rank() const { return energies.size(); }
  /// Share of the energy of the data that the basis does not hold, in [0, 1].
  double loss() const;
};

/// The basis of `rows` (PCA Eq. 7), found in double on one thread. Directions with less than 1e-12 of the
/// energy count as rounding and are left out, so that the rank is at most the numerical one: 0 for constant
/// rows that are centred. No rows give an empty basis of the right width. The same input gives the same
/// basis. Cost: n²d + 9n³ operations for n rows of d >= n columns, and likewise for more rows than columns;
/// about n²(d + 6 rank) by PcaSolver::subspace. Throws InputError naming row and column where a value is not
/// finite. Preconditions: as many weights as rows, or none; none negative.
PcaBasis pca(const Rows& rows, const PcaOptions& options = {});

inline double PcaBasis::loss() const {
  if (!(total_energy > 0)) return 0;
  double held = 0;
  for (const double energy : energies) held += energy;
  return held < total_energy ? (total_energy - held) / total_energy : 0;
}

}  // namespace coppice

namespace coppice::inline HWY_NAMESPACE {

/// Σ a[i] b[i], always in the same order for the same width of Lanes. Error: at most (n/16 + 24) · 6e-8 of
/// Σ |a[i] b[i]|. Precondition: equal sizes.
inline float dot(std::span<const float> a, std::span<const float> b) {
  COPPICE_ASSERT(a.size() == b.size());
  constexpr std::size_t width = Lanes::width;
  Lanes sums[4] = {0.0f, 0.0f, 0.0f, 0.0f};
  std::size_t i = 0;
  for (; i + 4 * width <= a.size(); i += 4 * width)
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t at = i + k * width;
      sums[k] = mul_add(Lanes::load(&a[at]), Lanes::load(&b[at]), sums[k]);
    }
  for (; i + width <= a.size(); i += width)
    sums[0] = mul_add(Lanes::load(&a[i]), Lanes::load(&b[i]), sums[0]);
  float sum = sum_of_lanes((sums[0] + sums[1]) + (sums[2] + sums[3]));
  for (; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

/// to[i] += factor · from[i]. Precondition: equal sizes.
inline void add_scaled(float factor, std::span<const float> from, std::span<float> to) {
  COPPICE_ASSERT(from.size() == to.size());
  std::size_t i = 0;
  for (; i + Lanes::width <= to.size(); i += Lanes::width)
    mul_add(factor, Lanes::load(&from[i]), Lanes::load(&to[i])).store(&to[i]);
  for (; i < to.size(); ++i) to[i] += factor * from[i];
}

/// The coefficients of a row in the basis (PCA Eq. 8), rank() of them. Preconditions: the row has the basis'
/// width, `to` its rank.
inline void project(const PcaBasis& basis, std::span<const float> row, std::span<float> to) {
  COPPICE_ASSERT(row.size() == basis.width() && to.size() == basis.rank());
  // The difference first: x·v - mean·v loses the digits of small deviations.
  std::vector<float> deviation(row.begin(), row.end());
  add_scaled(-1, basis.mean, deviation);
  for (std::size_t j = 0; j < basis.rank(); ++j) to[j] = dot(basis.vectors[j], deviation);
}

/// The coefficients of every row, a row of rank() for each.
inline Rows project(const PcaBasis& basis, const Rows& rows) {
  Rows coefficients(rows.count(), basis.rank());
  for (std::size_t i = 0; i < rows.count(); ++i) project(basis, rows[i], coefficients[i]);
  return coefficients;
}

/// The row of these coefficients (PCA Eq. 9). Preconditions: as many coefficients as the basis' rank, or
/// fewer, the first ones; `to` has its width.
inline void reconstruct(const PcaBasis& basis, std::span<const float> coefficients, std::span<float> to) {
  COPPICE_ASSERT(coefficients.size() <= basis.rank() && to.size() == basis.width());
  std::copy(basis.mean.begin(), basis.mean.end(), to.begin());
  for (std::size_t j = 0; j < coefficients.size(); ++j) add_scaled(coefficients[j], basis.vectors[j], to);
}

/// The rows of `count` rows of coefficients; where the rank is 0 these hold nothing, hence the count.
inline Rows reconstruct(const PcaBasis& basis, const Rows& coefficients, std::size_t count) {
  COPPICE_ASSERT(coefficients.width == basis.rank());
  Rows rows(count, basis.width());
  for (std::size_t i = 0; i < count; ++i) reconstruct(basis, coefficients[i], rows[i]);
  return rows;
}

/// Entry k alone of the row of these coefficients (PCA Eq. 9). Precondition: as for reconstruct.
inline float reconstruct_entry(const PcaBasis& basis, std::span<const float> coefficients, std::size_t k) {
  COPPICE_ASSERT(coefficients.size() <= basis.rank() && k < basis.width());
  float value = basis.mean[k];
  for (std::size_t j = 0; j < coefficients.size(); ++j) value += coefficients[j] * basis.vectors[j][k];
  return value;
}

}  // namespace coppice::inline HWY_NAMESPACE
