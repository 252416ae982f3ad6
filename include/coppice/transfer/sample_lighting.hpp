// Direct light at all samples, by shadow rays.
#pragma once

#include <algorithm>
#include <coppice/core/config.hpp>
#include <coppice/core/parallel.hpp>
#include <coppice/light/bounce.hpp>
#include <coppice/transfer/sample_lookup.hpp>
#include <coppice/transfer/sized_light.hpp>
#include <span>
#include <vector>

namespace coppice {

struct SampleLightingOptions {
  /// s in metres: irradiance falls as 1/√(d⁴ + s⁴) in place of 1/d²; usually softening_distance(). 0: lights
  /// as they are, with spikes where they come near.
  float softening = 0;
  std::uint32_t points = 25;  ///< of a light that has a radius (PCA section 6)
};

/// Four sample spacings: nearer lights make spikes that a sample's cell does not have in the mean, and that
/// no basis of few vectors holds. Farther than a metre it takes less than 0.4% at 45,000 samples in a
/// kitchen: docs/transfer.md.
inline float softening_distance(std::span<const SurfaceSample> samples) {
  return 4 * sample_spacing(samples);
}

namespace detail {

/// Shadow rays from any samples, traced sixteen at a time; adds what arrives to the samples' irradiance in
/// the order in which the rays come.
template <Occluder O>
class SampleShadows {
 public:
  SampleShadows(const O& occluder, std::span<vec3> irradiance)
      : occluder_(occluder), irradiance_(irradiance) {}

  void add(std::size_t sample, const vec3& origin, const LightPath& path) {
    rays_.origin_x[count_] = origin.x, rays_.origin_y[count_] = origin.y, rays_.origin_z[count_] = origin.z;
    rays_.direction_x[count_] = path.direction.x;
    rays_.direction_y[count_] = path.direction.y;
    rays_.direction_z[count_] = path.direction.z;
    rays_.t_max[count_] = path.t_max;
    samples_[count_] = sample;
    arriving_[count_] = path.irradiance;
    if (++count_ == 16) finish();
  }

  /// Traces those that wait.
  void finish() {
    if (count_ == 0) return;
    const std::uint32_t lanes = (1u << count_) - 1, free = lanes & ~occluder_.occluded(rays_, lanes);
    for (std::uint32_t i = 0; i < count_; ++i)
      if ((free >> i) & 1) irradiance_[samples_[i]] += arriving_[i];
    count_ = 0;
  }

 private:
  const O& occluder_;
  std::span<vec3> irradiance_;
  ShadowPacket rays_{};
  std::size_t samples_[16] = {};
  vec3 arriving_[16] = {};
  std::uint32_t count_ = 0;
};

/// d²/√(d⁴ + s⁴), without overflow.
inline float softened_share(float distance2, float softening) {
  const float ratio = (std::sqrt(distance2) / softening) * (std::sqrt(distance2) / softening);
  return ratio < 1 ? ratio / std::sqrt(1 + ratio * ratio) : 1 / std::sqrt(1 + 1 / (ratio * ratio));
}

/// The path with a brightness of 1/√(d⁴ + softening⁴) in place of 1/d²: smooth, and exact from afar.
inline LightPath softened(LightPath path, const LocalLight& light, const vec3& point, float softening) {
  const vec3 across = light.position - light.w * point;
  if (light.w > 0 && softening > 0) path.irradiance *= softened_share(dot(across, across), softening);
  return path;
}

}  // namespace detail

/// Direct irradiance (W/m², linear RGB) of points of light at every sample: out[i] is that of samples[i]. A
/// shadow ray a sample and point above its horizon. The same for any executor. Precondition: sizes equal.
template <Occluder O, Executor E>
void light_directly(std::span<const SurfaceSample> samples, std::span<const LocalLight> points,
                    const O& occluder, const E& executor, float softening, std::span<vec3> out) {
  COPPICE_ASSERT(out.size() == samples.size());
  executor(samples.size(), 1024, [&](std::size_t begin, std::size_t end) {
    std::fill(out.begin() + std::ptrdiff_t(begin), out.begin() + std::ptrdiff_t(end), vec3(0));
    detail::SampleShadows<O> shadows(occluder, out);
    for (std::size_t i = begin; i < end; ++i) {
      const vec3 origin = ray_origin(samples[i]);
      for (const LocalLight& light : points)
        if (const auto path = path_to(light, origin, samples[i].normal))
          shadows.add(i, origin, detail::softened(*path, light, origin, softening));
    }
    shadows.finish();
  });
}

/// The same of a light with a size, as its points.
template <Occluder O, Executor E>
std::vector<vec3> direct_irradiance(std::span<const SurfaceSample> samples, const SizedLight& light,
                                    const O& occluder, const E& executor,
                                    const SampleLightingOptions& options) {
  std::vector<vec3> irradiance(samples.size());
  light_directly(samples, points_of(light, options.points), occluder, executor, options.softening,
                 irradiance);
  return irradiance;
}

/// What a light brings to samples of which the visibility is known, at an intensity of 1 W/sr (W/m²): its
/// colour times out[i] is their irradiance. A light with a radius counts as one point at its centre, which is
/// exact where all of its ball is above the horizon (cosine / distance² is a harmonic function). The same for
/// any executor. Precondition: sizes equal.
template <Executor E>
void light_by_visibility(std::span<const SurfaceSample> samples, LocalLight light,
                         std::span<const float> visibility, float softening, const E& executor,
                         std::span<float> out) {
  COPPICE_ASSERT(visibility.size() == samples.size() && out.size() == samples.size());
  light.intensity = vec3(1);
  executor(samples.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      out[i] = 0;
      if (!(visibility[i] > 0)) continue;
      if (const auto path = path_to(light, samples[i].position, samples[i].normal))
        out[i] = visibility[i] * detail::softened(*path, light, samples[i].position, softening).irradiance.x;
    }
  });
}

}  // namespace coppice
