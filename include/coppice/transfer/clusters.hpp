// Samples grouped into clusters of about one size.
#pragma once

#include <bit>
#include <coppice/light/thin_samples.hpp>
#include <coppice/transfer/clustered_samples.hpp>

namespace coppice {

struct ClusterOptions {
  std::size_t count = 48;    ///< clusters wanted
  std::uint32_t steps = 16;  ///< of k-means; 0: samples go to the nearest root, as in the paper
  float normal_weight =
      0.5f;           ///< of normals' squared difference beside that of positions over the cluster's size
  float balance = 1;  ///< 0: plain k-means; up to 1: clusters that are too large give more away
};

/// The middle of a cluster, and what distance to it counts for.
struct ClusterRoot {
  vec3 position{0};
  float scale = 1;  ///< of squared distances; above 1 for clusters that were too large
  vec3 normal{0};   ///< mean: shorter than 1 where they differ
};

/// What a sample pays to belong to a cluster. size2: m², the area of a mean cluster.
inline float cluster_cost(const SurfaceSample& sample, const ClusterRoot& root, float size2,
                          float normal_weight) {
  const vec3 way = sample.position - root.position, turn = sample.normal - root.normal;
  return root.scale * (dot(way, way) + normal_weight * size2 * dot(turn, turn));
}

namespace detail {

/// For each sample the cheapest root, the first of equals.
template <Executor E>
std::vector<std::uint32_t> cheapest_roots(std::span<const SurfaceSample> samples,
                                          std::span<const ClusterRoot> roots, float size2,
                                          float normal_weight, const E& executor) {
  std::vector<std::uint32_t> of(samples.size());
  executor(samples.size(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      float least = std::numeric_limits<float>::infinity();
      for (std::uint32_t c = 0; c < roots.size(); ++c) {
        const float cost = cluster_cost(samples[i], roots[c], size2, normal_weight);
        if (cost < least) least = cost, of[i] = c;
      }
    }
  });
  return of;
}

/// Moves roots to the means of their samples; raises the scale of those with more than their share. Clusters
/// that lost all keep their place and become cheaper.
inline void move_roots(std::span<const SurfaceSample> samples, std::span<const std::uint32_t> of,
                       float balance, std::span<ClusterRoot> roots) {
  std::vector<glm::dvec3> place(roots.size(), glm::dvec3(0)), normal(roots.size(), glm::dvec3(0));
  std::vector<double> count(roots.size(), 0);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    place[of[i]] += glm::dvec3(samples[i].position);
    normal[of[i]] += glm::dvec3(samples[i].normal);
    ++count[of[i]];
  }
  const double share = double(samples.size()) / double(roots.size());
  for (std::size_t c = 0; c < roots.size(); ++c) {
    const double surplus = std::clamp(count[c] / share, 0.25, 4.0);
    roots[c].scale =
        std::clamp(roots[c].scale * float(std::pow(surplus, 0.5 * double(balance))), 0.1f, 10.0f);
    if (count[c] > 0)
      roots[c].position = vec3(place[c] / count[c]), roots[c].normal = vec3(normal[c] / count[c]);
  }
}

/// Bits of x with two zeros after each; x < 1024.
inline std::uint32_t spread_bits(std::uint32_t x) {
  x = (x | x << 16) & 0x030000ffu;
  x = (x | x << 8) & 0x0300f00fu;
  x = (x | x << 4) & 0x030c30c3u;
  return (x | x << 2) & 0x09249249u;
}

/// Sorts along a Morton curve through their box, so that neighbours in memory are mostly near in space.
inline void sort_along_curve(std::span<SurfaceSample> samples) {
  if (samples.empty()) return;
  vec3 low = samples[0].position, high = low;
  for (const SurfaceSample& s : samples) low = glm::min(low, s.position), high = glm::max(high, s.position);
  const vec3 size = high - low;
  const float widest = std::max({size.x, size.y, size.z, 1e-30f});
  std::ranges::stable_sort(samples, {}, [&](const SurfaceSample& s) {
    const vec3 at = 1023.0f * (s.position - low) / widest;
    return spread_bits(std::uint32_t(at.x)) | spread_bits(std::uint32_t(at.y)) << 1 |
           spread_bits(std::uint32_t(at.z)) << 2;
  });
}

}  // namespace detail

/// Where clusters begin: samples thinned with a larger radius (PCA section 4.1), about `count`.
inline std::vector<ClusterRoot> cluster_roots(std::span<const SurfaceSample> samples, std::size_t count) {
  std::vector<ClusterRoot> roots;
  for (const SurfaceSample& s : thin_samples(samples, count)) roots.push_back({s.position, 1, s.normal});
  return roots;
}

/// Groups samples into clusters: by the nearest root, then by k-means steps over positions and normals in
/// which clusters that are too large become dearer. All samples count alike. Clusters without samples are
/// left out, so there may be fewer than wanted; none where count is 0. Within a cluster samples follow a
/// Morton curve. Same bits for any executor. Cost: steps · samples · clusters. Precondition: 0 <= balance
/// <= 1.
template <Executor E>
ClusteredSamples cluster_samples(std::span<const SurfaceSample> samples, const E& executor,
                                 const ClusterOptions& options = {}) {
  COPPICE_ASSERT(options.balance >= 0 && options.balance <= 1);
  ClusteredSamples result;
  if (samples.empty() || options.count == 0) return result;
  std::vector<ClusterRoot> roots = cluster_roots(samples, options.count);
  double area = 0;
  for (const SurfaceSample& s : samples) area += double(s.area);
  const auto size2 = float(area / double(roots.size()));
  auto of = detail::cheapest_roots(samples, roots, size2, options.normal_weight, executor);
  for (std::uint32_t step = 0; step < options.steps; ++step) {
    detail::move_roots(samples, of, options.balance, roots);
    of = detail::cheapest_roots(samples, roots, size2, options.normal_weight, executor);
  }
  std::vector<std::vector<SurfaceSample>> members(roots.size());
  for (std::size_t i = 0; i < samples.size(); ++i) members[of[i]].push_back(samples[i]);
  for (auto& cluster : members) {
    if (cluster.empty()) continue;
    detail::sort_along_curve(cluster);
    result.samples.insert(result.samples.end(), cluster.begin(), cluster.end());
    result.ends.push_back(std::uint32_t(result.samples.size()));
  }
  return result;
}

}  // namespace coppice
