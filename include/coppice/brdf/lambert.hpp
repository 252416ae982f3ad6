// Lambert: the same radiance in every direction.
#pragma once

#include <coppice/brdf/brdf.hpp>

namespace coppice {

/// brdf_lambert of shared/brdf.h.
struct Lambert : SeenSurface {
  static constexpr int terms = 1;

  COPPICE_FUNCTION explicit Lambert(const SeenSurface& surface) : SeenSurface(surface) {}
  COPPICE_FUNCTION explicit Lambert(const ShadingPoint& point) : SeenSurface(seen_surface(point)) {}

  COPPICE_FUNCTION_OF_REAL
  BrdfTerms<REAL> operator()(REAL /*x*/, REAL /*y*/, REAL z) const { return brdf_lambert(z, viewer); }
  COPPICE_FUNCTION_OF_REAL
  FilteredTerms<REAL> filtered(REAL /*x*/, REAL /*y*/, REAL z, const LightSpread<REAL>& spread) const {
    return brdf_lambert_filtered(z, spread, viewer);
  }
  vec3 evaluate(const vec3& wi, const vec3& wo) const { return brdf_value(*this, wi, wo); }
};
static_assert(Brdf<Lambert>);

/// Fills the BRDF of the point; albedo in [0, 1], linear RGB.
inline void set_lambert(ShadingPoint& point, const vec3& albedo) {
  point.brdf = BRDF_LAMBERT;
  point.alpha_x = point.alpha_y = 1;
  point.diffuse = albedo;
  point.specular = point.fresnel = vec3(0);
}

}  // namespace coppice
