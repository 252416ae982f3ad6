// Any BRDF towards one viewer as Lambert and one modified Phong lobe about the mirror direction.
#pragma once

#include <coppice/brdf/brdf.hpp>
#include <coppice/lobe/phong_albedo.hpp>
#include <coppice/lobe/phong_table.hpp>

namespace coppice {

/// Towards one viewer: BRDF = diffuse/π + specular (n + 2)/2π max(0, mirror·ω)ⁿ.
struct PhongSurface {
  vec3 diffuse = vec3(0);   ///< linear RGB
  vec3 specular = vec3(0);  ///< linear RGB; may exceed 1 near the horizon, where the lobe's albedo is small
  float exponent = 1;       ///< n, [1, 1e5]
};

namespace detail {

/// Where x lies among the squares of 0, 1/steps … 1: the lower one's number, and the share of the next.
struct TablePlace {
  int index;
  float share;
};
inline TablePlace table_place(float x) {
  const float root = std::clamp(std::sqrt(x), 0.0f, 1.0f) * float(phong_steps);
  const int index = std::min(int(root), phong_steps - 1);
  const float low = float(index);
  return {index, (root * root - low * low) / (2 * low + 1)};
}

inline PhongEntry mix(const PhongEntry& a, const PhongEntry& b, float share) {
  const auto mixed = [&](float x, float y) { return x + share * (y - x); };
  return {mixed(a.variance, b.variance), mixed(a.root_albedo, b.root_albedo), mixed(a.flat, b.flat),
          mixed(a.root_fresnel, b.root_fresnel)};
}

inline PhongEntry look_up(const PhongTable& table, float alpha, float cosine) {
  const auto [row, down] = table_place(alpha);
  const auto [column, right] = table_place(cosine);
  return mix(mix(table[row][column], table[row][column + 1], right),
             mix(table[row + 1][column], table[row + 1][column + 1], right), down);
}

/// The fit of a lobe of width alpha; `diffuse` is the albedo of what is diffuse already.
inline PhongSurface fitted_phong(const PhongTable& table, float alpha, float cosine, const vec3& diffuse,
                                 const ShadingPoint& point) {
  const PhongEntry e = look_up(table, alpha, cosine);
  const float r2 = e.root_fresnel * e.root_fresnel, fresnel = r2 * r2 * e.root_fresnel;
  const float albedo = e.root_albedo * e.root_albedo;
  const float flat = std::min(e.flat, 1 - fresnel);  // all of it the specular term's: Fresnel's is narrow
  const vec3 lobe = (1 - fresnel - flat) * point.specular + fresnel * point.fresnel;
  PhongSurface surface;
  surface.exponent = valid_exponent(1 / (e.variance * alpha * alpha));
  surface.diffuse = diffuse + albedo * flat * point.specular;
  surface.specular = albedo / phong_albedo(surface.exponent, cosine) * lobe;
  return surface;
}

}  // namespace detail

/// What the point's BRDF is towards its viewer as Lambert and one Phong lobe; by reciprocity also how it
/// spreads the light that arrives from to_viewer, as a VPL does. Lambert and Phong are kept as they are. GGX,
/// Blinn-Phong and Ward are fitted (scripts/fit_phong.cpp): the Lambert term takes the tails and what is
/// rough, the lobe the rest. Together they keep the albedo for that viewer: within 1.5% for a metal, 2.5% for
/// a dielectric's lobe and Ward, 5% for Blinn-Phong, at viewer cosines from 0.1 and alpha from 0.05. GGX's
/// diffuse term is scaled by the mean of its Fresnel factor. Ward counts by its mean width.
///
/// Error ∫|f - fit| / ∫f of the lobe times the cosine, and the same for light from a Phong lobe of exponent
/// 50, for a GGX metal by alpha and viewer cosine:
///              1           0.8         0.6         0.4         0.2
///   0.05   31 / 9 %    36 / 11 %   46 / 13 %   64 / 15 %   100 / 17 %
///   0.1    23 / 8 %    32 / 15 %   43 / 19 %   60 / 23 %    94 / 29 %
///   0.3     4 / 2 %    20 / 17 %   25 / 19 %   35 / 24 %    49 / 33 %
///   0.5     1 / 1 %    16 / 15 %   13 / 11 %   16 / 12 %    23 / 18 %
///   1      13 / 12 %   15 / 14 %   18 / 16 %   21 / 20 %    27 / 25 %
/// The others: docs/lobe.md. Parameters outside the domains of shared/brdf.h are clamped. Cost: 0.1 µs.
inline PhongSurface phong_surface(const ShadingPoint& point) {
  const float cosine = std::min(brdf_viewer_to_local(point.normal, point.tangent, point.to_viewer).z, 1.0f);
  const float low = 1 - cosine;
  switch (point.brdf) {
    case BRDF_GGX:  // the diffuse term's Fresnel factor has this mean
      return detail::fitted_phong(detail::ggx_as_phong, valid_alpha(point.alpha_x), cosine,
                                  point.diffuse * (1 - low * low * (0.012f + 0.016f * low)), point);
    case BRDF_PHONG:
      return {point.diffuse, point.specular, valid_exponent(point.alpha_x)};
    case BRDF_BLINN_PHONG:
      return detail::fitted_phong(detail::blinn_phong_as_phong,
                                  std::sqrt(2 / (valid_exponent(point.alpha_x) + 2)), cosine, point.diffuse,
                                  point);
    case BRDF_WARD:
      return detail::fitted_phong(detail::ward_as_phong,
                                  std::sqrt(valid_alpha(point.alpha_x) * valid_alpha(point.alpha_y)), cosine,
                                  point.diffuse, point);
    default:
      return {point.diffuse, vec3(0), 1};
  }
}

}  // namespace coppice
