// Merging a face's cuts one end at a time: the portable twin of relight/merge_face.hpp.
#pragma once

#include <bit>
#include <coppice/cut/masked_cuts.hpp>
#include <coppice/relight/clusters.hpp>
#include <coppice/relight/frame_lighting.hpp>

namespace coppice::reference {

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

/// What a receiver sees of a cluster: nothing where the cluster's mean direction lies below its horizon.
template <Quantised Value>
float visible_above(const ReceiverHorizon& horizon, const vec3& direction, Value value) {
  return dot(horizon.normal, direction) > horizon.cosine ? float(value) : 0.0f;
}

}  // namespace detail

/// The clusters that FaceMerger gives, from left to right (Cuts section 3.2, on ends).
template <Quantised Value>
void merge_face(const MaskedCuts<Value>& cuts, const uvec3& receivers, const FrameLighting& frame,
                ClusterList& clusters) {
  const MaskedCutView<Value> a = cuts[receivers.x], b = cuts[receivers.y], c = cuts[receivers.z];
  const std::uint32_t granule_log2 = cuts.granule_log2(), leaf_count = cuts.leaf_count();
  clusters.reset(cuts.piece_count(receivers.x) + cuts.piece_count(receivers.y) +
                 cuts.piece_count(receivers.z) + frame.ends.size());
  const Value *va = a.values, *vb = b.values, *vc = c.values;
  const auto keep = [&](std::uint32_t h) {
    const LightNode& node = frame.nodes[h];
    const std::array<float, 3> visible{detail::visible_above(a.horizon, node.direction, *va),
                                       detail::visible_above(b.horizon, node.direction, *vb),
                                       detail::visible_above(c.horizon, node.direction, *vc)};
    if (node.power != vec3(0) && visible != std::array<float, 3>{}) clusters.push(h, node, visible);
  };
  std::uint32_t begin = 0;
  for (std::uint32_t w = 0; w < cuts.words_per_cut(); ++w) {
    const std::uint32_t ma = a.mask[w], mb = b.mask[w], mc = c.mask[w];
    for (std::uint32_t ends = ma | mb | mc | frame.granule_mask[w]; ends != 0; ends &= ends - 1) {
      const auto bit = std::uint32_t(std::countr_zero(ends));
      const std::uint32_t end = (32 * w + bit + 1) << granule_log2;
      if ((*va | *vb | *vc) != 0)
        detail::emit_cluster(frame, leaf_count, {begin, end}, 1u << granule_log2, keep);
      va += (ma >> bit) & 1, vb += (mb >> bit) & 1, vc += (mc >> bit) & 1;
      begin = end;
    }
  }
  clusters.pad();
}

}  // namespace coppice::reference
