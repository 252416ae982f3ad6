// Principal components by Eigen's self-adjoint solver. All that needs Eigen is in this file.
//
// Eigen's functions are inline and differ by instruction set and alignment. A host that has Eigen too, built
// for another processor, would share them and crash; so ours have a namespace of their own.
#define Eigen coppice_own_eigen
#include <Eigen/Dense>
//
#include <algorithm>
#include <cmath>
#include <coppice/core/error.hpp>
#include <coppice/core/random.hpp>
#include <coppice/pca/basis.hpp>
#include <coppice/pca/interval_pca.hpp>
#include <limits>
#include <string>

namespace coppice {
namespace {

using Index = Eigen::Index;
using Matrix = Eigen::MatrixXd;
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Vector = Eigen::VectorXd;

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr double least_share = 1e-12;  // of the energy: below are rounding errors

/// Eigenpairs of a symmetric matrix, values descending, a column for each vector.
struct EigenPairs {
  Vector values;
  Matrix vectors;
};

std::string place(const Rows& rows, std::size_t entry) {
  return "row " + std::to_string(entry / rows.width) + ", column " + std::to_string(entry % rows.width);
}

void require_finite(const Rows& rows) {
  for (std::size_t i = 0; i < rows.values.size(); ++i)
    if (!std::isfinite(rows.values[i]))
      throw InputError(place(rows, i), "the value is not finite", "leave such rows out of the data");
}

double weight_of(const PcaOptions& options, std::size_t row) {
  return options.weights.empty() ? 1 : double(options.weights[row]);
}

/// The mean row, rounded to float: deviations from what is stored, not from what was meant.
std::vector<float> mean_row(const Rows& rows, const PcaOptions& options) {
  std::vector<double> sums(rows.width, 0.0);
  double weight = 0;
  for (std::size_t i = 0; i < rows.count(); ++i) {
    weight += weight_of(options, i);
    for (std::size_t k = 0; k < rows.width; ++k) sums[k] += weight_of(options, i) * double(rows[i][k]);
  }
  std::vector<float> mean(rows.width, 0.0f);
  if (options.centred && weight > 0)
    for (std::size_t k = 0; k < rows.width; ++k) mean[k] = float(sums[k] / weight);
  return mean;
}

/// Rows less the mean, each times the root of its weight.
RowMatrix deviations(const Rows& rows, const std::vector<float>& mean, const PcaOptions& options) {
  RowMatrix result(Index(rows.count()), Index(rows.width));
  for (std::size_t i = 0; i < rows.count(); ++i) {
    const double scale = std::sqrt(weight_of(options, i));
    for (std::size_t k = 0; k < rows.width; ++k)
      result(Index(i), Index(k)) = scale * (double(rows[i][k]) - double(mean[k]));
  }
  return result;
}

EigenPairs all_pairs(const Matrix& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(symmetric);
  return {solver.eigenvalues().reverse(), solver.eigenvectors().rowwise().reverse()};
}

/// Columns of an orthonormal basis of the same space, in the same order.
Matrix orthonormal(const Matrix& columns) {
  const Eigen::HouseholderQR<Matrix> solver(columns);
  return solver.householderQ() * Matrix::Identity(columns.rows(), columns.cols());
}

Matrix random_columns(Index rows, Index columns, std::uint64_t seed) {
  Random random(seed);
  return Matrix::NullaryExpr(rows, columns, [&] { return 2 * double(random.uniform()) - 1; });
}

/// Largest distance of matrix · vector from value · vector over the first `count` pairs.
double residual(const Matrix& product, const EigenPairs& pairs, Index count) {
  const Matrix apart =
      product.leftCols(count) - pairs.vectors.leftCols(count) * pairs.values.head(count).asDiagonal();
  return apart.colwise().norm().maxCoeff();
}

/// The leading eigenpairs by block Krylov iteration with full orthonormalisation (Musco and Musco, NIPS
/// 2015): the space grows by a block at a time until the pairs are right to 1e-7 of the largest value.
EigenPairs leading_pairs(const Matrix& symmetric, Index count, std::uint64_t seed) {
  const Index size = symmetric.rows(), block = std::min(size, std::max<Index>(8, (count + 5) / 3));
  Matrix space(size, 0), product(size, 0), next = random_columns(size, block, seed);
  for (Index wanted = 2 * count + block; 2 * wanted <= size; wanted += count) {
    while (space.cols() < wanted) {
      for (int pass = 0; pass < 2; ++pass) {
        next -= space * (space.transpose() * next);
        next = orthonormal(next);
      }
      const Matrix image = symmetric * next;
      space.conservativeResize(Eigen::NoChange, space.cols() + block);
      product.conservativeResize(Eigen::NoChange, product.cols() + block);
      space.rightCols(block) = next;
      product.rightCols(block) = image;
      next = image;
    }
    EigenPairs pairs = all_pairs(space.transpose() * product);
    const Matrix turn = pairs.vectors;
    pairs.vectors = space * turn;
    if (residual(product * turn.leftCols(count), pairs, count) <= 1e-7 * pairs.values[0]) return pairs;
  }
  return all_pairs(symmetric);
}

/// The rank of options, from energies in descending order.
Index chosen_rank(const Vector& energies, double total, std::size_t most, double loss) {
  Index rank = 0;
  double held = 0;
  while (rank < energies.size() && std::size_t(rank) < most && energies[rank] > least_share * total &&
         !(loss > 0 && total - held <= loss * total))
    held += energies[rank++];
  return rank;
}

/// -1 for columns whose entry of the largest magnitude is negative, else 1.
Vector signs(const Matrix& columns) {
  Vector result = Vector::Ones(columns.cols());
  for (Index j = 0; j < columns.cols(); ++j) {
    Index largest = 0;
    columns.col(j).cwiseAbs().maxCoeff(&largest);
    if (columns(largest, j) < 0) result[j] = -1;
  }
  return result;
}

PcaSolver chosen_solver(const PcaOptions& options, Index rows, Index columns) {
  if (options.solver != PcaSolver::automatic) return options.solver;
  const std::size_t size = std::size_t(std::min(rows, columns));
  if (options.rank <= size / 16) return PcaSolver::subspace;  // measured: docs/pca.md
  return rows <= columns ? PcaSolver::gram : PcaSolver::covariance;
}

/// Energies and directions (columns) of the rows, all that the options may need.
EigenPairs directions(const RowMatrix& rows, const PcaOptions& options) {
  const PcaSolver solver = chosen_solver(options, rows.rows(), rows.cols());
  const bool by_rows =
      solver == PcaSolver::gram || (solver == PcaSolver::subspace && rows.rows() <= rows.cols());
  Matrix symmetric = Matrix::Zero(by_rows ? rows.rows() : rows.cols(), by_rows ? rows.rows() : rows.cols());
  if (by_rows)
    symmetric.selfadjointView<Eigen::Lower>().rankUpdate(rows);
  else
    symmetric.selfadjointView<Eigen::Lower>().rankUpdate(rows.transpose());
  symmetric.triangularView<Eigen::StrictlyUpper>() = symmetric.transpose();
  const Index most = Index(std::min(options.rank, std::size_t(symmetric.rows())));
  EigenPairs pairs = solver == PcaSolver::subspace && most > 0 ? leading_pairs(symmetric, most, options.seed)
                                                               : all_pairs(symmetric);
  const Index rank = chosen_rank(pairs.values, rows.squaredNorm(), options.rank, options.loss);
  pairs.values.conservativeResize(rank);
  pairs.vectors.conservativeResize(Eigen::NoChange, rank);
  if (by_rows) pairs.vectors = rows.transpose() * pairs.vectors;
  return pairs;
}

/// Writes orthonormal columns and their energies.
void store(const EigenPairs& pairs, PcaBasis& basis) {
  basis.energies.assign(pairs.values.begin(), pairs.values.end());
  basis.vectors = Rows(basis.energies.size(), basis.mean.size());
  for (std::size_t j = 0; j < basis.rank(); ++j)
    for (std::size_t k = 0; k < basis.mean.size(); ++k)
      basis.vectors[j][k] = float(pairs.vectors(Index(k), Index(j)));
}

void require_intervals(const Rows& low, const Rows& high) {
  for (std::size_t i = 0; i < low.values.size(); ++i)
    if (!(low.values[i] <= high.values[i]) || low.values[i] == infinity || high.values[i] == -infinity)
      throw InputError(place(low, i), "the interval holds no number", "give ends in ascending order");
}

/// The finite end of each interval, the lower first; 0 where there is none.
Rows finite_ends(const Rows& low, const Rows& high) {
  Rows result = low;
  for (std::size_t i = 0; i < low.values.size(); ++i)
    if (!std::isfinite(low.values[i])) result.values[i] = std::isfinite(high.values[i]) ? high.values[i] : 0;
  return result;
}

/// The state of interval_pca: rows, which change from the reconstruction to what it is clamped to and back.
struct IntervalFit {
  RowMatrix rows;
  Vector mean;
  EigenPairs pairs;  ///< orthonormal columns
  RowMatrix coefficients;
  double total_energy = 0;
};

IntervalFit first_fit(const Rows& rows, const PcaOptions& options) {
  const PcaBasis basis = pca(rows, options);
  IntervalFit fit;
  fit.mean = Eigen::Map<const Eigen::VectorXf>(basis.mean.data(), Index(basis.width())).cast<double>();
  fit.pairs.values = Eigen::Map<const Vector>(basis.energies.data(), Index(basis.rank()));
  fit.pairs.vectors = Eigen::Map<const Eigen::MatrixXf>(basis.vectors.values.data(), Index(basis.width()),
                                                        Index(basis.rank()))
                          .cast<double>();
  fit.total_energy = basis.total_energy;
  const RowMatrix data = deviations(rows, basis.mean, options);
  fit.coefficients = data * fit.pairs.vectors;
  fit.rows = (fit.coefficients * fit.pairs.vectors.transpose()).rowwise() + fit.mean.transpose();
  return fit;
}

double clamped(double x, float low, float high) { return std::min(std::max(x, double(low)), double(high)); }

double violation(const RowMatrix& rows, const Rows& low, const Rows& high) {
  double sum = 0;
  for (std::size_t i = 0; i < low.values.size(); ++i) {
    const double x = rows.data()[i], apart = x - clamped(x, low.values[i], high.values[i]);
    sum += apart * apart;
  }
  return sum;
}

void clamp(RowMatrix& rows, const Rows& low, const Rows& high) {
  for (std::size_t i = 0; i < low.values.size(); ++i)
    rows.data()[i] = clamped(rows.data()[i], low.values[i], high.values[i]);
}

/// The best basis of the rows (less their mean) within the span of the last one and its block power step.
/// That span holds the last basis, hence no fit is worse than the last.
EigenPairs improved(const RowMatrix& rows, const Matrix& last) {
  const Index rank = last.cols();
  if (rank == 0) return {Vector(0), last};
  Matrix span(last.rows(), std::min(last.rows(), 2 * rank));
  const Matrix step = rows.transpose() * (rows * last);
  span << last, step.leftCols(span.cols() - rank);
  span = orthonormal(span);
  const Matrix image = rows * span;
  const EigenPairs turn = all_pairs(image.transpose() * image);
  return {turn.values.head(rank), span * turn.vectors.leftCols(rank)};
}

/// Fits a basis to the rows and turns them into their reconstruction.
void refit(IntervalFit& fit, const PcaOptions& options) {
  if (options.centred) fit.mean = fit.rows.colwise().mean();
  fit.rows.rowwise() -= fit.mean.transpose();
  fit.total_energy = fit.rows.squaredNorm();
  const std::size_t most = std::size_t(std::min(fit.rows.rows(), fit.rows.cols()));
  if (std::size_t(fit.pairs.values.size()) == std::min(options.rank, most)) {
    fit.pairs = improved(fit.rows, fit.pairs.vectors);
  } else {  // The rows before had too low a rank.
    fit.pairs = directions(fit.rows, options);
    if (fit.pairs.values.size() > 0) fit.pairs.vectors = orthonormal(fit.pairs.vectors);
  }
  fit.coefficients = fit.rows * fit.pairs.vectors;
  fit.rows.noalias() = fit.coefficients * fit.pairs.vectors.transpose();
  fit.rows.rowwise() += fit.mean.transpose();
}

void store(IntervalFit fit, IntervalPca& result) {
  const Vector sign = signs(fit.pairs.vectors);
  fit.pairs.vectors *= sign.asDiagonal();
  fit.coefficients *= sign.asDiagonal();
  const Eigen::VectorXf mean = fit.mean.cast<float>();
  result.basis.mean.assign(mean.begin(), mean.end());
  result.basis.total_energy = fit.total_energy;
  store(fit.pairs, result.basis);
  result.coefficients = Rows(std::size_t(fit.coefficients.rows()), result.basis.rank());
  for (std::size_t i = 0; i < result.coefficients.values.size(); ++i)
    result.coefficients.values[i] = float(fit.coefficients.data()[i]);
}

}  // namespace

PcaBasis pca(const Rows& rows, const PcaOptions& options) {
  COPPICE_ASSERT(options.weights.empty() || options.weights.size() == rows.count());
  COPPICE_ASSERT(options.loss >= 0 && options.loss <= 1);
  require_finite(rows);
  PcaBasis basis;
  basis.mean = mean_row(rows, options);
  basis.vectors = Rows(0, rows.width);
  const RowMatrix data = deviations(rows, basis.mean, options);
  basis.total_energy = data.squaredNorm();
  if (!(basis.total_energy > 0)) return basis;
  EigenPairs pairs = directions(data, options);
  if (pairs.values.size() > 0) pairs.vectors = orthonormal(pairs.vectors);
  pairs.vectors *= signs(pairs.vectors).asDiagonal();
  store(pairs, basis);
  return basis;
}

IntervalPca interval_pca(const Rows& low, const Rows& high, const IntervalPcaOptions& options,
                         const Rows& start) {
  COPPICE_ASSERT(low.width == high.width && low.values.size() == high.values.size());
  COPPICE_ASSERT(start.values.empty() || start.values.size() == low.values.size());
  COPPICE_ASSERT(options.rounds >= 0);
  require_intervals(low, high);
  const PcaOptions first{options.centred, options.rank, 0, PcaSolver::automatic, {}, options.seed};
  const Rows rows = start.values.empty() ? finite_ends(low, high) : start;
  IntervalFit fit = first_fit(rows, first);
  IntervalPca result;
  result.violations.push_back(violation(fit.rows, low, high));
  for (int round = 0; round < options.rounds && result.violations.back() > 0; ++round) {
    clamp(fit.rows, low, high);
    refit(fit, first);
    result.violations.push_back(violation(fit.rows, low, high));
  }
  store(std::move(fit), result);
  return result;
}

}  // namespace coppice
