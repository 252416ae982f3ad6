// A matrix of yes and no as a product of two thin ones whose sign decides.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <algorithm>
#include <array>
#include <cmath>
#include <coppice/core/config.hpp>
#include <coppice/core/random.hpp>
#include <coppice/pca/rows.hpp>
#include <coppice/transfer/decision_matrix.hpp>
#include <coppice/transfer/integer_lanes.hpp>
#include <coppice/transfer/small_matrix.hpp>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace coppice {

/// Entry (i, t) ≈ dot(left[i], Σ weights · features[row]) over column t's mix.
struct DecisionFactors {
  Rows left;        ///< rows × rank; columns orthogonal, the longest first
  Rows features;    ///< feature rows × rank
  double loss = 0;  ///< mean squared distance of the counted entries from where they may be, last round
};

}  // namespace coppice

namespace coppice::detail::inline HWY_NAMESPACE {

/// Alternating least squares on the residual of a decision matrix. Component-major: the samples'
/// matrix (rank × rows) and the columns' features (rank × stride); row by row: the feature rows.
class DecisionFit {
 public:
  DecisionFit(const DecisionMatrix& matrix, std::span<const FeatureMix> mixes, std::size_t feature_rows,
              const DecisionOptions& options)
      : matrix_(matrix),
        mixes_(mixes),
        options_(options),
        rank_(std::min({options.rank, matrix.rows, matrix.columns, feature_rows})),
        n_((matrix.rows + block - 1) / block * block),
        m_(feature_rows),
        left_(rank_ * n_, 0.0f),
        features_(rank_ * m_),
        columns_(rank_ * matrix.stride, 0.0f) {
    Random random(options.seed);
    for (float& x : features_) x = 2 * random.uniform() - 1;
    mix_columns();
  }

  DecisionFactors run() {
    for (std::size_t round = 0; round < options_.rounds; ++round) {
      // The first rounds are plain: they find the subspace that the later ones bend.
      cap_ = round < std::min<std::size_t>(3, options_.rounds / 2) ? 1.0f : options_.cap;
      step_ = cap_ == 1.0f ? 1.0f : options_.relaxation;
      orthonormalise();
      step_left();
      step_features();
    }
    rotate();
    return factors();
  }

 private:
  static constexpr std::size_t block = 8, tile = DecisionMatrix::tile;

  float* left(std::size_t k) { return left_.data() + k * n_; }
  float* column(std::size_t k) { return columns_.data() + k * matrix_.stride; }

  /// The columns' features from the feature rows.
  void mix_columns() {
    std::vector<float> mixed(mixes_.size() * rank_);
    mix(features_, mixed);
    for (std::size_t t = 0; t < mixes_.size(); ++t)
      for (std::size_t k = 0; k < rank_; ++k) column(k)[t] = mixed[t * rank_ + k];
  }
  /// out[t] = Σ weights · features[row], W · x; both row by row, rank wide.
  void mix(const std::vector<float>& features, std::vector<float>& out) const {
    std::fill(out.begin(), out.end(), 0.0f);
    for (std::size_t t = 0; t < mixes_.size(); ++t)
      for (std::uint32_t c = 0; c < mixes_[t].count; ++c)
        add_scaled(mixes_[t].weights[c], features.data() + mixes_[t].rows[c] * rank_, out.data() + t * rank_);
  }
  /// Its transpose, Wᵀ · x.
  void unmix(const std::vector<float>& columns, std::vector<float>& out) const {
    std::fill(out.begin(), out.end(), 0.0f);
    for (std::size_t t = 0; t < mixes_.size(); ++t)
      for (std::uint32_t c = 0; c < mixes_[t].count; ++c)
        add_scaled(mixes_[t].weights[c], columns.data() + t * rank_, out.data() + mixes_[t].rows[c] * rank_);
  }
  void add_scaled(float weight, const float* from, float* to) const {
    for (std::size_t k = 0; k < rank_; ++k) to[k] += weight * from[k];
  }

  /// Where the entries of eight rows from i and a tile of columns from t ought to move: row j at j · tile.
  void residuals(std::size_t i, std::size_t t, float* out) {
    constexpr std::size_t wide = 2 * Lanes::width;
    Lanes loss(0.0f);
    for (std::size_t x = t; x < t + tile; x += wide) {
      Lanes v[block], w[block];
      for (std::size_t j = 0; j < block; ++j) v[j] = w[j] = Lanes(0.0f);
      for (std::size_t k = 0; k < rank_; ++k) {
        const Lanes f = Lanes::load(column(k) + x), g = Lanes::load(column(k) + x + Lanes::width);
        const float* u = left(k) + i;
        for (std::size_t j = 0; j < block; ++j) {
          const Lanes c(u[j]);
          v[j] = mul_add(c, f, v[j]), w[j] = mul_add(c, g, w[j]);
        }
      }
      for (std::size_t j = 0; j < std::min(block, matrix_.rows - i); ++j) {
        const std::int8_t* y = matrix_.row(i + j) + x;
        const Lanes e = residual(load_integers(y), v[j]), d = residual(load_integers(y + Lanes::width), w[j]);
        loss = mul_add(e, e, mul_add(d, d, loss));
        e.store(out + j * tile + (x - t)), d.store(out + j * tile + (x - t) + Lanes::width);
      }
    }
    if (matrix_.rows - i < block) std::fill(out + (matrix_.rows - i) * tile, out + block * tile, 0.0f);
    loss_ += double(sum_of_lanes(loss));
  }
  /// From v to the nearest value that is right for a decision y.
  Lanes residual(Lanes y, Lanes v) const {
    const Lanes yv = y * v;
    return y * (max(Lanes(1.0f) - yv, 0.0f) + min(Lanes(cap_) - yv, 0.0f));
  }

