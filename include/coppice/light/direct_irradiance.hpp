// What a point of a surface receives from all lights, by shadow rays.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <algorithm>
#include <coppice/core/random.hpp>
#include <coppice/light/local_light.hpp>
#include <coppice/light/surface_samples.hpp>
#include <coppice/scene/occluder.hpp>
#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace coppice {

/// From a point to a light, and what arrives there if nothing is between them.
struct LightPath {
  vec3 direction;  ///< unit
  float t_max;     ///< a little before the light: surface lights lie on surfaces; +infinity for distant ones
  vec3 irradiance;
};

/// To points, lights that are nearer than this (m) are this far away: what arrives stays finite.
inline constexpr float least_light_distance = 1e-6f;

/// None where the light is below the point's horizon, turned away, or dark.
inline std::optional<LightPath> path_to(const LocalLight& light, const vec3& point, const vec3& normal) {
  const vec3 across = light.position - light.w * point;
  const float along = dot(across, normal);
  if (!(along > 0) || light.intensity == vec3(0)) return std::nullopt;
  const float distance2 = std::max(dot(across, across), least_light_distance * least_light_distance);
  const float distance = std::sqrt(distance2);
  const float emission = emission_towards(light, across / -distance);
  if (!(emission > 0)) return std::nullopt;
  constexpr float short_of = 1 - 1e-4f;
  return LightPath{across / distance,
                   light.w > 0 ? short_of * distance / light.w : std::numeric_limits<float>::infinity(),
                   light.intensity * (emission * along / distance / (distance2 + light.area / pi))};
}

namespace detail {

/// Collects shadow rays from one point, traces them sixteen at a time, and calls visit(light, irradiance) for
/// those that are free, in their order.
template <Occluder O, class Visit>
class ShadowBatch {
 public:
  ShadowBatch(const O& occluder, const vec3& origin, Visit visit) : occluder_(occluder), visit_(visit) {
    std::fill_n(rays_.origin_x, 16, origin.x);
    std::fill_n(rays_.origin_y, 16, origin.y);
    std::fill_n(rays_.origin_z, 16, origin.z);
  }

  void add(std::size_t light, const LightPath& path, float weight = 1) {
    rays_.direction_x[count_] = path.direction.x;
    rays_.direction_y[count_] = path.direction.y;
    rays_.direction_z[count_] = path.direction.z;
    rays_.t_max[count_] = path.t_max;
    lights_[count_] = light;
    irradiance_[count_++] = weight * path.irradiance;
    if (count_ == 16) trace();
  }

  /// Traces those that wait. Whether one of the paths so far is free.
  bool finish() {
    if (count_ > 0) trace();
    return any_free_;
  }

 private:
  void trace() {
    const std::uint32_t lanes = (1u << count_) - 1, free = lanes & ~occluder_.occluded(rays_, lanes);
    for (std::uint32_t i = 0; i < count_; ++i)
      if ((free >> i) & 1) visit_(lights_[i], irradiance_[i]);
    any_free_ |= free != 0;
    count_ = 0;
  }

  const O& occluder_;
  Visit visit_;
  ShadowPacket rays_{};
  std::size_t lights_[16];
  vec3 irradiance_[16];
  std::uint32_t count_ = 0;
  bool any_free_ = false;
};

/// Items with weights, to be drawn in proportion.
class WeightedItems {
 public:
  explicit WeightedItems(std::span<const float> weights) : sums_(weights.size()) {
    for (std::size_t i = 0; i < weights.size(); ++i) {
      sums_[i] = total_ += double(weights[i]);
      positive_ += weights[i] > 0;
    }
  }
  std::size_t positive_count() const { return positive_; }

  /// Calls visit(i, n · step / weight) for items that n > 0 of all `count` draws meet, which lie a step apart
  /// on the line of all weights: E[Σ factor · value] is the sum of the values.
  template <class Visit>
  void draw(std::size_t count, Random& random, Visit&& visit) const {
    const double step = total_ / double(count);
    double next = step * double(random.uniform());
    for (auto item = sums_.begin(); next < total_;) {
      item = std::upper_bound(item, sums_.end(), next);
      if (item == sums_.end()) return;
      int draws = 0;
      for (; next < *item; next += step) ++draws;
      const double weight = *item - (item == sums_.begin() ? 0.0 : item[-1]);
      visit(std::size_t(item - sums_.begin()), float(draws * step / weight));
    }
  }

 private:
  std::vector<double> sums_;
  double total_ = 0;
  std::size_t positive_ = 0;
};

/// What lights send out, however near a point is to them.
inline std::vector<float> powers(std::span<const LocalLight> lights) {
  std::vector<float> result;
  for (const LocalLight& light : lights)
    result.push_back(luminance(light.intensity) / (light.w > 0 ? 1 : dot(light.position, light.position)));
  return result;
}

}  // namespace detail

}  // namespace coppice

namespace coppice::detail::inline HWY_NAMESPACE {

/// Lights as arrays, padded with dark ones to whole registers.
struct LightArrays {
  std::vector<float> x, y, z, w, axis_x, axis_y, axis_z, offset, square, disc, brightness;

