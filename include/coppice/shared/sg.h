// Spherical Gaussians as closed forms for C++ and GLSL.
//
// A Gaussian of axis p and sharpness λ is G(d) = exp(λ (d·p - 1)) = exp(-λ |d - p|²/2) over unit directions d
// (SG Eq. 3), times an amplitude. The first form loses the digits of 1 - d·p: 12% at λ = 1e6. Domain: λ in
// {0} and [1e-8, 1e10]. Errors are those of float (tests/shared/sg.cpp), relative where the exact value is at
// least 1e-30 (Lanes: 2e-29); below, the results fade and are never NaN.
#ifndef COPPICE_SHARED_SG_H
#define COPPICE_SHARED_SG_H
#include <coppice/shared/language.h>

COPPICE_BEGIN

#ifndef COPPICE_GLSL
using std::atan;
using std::sin;
#endif

COPPICE_CONST float SG_MAX_SHARPNESS = 1e10f;        ///< of the forms
COPPICE_CONST float SG_MAX_MOMENT_SHARPNESS = 1e7f;  ///< of sg_from_moments: what a float's length can tell
COPPICE_CONST float SG_HALF_LN_2 = 0.34657359f;      ///< least sharpness that falls to a half anywhere

/// A Gaussian without its amplitude.
struct SgShape {
  vec3 axis;        ///< unit
  float sharpness;  ///< λ >= 0
};

/// A Gaussian that shines: the radiance amplitude · G(d) from direction d.
struct SgLight {
  vec3 axis;  ///< unit, towards the light
  float sharpness;
  vec3 amplitude;   ///< linear RGB; may be negative
  float luminance;  ///< of the amplitude's absolute value, times the integral: what culling needs
};

/// A Gaussian and a factor.
struct SgProduct {
  vec3 axis;
  float sharpness;
  float scale;
};

/// (1 - e^-x)/x, 1 at 0: the mean of e^-t over [0, x]. Domain: x >= 0. Relative error 3e-7.
COPPICE_FUNCTION_OF_REAL REAL sg_mean_decay(REAL x) {
  const REAL s = min(x, REAL(0.25f));
  const REAL near =
      1.0f - s * (0.5f - s * (1.0f / 6.0f - s * (1.0f / 24.0f - s * (1.0f / 120.0f - s * (1.0f / 720.0f)))));
  return select(x < 0.25f, near, (1.0f - exp(-x)) / max(x, REAL(0.25f)));
}

/// ∫ G over the sphere, 2π (1 - e^-2λ)/λ; 4π at λ = 0. Relative error 5e-7.
COPPICE_FUNCTION_OF_REAL REAL sg_integral(REAL sharpness) {
  return COPPICE_SCALAR(12.566370614359172) * sg_mean_decay(2.0f * sharpness);
}

/// The amplitude that makes the integral 1 (von Mises and Fisher's density). Relative error 5e-7.
COPPICE_FUNCTION_OF_REAL REAL sg_normalisation(REAL sharpness) { return 1.0f / sg_integral(sharpness); }

/// x² + y² + z².
COPPICE_FUNCTION_OF_REAL REAL sg_squared(REAL x, REAL y, REAL z) {
  return mul_add(x, x, mul_add(y, y, z * z));
}

/// |a - b|² of unit vectors, a = (x, y, z), less what rounding adds to their lengths: 1e-4 in G at λ = 1e10.
COPPICE_FUNCTION_OF_REAL REAL sg_squared_distance(REAL x, REAL y, REAL z, vec3 b) {
  const REAL dx = x - b.x;
  const REAL dy = y - b.y;
  const REAL dz = z - b.z;
  const REAL sx = x + b.x;
  const REAL sy = y + b.y;
  const REAL sz = z + b.z;
  const REAL radial = mul_add(dx, sx, mul_add(dy, sy, dz * sz));
  const REAL sum2 = sg_squared(sx, sy, sz);
  const REAL apart2 = sg_squared(dx, dy, dz);
  const REAL longer = 1.0f - 0.25f * (apart2 + sum2);  // 1 - the mean of the squared lengths
  return mul_add(apart2, longer, apart2) - radial * radial / max(sum2, REAL(1.0f));
}
COPPICE_FUNCTION float sg_squared_distance(vec3 a, vec3 b) { return sg_squared_distance(a.x, a.y, a.z, b); }

