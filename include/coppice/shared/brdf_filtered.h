// The reflectance functions (BRDFs) over a cluster of lights: their mean, to the order that the lights'
// spread tells. Conventions and unfiltered forms are those of brdf.h. The stated errors are those of float
// against long double at the same inputs (tests/shared/brdf_filtered.cpp), over all z > 0, wo.z >=
// BRDF_MIN_COSINE and every spread in [0, 1].
#ifndef COPPICE_SHARED_BRDF_FILTERED_H
#define COPPICE_SHARED_BRDF_FILTERED_H
#include <coppice/shared/brdf.h>

COPPICE_BEGIN

/// How the light of a cluster spreads about its mean direction: `mean_length` is that of the mean of the unit
/// directions, in (0, 1], and `widening` = (1 - mean_length)/mean_length, one over the sharpness of a lobe
/// that spreads as much. One light has (1, 0).
COPPICE_STRUCT_OF_REAL struct LightSpread {
  REAL mean_length;
  REAL widening;
};

/// The terms of a cluster: the BRDF's mean over its lights, to the order that their spread tells.
/// `growth` is by how much the spread widens the lobe, as a share of the lobe's own squared width: where it
/// is small the lobe does not tell the lights apart.
COPPICE_STRUCT_OF_REAL struct FilteredTerms {
  REAL diffuse;
  REAL specular;
  REAL fresnel;
  REAL growth;
};

/// From LightNode::spread = 1 - mean_length, in [0, 1]. A cluster that shines from all sides alike counts as
/// widened 10^4 times. Error: mean_length 6e-8, widening 2e-7 of it.
COPPICE_FUNCTION_OF_REAL COPPICE_OF_REAL(LightSpread) light_spread(REAL one_minus_length) {
  COPPICE_OF_REAL(LightSpread) spread;
  spread.mean_length = 1.0f - one_minus_length;
  spread.widening = one_minus_length / max(spread.mean_length, REAL(1e-4f));
  return spread;
}

/// Lambert's mean over a cluster, which is exact where all its lights lie above the horizon: the cosine is
/// linear in the direction, so that the mean of the cosines is the cosine of the mean; less than it where the
/// horizon cuts the cluster. Error: 2e-7 of cos/π.
COPPICE_FUNCTION_OF_REAL COPPICE_OF_REAL(FilteredTerms)
    brdf_lambert_filtered(REAL z, COPPICE_OF_REAL(LightSpread) spread, vec3 wo) {
  COPPICE_OF_REAL(FilteredTerms) terms;
  terms.diffuse = brdf_cosine(z, wo) * spread.mean_length * REAL(0.31830988618379067);
  terms.specular = REAL(0.0f);
  terms.fresnel = REAL(0.0f);
  terms.growth = REAL(0.0f);
  return terms;
}

/// brdf_ggx's mean over a cluster, by a wider D: alpha² + 1.5 widening/|h| in place of alpha². A direction to
/// the light that turns by δ turns h by δ/2 in the plane of wi and wo and by δ/|h| across it, a variance of
/// widening/2|h| in the geometric mean of both. A Gaussian lobe of squared width alpha² would grow by twice
/// that; GGX's peak falls faster, its tail slower: 1.5, fitted, about halves the error of 1 (docs/brdf.md).
/// Shadowing and Fresnel are those at the mean direction; alpha² stops at 1. Domain: alpha in [1e-3, 1].
/// Error: diffuse 3e-7 of cos/π; specular and fresnel 1e-6 of their sum; growth 5e-7 of it.
COPPICE_FUNCTION_OF_REAL COPPICE_OF_REAL(FilteredTerms)
    brdf_ggx_filtered(REAL x, REAL y, REAL z, COPPICE_OF_REAL(LightSpread) spread, vec3 wo, float alpha) {
  const COPPICE_SCALAR alpha2 = COPPICE_SCALAR(alpha) * COPPICE_SCALAR(alpha);
  const REAL light = brdf_cosine(z, wo);
  const REAL shadowing = brdf_ggx_shadowing(light, wo, alpha2);
  const REAL hx = x + wo.x;
  const REAL hy = y + wo.y;
  const REAL hz = light + COPPICE_SCALAR(max(wo.z, BRDF_MIN_COSINE));
  const REAL across = mul_add(hx, hx, hy * hy);
  const REAL along = hz * hz;
  const REAL h2 = across + along;
  const REAL h = sqrt(h2);
  // All of D times |h|, so that one division gives both the lobe and 1/|h|; and times 2^36, without which its
  // square is denormal at grazing angles.
  const COPPICE_SCALAR scale = 68719476736.0f;
  const REAL scaled_h = h * scale;
  const REAL more = spread.widening * COPPICE_SCALAR(1.5f);
  const REAL wide = min(mul_add(h, REAL(alpha2 * scale), more * scale), scaled_h);
  const REAL width = mul_add(along, wide, across * scaled_h);
  const REAL below = width * width * shadowing;
  const REAL inverse = 1.0f / (below * h);
  const REAL lobe =
      light * (h2 * h2) * (inverse * (scale * COPPICE_SCALAR(0.15915494309189534))) * (h2 * wide);
  const REAL w = brdf_schlick(h);
  COPPICE_OF_REAL(FilteredTerms) terms;
  terms.diffuse = (1.0f - w) * light * spread.mean_length * REAL(0.31830988618379067);
  terms.fresnel = w * lobe;
  terms.specular = lobe - terms.fresnel;
  terms.growth = more * below * inverse * (1.0f / alpha2);
  return terms;
}

