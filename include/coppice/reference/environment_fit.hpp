// What the fit of an environment is judged by: convolutions, values and regions, the slow and obvious way.
#pragma once

#include <coppice/shared/sg.h>

#include <algorithm>
#include <coppice/core/image.hpp>
#include <coppice/light/environment.hpp>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace coppice::reference {

/// max(0, cosine)^exponent; 1 is the clamped cosine.
inline double lobe_value(double cosine, double exponent) {
  if (cosine <= 0) return 0;
  return exponent == 1 ? cosine : std::pow(cosine, exponent);
}

/// ∫ L(ω) max(0, ω·axis)^exponent dω of an environment, texel by texel, each as a point at its centre, in
/// double. Cost: one power a texel.
inline glm::dvec3 convolve(const Environment& environment, const vec3& axis, double exponent) {
  const Image& map = environment.map;
  const double turn = double(environment.rotation);
  glm::dvec3 sum(0);
  for (int y = 0; y < map.height; ++y) {
    const double elevation = std::numbers::pi * (0.5 - (y + 0.5) / map.height), c = std::cos(elevation);
    glm::dvec3 row(0);
    for (int x = 0; x < map.width; ++x) {
      const double azimuth = 2 * std::numbers::pi * ((x + 0.5) / map.width - 0.5) - turn;
      const glm::dvec3 d(c * std::cos(azimuth), std::sin(elevation), c * std::sin(azimuth));
      row += lobe_value(glm::dot(d, glm::dvec3(axis)), exponent) * glm::dvec3(map.at(x, y));
    }
    sum += texel_solid_angle(y, map.width, map.height) * row;
  }
  return sum;
}

/// The mean of max(0, along + across cos φ)^exponent over a turn: in closed form for the cosine, by 48 points
/// otherwise.
inline double ring_mean(double along, double across, double exponent) {
  constexpr int azimuths = 48;
  if (exponent == 1) {
    if (std::abs(along) >= across) return std::max(along, 0.0);
    const double edge = std::acos(-along / across);
    return (along * edge + across * std::sin(edge)) / std::numbers::pi;
  }
  double sum = 0;
  for (int i = 0; i < azimuths / 2; ++i)  // one half is like the other
    sum += lobe_value(along + across * std::cos(2 * std::numbers::pi * (i + 0.5) / azimuths), exponent);
  return sum * 2 / azimuths;
}

/// ∫ G(ω) max(0, ω·n)^exponent dω where n lies at this angle from the Gaussian's axis: Gauss's three points
/// on 32 pieces of √t, t = λ(1 - cos), rings about the axis. Against sums over the texels of its picture,
/// within 2e-5 of its greatest value for λ from 4 to 60 and exponents 1 and 50; 5e-4 at λ = 0.5.
inline double convolve_gaussian(double sharpness, double angle, double exponent) {
  constexpr int pieces = 32;
  const double most = std::sqrt(std::min(2 * sharpness, 40.0)), root = std::sqrt(0.6);
  const double places[3] = {0.5 - 0.5 * root, 0.5, 0.5 + 0.5 * root};
  const double weights[3] = {5 / 18.0, 8 / 18.0, 5 / 18.0};
  double sum = 0;
  for (int i = 0; i < 3 * pieces; ++i) {
    const double s = most * (i / 3 + places[i % 3]) / pieces, depth = s * s / sharpness;
    const double ring =
        ring_mean((1 - depth) * std::cos(angle), std::sqrt(depth * (2 - depth)) * std::sin(angle), exponent);
    sum += weights[i % 3] * 2 * s * std::exp(-s * s) * ring;
  }
  return 2 * std::numbers::pi * sum * most / (pieces * sharpness);
}

