// Images of the CPU and of the device, side by side.
#pragma once

#include <doctest/doctest.h>

#include <cmath>
#include <coppice/core/math.hpp>
#include <cstdint>
#include <functional>
#include <numeric>
#include <vector>

namespace coppice::test {

/// Radiance and clusters by point.
struct Shaded {
  std::vector<vec3> radiance;
  std::vector<std::uint32_t> clusters;
  explicit Shaded(std::size_t point_count) : radiance(point_count), clusters(point_count) {}
};

inline double relative_rms(const std::vector<vec3>& a, const std::vector<vec3>& reference) {
  REQUIRE(a.size() == reference.size());
  double difference = 0, total = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    difference += glm::dot(a[i] - reference[i], a[i] - reference[i]);
    total += glm::dot(reference[i], reference[i]);
  }
  REQUIRE(total > 0);
  return std::sqrt(difference / total);
}

inline std::size_t count_different(const std::vector<std::uint32_t>& a, const std::vector<std::uint32_t>& b) {
  return std::size_t(std::transform_reduce(a.begin(), a.end(), b.begin(), 0L, std::plus<>(),
                                           [](auto x, auto y) { return long(x != y); }));
}

inline double mean(const std::vector<std::uint32_t>& counts) {
  return std::accumulate(counts.begin(), counts.end(), 0.0) / double(counts.size());
}

/// The same image, and the same clusters but where rounding decides.
inline void check_alike(const Shaded& device, const Shaded& cpu) {
  CHECK(relative_rms(device.radiance, cpu.radiance) < 1e-4);
  CHECK(count_different(device.clusters, cpu.clusters) <= cpu.clusters.size() / 1000);
}

}  // namespace coppice::test
