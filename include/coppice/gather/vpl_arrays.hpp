// Nodes of a VPL tree as arrays, so that registers of nodes meet one point.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <coppice/shared/vpl.h>

#include <array>
#include <coppice/core/config.hpp>
#include <cstddef>
#include <span>
#include <vector>

namespace coppice::inline HWY_NAMESPACE {

/// A register of nodes.
struct VplLanes {
  VplShape<Lanes> shape;
  Lanes diffuse[3];
  Lanes specular[3];
};

/// Nodes field by field, each field padded with dark nodes to a whole register.
class VplArrays {
 public:
  /// Room for so many nodes, and none in it.
  void reset(std::size_t capacity) {
    const std::size_t padded = (capacity + Lanes::width - 1) / Lanes::width * Lanes::width;
    if (padded > stride_) stride_ = padded, values_.assign(fields * stride_, 0.0f);
    size_ = 0;
  }

  /// Precondition: there is room.
  void push(const VplNode& n) {
    COPPICE_ASSERT(size_ < stride_);
    const std::array<float, fields> row{n.position.x, n.position.y, n.position.z, n.variance,  n.normal.x,
                                        n.normal.y,   n.normal.z,   n.softening,  n.lobe.x,    n.lobe.y,
                                        n.lobe.z,     n.exponent,   n.diffuse.x,  n.diffuse.y, n.diffuse.z,
                                        n.specular.x, n.specular.y, n.specular.z};
    float* at = values_.data() + size_++;
    for (std::size_t k = 0; k < fields; ++k) at[k * stride_] = row[k];
  }

  /// These nodes, padded.
  void assign(std::span<const VplNode> nodes, std::span<const std::uint32_t> ids) {
    reset(ids.size());
    for (const std::uint32_t id : ids) push(nodes[id]);
    pad();
  }

  std::size_t size() const { return size_; }

  /// Fills the last register with dark nodes.
  void pad() {
    const std::size_t before = size_;
    while (size_ % Lanes::width != 0) push(VplNode{});
    size_ = before;
  }

  /// Nodes [begin, begin + width). Precondition: begin is a multiple of the width, below size().
  VplLanes load(std::size_t begin) const {
    const float* at = values_.data() + begin;
    const auto field = [&](std::size_t k) { return Lanes::load(at + k * stride_); };
    return {{field(0), field(1), field(2), field(3), field(4), field(5), field(6), field(7), field(8),
             field(9), field(10), field(11)},
            {field(12), field(13), field(14)},
            {field(15), field(16), field(17)}};
  }

 private:
  static constexpr std::size_t fields = 18;
  std::size_t size_ = 0, stride_ = 0;
  std::vector<float> values_;
};

}  // namespace coppice::inline HWY_NAMESPACE