/// G(d) of the Gaussian about (x, y, z), or of that about d at (x, y, z). Relative error 1e-5.
COPPICE_FUNCTION_OF_REAL REAL sg_evaluate(REAL x, REAL y, REAL z, REAL sharpness, vec3 d) {
  return exp(-0.5f * sharpness * sg_squared_distance(x, y, z, d));
}
COPPICE_FUNCTION float sg_evaluate(SgShape g, vec3 d) {
  return exp(-0.5f * g.sharpness * sg_squared_distance(g.axis, d));
}

/// The product of two Gaussians is scale · G' (exactly): λ' = |λ₁p₁ + λ₂p₂|. The exponent of the scale,
/// λ' - λ₁ - λ₂, cancels; λ₁λ₂|p₁ - p₂|²/(λ' + λ₁ + λ₂) is the same and does not. Relative error of the scale
/// 2e-5, of the sharpness 3e-7 of λ₁ + λ₂. Of equal and opposed ones the axis is that of a.
COPPICE_FUNCTION SgProduct sg_product(SgShape a, SgShape b) {
  const vec3 r = a.sharpness * a.axis + b.sharpness * b.axis;
  SgProduct product;
  product.sharpness = length(r);
  const float sum = max(product.sharpness + a.sharpness + b.sharpness, 1e-30f);
  product.scale = exp(-a.sharpness * (b.sharpness / sum) * sg_squared_distance(a.axis, b.axis));
  product.axis = product.sharpness > 0.0f ? r / product.sharpness : a.axis;
  return product;
}

/// ∫ of a product of Gaussians of |Σλp|, Σλ and Σ λᵢλⱼ|pᵢ - pⱼ|² over pairs (SG Eq. 4 overflows at Σλ = 90).
COPPICE_FUNCTION_OF_REAL REAL sg_product_integral(REAL resultant, REAL sum, REAL pairs) {
  return exp(-pairs / max(resultant + sum, REAL(1e-30f))) * sg_integral(resultant);
}

/// ∫ G₁G₂, which is also the convolution of the two at the angle between their axes; G₁ about (x, y, z).
/// |λ₁p₁ + λ₂p₂|² = (λ₁ - λ₂)² + λ₁λ₂|p₁ + p₂|² keeps its digits of opposed axes, too. Relative error 2e-5.
COPPICE_FUNCTION_OF_REAL REAL sg_inner_product(REAL x, REAL y, REAL z, REAL l, SgShape b) {
  const REAL more = l - b.sharpness;
  const REAL both = l * b.sharpness;
  const REAL sum2 = sg_squared(x + b.axis.x, y + b.axis.y, z + b.axis.z);
  const REAL resultant = sqrt(mul_add(both, sum2, more * more));
  return sg_product_integral(resultant, l + b.sharpness, both * sg_squared_distance(x, y, z, b.axis));
}
COPPICE_FUNCTION float sg_inner_product(SgShape a, SgShape b) {
  return sg_inner_product(a.axis.x, a.axis.y, a.axis.z, a.sharpness, b);
}

/// ∫ G₁G₂G₃ (SG Eq. 4); G₁ about (x, y, z). Relative error 2e-5.
COPPICE_FUNCTION_OF_REAL REAL sg_triple_product(REAL x, REAL y, REAL z, REAL l, SgShape b, SgShape c) {
  const vec3 r = b.sharpness * b.axis + c.sharpness * c.axis;
  const float bc = b.sharpness * c.sharpness * sg_squared_distance(b.axis, c.axis);
  const REAL ab = b.sharpness * sg_squared_distance(x, y, z, b.axis);
  const REAL ac = c.sharpness * sg_squared_distance(x, y, z, c.axis);
  const REAL rx = mul_add(l, x, REAL(r.x));
  const REAL ry = mul_add(l, y, REAL(r.y));
  const REAL size = sqrt(sg_squared(rx, ry, mul_add(l, z, REAL(r.z))));
  return sg_product_integral(size, l + (b.sharpness + c.sharpness), mul_add(l, ab + ac, REAL(bc)));
}
COPPICE_FUNCTION float sg_triple_product(SgShape a, SgShape b, SgShape c) {
  return sg_triple_product(a.axis.x, a.axis.y, a.axis.z, a.sharpness, b, c);
}

