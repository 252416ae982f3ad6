// Lobes as sums of elongated Gaussians above the horizon, and their integrals against a Gaussian of light.
#pragma once

#include <coppice/shared/brdf.h>
#include <coppice/shared/sg.h>

#include <algorithm>
#include <array>

namespace coppice {

/// amplitude · exp(-λ |d - p|²/2 - stripe (d·y)²/2), p the axis, y the direction across of its BrdfLobes: a
/// Gaussian that is narrower across the plane of incidence than in it, λ + stripe against λ.
struct BrdfLobe {
  SgShape shape;        ///< local frame; the axis is not below the horizon
  float amplitude = 0;  ///< 1/sr
  float stripe = 0;     ///< >= 0
};

/// A lobe of a BRDF towards one viewer: the sum of its Gaussians where d.z > 0, and 0 below. Local frame of
/// shared/brdf.h.
struct BrdfLobes {
  std::array<BrdfLobe, 3> lobes{};  ///< the first `count` are meant
  int count = 0;
  vec3 viewer = vec3(0, 0, 1);  ///< unit
  vec3 across = vec3(0, 1, 0);  ///< unit, across viewer and normal: no lobe's axis leaves the plane
  bool times_cosine = false;    ///< each Gaussian times d.z; then no stripes
  bool schlick = false;         ///< Fresnel changes over the lobe: BrdfTerms has fresnel and specular
};

/// The sum at a unit direction of the local frame.
inline float lobes_value(const BrdfLobes& lobes, const vec3& d) {
  if (!(d.z > 0)) return 0;
  const float across = dot(d, lobes.across);
  float sum = 0;
  for (int k = 0; k < lobes.count; ++k) {
    const BrdfLobe& lobe = lobes.lobes[std::size_t(k)];
    sum += lobe.amplitude * std::exp(-0.5f * (lobe.shape.sharpness * sg_squared_distance(lobe.shape.axis, d) +
                                              lobe.stripe * across * across));
  }
  return lobes.times_cosine ? sum * d.z : sum;
}

/// An integral of a lobe times light, and the direction that most of it comes from.
struct LobeIntegral {
  float value;
  vec3 direction;  ///< unit
};

namespace detail {

/// Where exp(-λ |d - p|²/2 - stripe (d·y)²/2) is greatest, as the sine and cosine of the angle that d makes
/// with the plane across y.
struct StripePeak {
  float sine, cosine;
  float curvature;  ///< minus the second derivative of the exponent by that angle, > 0
  float exponent;   ///< <= 0
};

/// Newton's method from the peak of a Gaussian in place of the stripe. `sine` and `cosine` are those of p.
inline StripePeak stripe_peak(float sharpness, float stripe, float sine, float cosine) {
  float s = sharpness * sine, c = sharpness * cosine + stripe;
  float size = std::sqrt(s * s + c * c);
  for (int step = 0; step < 3; ++step) {
    s /= size, c /= size;
    const float apart = sine * c - cosine * s, near = cosine * c + sine * s;
    const float slope = sharpness * apart - stripe * s * c;
    const float bend = sharpness * near + stripe * (c * c - s * s);
    const float floor = 0.1f * (sharpness + stripe * c * c);
    const float curvature = std::max(bend, floor);
    if (step == 2) return {s, c, curvature, -sharpness * apart * apart / (1 + near) - 0.5f * stripe * s * s};
    const float turn = std::clamp(slope / curvature, -0.5f, 0.5f);
    const float turned = s + turn * c;
    c = std::max(c - turn * s, 1e-6f), s = turned, size = std::sqrt(s * s + c * c);
  }
  return {};
}

/// ∫ G · exp(-bend s²/2) / ∫ G over the sphere, s the sine of the angle to a plane through the axis of G. The
/// second moment of G gives it for little bend, the mean of G in the plane for much. Error below 1%.
inline float stripe_narrowing(float sharpness, float bend) {
  const float little = sharpness > 1e-3f ? sharpness / sg_mean_length(sharpness) : 3.0f;
  const float much = sharpness + 0.25f + 1.321f * std::exp(-0.83f * sharpness);
  const float width = bend > 0 ? (little * little + much * bend) / (little + bend) : little;
  return std::sqrt(width / std::max(width + bend, 0.1f * width));
}

/// ∫ over d.z > 0 of the Gaussian of `product`, without its scale, times the stripe, over sg_integral of its
/// sharpness. By the angle to the plane across y the integral has one dimension, and the integrand is nearly
/// a Gaussian of that angle. Exact without a stripe but for
/// sg_hemisphere_share_fast.
inline LobeIntegral stripe_share(const SgProduct& product, float stripe, const vec3& across) {
  if (!(stripe > 0)) return {sg_hemisphere_share_fast(product.axis.z, product.sharpness), product.axis};
  const float sine = std::clamp(dot(product.axis, across), -1.0f, 1.0f);
  const float cosine = std::sqrt(std::max(1 - sine * sine, 1e-8f));
  const StripePeak peak = stripe_peak(product.sharpness, stripe, sine, cosine);
  const float wider = peak.cosine / cosine;  // the circle about y through the peak, against that of the axis
  const float height = std::exp(peak.exponent) * std::sqrt(wider) *
                       stripe_narrowing(product.sharpness, peak.curvature - product.sharpness);
  const float above = sg_hemisphere_share_fast(product.axis.z, product.sharpness * wider);
  return {height * above, (product.axis - sine * across) * wider + peak.sine * across};
}

}  // namespace detail

/// ∫ over the directions above the horizon of one of the lobe's Gaussians times a Gaussian of light
/// (amplitude 1, local frame), in closed form. Never negative for a positive amplitude, never NaN. Error
/// against the quadrature of the same Gaussians: docs/sg_materials.md.
inline LobeIntegral lobe_integral(const BrdfLobes& lobes, const BrdfLobe& lobe, const SgShape& light) {
  const SgProduct product = sg_product(lobe.shape, light);
  const float scale = lobe.amplitude * product.scale * sg_integral(product.sharpness);
  if (lobes.times_cosine)
    return {scale * sg_mean_cosine_fast(product.axis.z, product.sharpness), product.axis};
  const LobeIntegral share = detail::stripe_share(product, lobe.stripe, lobes.across);
  return {scale * share.value, share.direction};
}

/// ∫ of one of the lobe's Gaussians above the horizon: its integral against even light.
inline float lobe_energy(const BrdfLobes& lobes, const BrdfLobe& lobe) {
  return lobe_integral(lobes, lobe, {vec3(0, 0, 1), 0}).value;
}

/// ∫ of the whole lobe times a Gaussian of light; Σ of lobe_integral.
inline float lobes_integral(const BrdfLobes& lobes, const SgShape& light) {
  float sum = 0;
  for (int k = 0; k < lobes.count; ++k) sum += lobe_integral(lobes, lobes.lobes[std::size_t(k)], light).value;
  return sum;
}

namespace detail {

/// Schlick's (1 - h·wo)⁵ for light from d, lifted above the horizon.
inline float schlick_towards(const vec3& viewer, const vec3& d) {
  return brdf_schlick(length(normalize_or(vec3(d.x, d.y, std::max(d.z, 0.0f)), vec3(0, 0, 1)) + viewer));
}

}  // namespace detail

/// The terms of shared/brdf.h integrated against a Gaussian of light, so that
///   ∫ BRDF · cos · G = diffuse · coefficient 0 + specular · coefficient 1 + fresnel · coefficient 2.
/// Fresnel's factor is taken where the product of Gaussian and light is greatest.
inline BrdfTerms<float> gaussian_terms(const BrdfLobes& lobes, const SgShape& light) {
  BrdfTerms<float> terms{};
  terms.diffuse = sg_integral(light.sharpness) * sg_mean_cosine_fast(light.axis.z, light.sharpness) / pi;
  for (int k = 0; k < lobes.count; ++k) {
    const LobeIntegral part = lobe_integral(lobes, lobes.lobes[std::size_t(k)], light);
    const float w = lobes.schlick ? detail::schlick_towards(lobes.viewer, part.direction) : 0.0f;
    terms.fresnel += w * part.value;
    terms.specular += (1 - w) * part.value;
  }
  if (lobes.schlick) {  // the cosine as a Gaussian of sharpness 2 about the normal
    const SgProduct lit = sg_product(light, {vec3(0, 0, 1), 2});
    terms.diffuse *= 1 - detail::schlick_towards(lobes.viewer, lit.axis);
  }
  return terms;
}

}  // namespace coppice
