// A frame: the merge once a face, and its points from the merged clusters.
#pragma once

#include <coppice/relight/merge_face.hpp>
#include <coppice/relight/shade.hpp>
#include <coppice/relight/shading_buffer.hpp>
#include <span>

namespace coppice::inline HWY_NAMESPACE {

/// Shades the points of faces [begin, end) into radiance[point], merging once a face, and counts the clusters
/// that each point evaluates where cluster_count is not empty. Faces are independent: any split over threads
/// gives the same bits.
template <Quantised Value>
void shade_faces(const ShadingBuffer& buffer, const MaskedCuts<Value>& cuts, const FrameLighting& frame,
                 const LobeOptions& lobes, std::size_t begin, std::size_t end, std::span<vec3> radiance,
                 std::span<std::uint32_t> cluster_count) {
  FaceMerger<Value> merger(cuts, frame);
  ClusterList clusters;
  RefinementScratch scratch;
  for (std::size_t f = begin; f < end; ++f) {
    merger.merge(buffer.faces[f].receivers, clusters);
    for (std::uint32_t p = buffer.faces[f].first_point; p < buffer.end_of(f); ++p) {
      const ShadedPoint shaded =
          shade_point(buffer.points[p], clusters, 1 / quantised_one<Value>, lobes, frame.nodes, scratch);
      radiance[p] = shaded.radiance;
      if (!cluster_count.empty()) cluster_count[p] = shaded.clusters;
    }
  }
}

}  // namespace coppice::inline HWY_NAMESPACE
