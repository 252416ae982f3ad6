// Peak signal-to-noise ratio of displayed images.
#pragma once

#include <cmath>
#include <coppice/core/config.hpp>
#include <coppice/core/image.hpp>
#include <limits>
#include <vector>

namespace coppice {

/// 10 log₁₀(1 / mean squared error), in dB, over all channels of the pixels that count. Both images are as
/// displayed: exposed, encoded, and in [0, 1], the peak being 1. Infinite where they are equal or no pixel
/// counts; NaN where a value is NaN. Precondition: equal sizes.
inline double psnr(const Image& image, const Image& reference, const std::vector<bool>& counts) {
  COPPICE_ASSERT(image.pixels.size() == reference.pixels.size() && counts.size() == image.pixels.size());
  double sum = 0, values = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (!counts[i]) continue;
    const glm::dvec3 d = glm::dvec3(image.pixels[i]) - glm::dvec3(reference.pixels[i]);
    sum += dot(d, d);
    values += 3;
  }
  if (values == 0) return std::numeric_limits<double>::infinity();
  return -10 * std::log10(sum / values);
}

}  // namespace coppice
