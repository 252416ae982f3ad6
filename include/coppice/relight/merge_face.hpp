// The merged cut of a face: three visibility cuts and the illumination cut, vectorised.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <coppice/relight/clusters.hpp>
#include <coppice/relight/light_kinds.hpp>
#include <coppice/relight/merged_pieces.hpp>

namespace coppice::inline HWY_NAMESPACE {

namespace merging {

using Ids = hn::Vec<hn::ScalableTag<std::uint32_t>>;
inline constexpr hn::ScalableTag<std::uint32_t> id_tag;
inline constexpr hn::ScalableTag<std::int32_t> int_tag;
inline constexpr hn::ScalableTag<float> float_tag;

/// Heap ids of the nodes [begin, end): the level is the exponent of the size as a float, exact for powers of
/// two.
inline Ids nodes_of_ranges(std::uint32_t leaf_count, Ids begin, Ids end) {
  const auto size = hn::ConvertTo(float_tag, hn::BitCast(int_tag, hn::Sub(end, begin)));
  const Ids level = hn::Sub(hn::ShiftRight<23>(hn::BitCast(id_tag, size)), hn::Set(id_tag, 127));
  return hn::Shr(hn::Add(begin, hn::Set(id_tag, leaf_count)), level);
}

/// Lanes::width values as floats.
template <Quantised Value>
Lanes load_values(const Value* from) {
  const hn::Rebind<Value, hn::ScalableTag<std::int32_t>> tag;
  return Lanes(hn::ConvertTo(float_tag, hn::PromoteTo(int_tag, hn::LoadU(tag, from))));
}

/// Writes the lanes in the mask to `to` one after the other, and anything behind them up to a whole register.
inline void store_kept(LaneMask mask, Lanes values, float* to) {
  hn::StoreU(hn::Compress(values.values, mask.values), float_tag, to);
}
inline void store_kept(LaneMask mask, Ids values, std::uint32_t* to) {
  hn::StoreU(hn::Compress(values, hn::RebindMask(id_tag, mask.values)), id_tag, to);
}

inline std::size_t count(LaneMask mask) { return hn::CountTrue(float_tag, mask.values); }

/// Where a receiver sees a cluster at all.
inline Lanes above(const ReceiverHorizon& horizon, Lanes x, Lanes y, Lanes z, Lanes visible) {
  const Lanes cosine =
      mul_add(horizon.normal.x, x, mul_add(horizon.normal.y, y, Lanes(horizon.normal.z) * z));
  return select(cosine > horizon.cosine, visible, 0.0f);
}

}  // namespace merging

/// Merges the visibility cuts of faces with the illumination cut of a frame. Keeps its scratch between faces.
template <Quantised Value, class Lights = DistantLights>
class FaceMerger {
 public:
  /// Visibility comes in units of quantised_one; where `scales` has one a receiver, squared and multiplied by
  /// that. Precondition: cuts and frame are of one tree and granule.
  FaceMerger(const MaskedCuts<Value>& cuts, const LightingOf<typename Lights::Node>& frame,
             std::span<const float> scales = {})
      : cuts_(cuts), frame_(frame), scales_(scales) {}

  /// The clusters that are lit and that at least one receiver sees; they serve every point of the face. Those
  /// that nobody sees leave before their nodes are read.
  void merge(const uvec3& receivers, ClusterList& clusters) {
    pieces_.merge(cuts_, receivers, frame_);
    seen_.reset(pieces_.size() + frame_.fine_nodes.size());
    for (const FineGranule& fine : frame_.fine_granules) keep_fine(fine);
    for (std::size_t i = 0; i < pieces_.size(); i += Lanes::width) keep_seen(i);
    clusters.reset(seen_.size());
    make_room(found_, seen_.size());
    for (std::size_t i = 0; i < seen_.size(); ++i) found_[i] = frame_.nodes[seen_.nodes()[i]];
    const ReceiverHorizon horizons[3] = {cuts_[receivers.x].horizon, cuts_[receivers.y].horizon,
                                         cuts_[receivers.z].horizon};
    const Lanes scales[3] = {scale_of(receivers.x), scale_of(receivers.y), scale_of(receivers.z)};
    for (std::size_t i = 0; i < seen_.size(); i += Lanes::width) keep_lit(i, horizons, scales, clusters);
    clusters.pad();
  }