  explicit LightArrays(std::span<const LocalLight> lights) {
    for (const LocalLight& light : lights) append(light);
    while (x.size() % Lanes::width != 0) append({.intensity = vec3(0)});
  }

  /// Luminance of what each light brings to a point without shadows; the padding's after them, 0.
  std::vector<float> unshadowed(const vec3& point, const vec3& normal) const {
    std::vector<float> result(x.size());
    for (std::size_t i = 0; i < x.size(); i += Lanes::width) {
      const auto at = [i](const std::vector<float>& values) { return Lanes::load(&values[i]); };
      const Lanes ax = at(x) - at(w) * point.x, ay = at(y) - at(w) * point.y, az = at(z) - at(w) * point.z;
      const Lanes distance2 = max(ax * ax + ay * ay + az * az, least_light_distance * least_light_distance);
      const Lanes distance = sqrt(distance2);
      const Lanes tilt = (at(axis_x) * ax + at(axis_y) * ay + at(axis_z) * az) / distance;
      const Lanes s = min(max(at(offset) - tilt, 0.0f), 1.0f), q = at(square);
      const Lanes along = max(normal.x * ax + normal.y * ay + normal.z * az, 0.0f);
      const Lanes sent = at(brightness) * s * (1.0f - q + q * s);
      min(sent * along / (distance * (distance2 + at(disc))), 1e30f).store(&result[i]);
    }
    return result;
  }

 private:
  void append(const LocalLight& light) {
    x.push_back(light.position.x), y.push_back(light.position.y), z.push_back(light.position.z);
    w.push_back(light.w);
    axis_x.push_back(light.axis.x), axis_y.push_back(light.axis.y), axis_z.push_back(light.axis.z);
    offset.push_back(light.offset), square.push_back(light.square);
    disc.push_back(light.area / pi), brightness.push_back(luminance(light.intensity));
  }
};

}  // namespace coppice::detail::inline HWY_NAMESPACE

namespace coppice::inline HWY_NAMESPACE {

/// Irradiance at surfaces: a shadow ray to every light, or, where lights are more than `most_rays`, to that
/// many drawn by what they would bring without shadows. Systematic draws in the order of the lights: without
/// bias; standard deviation at most 1/(2√most_rays) of what would arrive without shadows (0.8% by default)
/// where shadows do not depend on the lights' order, and less where lights near in the list are near in
/// space. Does not copy the lights: they must outlive it.
class DirectIrradiance {
 public:
  explicit DirectIrradiance(std::span<const LocalLight> lights, std::size_t most_rays = 4096)
      : lights_(lights), arrays_(lights), by_power_(detail::powers(lights)), most_rays_(most_rays) {}

  /// W/m², linear RGB.
  template <Occluder O>
  vec3 at(const O& occluder, const vec3& origin, const vec3& normal, Random& random) const {
    glm::dvec3 sum(0);
    for_each_free(occluder, origin, normal, random,
                  [&sum](std::size_t, const vec3& irradiance) { sum += glm::dvec3(irradiance); });
    return vec3(sum);
  }

  /// Calls visit(light, irradiance) for the lights that reach the point, by index, in their order; where they
  /// are drawn, those that were, each with the irradiance that it stands for. The sum is the point's
  /// irradiance.
  template <Occluder O, class Visit>
  void for_each_free(const O& occluder, const vec3& origin, const vec3& normal, Random& random,
                     Visit&& visit) const {
    detail::ShadowBatch<O, Visit&> batch(occluder, origin, visit);
    const auto add = [&](std::size_t i, float weight) {
      if (const auto path = path_to(lights_[i], origin, normal)) batch.add(i, *path, weight);
    };
    if (lights_.size() <= most_rays_)
      for (std::size_t i = 0; i < lights_.size(); ++i) add(i, 1);
    else
      detail::WeightedItems(arrays_.unshadowed(origin, normal)).draw(most_rays_, random, add);
    batch.finish();
  }

  /// Whether any light reaches the point. Exact for up to 64 lights above its horizon. Otherwise no more than
  /// 64 lights are asked, drawn by what they would bring; where a share p of the light arrives, the answer is
  /// no with a probability of at most (1 - p)^64.
  template <Occluder O>
  bool reaches(const O& occluder, const vec3& origin, const vec3& normal, Random& random) const {
    detail::ShadowBatch batch(occluder, origin, [](std::size_t, const vec3&) {});
    const auto add = [&](std::size_t i, float) {
      if (const auto path = path_to(lights_[i], origin, normal)) batch.add(i, *path);
    };
    by_power_.draw(16, random, add);  // finds most points that are lit
    if (batch.finish()) return true;
    const detail::WeightedItems items(arrays_.unshadowed(origin, normal));
    if (items.positive_count() <= 64)
      for (std::size_t i = 0; i < lights_.size(); ++i) add(i, 1);
    else
      for (int round = 0; round < 4 && !batch.finish(); ++round) items.draw(16, random, add);
    return batch.finish();
  }

 private:
  std::span<const LocalLight> lights_;
  detail::LightArrays arrays_;
  detail::WeightedItems by_power_;
  std::size_t most_rays_;
};

}  // namespace coppice::inline HWY_NAMESPACE
