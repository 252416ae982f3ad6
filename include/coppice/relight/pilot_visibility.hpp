// Pilot visibility: a sample of receivers tells how lights are seen, and so which of them belong together.
#pragma once

#include <array>
#include <coppice/relight/visibility_cuts.hpp>
#include <coppice/tree/build.hpp>
#include <coppice/tree/visibility_metric.hpp>
#include <span>
#include <vector>

namespace coppice {

/// Receivers are clustered by position and normal, and a few of each cluster are traced.
struct PilotOptions {
  std::uint32_t clusters = 1024;  ///< M, entries of a light visibility vector; a power of two
  std::uint32_t members = 8;      ///< receivers of each that are traced, at most
  std::uint32_t length = 128;     ///< to which vectors are projected; 0, or M and more: as they are
  TreeOptions tree{8, 4};         ///< one first guess alone often ends in a poor split of the mixed distance
  MetricScale scale = MetricScale::variance;
};

/// Pilot receivers, cluster by cluster.
struct PilotReceivers {
  std::vector<std::uint32_t> receivers;  ///< indices among all
  std::vector<std::uint32_t> ends;       ///< a cluster; where it ends in `receivers`
};

/// Clusters are the nodes of a tree over the receivers by Eq. 11; their pilots are evenly spread over the
/// node's leaves. Where receivers are few, clusters have fewer members, then there are fewer clusters.
inline PilotReceivers choose_pilots(std::span<const Receiver> receivers, const PilotOptions& options) {
  COPPICE_ASSERT(std::has_single_bit(options.clusters) && options.members > 0);
  std::vector<LightSample> samples;
  samples.reserve(receivers.size());
  for (const Receiver& r : receivers) samples.push_back({r.position, r.normal});
  const LightTree tree = build_tree(GeometricMetric(samples));
  const std::uint32_t clusters = std::min(options.clusters, tree.leaf_count());
  PilotReceivers pilots;
  std::vector<std::uint32_t> below;
  for (std::uint32_t h = clusters; h < 2 * clusters; ++h) {
    const LeafRange leaves = leaves_below(tree.leaf_count(), h);
    below.assign(tree.light_of_leaf.begin() + leaves.begin, tree.light_of_leaf.begin() + leaves.end);
    std::erase(below, no_light);
    if (below.empty()) continue;
    const std::size_t count = std::min<std::size_t>(options.members, below.size());
    for (std::size_t i = 0; i < count; ++i)
      pilots.receivers.push_back(below[(2 * i + 1) * below.size() / (2 * count)]);
    pilots.ends.push_back(std::uint32_t(pilots.receivers.size()));
  }
  return pilots;
}

/// What the pilots see.
struct PilotVisibility {
  PilotReceivers pilots;
  VisibilityRows rows;  ///< of pilots.receivers, in order
  std::size_t rays = 0;
};

/// Traces all lights from the pilots. The result does not depend on the executor.
template <Occluder O, LightPackets L, Executor E>
PilotVisibility trace_pilots(const O& occluder, const L& leaf_lights, std::span<const Receiver> receivers,
                             const PilotOptions& options, const E& executor) {
  PilotVisibility result{choose_pilots(receivers, options), {}, 0};
  const auto& pilots = result.pilots.receivers;
  result.rows = VisibilityRows(leaf_lights.count(), pilots);
  std::vector<std::size_t> traced(pilots.size());
  executor(pilots.size(), 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      traced[i] = trace_visibility(occluder, leaf_lights, receivers[pilots[i]], result.rows[i]);
  });
  result.rays = std::accumulate(traced.begin(), traced.end(), std::size_t{0});
  return result;
}

namespace detail {

/// Shares of the rows [first, last) that see each of 64 leaves.
inline std::array<float, 64> shares_of_word(const VisibilityRows& rows, std::uint32_t first,
                                            std::uint32_t last, std::size_t word) {
  std::array<std::uint64_t, 64> seen{};
  for (std::uint32_t r = first; r < last; ++r) {
    const std::uint64_t bits = rows[r][word];
    for (std::uint32_t k = 0; k < 64; ++k) seen[k] += bits >> k & 1;
  }
  std::array<float, 64> shares;
  for (std::uint32_t k = 0; k < 64; ++k) shares[k] = float(seen[k]) / float(last - first);
  return shares;
}

/// Entries of the vectors of the lights in one word of the rows. Several clusters at once, as the vectors of
/// the lights lie apart.
inline void write_vectors_of_word(const PilotVisibility& pilot, const LightTree& tree, std::size_t word,
                                  LightVisibility& vectors) {
  constexpr std::size_t block = 16;
  const auto& ends = pilot.pilots.ends;
  const std::size_t leaves = std::min<std::size_t>(64, tree.leaf_count() - 64 * word);
  std::array<std::array<float, 64>, block> shares;
  for (std::size_t first = 0; first < ends.size(); first += block) {
    const std::size_t count = std::min(block, ends.size() - first);
    for (std::size_t i = 0; i < count; ++i)
      shares[i] = shares_of_word(pilot.rows, first + i == 0 ? 0 : ends[first + i - 1], ends[first + i], word);
    for (std::size_t k = 0; k < leaves; ++k) {
      const std::uint32_t light = tree.light_of_leaf[64 * word + k];
      if (light == no_light) continue;
      for (std::size_t i = 0; i < count; ++i)
        vectors.shares[light * vectors.length + first + i] = shares[i][k];
    }
  }
}

}  // namespace detail

/// The visibility vector of every light (Cuts section 3.4), from rows in the order of the tree's leaves.
template <Executor E>
LightVisibility light_visibility(const PilotVisibility& pilot, const LightTree& tree, const E& executor) {
  LightVisibility vectors{pilot.pilots.ends.size(), {}};
  if (vectors.length == 0) return vectors;
  vectors.shares.resize(vectors.length * tree.light_count[1]);
  executor(words_for_bits(tree.leaf_count()), 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t word = begin; word < end; ++word)
      detail::write_vectors_of_word(pilot, tree, word, vectors);
  });
  return vectors;
}

/// The tree by Eq. 13, from what the pilots see through the leaves of `tree`; the pilots' rows are put in the
/// order of the new leaves. Without pilots it is the geometric tree. `samples` by light. Deterministic. Takes
/// 128 MB for 1024 clusters and 32,768 lights.
template <Executor E>
LightTree build_data_driven_tree(std::span<const LightSample> samples, const LightTree& tree,
                                 PilotVisibility& pilot, float beta, const PilotOptions& options,
                                 const E& executor) {
  COPPICE_ASSERT(tree.empty() ? samples.empty() : samples.size() == tree.light_count[1]);
  const GeometricMetric geometry(samples);
  if (pilot.pilots.receivers.empty() || tree.empty()) return build_tree(geometry);
  LightVisibility vectors = light_visibility(pilot, tree, executor);
  if (options.length > 0 && options.length < vectors.length)
    vectors = project(vectors, options.length, executor);
  const VisibilityMetric visibility(vectors);
  LightTree result = build_tree(MixedMetric(geometry, visibility, beta, options.scale), options.tree);
  reorder(pilot.rows, tree, result, executor);
  return result;
}

}  // namespace coppice
