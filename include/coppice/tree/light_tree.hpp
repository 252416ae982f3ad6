// The light tree: a permutation of the lights into the leaves of a complete binary tree.
#pragma once

#include <coppice/shared/node.h>

#include <bit>
#include <coppice/core/config.hpp>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace coppice {

/// Marks a leaf that pads the tree to a power of two and holds no light.
inline constexpr std::uint32_t no_light = ~std::uint32_t{0};

/// A complete binary tree over N = 2^d >= light count leaves. Its topology is arithmetic on heap ids
/// (shared/node.h); all that is stored is which light is at which leaf. Whatever is known per light or per
/// cluster is an array beside the tree: 2N values by heap id, entry 0 unused (aggregate.hpp). Without lights
/// it has no leaves.
struct LightTree {
  std::vector<std::uint32_t> light_of_leaf;  ///< a leaf rank; no_light for padding
  std::vector<std::uint32_t> light_count;    ///< a heap id; lights, without padding, below the node

  std::uint32_t leaf_count() const { return std::uint32_t(light_of_leaf.size()); }
  bool empty() const { return light_of_leaf.empty(); }
};

/// A node as the half-open range of leaf ranks below it.
struct LeafRange {
  std::uint32_t begin = 0;
  std::uint32_t end = 0;

  std::uint32_t size() const { return end - begin; }
  friend bool operator==(const LeafRange&, const LeafRange&) = default;
};

/// Leaves below heap id h. Precondition: 1 <= h < 2·leaf_count.
inline LeafRange leaves_below(std::uint32_t leaf_count, std::uint32_t h) {
  COPPICE_ASSERT(h >= 1 && h < 2 * leaf_count);
  const int level = std::bit_width(h) - 1;
  const std::uint32_t size = leaf_count >> level;
  const std::uint32_t begin = (h - (1u << level)) * size;
  return {begin, begin + size};
}

/// Smallest power of two that holds `lights` leaves; 0 for none.
inline std::uint32_t leaf_count_for(std::size_t lights) {
  return lights == 0 ? 0 : std::bit_ceil(std::uint32_t(lights));
}

/// True where every light of [0, light_count) is at one leaf, the others are padding, and there are no more
/// leaves than are needed.
inline bool are_leaves(std::span<const std::uint32_t> light_of_leaf, std::size_t light_count) {
  if (light_count > 1u << 31 || light_of_leaf.size() != leaf_count_for(light_count)) return false;
  std::vector<bool> found(light_count, false);
  std::size_t padding = 0;
  for (const std::uint32_t light : light_of_leaf) {
    if (light == no_light) {
      ++padding;
      continue;
    }
    if (light >= light_count || found[light]) return false;
    found[light] = true;
  }
  return padding + light_count == light_of_leaf.size();
}

/// The tree with these leaves. Precondition: their number is 0 or a power of two.
inline LightTree tree_over(std::vector<std::uint32_t> light_of_leaf) {
  LightTree tree;
  const std::size_t n = light_of_leaf.size();
  COPPICE_ASSERT(n == 0 || std::has_single_bit(n));
  tree.light_count.assign(2 * n, 0);
  for (std::size_t leaf = 0; leaf < n; ++leaf) tree.light_count[n + leaf] = light_of_leaf[leaf] != no_light;
  for (std::size_t h = n; h-- > 1;)
    tree.light_count[h] = tree.light_count[2 * h] + tree.light_count[2 * h + 1];
  tree.light_of_leaf = std::move(light_of_leaf);
  return tree;
}

}  // namespace coppice