/// brdf_phong's mean over a cluster: 1/exponent + widening in place of 1/exponent (Filtering Eq. 4).
/// Domain: exponent in [1, 1e5]. Error: diffuse 2e-7 of cos/π; specular relative 2e-5 where it is at least
/// 1e-3, absolute 2e-8 below; growth 2e-7 of it. Within |r·wo| < 0.01, where a lobe widened to an exponent
/// below 1 falls to 0 as a step, rounding may take either side of the step.
COPPICE_FUNCTION_OF_REAL COPPICE_OF_REAL(FilteredTerms)
    brdf_phong_filtered(REAL x, REAL y, REAL z, COPPICE_OF_REAL(LightSpread) spread, vec3 wo,
                        float exponent) {
  COPPICE_OF_REAL(FilteredTerms) terms;
  terms.growth = REAL(exponent) * spread.widening;
  terms.diffuse = brdf_cosine(z, wo) * spread.mean_length * REAL(0.31830988618379067);
  terms.specular = brdf_phong_lobe(x, y, z, wo, REAL(exponent) / (1.0f + terms.growth));
  terms.fresnel = REAL(0.0f);
  return terms;
}

/// brdf_blinn_phong's mean over a cluster: 1/k + widening/(2 |h|) in place of 1/k, the variance of h, and a
/// peak that falls as the variance grows. Domain: exponent in [1, 1e5]. Error: diffuse 2e-7 of cos/π;
/// specular relative 3e-5 down to 1e-25; growth 4e-7 of it.
COPPICE_FUNCTION_OF_REAL COPPICE_OF_REAL(FilteredTerms)
    brdf_blinn_phong_filtered(REAL x, REAL y, REAL z, COPPICE_OF_REAL(LightSpread) spread, vec3 wo,
                              float exponent) {
  COPPICE_OF_REAL(FilteredTerms) terms;
  terms.growth = 0.5f * REAL(exponent) * spread.widening / brdf_half_length(x, y, z, wo);
  terms.diffuse = brdf_cosine(z, wo) * spread.mean_length * REAL(0.31830988618379067);
  const REAL narrower = 1.0f / (1.0f + terms.growth);
  terms.specular = brdf_blinn_phong_lobe(x, y, z, wo, REAL(exponent) * narrower) * narrower *
                   brdf_blinn_phong_scale(COPPICE_SCALAR(exponent));
  terms.fresnel = REAL(0.0f);
  return terms;
}

/// brdf_ward's mean over a cluster: both squared widths grow by widening/|h|, as in brdf_ggx_filtered.
/// Domain: alpha_x, alpha_y in [1e-3, 1]. Error: diffuse 2e-7 of cos/π; specular relative 2e-5 down to 1e-10,
/// absolute 1e-12 below; growth 4e-7 of it.
COPPICE_FUNCTION_OF_REAL COPPICE_OF_REAL(FilteredTerms)
    brdf_ward_filtered(REAL x, REAL y, REAL z, COPPICE_OF_REAL(LightSpread) spread, vec3 wo, float alpha_x,
                       float alpha_y) {
  const REAL more = spread.widening / brdf_half_length(x, y, z, wo);
  const REAL alpha_x2 = REAL(alpha_x) * REAL(alpha_x);
  const REAL alpha_y2 = REAL(alpha_y) * REAL(alpha_y);
  COPPICE_OF_REAL(FilteredTerms) terms;
  terms.growth = more / (REAL(alpha_x) * REAL(alpha_y));
  terms.diffuse = brdf_cosine(z, wo) * spread.mean_length * REAL(0.31830988618379067);
  terms.specular = brdf_ward_lobe(x, y, z, wo, alpha_x2 + more, alpha_y2 + more);
  terms.fresnel = REAL(0.0f);
  return terms;
}

/// The terms of any kind over a cluster, as brdf_terms.
COPPICE_FUNCTION_OF_REAL COPPICE_OF_REAL(FilteredTerms)
    brdf_filtered_terms(uint kind, float alpha_x, float alpha_y, REAL x, REAL y, REAL z,
                        COPPICE_OF_REAL(LightSpread) spread, vec3 wo) {
  switch (kind) {
    case BRDF_GGX:
      return brdf_ggx_filtered(x, y, z, spread, wo, alpha_x);
    case BRDF_PHONG:
      return brdf_phong_filtered(x, y, z, spread, wo, alpha_x);
    case BRDF_BLINN_PHONG:
      return brdf_blinn_phong_filtered(x, y, z, spread, wo, alpha_x);
    case BRDF_WARD:
      return brdf_ward_filtered(x, y, z, spread, wo, alpha_x, alpha_y);
    default:
      return brdf_lambert_filtered(z, spread, wo);
  }
}

COPPICE_END
#endif
