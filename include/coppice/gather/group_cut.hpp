// The cut of a VPL tree for a group of points: nodes are taken whole where an upper bound tells that it
// matters little.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <array>
#include <coppice/gather/bound_blocks.hpp>
#include <vector>

namespace coppice {

/// What decides whether a node is split, beside the bound of what it brings.
enum class SplitBy {
  bound_and_angle,  ///< times the root of the solid angle that it may cover: what taking it whole may err by
  bound             ///< alone: what a single ray decides upon, however small the node is
};

namespace detail {

/// Each of eight bits twice, side by side.
inline std::uint32_t doubled(std::uint32_t bits) {
  bits = (bits | bits << 4) & 0x0f0fu;
  bits = (bits | bits << 2) & 0x3333u;
  bits = (bits | bits << 1) & 0x5555u;
  return bits | bits << 1;
}

/// Of the places of a block, those all of whose ancestors in it are split: bits [2, 16).
inline std::uint32_t reached_places(std::uint32_t split) {
  const std::uint32_t second = doubled(split >> 2 & 3u) << 4;
  const std::uint32_t third = doubled((split & second) >> 4) << 8;
  return 12u | second | third;
}

}  // namespace detail

}  // namespace coppice

namespace coppice::inline HWY_NAMESPACE {

/// Finds cuts. Keeps its memory from group to group.
class GroupCutter {
 public:
  explicit GroupCutter(const BoundBlocks& blocks) : blocks_(blocks) {}

  /// Nodes of the cut by heap id, those left out that cannot bring anything. A node is split where its bound,
  /// times the root of the solid angle that it may cover, is above `limit`; the root always.
  std::span<const std::uint32_t> cut(const PointBound& points, float limit,
                                     SplitBy split = SplitBy::bound_and_angle) {
    const GroupBound bound(points);
    split_ = split;
    nodes_.clear();
    tests_ = 0;
    open_.assign(1, 1u);
    if (blocks_.layout().block_count() == 0) nodes_.push_back(1), open_.clear();
    while (!open_.empty()) {
      const std::uint32_t root = open_.back();
      open_.pop_back();
      visit(root, bound, limit);
    }
    return nodes_;
  }

  /// Nodes tested for the last cut, with those of which no ancestor was split.
  std::size_t tests() const { return tests_; }

 private:
  void visit(std::uint32_t root, const GroupBound& bound, float limit) {
    const std::uint32_t block = blocks_.layout().block_below(root);
    std::uint32_t split = 0, bright = 0;
    for (std::uint32_t i = 0; i < BlockLayout::places; i += Lanes::width) {
      const auto b = bound(blocks_.load(block, i));
      const Lanes factor =
          split_ == SplitBy::bound ? select(b.angle > 0.0f, Lanes(1.0f), Lanes(0.0f)) : b.angle;
      split |= std::uint32_t(bits_of(b.radiance * factor > limit)) << i;
      bright |= std::uint32_t(bits_of(!(b.radiance <= 0.0f))) << i;  // NaN must not vanish
    }
    tests_ += BlockLayout::places - 2;
    const std::uint32_t lowest = blocks_.layout().lowest_places(root);
    const std::uint32_t reached = detail::reached_places(split & ~lowest);
    push(nodes_, root, reached & bright & ~split);
    push(open_, root, reached & split & lowest);
  }

  static void push(std::vector<std::uint32_t>& list, std::uint32_t root, std::uint32_t places) {
    for (; places != 0; places &= places - 1)
      list.push_back(BlockLayout::node_at(root, std::uint32_t(std::countr_zero(places))));
  }

  const BoundBlocks& blocks_;
  std::vector<std::uint32_t> nodes_, open_;
  std::size_t tests_ = 0;
  SplitBy split_ = SplitBy::bound_and_angle;
};

}  // namespace coppice::inline HWY_NAMESPACE
