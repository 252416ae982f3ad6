// Phong's lobe about the mirror direction, normalised.
#pragma once

#include <coppice/brdf/brdf.hpp>

namespace coppice {

/// brdf_phong of shared/brdf.h; the exponent is clamped to [1, BRDF_MAX_EXPONENT].
struct Phong : SeenSurface {
  static constexpr int terms = 2;
  float exponent;

  COPPICE_FUNCTION Phong(const SeenSurface& surface, float power)
      : SeenSurface(surface), exponent(valid_exponent(power)) {}
  COPPICE_FUNCTION explicit Phong(const ShadingPoint& point) : Phong(seen_surface(point), point.alpha_x) {}

  COPPICE_FUNCTION_OF_REAL
  BrdfTerms<REAL> operator()(REAL x, REAL y, REAL z) const { return brdf_phong(x, y, z, viewer, exponent); }
  COPPICE_FUNCTION_OF_REAL
  FilteredTerms<REAL> filtered(REAL x, REAL y, REAL z, const LightSpread<REAL>& spread) const {
    return brdf_phong_filtered(x, y, z, spread, viewer, exponent);
  }
  vec3 evaluate(const vec3& wi, const vec3& wo) const { return brdf_value(*this, wi, wo); }
};
static_assert(Brdf<Phong>);

/// Fills the BRDF of the point: colours are linear RGB; where diffuse + specular <= 1 no energy is made.
inline void set_phong(ShadingPoint& point, const vec3& diffuse, const vec3& specular, float exponent) {
  point.brdf = BRDF_PHONG;
  point.alpha_x = point.alpha_y = valid_exponent(exponent);
  point.diffuse = diffuse;
  point.specular = specular;
  point.fresnel = vec3(0);
}

}  // namespace coppice
