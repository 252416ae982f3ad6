// The data-driven distance of lights: how differently they are seen from the scene.
#pragma once

#include <array>
#include <cmath>
#include <coppice/core/config.hpp>
#include <coppice/core/parallel.hpp>
#include <coppice/core/random.hpp>
#include <coppice/tree/metric.hpp>
#include <vector>

namespace coppice {

/// Light visibility vectors (Cuts section 3.4), one after the other: entry c of light i is the share of the
/// c-th cluster of receivers that sees it, in [0, 1].
struct LightVisibility {
  std::size_t length = 0;  ///< M, clusters of receivers
  std::vector<float> shares;

  std::size_t size() const { return length == 0 ? 0 : shares.size() / length; }
  std::span<const float> of(std::uint32_t light) const {
    return std::span(shares).subspan(light * length, length);
  }
};

/// The vectors multiplied by a random matrix of ±1/√length. Squared distances are kept but for a relative
/// standard deviation of at most √(2/length) (Achlioptas 2003), so that fewer numbers tell about the same;
/// they are no shares any more. Deterministic, whatever the executor. Cost: length · vectors.length additions
/// a light. Precondition: length > 0.
template <Executor E>
LightVisibility project(const LightVisibility& vectors, std::size_t length, const E& executor,
                        std::uint64_t seed = 1) {
  COPPICE_ASSERT(length > 0);
  constexpr std::size_t block = 16;
  const std::size_t blocks = (length + block - 1) / block;
  std::vector<float> signs(blocks * block * vectors.length);  // of 16 columns for each row, then the next 16
  Random random(seed);
  for (float& s : signs) s = random.bits() >> 63 ? 1.0f : -1.0f;
  const float scale = 1 / std::sqrt(float(length));
  LightVisibility result{length, std::vector<float>(vectors.size() * length)};
  executor(vectors.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t light = begin; light < end; ++light) {
      const float* sign = signs.data();
      for (std::size_t first = 0; first < length; first += block) {
        std::array<float, block> sum{};
        for (const float share : vectors.of(std::uint32_t(light))) {
          for (std::size_t k = 0; k < block; ++k) sum[k] += share * sign[k];
          sign += block;
        }
        for (std::size_t k = 0; k < block && first + k < length; ++k)
          result.shares[light * length + first + k] = scale * sum[k];
      }
    }
  });
  return result;
}

/// d_v(s, c) = (K+1)² A² / M · |l_s - l_c|² (Cuts Eq. 12), l the visibility vectors, M their length, A the
/// solid angle of a light, 4π/N. The vectors outlive the metric.
class VisibilityMetric {
 public:
  explicit VisibilityMetric(const LightVisibility& vectors, float position_weight = 30) : vectors_(&vectors) {
    if (vectors.size() == 0) return;
    const float solid_angle = 4 * pi / float(vectors.size());
    scale_ = (position_weight + 1) * solid_angle / std::sqrt(float(vectors.length));
  }

  std::size_t size() const { return vectors_->size(); }
  std::size_t dimension() const { return vectors_->length; }

  /// Precondition: `point` has room for dimension() coordinates.
  void write_point(std::uint32_t light, std::span<float> point) const {
    const auto shares = vectors_->of(light);
    for (std::size_t k = 0; k < shares.size(); ++k) point[k] = scale_ * shares[k];
  }

 private:
  const LightVisibility* vectors_;
  float scale_ = 0;
};
static_assert(LightMetric<VisibilityMetric>);

/// Mean squared distance of the lights from their mean: what a tree of one node leaves. 0 without lights.
template <LightMetric Metric>
double variance(const Metric& metric) {
  std::vector<float> point(metric.dimension());
  std::vector<double> sum(metric.dimension());
  for (std::uint32_t i = 0; i < metric.size(); ++i) {
    metric.write_point(i, point);
    for (std::size_t k = 0; k < point.size(); ++k) sum[k] += double(point[k]);
  }
  double squares = 0;
  for (std::uint32_t i = 0; i < metric.size(); ++i) {
    metric.write_point(i, point);
    for (std::size_t k = 0; k < point.size(); ++k) {
      const double deviation = double(point[k]) - sum[k] / double(metric.size());
      squares += deviation * deviation;
    }
  }
  return metric.size() == 0 ? 0 : squares / double(metric.size());
}

/// How the two distances of Eq. 13 are made comparable. variance: each is divided by its variance over all
/// lights. constant: as they are, Eq. 12's constant being "intended to normalize"; under environments it
/// makes d_v less than a millionth of d_g, so that any β > 0 clusters by geometry.
enum class MetricScale { variance, constant };

/// d = (1 - β) d_v + β d_g (Cuts Eq. 13). β = 1 is the geometric distance, β = 0 the data-driven one, in
/// which lights that no receiver sees coincide. Both metrics outlive this one.
class MixedMetric {
 public:
  /// Precondition: both know the same lights; 0 <= beta <= 1.
  MixedMetric(const GeometricMetric& geometry, const VisibilityMetric& visibility, float beta,
              MetricScale scale = MetricScale::variance)
      : geometry_(&geometry), visibility_(&visibility) {
    COPPICE_ASSERT(geometry.size() == visibility.size() && beta >= 0 && beta <= 1);
    const bool by_variance = scale == MetricScale::variance;
    geometry_scale_ = root_of_share(beta, by_variance ? variance(geometry) : 1);
    visibility_scale_ = root_of_share(1 - beta, by_variance ? variance(visibility) : 1);
  }

  std::size_t size() const { return geometry_->size(); }
  std::size_t dimension() const { return GeometricMetric::dimension() + visibility_->dimension(); }

  /// Precondition: `point` has room for dimension() coordinates.
  void write_point(std::uint32_t light, std::span<float> point) const {
    const auto place = point.first(GeometricMetric::dimension()),
               seen = point.subspan(GeometricMetric::dimension());
    geometry_->write_point(light, place);
    visibility_->write_point(light, seen);
    for (float& x : place) x *= geometry_scale_;
    for (float& x : seen) x *= visibility_scale_;
  }

 private:
  /// Lights that all coincide need no scale.
  static float root_of_share(float share, double whole) {
    return whole > 0 ? float(std::sqrt(double(share) / whole)) : 0.0f;
  }

  const GeometricMetric* geometry_;
  const VisibilityMetric* visibility_;
  float geometry_scale_ = 0, visibility_scale_ = 0;
};
static_assert(LightMetric<MixedMetric>);

}  // namespace coppice
