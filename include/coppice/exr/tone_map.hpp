// From linear radiance to what a screen shows.
#pragma once

#include <cmath>
#include <coppice/core/math.hpp>

namespace coppice {

/// The filmic curve of Narkowicz ("ACES Filmic Tone Mapping Curve", 2016), a rational fit of the ACES
/// reference and output transforms: x(2.51x + 0.03) / (x(2.43x + 0.59) + 0.14), display-linear. Total: 0 for
/// NaN and x <= 0, 1 from x = 7.25 to infinity, and increasing (to an ulp) between.
inline float filmic(float x) {
  const float bounded = std::fmin(std::fmax(x, 0.0f), 8.0f);
  const float shown = bounded * (2.51f * bounded + 0.03f) / (bounded * (2.43f * bounded + 0.59f) + 0.14f);
  return std::fmin(shown, 1.0f);
}

/// filmic(linear · exposure) of each channel: display-linear RGB in [0, 1], whatever the arguments, so that
/// 1e30 and infinity are white and NaN is black. `exposure` is a factor, not stops.
inline vec3 tone_map(const vec3& linear, float exposure) {
  return {filmic(linear.x * exposure), filmic(linear.y * exposure), filmic(linear.z * exposure)};
}

/// The sRGB transfer function (IEC 61966-2-1): display-linear [0, 1] to encoded [0, 1].
inline float srgb_encode(float linear) {
  if (linear <= 0.0031308f) return 12.92f * linear;
  return 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
}

}  // namespace coppice
