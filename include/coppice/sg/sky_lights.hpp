// An environment that changes from frame to frame, as a light tree and as peaks.
#pragma once

#include <algorithm>
#include <coppice/light/directions.hpp>
#include <coppice/light/environment_cells.hpp>
#include <coppice/relight/frame_lighting.hpp>
#include <coppice/sg/peaks.hpp>
#include <coppice/tree/build.hpp>
#include <optional>
#include <vector>

namespace coppice {

struct SkyOptions {
  std::uint32_t lights = 32768;  ///< leaves of the tree: cells of the sphere
  std::size_t pieces = 256;      ///< of the illumination cut
  std::uint64_t seed = 0;        ///< turns the lattice of cells at random; 0 leaves it
  /// What stays in the cells is found by cuts as well: only lamps that rule the map are worth a cone at each
  /// point, and they are narrow.
  PeakOptions peaks{.threshold = 30, .least_share = 0.02f};
};

/// The map without the texels of its peaks, and the peaks: together they have the map's energy.
struct SkyParts {
  Environment rest;
  std::vector<SgLight> peaks;
};

/// Luminance of the map's mean radiance over the sphere.
inline double mean_luminance(const Image& map) {
  double sum = 0;
  for (int y = 0; y < map.height; ++y) {
    double row = 0;
    for (int x = 0; x < map.width; ++x) row += double(luminance(map.at(x, y)));
    sum += row * texel_solid_angle(y, map.width, map.height);
  }
  return sum / (4 * std::numbers::pi);
}

/// Precondition: the map has texels.
inline SkyParts without_peaks(const Image& map, const PeakOptions& options) {
  Peaks peaks = find_peaks_and_texels(map, mean_luminance(map), options);
  SkyParts parts{{map, 0}, std::move(peaks.lights)};
  for (const BrightRun& run : peaks.runs)
    std::fill_n(parts.rest.map.pixels.begin() + std::ptrdiff_t(map.index(run.begin, run.row)),
                run.end - run.begin, vec3(0));
  return parts;
}

/// Directions of world space as the map has them, and back: turns about +Y (Environment::rotation).
class MapFrame {
 public:
  explicit MapFrame(float rotation) : sine_(std::sin(rotation)), cosine_(std::cos(rotation)) {}
  vec3 to_map(const vec3& d) const { return {cosine_ * d.x - sine_ * d.z, d.y, sine_ * d.x + cosine_ * d.z}; }
  vec3 to_world(const vec3& d) const {
    return {cosine_ * d.x + sine_ * d.z, d.y, cosine_ * d.z - sine_ * d.x};
  }
  /// The point as it stands under the map.
  ShadingPoint to_map(ShadingPoint p) const {
    p.normal = to_map(p.normal), p.tangent = to_map(p.tangent), p.to_viewer = to_map(p.to_viewer);
    return p;
  }

 private:
  float sine_, cosine_;
};

/// A tree over a lattice of directions that is built once; each map fills it anew, the light of a cell
/// standing where it comes from. Directions are those of the map: MapFrame turns them, exactly.
class SkyLights {
 public:
  explicit SkyLights(const SkyOptions& options)
      : options_(options), lattice_(even_directions(options.lights, options.seed)) {
    std::vector<LightSample> samples(lattice_.size());
    for (std::size_t i = 0; i < samples.size(); ++i) samples[i].position = lattice_[i];
    tree_ = build_tree(GeometricMetric(samples));
  }

  /// Takes a map. Cost: two passes over its texels and one over the tree; 0.3 s more where its size is not
  /// that of the last one. Precondition: the map has texels.
  void take(const Image& map) {
    parts_ = without_peaks(map, options_.peaks);
    if (!cells_ || width_ != map.width || height_ != map.height)
      cells_.emplace(lattice_, width_ = map.width, height_ = map.height);
    lighting_ = light_frame(tree_, cells_->gather(parts_.rest), cells_->centroids(parts_.rest, lattice_),
                            options_.pieces, 0);
  }

  const FrameLighting& lighting() const { return lighting_; }
  const SkyParts& parts() const { return parts_; }

 private:
  SkyOptions options_;
  std::vector<vec3> lattice_;
  LightTree tree_;
  std::optional<EnvironmentCells> cells_;
  int width_ = 0, height_ = 0;
  SkyParts parts_;
  FrameLighting lighting_;
};

}  // namespace coppice
