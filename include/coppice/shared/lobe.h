// Phong lobes of radiance, and the lobe of many of them, as closed forms for C++ and GLSL.
//
// A lobe of energy l, unit direction d and exponent k is the radiance l (k + 1)/2π max(0, ω·d)^k (Filtering
// Eq. 1): its integral over all directions is l. The mean of its directions points along d and is
// R = (k + 1)/(k + 2) long; 1 - R = 1/(k + 2) is what the forms below carry, because R itself loses the
// exponent's digits. Exponents reach down to -1, R = 0: lobes that point apart more than one lobe can tell.
// Such a lobe shines as lobe_shining says.
#ifndef COPPICE_SHARED_LOBE_H
#define COPPICE_SHARED_LOBE_H
#include <coppice/shared/language.h>

COPPICE_BEGIN

/// Direction and exponent of a lobe, without its energy.
struct LobeShape {
  vec3 direction;  ///< unit
  float exponent;  ///< [-1, inf)
};

/// 1 - R of an exponent, in (0, 1]. Precondition: exponent >= -1. Relative error 1.2e-7.
COPPICE_FUNCTION float lobe_shortfall(float exponent) { return 1.0f / (exponent + 2.0f); }

/// The exponent of 1 - R, (2R - 1)/(1 - R). Precondition: 0 < shortfall <= 1. Relative error 1.2e-7 of
/// exponent + 2.
COPPICE_FUNCTION float lobe_exponent(float shortfall) { return 1.0f / shortfall - 2.0f; }

/// The lobe whose directions have the same mean as those of two lobes, which count by their shares of the
/// energy, wa + wb = 1: the vectors R d add up. 1 - |sum| is a sum of positive terms, so that it keeps its
/// digits for all exponents: relative error 1e-6 of exponent + 2 over [-1, 1e6]. Lobes that cancel keep the
/// direction of a. Precondition: wa, wb >= 0.
COPPICE_FUNCTION LobeShape lobe_sum(LobeShape a, float wa, LobeShape b, float wb) {
  const float qa = lobe_shortfall(a.exponent);
  const float qb = lobe_shortfall(b.exponent);
  const float ra = wa * (1.0f - qa);
  const float rb = wb * (1.0f - qb);
  const vec3 apart = a.direction - b.direction;
  const vec3 mean = ra * a.direction + rb * b.direction;
  const float below = wa * qa + wb * qb;                                       // 1 - (ra + rb)
  const float squared = below * (2.0f - below) + ra * rb * dot(apart, apart);  // 1 - |mean|^2
  const float size2 = dot(mean, mean);
  LobeShape sum;
  sum.direction = size2 > 1e-20f ? mean / sqrt(size2) : a.direction;
  sum.exponent = lobe_exponent(min(max(squared / (1.0f + sqrt(size2)), 1e-7f), 1.0f));
  return sum;
}

/// The exponent that a lobe has after its direction spreads: 1/k' = 1/k + variance (Filtering Eq. 4).
COPPICE_FUNCTION_OF_REAL REAL lobe_widened(REAL exponent, REAL variance) {
  return exponent / mul_add(exponent, variance, REAL(1.0f));
}

/// Variance of a distribution of directions whose mean is 1 - shortfall long (Filtering Eq. 3): 1e7 at 1, so
/// that lobe_widened stays a number. Precondition: 0 <= shortfall <= 1. Relative error 1.2e-7 below
/// 0.9999999.
COPPICE_FUNCTION float lobe_variance(float shortfall) { return shortfall / max(1.0f - shortfall, 1e-7f); }

/// The exponent that light spread all over looks most like, of a lobe of lobe_sum: itself from 1 on, 0 at -1.
/// Below 1 the exponent of the same mean makes the lobe an even half of the sphere with a sharp edge.
COPPICE_FUNCTION_OF_REAL REAL lobe_shining(REAL exponent) {
  return max(exponent, mul_add(exponent, REAL(0.5f), REAL(0.5f)));
}

/// max(0, cosine)^exponent from half the squared distance of two unit vectors, 1 - cosine, which keeps its
/// digits where they nearly agree. 0^0 = 0: no lobe shines beyond a quarter turn. Domain: 0 <= drop <= 2,
/// exponent in [0, 1e6]. Relative error 2e-6 where it is at least 1e-3, absolute 2e-9 below, at the same
/// drop.
COPPICE_FUNCTION_OF_REAL REAL lobe_power(REAL drop, REAL exponent) {
  const REAL power = exp(exponent * log1p(-min(drop, REAL(0.99999994f))));
  return select(drop < REAL(1.0f), power, REAL(0.0f));
}

COPPICE_END
#endif
