// Clusters that wait to be evaluated at one point, and what was found out about those of its face.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <coppice/shared/layout.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace coppice::inline HWY_NAMESPACE {

/// Nodes, with their heap ids and their visibility in [0, 1] at the point, in the order in which they were
/// pushed. The nodes are copied: siblings lie side by side in the tree, and so they do here, where a register
/// of them is read without a gather. A whole register can be read from any element on.
template <class Node>
class NodeQueue {
 public:
  void clear() { size_ = 0; }
  std::size_t size() const { return size_; }
  const Node* nodes() const { return nodes_.data(); }
  std::uint32_t id(std::size_t i) const { return ids_[i]; }
  const float* visibility() const { return visibility_.data(); }

  /// The nodes first … first + count - 1, all with one visibility.
  template <std::uint32_t count>
  HWY_INLINE void push(const Node* tree, std::uint32_t first, float visibility) {
    if (size_ + count + Lanes::width > ids_.size()) grow();
    for (std::uint32_t k = 0; k < count; ++k) {
      nodes_[size_ + k] = tree[first + k];
      ids_[size_ + k] = first + k;
      visibility_[size_ + k] = visibility;
    }
    size_ += count;
  }

 private:
  HWY_NOINLINE void grow() {
    const std::size_t size = 2 * ids_.size() + 64 * Lanes::width;
    ids_.resize(size), visibility_.resize(size), nodes_.resize(size, Node{});
  }

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> ids_;
  std::vector<float> visibility_;
  std::size_t size_ = 0;
};

/// A register of clusters that were evaluated: the terms of the BRDF, the visibility at the point, the error.
struct EvaluatedLanes {
  Lanes diffuse, specular, fresnel, visible, error;
};

/// What PointShader::refined keeps from one point to the next: memory.
template <class Node>
class RefinementScratchOf {
 public:
  NodeQueue<Node> queue;

  /// Room for the clusters of a face; the queue is empty.
  void reset(std::size_t padded_size) {
    queue.clear();
    if (evaluated_.size() < 5 * padded_size) evaluated_.resize(5 * padded_size);
  }

  HWY_INLINE void store(std::size_t i, const EvaluatedLanes& e) {
    float* to = evaluated_.data() + 5 * i;
    e.diffuse.store(to), e.specular.store(to + Lanes::width), e.fresnel.store(to + 2 * Lanes::width);
    e.visible.store(to + 3 * Lanes::width), e.error.store(to + 4 * Lanes::width);
  }
  HWY_INLINE EvaluatedLanes load(std::size_t i) const {
    const float* from = evaluated_.data() + 5 * i;
    return {Lanes::load(from), Lanes::load(from + Lanes::width), Lanes::load(from + 2 * Lanes::width),
            Lanes::load(from + 3 * Lanes::width), Lanes::load(from + 4 * Lanes::width)};
  }
  /// Of one cluster.
  float visibility(std::size_t k) const {
    return evaluated_[5 * (k / Lanes::width * Lanes::width) + 3 * Lanes::width + k % Lanes::width];
  }

 private:
  std::vector<float> evaluated_;  // registers of five fields
};
using RefinementScratch = RefinementScratchOf<LightNode>;

}  // namespace coppice::inline HWY_NAMESPACE
