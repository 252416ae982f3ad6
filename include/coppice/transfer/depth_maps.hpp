// How far samples see in fixed directions, and how much farther they might without an error in any shadow.
#pragma once

#include <algorithm>
#include <coppice/pca/rows.hpp>
#include <coppice/scene/hit.hpp>
#include <coppice/transfer/clustered_samples.hpp>
#include <coppice/transfer/direction_grid.hpp>
#include <coppice/transfer/free_cells.hpp>

namespace coppice {

/// Where the axes of a grid's dome lie in the world at a surface of this normal, as columns: +Y along the
/// normal for the hemisphere (PCA section 4.2), the world's axes for the sphere. frame · d takes a direction
/// of the grid to the world, d · frame one of the world to the grid.
inline mat3 dome_frame(Dome dome, const vec3& normal) {
  if (dome == Dome::sphere) return mat3(1);
  vec3 tangent, bitangent;
  make_frame(normal, tangent, bitangent);
  return {tangent, normal, bitangent};
}

/// The depth of directions below a sample's horizon, where no light shines from.
inline constexpr float no_depth = -1;

/// Depth maps of samples: entry (i, k) is how far sample i sees along direction k, at most `limit` metres,
/// and no_depth below its horizon (directions of the sphere). Cost: a ray an entry.
template <RayTracer T>
Rows trace_depths(std::span<const SurfaceSample> samples, const DirectionGrid& grid, const T& tracer,
                  float limit) {
  Rows depths(samples.size(), grid.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const mat3 frame = dome_frame(grid.dome(), samples[i].normal);
    const vec3 origin = ray_origin(samples[i]);
    for (std::size_t k = 0; k < grid.size(); ++k) {
      const vec3 direction = frame * grid.directions()[k];
      if (!(dot(direction, samples[i].normal) > 0)) {
        depths[i][k] = no_depth;
        continue;
      }
      const auto hit = tracer.closest(origin, direction);
      depths[i][k] = hit ? std::min(hit->t, limit) : limit;
    }
  }
  return depths;
}

/// The far ends of the intervals that begin at the depths of trace_depths: any depth between the two decides
/// every shadow alike, because no light stands there. +infinity where nothing hides a light within `limit`,
/// where no free space follows, and below the horizon.
inline Rows far_ends(std::span<const SurfaceSample> samples, const DirectionGrid& grid, const Rows& depths,
                     const FreeCells& cells, float limit) {
  Rows ends(samples.size(), grid.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const mat3 frame = dome_frame(grid.dome(), samples[i].normal);
    const vec3 origin = ray_origin(samples[i]);
    for (std::size_t k = 0; k < grid.size(); ++k) {
      const float depth = depths[i][k];
      ends[i][k] = depth == no_depth || depth >= limit
                       ? std::numeric_limits<float>::infinity()
                       : cells.next_free(origin, frame * grid.directions()[k], depth, limit);
    }
  }
  return ends;
}

/// The distance (m) that a share of the pairs of a sample and a light above its horizon stay within, from
/// example positions of lights: what depths are clamped at. One light in a corner far away would otherwise
/// set the scale of all depths. Takes a million pairs at most, evenly from all; +infinity where none are.
inline float light_reach(std::span<const SurfaceSample> samples, std::span<const vec3> positions,
                         double share = 0.995) {
  std::vector<float> distances;
  const std::size_t step = std::max<std::size_t>(1, samples.size() * positions.size() / 1000000);
  for (std::size_t i = 0; i < samples.size() * positions.size(); i += step) {
    const SurfaceSample& sample = samples[i / positions.size()];
    const vec3 across = positions[i % positions.size()] - sample.position;
    if (dot(across, sample.normal) > 0) distances.push_back(length(across));
  }
  if (distances.empty()) return std::numeric_limits<float>::infinity();
  const auto at = std::min(distances.size() - 1, std::size_t(share * double(distances.size())));
  std::nth_element(distances.begin(), distances.begin() + std::ptrdiff_t(at), distances.end());
  return distances[at];
}

}  // namespace coppice
