// The bounds of a VPL tree in blocks of sixteen, so that a register tests the nodes of three levels at once.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <bit>
#include <coppice/core/config.hpp>
#include <coppice/gather/vpl_bounds.hpp>
#include <cstdint>
#include <vector>

namespace coppice {

/// Blocks hang below the root and below the nodes of every third level, counted from the leaves. A node is in
/// the block of its nearest ancestor that has one, at the place that would be its heap id were that ancestor
/// the root: [2, 16).
class BlockLayout {
 public:
  static constexpr std::uint32_t places = 16;
  struct Place {
    std::uint32_t block;
    std::uint32_t place;
  };

  explicit BlockLayout(std::uint32_t leaf_count = 0)
      : depth_(leaf_count == 0 ? 0 : depth_of(leaf_count)), first_(depth_ == 0 ? 0 : (depth_ - 1) % 3 + 1) {}

  /// 0 where the root is the only node.
  std::size_t block_count() const { return depth_ == 0 ? 0 : block_below(1u << depth_); }

  /// Bit p is set where the node at place p of the block below a node has a block of its own or is a leaf.
  std::uint32_t lowest_places(std::uint32_t root) const { return run(root == 1 ? 1u << first_ : 8); }

  /// Precondition: the node has a block of its own: the root, or one whose level is a multiple of three above
  /// the leaves.
  std::uint32_t block_below(std::uint32_t h) const {
    if (h == 1) return 0;
    const std::uint32_t level = depth_of(h);
    return 1 + ((1u << level) - (1u << first_)) / 7 + (h - (1u << level));
  }

  /// Precondition: 1 < h < 2 · leaf count.
  Place place_of(std::uint32_t h) const {
    const std::uint32_t level = depth_of(h);
    const std::uint32_t above = level <= first_ ? level : (level - first_ - 1) % 3 + 1;
    return {block_below(h >> above), (1u << above) | (h & ((1u << above) - 1))};
  }

  /// The node at a place of the block below another.
  static std::uint32_t node_at(std::uint32_t root, std::uint32_t place) {
    const std::uint32_t below = depth_of(place);
    return (root << below) | (place & ((1u << below) - 1));
  }

 private:
  static std::uint32_t depth_of(std::uint32_t h) { return std::uint32_t(std::bit_width(h)) - 1; }
  /// Bits [first, 2 · first).
  static std::uint32_t run(std::uint32_t first) { return ((1u << first) - 1) << first; }

  std::uint32_t depth_, first_;
};

}  // namespace coppice

namespace coppice::inline HWY_NAMESPACE {

/// The bounds by block and field.
class BoundBlocks {
 public:
  BoundBlocks() = default;
  explicit BoundBlocks(std::uint32_t leaf_count)
      : layout_(leaf_count), values_(layout_.block_count() * stride, 0.0f) {}

  const BlockLayout& layout() const { return layout_; }

  /// `size`: what the error of taking the node whole grows with, m; 0 for leaves. Precondition: h > 1.
  void set(std::uint32_t h, const VplBound& b, float size) {
    const auto [block, place] = layout_.place_of(h);
    float* at = values_.data() + block * stride + place;
    const vec3* boxes[] = {&b.low, &b.high, &b.normal_low, &b.normal_high, &b.lobe_low, &b.lobe_high};
    for (const vec3* v : boxes)
      for (int k = 0; k < 3; ++k, at += BlockLayout::places) *at = (*v)[k];
    for (const float x : {b.slowest, b.peak, b.diffuse, b.softening, size}) {
      *at = x;
      at += BlockLayout::places;
    }
  }

  /// Nodes [first, first + width) of a block.
  VplBoundLanes load(std::uint32_t block, std::size_t first) const {
    const float* at = values_.data() + block * stride + first;
    const auto next = [&at] {
      const Lanes x = Lanes::load(at);
      at += BlockLayout::places;
      return x;
    };
    VplBoundLanes n;
    for (Lanes* box : {n.low, n.high, n.normal_low, n.normal_high, n.lobe_low, n.lobe_high})
      for (int k = 0; k < 3; ++k) box[k] = next();
    for (Lanes* x : {&n.slowest, &n.peak, &n.diffuse, &n.softening, &n.size}) *x = next();
    return n;
  }

 private:
  static constexpr std::size_t fields = 23, stride = fields * BlockLayout::places;
  BlockLayout layout_;
  std::vector<float> values_;
};

}  // namespace coppice::inline HWY_NAMESPACE
