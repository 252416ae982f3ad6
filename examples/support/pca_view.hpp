// What the camera sees of a room, and how light at its samples reaches each pixel.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <coppice/embree/threads.hpp>
#include <coppice/embree/tracer.hpp>
#include <coppice/relight/deferred.hpp>
#include <coppice/transfer/clustered_samples.hpp>
#include <coppice/transfer/sized_light.hpp>
#include <coppice/transfer/splat.hpp>
#include <support/words.hpp>

namespace coppice::program {

/// Where splats are summed.
enum class SplatTarget {
  pixels,   ///< at each pixel
  vertices  ///< at the vertices that are seen, and interpolated between them
};
inline const Words<SplatTarget> splat_target_words{{"pixels", SplatTarget::pixels},
                                                   {"vertices", SplatTarget::vertices}};

/// A light of a frame, and how much of it each sample sees.
struct SeenLight {
  SizedLight light;
  std::vector<LocalLight> points;  ///< points_of(light)
  std::vector<float> visibility;   ///< a sample, in [0, 1]
};

/// Camera and scene rest; lights do not. Scene, tracer and threads outlive it.
class PcaView {
 public:
  PcaView(const Scene& scene, const EmbreeTracer& tracer, const Camera& camera, const Raster& raster,
          Shading shading, std::span<const SurfaceSample> samples, SplatTarget target,
          const SplatOptions& splats, const Threads& threads);

  const DirectImage& seen() const { return seen_; }
  std::size_t splat_count() const { return splats_.samples.size(); }

  /// Reflected light of the lights themselves: without shadows at each pixel, times the visibility that the
  /// samples share in it.
  Image direct(std::span<const SurfaceSample> samples, std::span<const SeenLight> lights) const;
  /// The same with a shadow ray from each pixel to each point of the lights.
  Image direct_by_rays(std::span<const SeenLight> lights) const;
  /// Irradiance at samples as light that the pixels reflect alike in all directions.
  Image indirect(std::span<const vec3> irradiance) const;

 private:
  void splat_onto_pixels(std::span<const SurfaceSample> samples, const SplatOptions& options);
  void splat_onto_vertices(std::span<const SurfaceSample> samples, const SplatOptions& options);
  template <class Radiance>
  Image shade(Radiance&& radiance) const;

  const Scene& scene_;
  const EmbreeTracer& tracer_;
  const Threads& threads_;
  Raster raster_;
  std::vector<CameraHit> hits_;
  std::vector<ShadingPoint> points_;
  std::vector<vec3> origins_, albedos_;  ///< a hit
  SplatWeights splats_;                  ///< a hit
  DirectImage seen_;
};

}  // namespace coppice::program
