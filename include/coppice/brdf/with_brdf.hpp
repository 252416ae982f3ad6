// From a shading point, which holds any BRDF, to code that is compiled for one.
#pragma once

#include <coppice/brdf/blinn_phong.hpp>
#include <coppice/brdf/ggx.hpp>
#include <coppice/brdf/lambert.hpp>
#include <coppice/brdf/phong.hpp>
#include <coppice/brdf/ward.hpp>
#include <coppice/core/config.hpp>
#include <utility>

namespace coppice {

/// f(brdf) with the point's BRDF as its own type; f must return the same type for each.
/// Precondition: point.brdf is a BRDF_ constant (otherwise Lambert, as brdf_terms does).
template <class F>
decltype(auto) with_brdf(const ShadingPoint& point, F&& f) {
  COPPICE_ASSERT(point.brdf <= BRDF_WARD);
  switch (point.brdf) {
    case BRDF_GGX:
      return std::forward<F>(f)(Ggx(point));
    case BRDF_PHONG:
      return std::forward<F>(f)(Phong(point));
    case BRDF_BLINN_PHONG:
      return std::forward<F>(f)(BlinnPhong(point));
    case BRDF_WARD:
      return std::forward<F>(f)(Ward(point));
    default:
      return std::forward<F>(f)(Lambert(point));
  }
}

}  // namespace coppice