/// 1 - A for λ >= 1.5.
COPPICE_FUNCTION_OF_REAL REAL sg_sharp_shortfall(REAL l) {
  const REAL decay = exp(-2.0f * l);
  return 1.0f / l - 2.0f * decay / (1.0f - decay);
}

/// Length of the mean direction, A = coth λ - 1/λ = λ/(3 + λ²/(5 + λ²/(7 + λ²/(9 + …)))). Error 5e-7.
COPPICE_FUNCTION_OF_REAL REAL sg_mean_length(REAL sharpness) {
  const REAL l = min(sharpness, REAL(1.5f));
  const REAL l2 = l * l;
  const REAL wide = l * (3465.0f + l2 * (189.0f + l2)) / (10395.0f + l2 * (1260.0f + 21.0f * l2));
  return select(sharpness < 1.5f, wide, 1.0f - sg_sharp_shortfall(max(sharpness, REAL(1.5f))));
}

/// 1 - A, which keeps its digits where A is near 1. Relative error 5e-7.
COPPICE_FUNCTION_OF_REAL REAL sg_mean_shortfall(REAL sharpness) {
  const REAL sharp = sg_sharp_shortfall(max(sharpness, REAL(1.5f)));
  return select(sharpness < 1.5f, 1.0f - sg_mean_length(sharpness), sharp);
}

/// The λ of A, which counts below a half, and of 1 - A, which counts elsewhere: two steps of Newton's method
/// from A (3 - A²)/(1 - A²) (Banerjee et al. 2005, Eq. 4.4). Domain: [0, 1] each. Relative error 1e-6.
COPPICE_FUNCTION float sg_sharpness_of_mean(float mean, float shortfall) {
  const float q = max(shortfall, 1.0f / SG_MAX_SHARPNESS);
  const bool wide = mean < 0.5f;
  const float rest = wide ? 1.0f - mean * mean : q * (2.0f - q);
  float l = (wide ? mean : 1.0f - q) * (2.0f + rest) / rest;
  for (int i = 0; i < 2; ++i) {
    const float a = sg_mean_length(l);
    const float s = sg_mean_shortfall(l);
    const float decay = exp(-2.0f * l);
    if (wide)
      l -= (a - mean) / (1.0f - a * a - 2.0f * a / max(l, 1e-20f));
    else
      l += s / q * (s - q) / (1.0f / (l * l) - 4.0f * decay / ((1.0f - decay) * (1.0f - decay)));
  }
  return l;
}

/// The Gaussian whose directions have these moments: the mean Σ w d/Σ w of unit vectors, and their variance
/// Σ w |d - mean|²/Σ w = 1 - |mean|². From one direction (λ = SG_MAX_MOMENT_SHARPNESS) to all (λ = 0).
/// Precondition: |mean| <= 1, variance in [0, 1]. Relative error of λ 1e-6.
COPPICE_FUNCTION SgShape sg_from_moments(vec3 mean, float variance) {
  const float size = length(mean);
  const float shortfall = max(variance / (1.0f + size), 1.0f / SG_MAX_MOMENT_SHARPNESS);
  SgShape g;
  g.axis = size > 1e-18f ? mean / size : vec3(0.0f, 1.0f, 0.0f);
  g.sharpness = size > 1e-18f ? sg_sharpness_of_mean(size, shortfall) : 0.0f;
  return g;
}

/// The same from the mean alone, whose rounding costs λ a relative 3e-7 (1 + λ): not for λ above 1e4.
COPPICE_FUNCTION SgShape sg_from_moments(vec3 mean) {
  return sg_from_moments(mean, max(1.0f - dot(mean, mean), 0.0f));
}

