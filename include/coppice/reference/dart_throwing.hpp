// Thinning as the paper does it, and clusters by the nearest root: slow and obvious.
#pragma once

#include <coppice/light/thin_samples.hpp>
#include <coppice/transfer/clusters.hpp>

namespace coppice::reference {

/// Candidates in a random order, each kept unless one that faces alike lies nearer than the radius and was
/// kept before (PCA section 4.1). Indices in the order of keeping. O(n²).
inline std::vector<std::uint32_t> throw_darts(std::span<const SurfaceSample> candidates, float radius,
                                              std::uint64_t seed) {
  std::vector<std::uint32_t> order(candidates.size()), kept;
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  Random random(seed);
  for (std::size_t i = order.size(); i > 1; --i)
    std::swap(order[i - 1], order[random.below(std::uint32_t(i))]);
  for (const std::uint32_t i : order) {
    const auto crowds = [&](std::uint32_t k) {
      return coppice::detail::faces_alike(candidates[i], candidates[k]) &&
             length(candidates[i].position - candidates[k].position) < radius;
    };
    if (std::ranges::none_of(kept, crowds)) kept.push_back(i);
  }
  return kept;
}

/// The root whose cost is least, the first of equals.
inline std::uint32_t nearest_root(const SurfaceSample& sample, std::span<const ClusterRoot> roots,
                                  float size2, float normal_weight) {
  const auto cost = [&](const ClusterRoot& r) { return cluster_cost(sample, r, size2, normal_weight); };
  return std::uint32_t(std::ranges::min_element(roots, {}, cost) - roots.begin());
}

}  // namespace coppice::reference