 private:
  /// A granule in which the illumination cut is finer leaves the pieces, and its parts come in from a side
  /// list.
  void keep_fine(const FineGranule& fine) {
    const std::size_t piece = pieces_.piece_of(fine.granule);
    const std::array<float, 3> visible{float(pieces_.values(0)[piece]), float(pieces_.values(1)[piece]),
                                       float(pieces_.values(2)[piece])};
    if (visible == std::array<float, 3>{}) return;
    for (std::uint32_t k = 0; k < fine.count; ++k) seen_.push(frame_.fine_nodes[fine.first + k], visible);
    pieces_.hide(piece);
  }

  /// Nodes and values of a register of pieces that some receiver sees.
  void keep_seen(std::size_t i) {
    const auto begin = hn::LoadU(merging::id_tag, pieces_.ends() + i - 1),
               end = hn::LoadU(merging::id_tag, pieces_.ends() + i);
    const Lanes a = merging::load_values(pieces_.values(0) + i),
                b = merging::load_values(pieces_.values(1) + i),
                c = merging::load_values(pieces_.values(2) + i);
    const LaneMask seen = (a + b + c > 0.0f) & first_lanes(pieces_.size() - i);
    const std::size_t at = seen_.size();
    merging::store_kept(seen, merging::nodes_of_ranges(cuts_.leaf_count(), begin, end), seen_.nodes() + at);
    merging::store_kept(seen, a, seen_.field(ClusterList::visible_0) + at);
    merging::store_kept(seen, b, seen_.field(ClusterList::visible_1) + at);
    merging::store_kept(seen, c, seen_.field(ClusterList::visible_2) + at);
    seen_.grow(merging::count(seen));
  }

  Lanes scale_of(std::uint32_t receiver) const { return scales_.empty() ? 1.0f : scales_[receiver]; }

  /// What a receiver sees of a register of clusters.
  static HWY_INLINE Lanes visible_from(const ReceiverHorizon& horizon, Lanes scale, const NodeLanes& n,
                                       Lanes visible) {
    if constexpr (std::is_same_v<Lights, DistantLights>)
      return merging::above(horizon, n.x, n.y, n.z, visible);
    else
      return scale * visible * visible;
  }

  /// Of these, the ones that have power and lie above the horizon of a receiver that sees them.
  void keep_lit(std::size_t i, const ReceiverHorizon* horizons, const Lanes* scales, ClusterList& clusters) {
    const std::size_t valid = std::min(Lanes::width, seen_.size() - i);
    const NodeLanes n = load_nodes(found_.data() + i);
    Lanes visible[3];
    for (int j = 0; j < 3; ++j) {
      const auto field = ClusterList::Field(ClusterList::visible_0 + j);
      visible[j] = visible_from(horizons[j], scales[j], n, Lanes::load(seen_.field(field) + i));
    }
    const LaneMask kept = (n.red + n.green + n.blue != 0.0f) & (visible[0] + visible[1] + visible[2] > 0.0f) &
                          first_lanes(valid);
    const auto spread = Lights::kept(n);
    const Lanes values[ClusterList::field_count] = {
        n.x,        n.y,        n.z,       n.red, n.green, n.blue, spread.mean_length, spread.widening,
        visible[0], visible[1], visible[2]};
    const std::size_t at = clusters.size();
    for (std::size_t f = 0; f < ClusterList::field_count; ++f)
      if (all(kept))
        values[f].store(clusters.field(ClusterList::Field(f)) + at);
      else
        merging::store_kept(kept, values[f], clusters.field(ClusterList::Field(f)) + at);
    merging::store_kept(kept, hn::LoadU(merging::id_tag, seen_.nodes() + i), clusters.nodes() + at);
    clusters.grow(merging::count(kept));
  }

  const MaskedCuts<Value>& cuts_;
  const LightingOf<typename Lights::Node>& frame_;
  std::span<const float> scales_;
  MergedPieces<Value> pieces_;
  ClusterList seen_;                          // of which only nodes and visibility are used
  std::vector<typename Lights::Node> found_;  // the nodes of seen_, side by side: read without a gather
};

}  // namespace coppice::inline HWY_NAMESPACE
