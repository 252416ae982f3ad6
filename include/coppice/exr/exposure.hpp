// An exposure for a preview, chosen from the image.
#pragma once

#include <algorithm>
#include <cmath>
#include <coppice/core/config.hpp>
#include <coppice/core/image.hpp>
#include <cstddef>
#include <limits>
#include <span>

namespace coppice {

/// The factor that brings the geometric mean of luminance to `key` (Reinhard et al., "Photographic Tone
/// Reproduction for Digital Images", 2002, Eq. 1 and 2, without their offset: black pixels are left out
/// instead). The mean is over the pixels of finite, positive luminance that `coverage` (one value a pixel;
/// empty: all) does not give as 0. 1 where there are none; always positive and finite for a positive, finite
/// key.
inline float automatic_exposure(const Image& image, std::span<const float> coverage = {}, float key = 0.18f) {
  COPPICE_ASSERT(coverage.empty() || coverage.size() == image.pixels.size());
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    const float value = luminance(image.pixels[i]);
    if (!(value > 0) || !std::isfinite(value) || (!coverage.empty() && !(coverage[i] > 0))) continue;
    sum += std::log(double(value));
    ++count;
  }
  if (count == 0) return 1;
  const double exposure = key / std::exp(sum / double(count));
  const double smallest = std::numeric_limits<float>::min(), largest = std::numeric_limits<float>::max();
  return float(std::clamp(exposure, smallest, largest));
}

}  // namespace coppice