/// ∫ G₁(ω·a) G₂(ω·d) dω over d as a Gaussian about the same axis: that of the same integral, I₁I₂, and the
/// same mean length, A₁A₂, to 1e-6. The shape is not exact (sg_inner_product is): within 9.5% of the peak, 1%
/// where either λ is above 100, 5e-4 where either is below 0.1.
COPPICE_FUNCTION SgProduct sg_convolution(SgShape a, float sharpness) {
  const float mean = sg_mean_length(a.sharpness);
  const float shortfall = sg_mean_shortfall(a.sharpness) + mean * sg_mean_shortfall(sharpness);
  SgProduct g;
  g.axis = a.axis;
  g.sharpness = sg_sharpness_of_mean(mean * sg_mean_length(sharpness), shortfall);
  g.scale = sg_integral(a.sharpness) * (sg_integral(sharpness) / sg_integral(g.sharpness));
  return g;
}

/// Half the angle of the cone at whose edge G is a half, radians (SG Eq. 5, 6); π below ln 2/2. Error 5e-7.
COPPICE_FUNCTION float sg_cone_angle(float sharpness) {  // SG_HALF_LN_2 is 9.523e-10 above the number
  return 2.0f * atan(sqrt(SG_HALF_LN_2 / max((sharpness - SG_HALF_LN_2) + 9.523e-10f, 1e-30f)));
}

/// The sharpness of a cone's half angle, ln 2/(2 sin²(angle/2)) up to 1e10. Domain: [0, π]. Error 1e-6.
COPPICE_FUNCTION float sg_cone_sharpness(float half_angle) {
  const float s = sin(0.5f * half_angle);
  return min(SG_HALF_LN_2 / max(s * s, 1e-12f), SG_MAX_SHARPNESS);
}

/// e^-x I₀(x) (Abramowitz and Stegun 9.8.1, 9.8.2). Domain: x >= 0. Relative error 5e-7.
COPPICE_FUNCTION float sg_bessel_i0(float x) {
  const float y = x / 3.75f;
  const float t = y * y;
  const float s = 1.0f / max(y, 1.0f);
  const float near = 1.2067492f + t * (0.2659732f + t * (0.0360768f + t * 0.0045813f));
  const float far =
      0.00916281f + s * (-0.02057706f + s * (0.02635537f + s * (-0.01647633f + s * 0.00392377f)));
  if (y <= 1.0f) return exp(-x) * (1.0f + t * (3.5156229f + t * (3.0899424f + t * near)));
  return (0.39894228f + s * (0.01328592f + s * (0.00225319f + s * (-0.00157565f + s * far)))) / sqrt(x);
}

/// What sg_tail sums at t = tan(h/2), of a Gaussian given as (below, level, λ).
COPPICE_FUNCTION vec2 sg_tail_node(float t, vec3 g) {
  const float v = 1.0f / (1.0f + t * t);
  const float m = (1.0f - t * t) * v;
  const float share = v * m * exp(-2.0f * g.z * t * (g.y * t + g.x) * v) * sg_bessel_i0(g.z * g.y * m);
  return vec2(share, share * 2.0f * t * v);
}

/// ∫ G and ∫ G n·ω over n·ω > 0 of a Gaussian with -n·p = below >= 0. At elevation h, with level = √(1 -
/// below²), the mean of G round n is e^-λ(1 - level) e^-λ(level (1 - cos h) + below sin h) B(λ level cos h),
/// B(x) = e^-x I₀(x). Gauss and Legendre's 12 points over tan(h/2), as far as e^-16 of h = 0. Error 1e-5.
COPPICE_FUNCTION vec2 sg_tail(float below, float sharpness) {
  const float level = sqrt((1.0f - below) * (1.0f + below));
  const float w = 16.0f / max(sharpness, 1e-6f);
  const float root = sqrt(max(below * below + w * (2.0f * level - w), 0.0f));
  const float top = w < level + below ? 0.5f * min(w / (below + root), 1.0f) : 0.5f;  // half the range of t
  const vec3 g = vec3(below, level, sharpness);
  vec2 sum = 0.249147046f * (sg_tail_node(0.8747665915f * top, g) + sg_tail_node(1.125233409f * top, g));
  sum += 0.233492537f * (sg_tail_node(0.6321685010f * top, g) + sg_tail_node(1.367831499f * top, g));
  sum += 0.203167427f * (sg_tail_node(0.4126820457f * top, g) + sg_tail_node(1.587317954f * top, g));
  sum += 0.160078329f * (sg_tail_node(0.2300973258f * top, g) + sg_tail_node(1.769902674f * top, g));
  sum += 0.106939326f * (sg_tail_node(0.0958827436f * top, g) + sg_tail_node(1.904117256f * top, g));
  sum += 0.047175336f * (sg_tail_node(0.0184393658f * top, g) + sg_tail_node(1.981560634f * top, g));
  return sum * (12.566370614f * top * exp(-sharpness * (below * below / (1.0f + level))));
}

