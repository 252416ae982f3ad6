// The clusters of a merged cut as arrays, ready to be shaded a register at a time.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <coppice/shared/brdf_filtered.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace coppice::inline HWY_NAMESPACE {

/// Clusters of one face as structure of arrays, padded with dark clusters to a multiple of Lanes::width.
/// Visibility is in units of quantised_one. Those of lights in the scene have their position in place of the
/// direction, and w and variance in place of the LightSpread (LocalLights).
class ClusterList {
 public:
  enum Field {
    x,  ///< unit mean direction
    y,
    z,
    red,  ///< power
    green,
    blue,
    mean_length,  ///< LightSpread of the lights
    widening,
    visible_0,  ///< of the face's three receivers
    visible_1,
    visible_2,
    field_count
  };

  /// Room for `capacity` clusters; what was in it is gone.
  void reset(std::size_t capacity) {
    stride_ = (capacity + 2 * Lanes::width - 1) / Lanes::width * Lanes::width;
    if (data_.size() < stride_ * field_count) data_.resize(stride_ * field_count);
    if (nodes_.size() < stride_) nodes_.resize(stride_);
    size_ = 0;
  }

  void push(std::uint32_t heap_id, const LightNode& node, const std::array<float, 3>& visible) {
    const auto spread = light_spread(node.spread);
    const float values[field_count] = {
        node.direction.x,   node.direction.y, node.direction.z, node.power.x, node.power.y, node.power.z,
        spread.mean_length, spread.widening,  visible[0],       visible[1],   visible[2]};
    for (std::size_t f = 0; f < field_count; ++f) data_[f * stride_ + size_] = values[f];
    nodes_[size_++] = heap_id;
  }

  /// One light of the scene, of which `arriving` reaches every receiver.
  void push(std::uint32_t heap_id, const LocalLightNode& light, float arriving) {
    const float values[field_count] = {light.position.x, light.position.y, light.position.z, light.power.x,
                                       light.power.y,    light.power.z,    light.w,          light.variance,
                                       arriving,         arriving,         arriving};
    for (std::size_t f = 0; f < field_count; ++f) data_[f * stride_ + size_] = values[f];
    nodes_[size_++] = heap_id;
  }

  /// The same where only node and visibility are wanted.
  void push(std::uint32_t heap_id, const std::array<float, 3>& visible) {
    for (std::size_t j = 0; j < 3; ++j) data_[(visible_0 + j) * stride_ + size_] = visible[j];
    nodes_[size_++] = heap_id;
  }

  /// Fills the last register with clusters that give no light.
  void pad() {
    padded_ = (size_ + Lanes::width - 1) / Lanes::width * Lanes::width;
    for (std::size_t f = 0; f < field_count; ++f)
      std::fill(data_.data() + f * stride_ + size_, data_.data() + f * stride_ + padded_, 0.0f);
  }

  std::size_t size() const { return size_; }
  std::size_t padded_size() const { return padded_; }
  const float* field(Field f) const { return data_.data() + std::size_t(f) * stride_; }
  const std::uint32_t* nodes() const { return nodes_.data(); }  ///< heap ids

  /// For who fills a register at a time: arrays with room for Lanes::width beyond the size.
  float* field(Field f) { return data_.data() + std::size_t(f) * stride_; }
  std::uint32_t* nodes() { return nodes_.data(); }
  void grow(std::size_t count) { size_ += count; }

 private:
  std::vector<float> data_;
  std::vector<std::uint32_t> nodes_;
  std::size_t stride_ = 0, size_ = 0, padded_ = 0;
};

}  // namespace coppice::inline HWY_NAMESPACE
