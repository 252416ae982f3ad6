// How much of a Gaussian a point of a surface sees, by a march through distances: one cone at a time.
#pragma once

#include <algorithm>
#include <coppice/voxel/brick_grid.hpp>

namespace coppice {

/// What measured best (docs/voxel.md): 8 rays of at most 64 steps, 8 to 13 on average.
inline constexpr VoxelTrace default_voxel_trace{8, 64, 1.0f, 0.5f, 0.62f, 0.3f, 0.8f, 0.25f};

/// A ray of a cone, and how much of the ray is above the horizon.
struct ConeRay {
  vec3 direction;
  float share;
};

/// Ray i of a cone. All stand for equal parts of the Gaussian, on a golden spiral around the axis. Those
/// below the horizon of the surface, or nearly so, are turned up to it.
inline ConeRay cone_ray(const SgShape& cone, const vec3& normal, std::uint32_t i, std::uint32_t count) {
  const float u = (float(i) + 0.5f) / float(count), width = voxel_ray_width(cone.sharpness, count);
  const float drop = count == 1 ? 0 : voxel_ray_drop(u, std::fmax(cone.sharpness, 1e-4f));
  const float radius = std::sqrt(std::fmax(drop * (2 - drop), 0.0f)), angle = float(i) * VOXEL_TURN;
  vec3 x, y;
  make_frame(cone.axis, x, y);
  const vec3 d = (1 - drop) * cone.axis + radius * (std::cos(angle) * x + std::sin(angle) * y);
  const float rise = dot(d, normal), up = std::fmax(voxel_ray_least_rise(width) - rise, 0.0f);
  return {normalize_or(d + up * normal, normal), voxel_ray_share(rise, width)};
}

namespace cone_visibility_detail {

/// Nothing of the grid is ahead of a ray beyond this distance.
inline float last_surface(const vec3& size, const vec3& from, const vec3& direction) {
  const vec3 half = 0.5f * size;
  const float all = dot(half - from, direction) + dot(half, glm::abs(direction));
  float exit = all, entry = 0;
  for (int k = 0; k < 3; ++k) {
    const float inverse = 1 / (std::fabs(direction[k]) > 1e-12f ? direction[k] : 1e-12f);
    const float a = -from[k] * inverse, b = (size[k] - from[k]) * inverse;
    exit = std::fmin(exit, std::fmax(a, b)), entry = std::fmax(entry, std::fmin(a, b));
  }
  return entry < exit ? exit : all;
}

/// How open one ray is, in [0, 1].
inline float march(const BrickGrid& g, const vec3& from, const vec3& normal, const vec3& direction,
                   float width, const VoxelTrace& trace) {
  const float slope = std::fmax(dot(normal, direction), 0.0f), reach = trace.softness * width;
  const vec3 start = from + trace.lift * normal;
  const float end = last_surface(g.size(), start, direction);
  float t = trace.start, open = 1;
  for (std::uint32_t step = 0; step < trace.steps && t < end && open > 0; ++step) {
    const float d = nearest_surface(g, start + t * direction), rise = trace.lift + t * slope;
    open = std::fmin(open, voxel_opening(d, t, rise, reach, trace.skin, trace.slack));
    t += voxel_stride(d, t, reach, trace.growth);
  }
  return open;
}

}  // namespace cone_visibility_detail

/// The share of a Gaussian's integral above the surface's horizon that the grid leaves visible, in [0, 1],
/// from a point with a unit geometric normal, world space. 0 where nothing of the Gaussian is above the
/// horizon. Cost: trace.rays marches of 0.3 µs; ConeTracer (voxel/cone_tracer.hpp) does many at once.
inline float cone_visibility(const BrickGrid& g, const vec3& origin, const vec3& normal, const SgShape& cone,
                             const VoxelTrace& trace = default_voxel_trace) {
  const vec3 from = g.place(origin);
  const float width = voxel_ray_width(cone.sharpness, trace.rays);
  float seen = 0, all = 0;
  for (std::uint32_t i = 0; i < trace.rays; ++i) {
    const ConeRay ray = cone_ray(cone, normal, i, trace.rays);
    if (ray.share <= 0) continue;
    seen += ray.share * cone_visibility_detail::march(g, from, normal, ray.direction, width, trace);
    all += ray.share;
  }
  return all > 0 ? seen / all : 0.0f;
}

}  // namespace coppice
