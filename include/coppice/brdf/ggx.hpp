// The metallic-roughness material of glTF 2.0.
#pragma once

#include <coppice/brdf/brdf.hpp>

namespace coppice {

/// brdf_ggx of shared/brdf.h; `alpha` is the roughness squared, clamped to [BRDF_MIN_ALPHA, 1].
struct Ggx : SeenSurface {
  static constexpr int terms = 3;
  float alpha;

  COPPICE_FUNCTION Ggx(const SeenSurface& surface, float width)
      : SeenSurface(surface), alpha(valid_alpha(width)) {}
  COPPICE_FUNCTION explicit Ggx(const ShadingPoint& point) : Ggx(seen_surface(point), point.alpha_x) {}

  COPPICE_FUNCTION_OF_REAL
  BrdfTerms<REAL> operator()(REAL x, REAL y, REAL z) const { return brdf_ggx(x, y, z, viewer, alpha); }
  COPPICE_FUNCTION_OF_REAL
  FilteredTerms<REAL> filtered(REAL x, REAL y, REAL z, const LightSpread<REAL>& spread) const {
    return brdf_ggx_filtered(x, y, z, spread, viewer, alpha);
  }
  vec3 evaluate(const vec3& wi, const vec3& wo) const { return brdf_value(*this, wi, wo); }
};
static_assert(Brdf<Ggx>);

/// Fills the BRDF of the point as glTF 2.0 (appendix B.2) mixes metal and dielectric of index 1.5: base
/// colour in [0, 1], linear RGB; metallic and roughness in [0, 1]. roughness² is clamped to [BRDF_MIN_ALPHA,
/// 1]. As in glTF, a bright dielectric seen at grazing angles reflects more than it receives (albedo up to
/// 1.9).
inline void set_metallic_roughness(ShadingPoint& point, const vec3& base, float metallic, float roughness) {
  const vec3 f0 = glm::mix(vec3(0.04f), base, metallic);
  point.brdf = BRDF_GGX;
  point.alpha_x = point.alpha_y = valid_alpha(roughness * roughness);
  point.diffuse = base * (1 - metallic) * (vec3(1) - f0);
  point.specular = f0;
  point.fresnel = vec3(1);
}

}  // namespace coppice
