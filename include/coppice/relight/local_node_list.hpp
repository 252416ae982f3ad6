// Nodes of local lights side by side, to be read a register at a time.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <coppice/relight/local_lighting.hpp>
#include <coppice/relight/node_lanes.hpp>

namespace coppice::inline HWY_NAMESPACE {

/// A register of nodes and of how they shine. `is_leaf` counts where a node is one light.
struct LocalNodeLanes {
  Lanes red, green, blue, variance, x, y, z, w;
  Lanes axis_x, axis_y, axis_z, offset, square, softening, radius, luminance;
  LaneMask is_leaf;
};

/// Lanes::width nodes of both arrays, one after the other. Bit i of `leaves` tells whether node i is a leaf.
inline LocalNodeLanes load_local_nodes(const LocalLightNode* nodes, const LocalEmission* emissions,
                                       std::uint64_t leaves) {
  const NodeLanes n = load_nodes(nodes), e = load_nodes(emissions);
  return {n.red,   n.green, n.blue,   n.spread, n.x, n.y, n.z,           n.solid_angle,    e.red,
          e.green, e.blue,  e.spread, e.x,      e.y, e.z, e.solid_angle, lane_mask(leaves)};
}

/// Copies of nodes, each with its heap id and a number of its user's. A whole register can be read from any
/// element on.
class LocalNodeList {
 public:
  void clear() { size_ = 0; }
  std::size_t size() const { return size_; }
  std::uint32_t id(std::size_t i) const { return ids_[i]; }
  float value(std::size_t i) const { return values_[i]; }

  /// The nodes first … first + count - 1, all with one value.
  void push(const LocalLighting& lighting, std::uint32_t first, std::uint32_t count, float value) {
    if (size_ + count + Lanes::width > ids_.size()) grow(count);
    std::copy_n(lighting.frame().nodes.data() + first, count, nodes_.data() + size_);
    std::copy_n(lighting.emissions().data() + first, count, emissions_.data() + size_);
    for (std::uint32_t k = 0; k < count; ++k, ++size_) ids_[size_] = first + k, values_[size_] = value;
  }
  /// Drops all from element `size` on; what they held can be read until the next push.
  void shrink(std::size_t size) { size_ = size; }

  /// A register from element i on, of which `count` are wanted.
  LocalNodeLanes load(std::size_t i, std::size_t count, std::uint32_t leaf_count) const {
    std::uint64_t leaves = 0;
    for (std::size_t k = 0; k < count; ++k) leaves |= std::uint64_t(ids_[i + k] >= leaf_count) << k;
    return load_local_nodes(nodes_.data() + i, emissions_.data() + i, leaves);
  }

 private:
  void grow(std::size_t count) {
    const std::size_t size = 2 * ids_.size() + count + 64 * Lanes::width;
    nodes_.resize(size, LocalLightNode{}), emissions_.resize(size, LocalEmission{});
    ids_.resize(size), values_.resize(size);
  }

  std::vector<LocalLightNode> nodes_;
  std::vector<LocalEmission> emissions_;
  std::vector<std::uint32_t> ids_;
  std::vector<float> values_;
  std::size_t size_ = 0;
};

}  // namespace coppice::inline HWY_NAMESPACE
