// The light tree: a permutation of the lights into the leaves of a complete binary tree.
#pragma once

#include <coppice/shared/node.h>

#include <bit>
#include <coppice/core/config.hpp>
#include <cstdint>
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

}  // namespace coppice
