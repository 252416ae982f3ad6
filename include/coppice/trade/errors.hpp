// How far an image is from its reference.
#pragma once

#include <algorithm>
#include <cmath>
#include <coppice/core/config.hpp>
#include <coppice/core/image.hpp>
#include <span>
#include <vector>

namespace coppice {

/// Errors of x against r over all channels of the pixels that count. All zero where no pixel counts.
struct ImageErrors {
  double rel_rmse = 0;  ///< |x - r|₂ / |r|₂: bright spots rule
  double mre = 0;       ///< mean |x - r| / (r + 0.1 r̄): each pixel counts alike
  double rel_mse = 0;   ///< mean (x - r)² / (r² + 0.01)
  double p95 = 0;       ///< 95th percentile of |x - r| / (r + 0.1 r̄)
  double p99 = 0;       ///< 99th percentile
  std::size_t pixels = 0;
};

namespace detail {

struct ErrorSums {
  double difference2 = 0, reference2 = 0, relative = 0, relative2 = 0;
  std::vector<double> each;

  void add(double x, double r, double tenth_of_mean) {
    const double d = x - r, size = std::fabs(d), weighted = size / std::max(r + tenth_of_mean, 1e-300);
    difference2 += d * d;
    reference2 += r * r;
    relative += weighted;
    relative2 += d * d / (r * r + 0.01);
    each.push_back(weighted);
  }
};

}  // namespace detail

/// Errors of `image` over the pixels with `counts`; the definitions of the report (docs/trade.md). r̄ is the
/// mean of the reference over those pixels. A black reference that the image misses has infinite rel_rmse.
/// Precondition: equal sizes.
inline ImageErrors image_errors(const Image& image, const Image& reference, const std::vector<bool>& counts) {
  COPPICE_ASSERT(image.pixels.size() == reference.pixels.size() && counts.size() == image.pixels.size());
  ImageErrors errors;
  double mean = 0;
  for (std::size_t i = 0; i < counts.size(); ++i)
    if (counts[i])
      mean += double(reference.pixels[i].x) + reference.pixels[i].y + reference.pixels[i].z, ++errors.pixels;
  if (errors.pixels == 0) return errors;
  const double values = 3.0 * double(errors.pixels);
  mean /= values;
  detail::ErrorSums sums;
  for (std::size_t i = 0; i < counts.size(); ++i)
    for (int c = 0; counts[i] && c < 3; ++c) sums.add(image.pixels[i][c], reference.pixels[i][c], 0.1 * mean);
  if (sums.difference2 > 0) errors.rel_rmse = std::sqrt(sums.difference2 / sums.reference2);
  errors.mre = sums.relative / values;
  errors.rel_mse = sums.relative2 / values;
  const auto percentile = [&](double share) {
    const auto nth = sums.each.begin() + std::ptrdiff_t(share * (values - 1));
    std::ranges::nth_element(sums.each, nth);
    return *nth;
  };
  errors.p95 = percentile(0.95);
  errors.p99 = percentile(0.99);
  return errors;
}

/// Means over block × block pixels that count, for noisy references; blocks of which at most half count are
/// left out. `counts` is replaced by that of the blocks.
inline Image block_means(const Image& image, const std::vector<bool>& counts, int block,
                         std::vector<bool>& block_counts) {
  COPPICE_ASSERT(block >= 1);
  Image means(image.width / block, image.height / block);
  block_counts.assign(means.pixels.size(), false);
  for (int y = 0; y < means.height; ++y)
    for (int x = 0; x < means.width; ++x) {
      glm::dvec3 sum(0);
      int n = 0;
      for (int k = 0; k < block * block; ++k) {
        const std::size_t i = image.index(x * block + k % block, y * block + k / block);
        if (counts[i]) sum += glm::dvec3(image.pixels[i]), ++n;
      }
      if (2 * n > block * block)
        means.at(x, y) = vec3(sum / double(n)), block_counts[means.index(x, y)] = true;
    }
  return means;
}

}  // namespace coppice