  void step_left() {
    auto inverse = gram_of(columns_.data(), matrix_.stride, matrix_.columns, rank_, 1e-6);
    cholesky(inverse);
    alignas(64) float e[block * tile];
    std::vector<double> change(block * rank_);
    for (std::size_t i = 0; i < n_; i += block) {
      std::fill(change.begin(), change.end(), 0.0);
      for (std::size_t t = 0; t < matrix_.stride; t += tile) {
        residuals(i, t, e);
        for (std::size_t k = 0; k < rank_; ++k) {
          Lanes sums[block];
          for (Lanes& each : sums) each = Lanes(0.0f);
          for (std::size_t x = 0; x < tile; x += Lanes::width) {
            const Lanes f = Lanes::load(column(k) + t + x);
            for (std::size_t j = 0; j < block; ++j)
              sums[j] = mul_add(Lanes::load(e + j * tile + x), f, sums[j]);
          }
          for (std::size_t j = 0; j < block; ++j) change[j * rank_ + k] += double(sum_of_lanes(sums[j]));
        }
      }
      for (std::size_t j = 0; j < block; ++j) {
        solve(inverse, change.data() + j * rank_);
        for (std::size_t k = 0; k < rank_; ++k) left(k)[i + j] += step_ * float(change[j * rank_ + k]);
      }
    }
  }

  void step_features() {
    auto inverse = gram_of(left_.data(), n_, n_, rank_, 1e-6);
    cholesky(inverse);
    std::vector<float> change(rank_ * matrix_.stride, 0.0f);
    alignas(64) float e[block * tile];
    loss_ = 0;
    for (std::size_t i = 0; i < n_; i += block)
      for (std::size_t t = 0; t < matrix_.stride; t += tile) {
        residuals(i, t, e);
        for (std::size_t k = 0; k < rank_; ++k) {
          float* to = change.data() + k * matrix_.stride + t;
          Lanes u[block];
          for (std::size_t j = 0; j < block; ++j) u[j] = Lanes(left(k)[i + j]);
          for (std::size_t x = 0; x < tile; x += Lanes::width) {
            Lanes sum = Lanes::load(to + x);
            for (std::size_t j = 0; j < block; ++j) sum = mul_add(u[j], Lanes::load(e + j * tile + x), sum);
            sum.store(to + x);
          }
        }
      }
    std::vector<float> wanted(matrix_.columns * rank_);
    std::vector<double> row(rank_);
    for (std::size_t t = 0; t < matrix_.columns; ++t) {
      for (std::size_t k = 0; k < rank_; ++k) row[k] = double(change[k * matrix_.stride + t]);
      solve(inverse, row.data());
      for (std::size_t k = 0; k < rank_; ++k) wanted[t * rank_ + k] = float(row[k]);
    }
    move_features(wanted);
    mix_columns();
  }

  /// features += step · (WᵀW + ridge)⁻¹ Wᵀ · wanted, by conjugate gradients, each component for itself.
  void move_features(const std::vector<float>& wanted) {
    constexpr int steps = 8;
    constexpr float ridge = 1e-2f;
    std::vector<float> r(m_ * rank_), p, q(m_ * rank_), x(m_ * rank_, 0.0f), mixed(wanted.size());
    std::vector<float> a(rank_), b(rank_);
    unmix(wanted, r);
    p = r;
    std::vector<double> rr = products(r, r);
    for (int step = 0; step < steps; ++step) {
      mix(p, mixed);
      unmix(mixed, q);
      for (std::size_t i = 0; i < q.size(); ++i) q[i] += ridge * p[i];
      const std::vector<double> pq = products(p, q);
      for (std::size_t k = 0; k < rank_; ++k) a[k] = pq[k] > 0 ? float(rr[k] / pq[k]) : 0.0f;
      for (std::size_t i = 0; i < m_; ++i)
        for (std::size_t k = 0; k < rank_; ++k) {
          x[i * rank_ + k] += a[k] * p[i * rank_ + k];
          r[i * rank_ + k] -= a[k] * q[i * rank_ + k];
        }
      const std::vector<double> next = products(r, r);
      for (std::size_t k = 0; k < rank_; ++k) b[k] = rr[k] > 0 ? float(next[k] / rr[k]) : 0.0f;
      for (std::size_t i = 0; i < m_; ++i)
        for (std::size_t k = 0; k < rank_; ++k) p[i * rank_ + k] = r[i * rank_ + k] + b[k] * p[i * rank_ + k];
      rr = next;
    }
    for (std::size_t i = 0; i < x.size(); ++i) features_[i] += step_ * x[i];
  }
  /// Of two matrices of feature rows, component by component.
  std::vector<double> products(const std::vector<float>& x, const std::vector<float>& y) const {
    std::vector<double> sums(rank_, 0.0);
    for (std::size_t i = 0; i < m_; ++i)
      for (std::size_t k = 0; k < rank_; ++k) sums[k] += double(x[i * rank_ + k]) * double(y[i * rank_ + k]);
    return sums;
  }

