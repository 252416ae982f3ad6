// Shadows from uncompressed depth maps: what compression is measured against.
#pragma once

#include <coppice/transfer/depth_maps.hpp>
#include <coppice/transfer/sized_light.hpp>
#include <numeric>
#include <optional>

namespace coppice::reference {

/// The four directions of a grid that are nearest to d, the nearest first, by looking at all; of equally near
/// ones those of lower index.
inline DirectionGrid::Four nearest_directions(const DirectionGrid& grid, const vec3& d) {
  std::vector<std::uint16_t> order(grid.size());
  std::iota(order.begin(), order.end(), std::uint16_t{0});
  std::ranges::stable_sort(
      order, [&](auto a, auto b) { return dot(grid.directions()[a], d) > dot(grid.directions()[b], d); });
  return {order[0], order[1], order[2], order[3]};
}

/// Visibility of one point of light at a sample, from its own row of trace_depths: a decision for each of
/// four directions above the horizon, then their mean. None where the point is below the horizon.
inline std::optional<float> depth_decision(const SurfaceSample& sample, const LocalLight& point,
                                           const DirectionGrid& grid, std::span<const float> depths,
                                           const DirectionGrid::Four& four, float limit, float bias) {
  const vec3 across = point.position - point.w * ray_origin(sample);
  if (!(dot(across, sample.normal) > 0)) return std::nullopt;
  const float distance = point.w > 0 ? std::min(length(across) / point.w, limit) : limit;
  float visible = 0, count = 0;
  for (const std::uint16_t k : four) {
    if (grid.dome() == Dome::sphere && !(dot(grid.directions()[k], sample.normal) > 0)) continue;
    visible += (1 - bias) * distance <= depths[k] ? 1.0f : 0.0f;
    ++count;
  }
  return count > 0 ? visible / count : 1.0f;
}

/// The twin of DepthVisibility::visibility without compression. `find(grid, d)` gives four directions.
template <class Find>
std::vector<float> depth_visibility(std::span<const SurfaceSample> samples, const DirectionGrid& grid,
                                    const Rows& depths, const SizedLight& light, float limit, float bias,
                                    Find&& find, std::uint32_t points = 25) {
  std::vector<float> result(samples.size(), 0);
  const std::vector<LocalLight> parts = points_of(light, points);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    float count = 0;
    for (const LocalLight& point : parts) {
      const vec3 towards = normalize(point.position - point.w * ray_origin(samples[i]));
      const auto four = find(grid, towards * dome_frame(grid.dome(), samples[i].normal));
      const auto decision = depth_decision(samples[i], point, grid, depths[i], four, limit, bias);
      if (!decision) continue;
      result[i] += *decision;
      ++count;
    }
    if (count > 1) result[i] /= count;
  }
  return result;
}

}  // namespace coppice::reference
