// The distance of points of surfaces: by position and normal, each by its own length.
#pragma once

#include <cmath>
#include <coppice/tree/metric.hpp>

namespace coppice {

/// dist(i, c) = |p_i - p_c| / (d/2) + √(2 - 2 n_i·n_c) / 4 (Filtering Eq. 5), d the diagonal of the samples'
/// bounding box. Points of this metric are (2 p/d, n/4), so that the two terms are the lengths of their
/// halves; a cluster's centre has the mean of the normals, not normalised. The samples outlive the metric.
class SurfaceMetric {
 public:
  explicit SurfaceMetric(std::span<const LightSample> samples) : scaled_(samples, 8) {}

  std::size_t size() const { return scaled_.size(); }
  static constexpr std::size_t dimension() { return GeometricMetric::dimension(); }

  /// Precondition: `point` has room for dimension() coordinates.
  void write_point(std::uint32_t light, std::span<float> point) const {
    scaled_.write_point(light, point);
    for (float& x : point) x *= 0.25f;
  }
  float distance(const float* point, const float* centre) const {
    return distance3(point, centre) + distance3(point + 3, centre + 3);
  }

 private:
  static float distance3(const float* a, const float* b) {
    const float x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
    return std::sqrt(x * x + y * y + z * z);
  }

  GeometricMetric scaled_;  ///< K = 8: (8 p/d, n), four times as large
};
static_assert(LightMetric<SurfaceMetric>);

}  // namespace coppice