  /// Makes the columns' features orthonormal (F L⁻ᵀ), the samples' such that the products stay (U L).
  void orthonormalise() {
    auto lower = gram_of(columns_.data(), matrix_.stride, matrix_.columns, rank_, 1e-9);
    cholesky(lower);
    const double scale = std::sqrt(double(std::max<std::size_t>(matrix_.columns, 1)));
    const auto forward = [&](double* x) {
      for (std::size_t i = 0; i < rank_; ++i) {
        for (std::size_t k = 0; k < i; ++k) x[i] -= lower(i, k) * x[k];
        x[i] /= lower(i, i);
      }
      for (std::size_t i = 0; i < rank_; ++i) x[i] *= scale;
    };
    change_rows(features_.data(), 1, rank_, m_, rank_, forward);
    change_rows(left_.data(), n_, 1, n_, rank_, [&](double* x) {
      for (std::size_t i = 0; i < rank_; ++i) {
        double sum = 0;
        for (std::size_t k = i; k < rank_; ++k) sum += lower(k, i) * x[k];
        x[i] = sum / scale;
      }
    });
    mix_columns();
  }

  /// Turns both sides so that the samples' columns are orthogonal, the longest first.
  void rotate() {
    orthonormalise();
    const auto v = eigenvectors(gram_of(left_.data(), n_, n_, rank_, 0));
    std::vector<double> old(rank_);
    const auto turn = [&](double* x) {
      std::copy_n(x, rank_, old.begin());
      for (std::size_t k = 0; k < rank_; ++k) {
        x[k] = 0;
        for (std::size_t i = 0; i < rank_; ++i) x[k] += old[i] * v(i, k);
      }
    };
    change_rows(features_.data(), 1, rank_, m_, rank_, turn);
    change_rows(left_.data(), n_, 1, n_, rank_, turn);
  }

  DecisionFactors factors() const {
    DecisionFactors result{Rows(matrix_.rows, options_.rank), Rows(m_, options_.rank), 0};
    for (std::size_t i = 0; i < matrix_.rows; ++i)
      for (std::size_t k = 0; k < rank_; ++k) result.left[i][k] = left_[k * n_ + i];
    for (std::size_t i = 0; i < m_; ++i)
      for (std::size_t k = 0; k < rank_; ++k) result.features[i][k] = features_[i * rank_ + k];
    std::size_t counted = 0;
    for (const std::int8_t y : matrix_.values) counted += y != 0;
    result.loss = counted > 0 ? loss_ / double(counted) : 0;
    return result;
  }

  const DecisionMatrix& matrix_;
  std::span<const FeatureMix> mixes_;
  DecisionOptions options_;
  std::size_t rank_, n_, m_;
  std::vector<float> left_, features_, columns_;
  float cap_ = 1, step_ = 1;
  double loss_ = 0;
};

}  // namespace coppice::detail::inline HWY_NAMESPACE

namespace coppice::inline HWY_NAMESPACE {

/// Fits a low-rank product to decisions: the squared distance of each entry y · product from [1, cap] is
/// lowered by alternating least squares over the two sides, each on the residual of the entries that are not
/// yet where they may be (a majorisation: without over-relaxation no step raises the loss). Column t's
/// features are its mix of feature rows, solved by conjugate gradients. Same bits always. Preconditions: a
/// mix a column, its rows < feature_rows. Cost: 4 · rows · columns · rank multiply-adds a round.
inline DecisionFactors fit_decisions(const DecisionMatrix& matrix, std::span<const FeatureMix> mixes,
                                     std::size_t feature_rows, const DecisionOptions& options) {
  COPPICE_ASSERT(mixes.size() == matrix.columns);
  if (options.rank == 0 || matrix.rows == 0 || matrix.columns == 0 || feature_rows == 0)
    return {Rows(matrix.rows, options.rank), Rows(feature_rows, options.rank), 0};
  return detail::DecisionFit(matrix, mixes, feature_rows, options).run();
}

}  // namespace coppice::inline HWY_NAMESPACE
