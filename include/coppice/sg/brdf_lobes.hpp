// The lobe of a BRDF towards one viewer as a sum of up to three Gaussians above the horizon.
#pragma once

#include <coppice/brdf/brdf.hpp>
#include <coppice/sg/blinn_phong_table.hpp>
#include <coppice/sg/ggx_table.hpp>
#include <coppice/sg/lobe_integral.hpp>
#include <coppice/sg/phong_table.hpp>
#include <coppice/sg/ward_table.hpp>

namespace coppice {

/// How the lobe of a BRDF becomes Gaussians.
enum class LobeFit {
  fitted,  ///< by the tables of scripts/fit_gaussians.cpp
  warped   ///< one about the mirror direction, the Gaussian of the distribution of normals (Wang et al. 2009)
};

/// Lambert's cos/π, exactly: a Gaussian of sharpness 0 times the cosine.
inline BrdfLobes lambert_lobes(const vec3& viewer) {
  BrdfLobes lobes;
  lobes.viewer = viewer;
  lobes.times_cosine = true;
  lobes.count = 1;
  lobes.lobes[0] = {{vec3(0, 0, 1), 0}, 1 / pi, 0};
  return lobes;
}

namespace detail {

/// What the viewer in the local frame makes of the plane of incidence.
struct IncidencePlane {
  vec3 mirror;  ///< unit
  vec3 up;      ///< unit, across the mirror direction, towards the normal
  vec3 across;  ///< unit, across the plane
};

inline IncidencePlane incidence_plane(const vec3& viewer) {
  const float sine = std::sqrt(viewer.x * viewer.x + viewer.y * viewer.y);
  const vec3 along = sine > 1e-12f ? vec3(viewer.x / sine, viewer.y / sine, 0) : vec3(1, 0, 0);
  return {vec3(-viewer.x, -viewer.y, viewer.z), along * viewer.z + vec3(0, 0, sine),
          vec3(-along.y, along.x, 0)};
}

/// The unit direction `angle` radians from the mirror direction towards the normal, but not below the
/// horizon.
inline vec3 turned_up(const IncidencePlane& plane, float angle) {
  const vec3 d = plane.mirror * std::cos(angle) + plane.up * std::sin(angle);
  return d.z < 0 ? normalize_or(vec3(d.x, d.y, 0), plane.mirror) : d;
}

/// The Gaussians of a table's entry for width alpha; each has its share of the albedo above the horizon.
template <int Lobes>
BrdfLobes table_lobes(const GaussianTable<Lobes>& table, uint kind, float alpha, const vec3& viewer) {
  GaussianEntry<Lobes> entry = look_up<Lobes>(table, alpha, viewer.z);
  if (kind == BRDF_BLINN_PHONG) entry.albedo *= entry.shrink * entry.shrink;
  const IncidencePlane plane = incidence_plane(viewer);
  BrdfLobes lobes;
  lobes.viewer = viewer;
  lobes.across = plane.across;
  lobes.count = Lobes;
  for (int k = 0; k < Lobes; ++k) {
    const GaussianFit& fit = entry.lobes[std::size_t(k)];
    const float sharpness = std::exp(fit.log_sharpness) / (2 * alpha * alpha);
    BrdfLobe& lobe = lobes.lobes[std::size_t(k)];
    lobe = {{turned_up(plane, alpha * fit.tilt), sharpness}, 1, sharpness * std::expm1(fit.log_ratio)};
    lobe.amplitude = entry.albedo * fit.share / lobe_energy(lobes, lobe);
  }
  return lobes;
}

/// Phong's power as two Gaussians, one of them negative, times the cosine.
inline BrdfLobes phong_lobes(float exponent, const vec3& viewer) {
  const PhongFit fit = phong_fit(phong_power, exponent);
  const IncidencePlane plane = incidence_plane(viewer);
  const float sharpness = exponent * std::exp(fit.log_sharpness), second = fit.share / exponent;
  const float scale = (exponent + 2) / (exponent + 1);
  BrdfLobes lobes;
  lobes.viewer = viewer;
  lobes.times_cosine = true;
  lobes.count = 2;
  lobes.across = plane.across;
  lobes.lobes[0] = {{plane.mirror, sharpness}, scale * (1 - second) * sg_normalisation(sharpness), 0};
  lobes.lobes[1] = {{plane.mirror, phong_ratio * sharpness}, 0, 0};
  lobes.lobes[1].amplitude = scale * second * sg_normalisation(phong_ratio * sharpness);
  return lobes;
}

inline BrdfLobes fitted_lobes(uint kind, float alpha_x, float alpha_y, const vec3& viewer) {
  switch (kind) {
    case BRDF_GGX:
      return table_lobes<3>(ggx_gaussians, kind, alpha_x, viewer);
    case BRDF_PHONG:
      return phong_lobes(alpha_x, viewer);
    case BRDF_BLINN_PHONG:
      return table_lobes<2>(blinn_phong_gaussians, kind, std::sqrt(2 / (alpha_x + 2)), viewer);
    default:
      return table_lobes<2>(ward_gaussians, kind, std::sqrt(alpha_x * alpha_y), viewer);
  }
}

/// The lobe's sharpness in half vectors, over 4 times the cosine of the viewer, which is how fast the half
/// vector turns with the light; its height is the BRDF's.
inline BrdfLobes warped_lobes(uint kind, float alpha_x, float alpha_y, const vec3& viewer) {
  const IncidencePlane plane = incidence_plane(viewer);
  const BrdfTerms<float> terms =
      brdf_terms<float>(kind, alpha_x, alpha_y, plane.mirror.x, plane.mirror.y, plane.mirror.z, viewer);
  const float halved = 1 / (4 * viewer.z);
  const float sharpness = kind == BRDF_PHONG         ? alpha_x
                          : kind == BRDF_BLINN_PHONG ? alpha_x * halved
                                                     : 2 / (alpha_x * alpha_y) * halved;
  BrdfLobes lobes;
  lobes.viewer = viewer;
  lobes.across = plane.across;
  lobes.count = 1;
  lobes.lobes[0] = {{plane.mirror, sharpness}, terms.specular + terms.fresnel, 0};
  return lobes;
}

}  // namespace detail

/// The Gaussians whose sum is like the lobe of a BRDF times the cosine (BrdfTerms' specular + fresnel) over
/// the directions of the light, towards a viewer in the local frame of shared/brdf.h; none for Lambert, whose
/// lobe is lambert_lobes. `kind` and the widths are those of a ShadingPoint; Ward counts by its mean width.
/// GGX: three elongated Gaussians, Blinn-Phong and Ward two, by table over alpha and the viewer's cosine, all
/// positive, of the lobe's albedo; Phong: two about the mirror direction times the cosine. Viewers below
/// BRDF_MIN_COSINE and parameters outside their domain are clamped.
/// Error: docs/sg_materials.md. Cost: 0.6 µs (GGX), 0.4 (Blinn-Phong, Ward), 0.03 (Phong).
inline BrdfLobes brdf_lobes(uint kind, float alpha_x, float alpha_y, const vec3& viewer,
                            LobeFit fit = LobeFit::fitted) {
  const vec3 seen =
      normalize_or(vec3(viewer.x, viewer.y, std::max(viewer.z, BRDF_MIN_COSINE)), vec3(0, 0, 1));
  const bool power = kind == BRDF_PHONG || kind == BRDF_BLINN_PHONG;
  const float x = power ? valid_exponent(alpha_x) : valid_alpha(alpha_x);
  const float y = kind == BRDF_WARD ? valid_alpha(alpha_y) : x;
  BrdfLobes none;
  none.viewer = seen;
  if (kind == BRDF_LAMBERT || kind > BRDF_WARD) return none;
  BrdfLobes lobes = fit == LobeFit::warped ? detail::warped_lobes(kind, x, y, seen)
                                           : detail::fitted_lobes(kind, x, y, seen);
  lobes.schlick = kind == BRDF_GGX;
  return lobes;
}

/// The same for a point that is shaded.
inline BrdfLobes brdf_lobes(const ShadingPoint& point, LobeFit fit = LobeFit::fitted) {
  return brdf_lobes(point.brdf, point.alpha_x, point.alpha_y,
                    brdf_viewer_to_local(point.normal, point.tangent, point.to_viewer), fit);
}

}  // namespace coppice
