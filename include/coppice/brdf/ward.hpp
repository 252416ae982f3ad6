// Ward's anisotropic lobe, with bounded albedo.
#pragma once

#include <coppice/brdf/brdf.hpp>

namespace coppice {

/// brdf_ward of shared/brdf.h; the widths along and across the tangent are clamped to [BRDF_MIN_ALPHA, 1].
struct Ward : SeenSurface {
  static constexpr int terms = 2;
  float alpha_x, alpha_y;

  COPPICE_FUNCTION Ward(const SeenSurface& surface, float along, float across)
      : SeenSurface(surface), alpha_x(valid_alpha(along)), alpha_y(valid_alpha(across)) {}
  COPPICE_FUNCTION explicit Ward(const ShadingPoint& point)
      : Ward(seen_surface(point), point.alpha_x, point.alpha_y) {}

  COPPICE_FUNCTION_OF_REAL
  BrdfTerms<REAL> operator()(REAL x, REAL y, REAL z) const {
    return brdf_ward(x, y, z, viewer, alpha_x, alpha_y);
  }
  COPPICE_FUNCTION_OF_REAL
  FilteredTerms<REAL> filtered(REAL x, REAL y, REAL z, const LightSpread<REAL>& spread) const {
    return brdf_ward_filtered(x, y, z, spread, viewer, alpha_x, alpha_y);
  }
  vec3 evaluate(const vec3& wi, const vec3& wo) const { return brdf_value(*this, wi, wo); }
};
static_assert(Brdf<Ward>);

/// Fills the BRDF of the point: colours are linear RGB; where diffuse + specular <= 1 no energy is made.
inline void set_ward(ShadingPoint& point, const vec3& diffuse, const vec3& specular, float alpha_x,
                     float alpha_y) {
  point.brdf = BRDF_WARD;
  point.alpha_x = valid_alpha(alpha_x);
  point.alpha_y = valid_alpha(alpha_y);
  point.diffuse = diffuse;
  point.specular = specular;
  point.fresnel = vec3(0);
}

}  // namespace coppice
