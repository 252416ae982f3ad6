// Distances that decide which lights share a cluster.
#pragma once

#include <concepts>
#include <coppice/core/math.hpp>
#include <cstdint>
#include <span>

namespace coppice {

/// Position and normal of a light as the metric sees it. Distant lights have their direction as position and
/// normal zero.
struct LightSample {
  vec3 position{0};
  vec3 normal{0};
};

/// What a tree is built by: `size()` lights as points of `dimension()` finite coordinates, whose squared
/// Euclidean distance is the distance of the lights. write_point(light, point) fills in one of them. A metric
/// whose distance is another one says so by distance(const float* point, const float* centre).
template <class M>
concept LightMetric = requires(const M& metric, std::uint32_t light, std::span<float> point) {
  { metric.size() } -> std::convertible_to<std::size_t>;
  { metric.dimension() } -> std::convertible_to<std::size_t>;
  metric.write_point(light, point);
};

/// d_g(s, c) = K²/d² · |x_s - x_c|² + |n_s - n_c|² (Cuts Eq. 11), d the diagonal of the samples' bounding
/// box. Points of this metric are 6-vectors; where all samples coincide, d = 0 and only the normals count.
/// The samples outlive the metric.
class GeometricMetric {
 public:
  /// `position_weight` is the paper's K.
  explicit GeometricMetric(std::span<const LightSample> samples, float position_weight = 30)
      : samples_(samples) {
    if (samples.empty()) return;
    vec3 low = samples[0].position, high = low;
    for (const auto& s : samples) low = glm::min(low, s.position), high = glm::max(high, s.position);
    origin_ = low;
    const float largest = glm::max(high.x - low.x, glm::max(high.y - low.y, high.z - low.z));
    if (largest > 0) largest_ = largest, scale_ = position_weight / length((high - low) / largest);
  }

  std::size_t size() const { return samples_.size(); }
  static constexpr std::size_t dimension() { return 6; }

  /// The sample scaled so that Eq. 11 is a squared Euclidean distance. Precondition: `point` has room for
  /// dimension() coordinates.
  void write_point(std::uint32_t light, std::span<float> point) const {
    const vec3 x = (samples_[light].position - origin_) / largest_ * scale_, n = samples_[light].normal;
    for (int k = 0; k < 3; ++k) point[std::size_t(k)] = x[k], point[std::size_t(k + 3)] = n[k];
  }

 private:
  std::span<const LightSample> samples_;
  vec3 origin_{0};
  float largest_ = 1;  ///< side of the bounding box; divided by first, as K/d overflows where d is denormal
  float scale_ = 0;
};
static_assert(LightMetric<GeometricMetric>);

}  // namespace coppice
