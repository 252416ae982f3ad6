// What a BRDF is to the rest of Coppice, and what all of ours share.
#pragma once

#include <coppice/shared/brdf_filtered.h>

#include <algorithm>
#include <concepts>

namespace coppice {

/// A reflectance function seen from one viewer. Directions are unit, in the local frame of shared/brdf.h.
///   terms            how many of its BrdfTerms are not always 0, from the first
///   brdf(x, y, z)    the cosine-weighted terms for light from (x, y, z), for REAL = float and Lanes alike
///   filtered(x, y, z, spread)  the same for a cluster of lights about (x, y, z), and how much its lobe grows
///   colour(terms)    their sum, each times its colour: BRDF · cos, linear RGB
///   evaluate(wi, wo) the BRDF itself, without the cosine, 1/sr, for any viewer wo; 0 below the horizon
template <class B>
concept Brdf = std::copyable<B> &&
    requires(const B& brdf, float x, vec3 direction, BrdfTerms<float> values, LightSpread<float> spread) {
  requires B::terms >= 1 && B::terms <= 3;
  { brdf(x, x, x) } -> std::same_as<BrdfTerms<float>>;
  { brdf.filtered(x, x, x, spread) } -> std::same_as<FilteredTerms<float>>;
  { brdf.colour(values) } -> std::same_as<vec3>;
  { brdf.evaluate(direction, direction) } -> std::same_as<vec3>;
};

/// The viewer and the colours of the terms.
struct SeenSurface {
  vec3 viewer = vec3(0, 0, 1);  ///< unit, local frame
  vec3 diffuse = vec3(0);       ///< linear RGB coefficients of the three terms
  vec3 specular = vec3(0);
  vec3 fresnel = vec3(0);

  vec3 colour(const BrdfTerms<float>& terms) const {
    return diffuse * terms.diffuse + specular * terms.specular + fresnel * terms.fresnel;
  }
};

COPPICE_FUNCTION SeenSurface seen_surface(const ShadingPoint& point) {
  return {brdf_viewer_to_local(point.normal, point.tangent, point.to_viewer), point.diffuse, point.specular,
          point.fresnel};
}

/// BRDF, without the cosine, for any pair of local unit directions.
template <class B>
vec3 brdf_value(B brdf, const vec3& wi, const vec3& wo) {
  if (!(wi.z > 0)) return vec3(0);
  brdf.viewer = wo;
  return brdf.colour(brdf(wi.x, wi.y, wi.z)) / wi.z;
}

/// Width of GGX and Ward, kept where the closed forms hold.
COPPICE_FUNCTION float valid_alpha(float alpha) { return std::clamp(alpha, BRDF_MIN_ALPHA, 1.0f); }
/// Exponent of Phong and Blinn-Phong, kept where the closed forms hold.
COPPICE_FUNCTION float valid_exponent(float exponent) {
  return std::clamp(exponent, 1.0f, BRDF_MAX_EXPONENT);
}

}  // namespace coppice
