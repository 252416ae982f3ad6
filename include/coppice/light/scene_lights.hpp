// The lights that a scene brings: punctual ones, and its shining surfaces as many small ones.
#pragma once

#include <coppice/light/local_light.hpp>
#include <coppice/light/thin_samples.hpp>

namespace coppice {

/// Candidates for each sample that is kept.
inline constexpr std::size_t candidates_a_sample = 5;

/// Diagonal of the box around all vertices; 1 where that is no length.
inline float scene_size(const Mesh& mesh) {
  if (mesh.positions.empty()) return 1;
  vec3 low = mesh.positions[0], high = low;
  for (const vec3& p : mesh.positions) low = glm::min(low, p), high = glm::max(high, p);
  const float diagonal = length(high - low);
  return diagonal > 0 && std::isfinite(diagonal) ? diagonal : 1.0f;
}

/// The light as KHR_lights_punctual means it, but for its range, which cuts off what physics does not:
/// ignored. `reach` as for distant_light.
inline LocalLight local_light(const PunctualLight& light, float reach) {
  switch (light.type) {
    case PunctualLightType::spot:
      return spot_light(light.position, light.intensity, light.direction, light.inner_cone, light.outer_cone);
    case PunctualLightType::directional:
      return distant_light(-light.direction, light.intensity, reach);
    default:
      return point_light(light.position, light.intensity);
  }
}

namespace detail {

/// Candidates on every shining side, those that are dark or in holes left out. Their colour is radiance.
inline std::vector<SurfaceSample> emission_candidates(const Scene& scene, std::size_t count,
                                                      std::uint64_t seed) {
  const auto sides =
      triangle_sides(scene, [](const Material& material) { return material.emission != vec3(0); });
  auto candidates =
      scatter_samples(scene.mesh, sides, candidates_a_sample * count, Shares::at_least_one, seed);
  for (SurfaceSample& c : candidates) c.colour = emission_at(scene, hit_of(c));
  std::erase_if(candidates,
                [&](const SurfaceSample& c) { return c.colour == vec3(0) || !is_solid(scene, c); });
  return candidates;
}

}  // namespace detail

/// The shining surfaces as at most `count` surface lights that lie evenly by area, on both sides of
/// double-sided ones. Σ area · radiance is that of all triangles: to rounding without textures; with them, as
/// the mean over some five points a light tells. Where lights are fewer than triangles, each triangle's power
/// goes to a near light that faces alike. The lights lie on the surface: a shadow ray to one must end before
/// it.
inline std::vector<LocalLight> emission_lights(const Scene& scene, std::size_t count, std::uint64_t seed) {
  std::vector<LocalLight> lights;
  for (const SurfaceSample& s : thin_samples(detail::emission_candidates(scene, count, seed), count))
    lights.push_back(surface_light(s.position, s.normal, s.colour, s.area));
  return lights;
}

/// The scene's punctual lights, in their order, then its emission_lights. Suns stand scene_size(mesh) away.
inline std::vector<LocalLight> scene_lights(const Scene& scene, std::size_t count, std::uint64_t seed = 0) {
  std::vector<LocalLight> lights;
  const float reach = scene_size(scene.mesh);
  for (const PunctualLight& light : scene.lights) lights.push_back(local_light(light, reach));
  const std::vector<LocalLight> surfaces = emission_lights(scene, count, seed);
  lights.insert(lights.end(), surfaces.begin(), surfaces.end());
  return lights;
}

}  // namespace coppice
