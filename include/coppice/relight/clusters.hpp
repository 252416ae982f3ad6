// The merged cut of a face: three visibility cuts and the illumination cut, as arrays ready to be shaded.
#pragma once

#include <algorithm>
#include <bit>
#include <coppice/core/simd.hpp>
#include <coppice/cut/masked_cuts.hpp>
#include <coppice/relight/frame_lighting.hpp>
#include <cstdint>
#include <vector>

namespace coppice {

/// Clusters of one face as structure of arrays, padded with dark clusters to a multiple of Lanes::width.
/// Visibility is in units of quantised_one.
class ClusterList {
 public:
  enum Field { x, y, z, red, green, blue, visible_0, visible_1, visible_2, field_count };

  /// Room for `capacity` clusters; what was in it is gone.
  void reset(std::size_t capacity) {
    stride_ = (capacity + 2 * Lanes::width - 1) / Lanes::width * Lanes::width;
    if (data_.size() < stride_ * field_count) data_.resize(stride_ * field_count);
    size_ = 0;
  }

  void push(const LightNode& node, float v0, float v1, float v2) {
    float* p = data_.data() + size_++;
    p[x * stride_] = node.direction.x, p[y * stride_] = node.direction.y, p[z * stride_] = node.direction.z;
    p[red * stride_] = node.power.x, p[green * stride_] = node.power.y, p[blue * stride_] = node.power.z;
    p[visible_0 * stride_] = v0, p[visible_1 * stride_] = v1, p[visible_2 * stride_] = v2;
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

 private:
  std::vector<float> data_;
  std::size_t stride_ = 0, size_ = 0, padded_ = 0;
};

namespace detail {

/// One cluster of the merged cut on granules: split where the illumination cut is finer than the granule.
template <class Emit>
void emit_cluster(const FrameLighting& frame, std::uint32_t leaf_count, LeafRange range,
                  std::uint32_t granule, Emit&& emit) {
  if (range.size() == granule && granule > 1) {
    std::uint32_t inside = frame.mask[range.begin / 32] >> (range.begin % 32);
    inside &= (granule < 32 ? (1u << granule) : 0u) - 1u;
    for (inside &= ~(1u << (granule - 1)); inside != 0; inside &= inside - 1) {
      const std::uint32_t end = (range.end - granule) + std::uint32_t(std::countr_zero(inside)) + 1;
      emit(node_of_range(leaf_count, range.begin, end));
      range.begin = end;
    }
  }
  emit(node_of_range(leaf_count, range.begin, range.end));
}

}  // namespace detail

/// Merges the visibility cuts of three receivers and the illumination cut, and keeps the clusters that are
/// lit and that at least one receiver sees. One pass over the OR of the masks: each step yields one cluster
/// (Cuts section 3.2, on ends). The clusters serve every point of the face. Precondition: cuts and frame are
/// of one tree and granule.
template <Quantised Value>
void merge_face(const MaskedCuts<Value>& cuts, const uvec3& receivers, const FrameLighting& frame,
                ClusterList& clusters) {
  const MaskedCutView<Value> a = cuts[receivers.x], b = cuts[receivers.y], c = cuts[receivers.z];
  const std::uint32_t granule_log2 = cuts.granule_log2(), leaf_count = cuts.leaf_count();
  clusters.reset(cuts.piece_count(receivers.x) + cuts.piece_count(receivers.y) +
                 cuts.piece_count(receivers.z) + frame.ends.size());
  const Value *va = a.values, *vb = b.values, *vc = c.values;
  std::uint32_t begin = 0;
  for (std::uint32_t w = 0; w < cuts.words_per_cut(); ++w) {
    const std::uint32_t ma = a.mask[w], mb = b.mask[w], mc = c.mask[w];
    for (std::uint32_t ends = ma | mb | mc | frame.granule_mask[w]; ends != 0; ends &= ends - 1) {
      const auto bit = std::uint32_t(std::countr_zero(ends));
      const std::uint32_t end = (32 * w + bit + 1) << granule_log2;
      if ((*va | *vb | *vc) != 0)
        detail::emit_cluster(frame, leaf_count, {begin, end}, 1u << granule_log2, [&](std::uint32_t h) {
          const LightNode& node = frame.nodes[h];
          if (node.power != vec3(0)) clusters.push(node, float(*va), float(*vb), float(*vc));
        });
      va += (ma >> bit) & 1, vb += (mb >> bit) & 1, vc += (mc >> bit) & 1;
      begin = end;
    }
  }
  clusters.pad();
}

}  // namespace coppice
