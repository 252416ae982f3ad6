// A frame: the merge once a face, and its points from the merged clusters.
#pragma once

#include <coppice/relight/merge_face.hpp>
#include <coppice/relight/shade.hpp>
#include <coppice/relight/shading_buffer.hpp>
#include <span>

namespace coppice::inline HWY_NAMESPACE {

/// Shades the points of faces [begin, end) into radiance[point], merging once a face, and counts the clusters
/// that each point evaluates where cluster_count is not empty. `scales`: those of FaceMerger. Faces are
/// independent: any split over threads gives the same bits.
template <class Lights, Quantised Value>
void shade_faces(const ShadingBuffer& buffer, const MaskedCuts<Value>& cuts, std::span<const float> scales,
                 const LightingOf<typename Lights::Node>& frame, const LobeOptions& lobes, std::size_t begin,
                 std::size_t end, std::span<vec3> radiance, std::span<std::uint32_t> cluster_count) {
  FaceMerger<Value, Lights> merger(cuts, frame, scales);
  ClusterList clusters;
  RefinementScratchOf<typename Lights::Node> scratch;
  const float scale = scales.empty() ? 1 / quantised_one<Value> : 1.0f;
  constexpr bool has_positions = std::is_same_v<Lights, LocalLights>;
  for (std::size_t f = begin; f < end; ++f) {
    merger.merge(buffer.faces[f].receivers, clusters);
    for (std::uint32_t p = buffer.faces[f].first_point; p < buffer.end_of(f); ++p) {
      const Lights lights(has_positions ? buffer.positions[p] : vec3(0));
      const ShadedPoint shaded =
          shade_point(buffer.points[p], clusters, scale, lobes,
                      std::span<const typename Lights::Node>(frame.nodes), scratch, lights);
      radiance[p] = shaded.radiance;
      if (!cluster_count.empty()) cluster_count[p] = shaded.clusters;
    }
  }
}

/// For distant lights.
template <Quantised Value>
void shade_faces(const ShadingBuffer& buffer, const MaskedCuts<Value>& cuts, const FrameLighting& frame,
                 const LobeOptions& lobes, std::size_t begin, std::size_t end, std::span<vec3> radiance,
                 std::span<std::uint32_t> cluster_count) {
  shade_faces<DistantLights>(buffer, cuts, {}, frame, lobes, begin, end, radiance, cluster_count);
}

}  // namespace coppice::inline HWY_NAMESPACE
