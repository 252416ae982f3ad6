// The sum over all lights that every fast path approximates.
#pragma once

#include <coppice/shared/brdf.h>

#include <coppice/core/math.hpp>
#include <span>

namespace coppice::reference {

/// Radiance of one shading point: Σ_i power_i · f(direction_i) cos · visibility_i (Cuts Eq. 2), one light
/// after the other, in double. Arrays are by light (or leaf), of equal length.
inline vec3 dense_radiance(const ShadingPoint& point, std::span<const vec3> directions,
                           std::span<const vec3> powers, std::span<const float> visibility) {
  const vec3 wo = brdf_viewer_to_local(point.normal, point.tangent, point.to_viewer);
  glm::dvec3 sum(0);
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const vec3 wi = brdf_to_local(point.normal, point.tangent, directions[i]);
    const auto t = brdf_terms<float>(point.brdf, point.alpha_x, point.alpha_y, wi.x, wi.y, wi.z, wo);
    const glm::dvec3 f = glm::dvec3(point.diffuse) * double(t.diffuse) +
                         glm::dvec3(point.specular) * double(t.specular) +
                         glm::dvec3(point.fresnel) * double(t.fresnel);
    sum += glm::dvec3(powers[i]) * f * double(visibility[i]);
  }
  return vec3(sum);
}

}  // namespace coppice::reference