/// convolve_gaussian at any angle, from a table: many directions, few sharpnesses.
class GaussianConvolution {
 public:
  GaussianConvolution(double sharpness, double exponent) {
    for (int i = 0; i <= steps; ++i)
      values_.push_back(convolve_gaussian(sharpness, std::numbers::pi * i / steps, exponent));
  }
  /// Linear between steps of 0.18°.
  double at(double cosine) const {
    const double x = std::acos(std::clamp(cosine, -1.0, 1.0)) / std::numbers::pi * steps;
    const std::size_t i = std::size_t(std::min(x, steps - 1.0));
    return values_[i] + (x - double(i)) * (values_[i + 1] - values_[i]);
  }

 private:
  static constexpr int steps = 1024;
  std::vector<double> values_;
};

/// The sum of the lights' convolutions with the lobe about each axis. Sharpnesses that many lights share get
/// a table.
inline std::vector<glm::dvec3> convolve(std::span<const SgLight> lights, std::span<const vec3> axes,
                                        double exponent) {
  std::map<float, std::vector<const SgLight*>> by_sharpness;
  for (const SgLight& light : lights) by_sharpness[light.sharpness].push_back(&light);
  std::vector<glm::dvec3> sums(axes.size(), glm::dvec3(0));
  for (const auto& [sharpness, alike] : by_sharpness) {
    std::optional<GaussianConvolution> table;
    if (alike.size() > 4) table.emplace(double(sharpness), exponent);
    for (const SgLight* light : alike)
      for (std::size_t i = 0; i < axes.size(); ++i) {
        const double cosine = std::clamp(glm::dot(glm::dvec3(light->axis), glm::dvec3(axes[i])), -1.0, 1.0);
        sums[i] +=
            glm::dvec3(light->amplitude) *
            (table ? table->at(cosine) : convolve_gaussian(double(sharpness), std::acos(cosine), exponent));
      }
  }
  return sums;
}

/// Σ amplitude · G(d), in double.
inline glm::dvec3 radiance(std::span<const SgLight> lights, const vec3& d) {
  glm::dvec3 sum(0);
  for (const SgLight& light : lights) {
    const glm::dvec3 apart = glm::dvec3(d) - glm::dvec3(light.axis);
    sum += std::exp(-0.5 * double(light.sharpness) * glm::dot(apart, apart)) * glm::dvec3(light.amplitude);
  }
  return sum;
}

/// √(Σ|a - b|²/Σ|b|²), over all channels alike; 0 where both are black.
inline double relative_rms(std::span<const glm::dvec3> a, std::span<const glm::dvec3> b) {
  double error = 0, size = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    error += glm::dot(a[i] - b[i], a[i] - b[i]);
    size += glm::dot(b[i], b[i]);
  }
  return error > 0 ? std::sqrt(error / size) : 0;
}

/// The connected regions of texels brighter than the threshold, by flooding: for each texel the number of its
/// region, from 1 on in the order of their first texels, 0 for none. Neighbours as in bright_regions.hpp.
inline std::vector<std::uint32_t> flood_regions(const Image& map, float threshold) {
  std::vector<std::uint32_t> labels(map.pixels.size(), 0);
  std::uint32_t count = 0;
  std::vector<std::pair<int, int>> open;
  const auto enter = [&](int x, int y) {
    x = (x + map.width) % map.width;
    if (y < 0 || y >= map.height || labels[map.index(x, y)] || !(luminance(map.at(x, y)) > threshold)) return;
    labels[map.index(x, y)] = count;
    open.push_back({x, y});
  };
  const auto flood = [&] {
    while (!open.empty()) {
      const auto [x, y] = open.back();
      open.pop_back();
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) enter(x + dx, y + dy);
      if (y == 0 || y == map.height - 1)
        for (int other = 0; other < map.width; ++other) enter(other, y);
    }
  };
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) {
      if (labels[map.index(x, y)] || !(luminance(map.at(x, y)) > threshold)) continue;
      ++count;
      enter(x, y);
      flood();
    }
  return labels;
}

}  // namespace coppice::reference
