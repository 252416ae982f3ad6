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
/// pushed. Negative visibility takes a cluster out of the sum again. The nodes are copied: siblings lie side
/// by side in the tree, and so they do here, where a register of them is read without a gather. A whole
/// register can be read from any element on.
class NodeQueue {
 public:
  void clear() { size_ = 0; }
  std::size_t size() const { return size_; }
  const LightNode* nodes() const { return nodes_.data(); }
  std::uint32_t id(std::size_t i) const { return ids_[i]; }
  const float* visibility() const { return visibility_.data(); }

  /// The nodes first … first + count - 1, all with one visibility.
  template <std::uint32_t count>
  HWY_INLINE void push(const LightNode* tree, std::uint32_t first, float visibility) {
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
    ids_.resize(size), visibility_.resize(size), nodes_.resize(size, LightNode{});
  }

  std::vector<LightNode> nodes_;
  std::vector<std::uint32_t> ids_;
  std::vector<float> visibility_;
  std::size_t size_ = 0;
};

/// What PointShader::refined needs from one point to the next.
struct RefinementScratch {
  NodeQueue queue;
  std::vector<float> errors, visibility;  ///< a cluster of the face

  void reset(std::size_t padded_size) {
    queue.clear();
    if (errors.size() < padded_size) errors.resize(padded_size), visibility.resize(padded_size);
  }
};

}  // namespace coppice::inline HWY_NAMESPACE
