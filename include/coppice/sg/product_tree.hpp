// What a frame shines with, ready to be multiplied with BRDFs: the pieces of an illumination cut, the tree
// that joins them, and peaks.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <coppice/shared/sg.h>

#include <algorithm>
#include <coppice/relight/clusters.hpp>
#include <coppice/relight/frame_lighting.hpp>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace coppice::inline HWY_NAMESPACE {

/// Nodes are numbered: first the pieces of the frame's illumination cut in the order of their leaves, then
/// one for each joint of two nodes, so that children come before their parent and the last joint is the root.
/// Peaks come after the pieces in the same list of clusters and are joined with nothing.
class ProductTree {
 public:
  ProductTree() = default;

  /// `frame` lasts as long as the tree. Cost: M log M for M pieces.
  ProductTree(const FrameLighting& frame, std::span<const SgLight> peaks) : frame_(&frame) {
    const auto leaf_count = std::uint32_t(frame.nodes.size() / 2);
    clusters_.reset(frame.ends.size() + peaks.size());
    std::vector<std::pair<std::uint32_t, std::uint32_t>> open;  // heap id, node
    for_each_piece(frame.ends, [&](LeafRange r, std::size_t i) {
      const std::uint32_t h = node_of_range(leaf_count, r.begin, r.end);
      clusters_.push(h, frame.nodes[h], {1, 1, 1});
      open.push_back({h, std::uint32_t(i)});
    });
    piece_count_ = std::uint32_t(open.size());
    for (const SgLight& peak : peaks) push(peak);
    clusters_.pad();
    join(open);
  }

  std::uint32_t piece_count() const { return piece_count_; }
  /// Pieces, then peaks; all visible.
  const ClusterList& clusters() const { return clusters_; }
  std::span<const SgShape> peaks() const { return peaks_; }
  std::uint32_t peak_count() const { return std::uint32_t(clusters_.size()) - piece_count_; }
  /// The children of node piece_count() + i.
  std::span<const uvec2> joints() const { return joints_; }
  /// Precondition: there are pieces.
  std::uint32_t root() const { return piece_count_ + std::uint32_t(joints_.size()) - 1; }
  /// By heap id.
  std::span<const LightNode> nodes() const { return frame_->nodes; }

 private:
  /// A cluster of no node of the tree: refinement never splits it.
  void push(const SgLight& peak) {
    peaks_.push_back({peak.axis, peak.sharpness});
    LightNode node;
    node.power = peak.amplitude * sg_integral(peak.sharpness);
    node.direction = peak.axis;
    node.solid_angle = 0;
    node.spread = sg_mean_shortfall(peak.sharpness);
    clusters_.push(0, node, {1, 1, 1});
  }

  /// The deepest node's sibling is always there: the pieces are a cut, and so they stay when two are joined.
  void join(std::vector<std::pair<std::uint32_t, std::uint32_t>>& open) {
    std::make_heap(open.begin(), open.end());
    const auto pop = [&] {
      std::pop_heap(open.begin(), open.end());
      const auto top = open.back();
      open.pop_back();
      return top;
    };
    while (open.size() > 1) {
      const auto second = pop(), first = pop();
      joints_.push_back({first.second, second.second});
      open.push_back({first.first / 2, piece_count_ + std::uint32_t(joints_.size()) - 1});
      std::push_heap(open.begin(), open.end());
    }
  }

  const FrameLighting* frame_ = nullptr;
  ClusterList clusters_;
  std::uint32_t piece_count_ = 0;
  std::vector<SgShape> peaks_;
  std::vector<uvec2> joints_;
};

}  // namespace coppice::inline HWY_NAMESPACE
