// The shadowed direct light that arrives at each VPL: how much, from where, and from how many sides.
#pragma once

#include <coppice/light/direct_irradiance.hpp>
//
#include <coppice/core/config.hpp>
#include <coppice/core/parallel.hpp>
#include <coppice/light/bounce.hpp>

namespace coppice {

/// What a VPL receives of all lights. Its mean direction, (1 - shortfall) · direction, is Σ w ω / Σ w over
/// the lights that reach it, ω the unit direction to one and w the luminance of its irradiance: what a lobe
/// of many lights' reflections is merged from (Filtering sections 2.1 and 2.4). In the dark: no irradiance, a
/// shortfall of 1, and the VPL's normal.
struct VplLight {
  vec3 irradiance{0};       ///< W/m², linear RGB
  float shortfall = 1;      ///< 1 - |mean direction|, in [0, 1]; absolute error 1e-14, then rounded
  vec3 direction{0, 0, 1};  ///< unit, towards the light
};

namespace detail {

/// Adds up, in double, what reaches one point from many lights.
class VplLightSum {
 public:
  /// `towards` need not be unit.
  void add(const vec3& irradiance, const glm::dvec3& towards) {
    const glm::dvec3 e(irradiance);
    const double weight = 0.2126 * e.x + 0.7152 * e.y + 0.0722 * e.z;
    irradiance_ += e, weight_ += weight, arriving_ += weight * normalize(towards);
  }

  VplLight mean(const vec3& normal) const {
    const double size = length(arriving_);
    if (!(size > 0)) return {vec3(irradiance_), 1, normal};
    return {vec3(irradiance_), float(std::clamp(1 - size / weight_, 0.0, 1.0)), vec3(arriving_ / size)};
  }

 private:
  glm::dvec3 irradiance_{0}, arriving_{0};
  double weight_ = 0;
};

}  // namespace detail

}  // namespace coppice

namespace coppice::inline HWY_NAMESPACE {

/// Lights the VPLs for a frame. Exact up to `most_rays` lights; beyond, that many are drawn for each VPL as
/// DirectIrradiance says, by its index: the same lights give the same bits in each frame and for any
/// executor. Cost: a shadow ray a VPL and light above its horizon. Precondition: out has the VPLs' size.
template <Occluder O, Executor E>
void light_vpls(std::span<const SurfaceSample> vpls, std::span<const LocalLight> lights, const O& occluder,
                const E& executor, std::span<VplLight> out, std::size_t most_rays = 1024) {
  COPPICE_ASSERT(out.size() == vpls.size());
  const DirectIrradiance direct(lights, most_rays);
  executor(vpls.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const vec3 origin = ray_origin(vpls[i]);
      Random random(Random(i).bits());
      detail::VplLightSum sum;
      direct.for_each_free(
          occluder, origin, vpls[i].normal, random, [&](std::size_t l, const vec3& irradiance) {
            sum.add(irradiance, glm::dvec3(lights[l].position) - double(lights[l].w) * glm::dvec3(origin));
          });
      out[i] = sum.mean(vpls[i].normal);
    }
  });
}

}  // namespace coppice::inline HWY_NAMESPACE
