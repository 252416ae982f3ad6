// Which Gaussian lights can matter to a lobe: an upper bound from the angle between them alone.
#pragma once

#include <coppice/shared/sg.h>

#include <coppice/core/config.hpp>

namespace coppice {

/// An upper bound of ∫ |light| · lobe for all lights of one sharpness and a Gaussian lobe: luminance ·
/// scale · e^(-rate d²), where d² = |p₁ - p₂|² = 2 - 2 cos and the luminance is SgLight's.
///
/// In space, λ₁|ω - p₁|² + λ₂|ω - p₂|² = s|ω - c|² + (λ₁λ₂/s) d² with s = λ₁ + λ₂ and c between p₁ and p₂;
/// so ∫ G₁G₂ = e^(-λ₁λ₂d²/2s) ∫ e^(-s|ω - c|²/2) dω. The last integral, over the unit sphere, is no more than
/// 1.5 times what it is at |c| = 1, which is sg_integral(s). No root and no division a light.
///
/// Lobes that are no Gaussians lie below one: max(0, x)^n <= e^(n (x - 1)), Phong's exponent or 1 for Lambert
/// being the sharpness.
struct SgLightBound {
  float rate = 0;
  float scale = 0;

  /// Preconditions: light_sharpness, lobe_sharpness >= 0, not both 0.
  SgLightBound(float light_sharpness, float lobe_sharpness) {
    const float sum = light_sharpness + lobe_sharpness;
    COPPICE_ASSERT(light_sharpness >= 0 && lobe_sharpness >= 0 && sum > 0);
    rate = 0.5f * light_sharpness * (lobe_sharpness / sum);
    scale = 1.5f * sg_integral(sum) * sg_normalisation(light_sharpness);
  }

  /// Of ∫ |light| · lobe in luminance. 1.5 times the exact value at d = 0, and more beyond.
  float at(float cosine, float luminance) const {
    return luminance * scale * std::exp(-2 * rate * (1 - cosine));
  }

  /// The cosine below which a light of that luminance brings no more than `threshold`: one comparison a
  /// light. Above 1: nowhere does it. Precondition: threshold > 0.
  float least_cosine(float luminance, float threshold) const {
    const float excess = luminance * scale / threshold;
    if (excess <= 1) return 2;
    return rate > 0 ? 1 - std::log(excess) / (2 * rate) : -2;
  }
};

}  // namespace coppice
