// How shadows are judged: by the share of decisions, lit or not, that shadow rays would have made otherwise.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <coppice/core/parallel.hpp>
#include <coppice/light/bounce.hpp>
#include <coppice/transfer/sized_light.hpp>
#include <cstddef>
#include <span>
#include <vector>

namespace coppice {

namespace detail {

/// Shadow rays of many samples, traced sixteen at a time.
template <Occluder O>
class SampleRays {
 public:
  /// free[sample] counts the rays of a sample that nothing blocks.
  SampleRays(const O& occluder, std::span<float> free) : occluder_(occluder), free_(free) {}

  void add(std::size_t sample, const vec3& origin, const LightPath& path) {
    rays_.origin_x[count_] = origin.x, rays_.direction_x[count_] = path.direction.x;
    rays_.origin_y[count_] = origin.y, rays_.direction_y[count_] = path.direction.y;
    rays_.origin_z[count_] = origin.z, rays_.direction_z[count_] = path.direction.z;
    rays_.t_max[count_] = path.t_max;
    samples_[count_++] = sample;
    if (count_ == 16) trace();
  }

  /// Traces those that wait.
  void trace() {
    if (count_ == 0) return;
    const std::uint32_t lanes = (1u << count_) - 1, free = lanes & ~occluder_.occluded(rays_, lanes);
    for (std::uint32_t i = 0; i < count_; ++i) free_[samples_[i]] += float((free >> i) & 1);
    count_ = 0;
  }

 private:
  const O& occluder_;
  std::span<float> free_;
  ShadowPacket rays_{};
  std::size_t samples_[16];
  std::uint32_t count_ = 0;
};

/// out[i]: the share of the points above the horizon of sample i that it sees; 0 where there are none.
template <Occluder O>
void exact_visibility(std::span<const SurfaceSample> samples, std::span<const LocalLight> points,
                      const O& occluder, std::span<float> out) {
  std::vector<std::uint32_t> above(samples.size(), 0);
  std::fill(out.begin(), out.end(), 0.0f);
  SampleRays<O> rays(occluder, out);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const vec3 origin = ray_origin(samples[i]);
    for (const LocalLight& point : points)
      if (const auto path = path_to(point, origin, samples[i].normal)) {
        rays.add(i, origin, *path);
        ++above[i];
      }
  }
  rays.trace();
  for (std::size_t i = 0; i < samples.size(); ++i)
    if (above[i] > 1) out[i] /= float(above[i]);
}

}  // namespace detail

/// Visibility of a light at samples by shadow rays, `points` of it each (points_of): out[i] is the share of
/// those above the horizon of sample i that nothing hides, 0 where all are below it. So 0 or 1 for a light of
/// one point. The same for any executor. Cost: a ray a sample and point, in packets of 16. Precondition: out
/// has the samples' size.
template <Occluder O, Executor E>
void exact_visibility(std::span<const SurfaceSample> samples, std::span<const LocalLight> points,
                      const O& occluder, const E& executor, std::span<float> out) {
  COPPICE_ASSERT(out.size() == samples.size());
  executor(samples.size(), 1024, [&](std::size_t begin, std::size_t end) {
    detail::exact_visibility(samples.subspan(begin, end - begin), points, occluder,
                             out.subspan(begin, end - begin));
  });
}

/// What arrives at a sample from all points of a light if nothing is between them (W/m², luminance); 0 where
/// all are below its horizon.
inline double unshadowed_luminance(std::span<const LocalLight> points, const SurfaceSample& sample) {
  double sum = 0;
  for (const LocalLight& point : points)
    if (const auto path = path_to(point, ray_origin(sample), sample.normal))
      sum += double(luminance(path->irradiance));
  return sum;
}

/// How often a reconstruction of visibility takes lit samples for dark or dark ones for lit (a visibility of
/// one half or more counts as lit). Pairs of a sample and a light below its horizon do not count.
struct WrongDecisions {
  double plain = 0;       ///< share of the pairs; 0 where there are none
  double weighted = 0;    ///< the same with each pair weighted by its unshadowed irradiance
  std::size_t pairs = 0;  ///< that count
};

/// Adds up wrong decisions over lights.
class DecisionCount {
 public:
  /// Compares visibility of the light that consists of `points` at all samples with the exact one. A NaN
  /// counts as dark. Precondition: both have the samples' size.
  void add(std::span<const SurfaceSample> samples, std::span<const LocalLight> points,
           std::span<const float> visibility, std::span<const float> exact) {
    COPPICE_ASSERT(visibility.size() == samples.size() && exact.size() == samples.size());
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double weight = unshadowed_luminance(points, samples[i]);
      if (!(weight > 0)) continue;
      const bool wrong = (visibility[i] >= 0.5f) != (exact[i] >= 0.5f);
      ++pairs_, wrong_pairs_ += wrong;
      weight_ += weight, wrong_weight_ += wrong ? weight : 0;
    }
  }

  WrongDecisions result() const {
    if (pairs_ == 0) return {};
    return {double(wrong_pairs_) / double(pairs_), wrong_weight_ / weight_, pairs_};
  }

 private:
  std::size_t pairs_ = 0, wrong_pairs_ = 0;
  double weight_ = 0, wrong_weight_ = 0;
};

/// Wrong decisions over all samples and lights against shadow rays to `points` points of each light.
/// `visibility(light)` gives a value in [0, 1] for every sample, as a span<const float>. The same for any
/// executor.
template <Occluder O, Executor E, class Visibility>
WrongDecisions wrong_decisions(std::span<const SurfaceSample> samples, std::span<const SizedLight> lights,
                               const O& occluder, const E& executor, Visibility&& visibility,
                               std::uint32_t points = 25) {
  DecisionCount count;
  std::vector<float> exact(samples.size());
  for (const SizedLight& light : lights) {
    const std::vector<LocalLight> parts = points_of(light, points);
    exact_visibility(samples, parts, occluder, executor, exact);
    count.add(samples, parts, visibility(light), exact);
  }
  return count.result();
}

}  // namespace coppice