/// ∫ G(ω) max(0, n·ω) dω from c = n·p: F(c) = I A c + F(-c) leaves tails. Domain: [-1, 1]. Error 1e-5.
COPPICE_FUNCTION float sg_clamped_cosine(float cosine, float sharpness) {
  const float tail = sg_tail(min(abs(cosine), 1.0f), sharpness).y;
  return tail + max(cosine, 0.0f) * sg_integral(sharpness) * sg_mean_length(sharpness);
}

/// The share of G above a plane, ∫_{n·ω > 0} G/∫ G, from n·p. Domain: [-1, 1]. Relative error 1e-5.
COPPICE_FUNCTION float sg_hemisphere_share(float cosine, float sharpness) {
  const float tail = sg_tail(min(abs(cosine), 1.0f), sharpness).x / sg_integral(sharpness);
  return cosine > 0.0f ? 1.0f - tail : tail;
}

/// σ² of the next form at c = 0: (√2π F(0)/∫ G)², F(0) = 2π e^-λ I₁(λ)/λ. Domain: up to 1e8. Error 2e-4.
COPPICE_FUNCTION_OF_REAL REAL sg_horizon_variance(REAL l) {
  const REAL over = 19.05759f + l * (8.27519f + l * (2.822377f + l));
  return over / (48.529765f + l * (20.99162f + l * (11.68546f + l * (3.554928f + l))));
}

/// sg_clamped_cosine/∫ G in closed form: σ ψ(A c/σ), ψ(x) = x Φ(x) + φ(x), whose F(c) - F(-c) = I A c holds
/// for any σ(λ, c²), here fitted. Domain: [-1, 1]. Absolute error 3e-4.
COPPICE_FUNCTION_OF_REAL REAL sg_mean_cosine_fast(REAL cosine, REAL sharpness) {
  const REAL l = min(sharpness, REAL(1e8f));
  const REAL c2 = cosine * cosine;
  const REAL fall = 1.854587f + 0.5f * l + c2 * (0.4324325f * l - 0.0457151f);
  const REAL share = c2 * (l * l) * fall / (68.4125f + l * l * (16.638f + l));
  const REAL sigma = sqrt(sg_horizon_variance(l) * (1.0f - share));
  const REAL along = sg_mean_length(sharpness) * cosine;
  const REAL x = abs(along) / sigma;
  const REAL s = min(x, REAL(8.0f));
  const REAL over = 1.0f + s * (1.2533141f + s * (0.5708457f + s * (0.08906475f - 0.008978777f * s)));
  return max(along, REAL(0.0f)) + 0.3989422804f * sigma * exp(-0.5f * x * x) / over;
}

/// sg_hemisphere_share as Φ(c √(λ² σ² (1 + fitted))). Domain: [-1, 1]. Absolute error 4e-4.
COPPICE_FUNCTION_OF_REAL REAL sg_hemisphere_share_fast(REAL cosine, REAL sharpness) {
  const REAL l = min(sharpness, REAL(1e8f));
  const REAL c2 = cosine * cosine;
  const REAL more = c2 * (0.4503639f * l - 0.5417172f) - (0.04475952f + 0.04059009f * l);
  const REAL rise = c2 * (l * l) * (0.5366185f + 0.25f * l + c2 * more) /
                    (3.51709f + l * (9.831399f + l * (0.4977797f + l)));
  const REAL x = abs(cosine) * sqrt(sharpness * l * sg_horizon_variance(l) * (1.0f + rise));
  const REAL s = min(x, REAL(8.0f));
  const REAL tail = exp(-0.5f * x * x) / (2.0f + s * (1.59576912f + s * (0.2685012f - 0.04055378f * s)));
  return select(cosine > 0.0f, 1.0f - tail, tail);
}

COPPICE_END
#endif
