// The samples at which light is stored, cluster by cluster.
#pragma once

#include <coppice/light/surface_samples.hpp>
#include <cstdint>
#include <vector>

namespace coppice {

/// Surface samples sorted by cluster (PCA section 4.1): cluster c has those in [begin(c), end(c)). Colours
/// are albedos in [0, 1], areas those of the samples' cells.
struct ClusteredSamples {
  std::vector<SurfaceSample> samples;
  std::vector<std::uint32_t> ends;  ///< a cluster: its samples end before this index; ascending

  std::size_t size() const { return samples.size(); }
  std::size_t cluster_count() const { return ends.size(); }
  std::size_t begin(std::size_t cluster) const { return cluster == 0 ? 0 : ends[cluster - 1]; }
  std::size_t end(std::size_t cluster) const { return ends[cluster]; }
  std::size_t size(std::size_t cluster) const { return end(cluster) - begin(cluster); }
  std::span<const SurfaceSample> of(std::size_t cluster) const {
    return std::span(samples).subspan(begin(cluster), size(cluster));
  }
};

}  // namespace coppice
