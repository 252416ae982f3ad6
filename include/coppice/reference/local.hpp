// Lights of the scene one after the other.
#pragma once

#include <coppice/cut/masked_cuts.hpp>
#include <coppice/light/local_light.hpp>
#include <coppice/reference/dense.hpp>
#include <coppice/reference/merge_per_leaf.hpp>
#include <coppice/scene/occluder.hpp>
#include <limits>
#include <vector>

namespace coppice::reference {

/// A light as one point meets it. A light at the point itself has no direction and gives nothing.
struct ArrivingLight {
  glm::dvec3 direction{0};  ///< unit, towards the light
  double distance = 0;      ///< infinite where w = 0
  double share = 0;         ///< of its intensity: emission / (distance² + area / π), 1/m²
};

inline ArrivingLight arriving(const LocalLight& light, const vec3& point) {
  const glm::dvec3 to_light = glm::dvec3(light.position) - double(light.w) * glm::dvec3(point);
  const double distance = glm::length(to_light);
  if (!(distance > 0)) return {};
  const glm::dvec3 d = to_light / distance;
  const double s = std::clamp(double(light.offset) - glm::dot(glm::dvec3(light.axis), d), 0.0, 1.0);
  const double emission = s * (1 - double(light.square) + double(light.square) * s);
  return {d, light.w > 0 ? distance : std::numeric_limits<double>::infinity(),
          emission / (distance * distance + double(light.area) / std::numbers::pi)};
}

/// Radiance of a point from `shares` of the lights' intensities, an entry a light.
inline vec3 radiance_of_shares(const ShadingPoint& point, const vec3& position,
                               std::span<const LocalLight> lights, std::span<const float> shares) {
  std::vector<vec3> directions, intensities;
  for (const LocalLight& light : lights) {
    directions.push_back(vec3(arriving(light, position).direction));
    intensities.push_back(light.intensity);
  }
  return dense_radiance(point, directions, intensities, shares);
}

/// Radiance of a point: Σ intensity · emission / (distance² + area / π) · BRDF · cosine over the lights that
/// a shadow ray reaches (Cuts section 4.1).
template <Occluder O>
vec3 local_radiance(const ShadingPoint& point, const vec3& position, std::span<const LocalLight> lights,
                    const O& occluder) {
  std::vector<float> shares;
  for (const LocalLight& light : lights) {
    const ArrivingLight a = arriving(light, position);
    const bool hidden = occluder.occluded(position, vec3(a.direction), float(a.distance * (1 - 1e-4)));
    shares.push_back(hidden ? 0.0f : float(a.share));
  }
  return radiance_of_shares(point, position, lights, shares);
}

/// The same with V·G as three receivers have it stored, interpolated by the point's weights. `leaf_lights`: a
/// light a leaf; `scales`: a receiver, by which the squares of its values are multiplied.
inline vec3 local_radiance_from_cuts(const ShadingPoint& point, const vec3& position,
                                     std::span<const LocalLight> leaf_lights,
                                     const MaskedCuts<std::uint16_t>& cuts, std::span<const float> scales,
                                     const uvec3& receivers) {
  const double weights[3] = {point.weight_0, point.weight_1,
                             1 - double(point.weight_0) - double(point.weight_1)};
  std::vector<float> shares(leaf_lights.size());
  for (int k = 0; k < 3; ++k) {
    const auto cut = cuts.unpack(receivers[k]);
    const std::vector<double> values = expand(CutView<std::uint16_t>(cut));
    for (std::size_t leaf = 0; leaf < shares.size(); ++leaf)
      shares[leaf] += float(weights[k] * double(scales[receivers[k]]) * values[leaf] * values[leaf]);
  }
  return radiance_of_shares(point, position, leaf_lights, shares);
}

}  // namespace coppice::reference
