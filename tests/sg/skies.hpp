// Maps, points and sums for the tests of relighting by cones.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <coppice/sg/product_tree.hpp>
#include <coppice/sg/sky_lights.hpp>

#include "support/generators.hpp"
#include "support/shading.hpp"

namespace sg_test {

using namespace coppice;

/// A dim gradient, a bright band, and lamps of some size: what rooms and skies are like.
inline Image some_map(Random& random, int width, int height, int lamps = 3) {
  Image map(width, height);
  const vec3 low = support::random_colour(random), high = support::random_colour(random);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const float up = float(y) / float(height), round = std::cos(2 * pi * float(x) / float(width));
      map.at(x, y) = (0.2f + 0.1f * random.uniform()) * (low * up + high * (1 - up)) * (1.2f + round);
    }
  for (int i = 0; i < lamps; ++i) {
    const int x0 = int(random.below(std::uint32_t(width))), y0 = int(random.below(std::uint32_t(height)));
    const vec3 colour = 300.0f * support::random_colour(random) + 30.0f;
    for (int y = y0; y < std::min(height, y0 + 2); ++y)
      for (int x = x0; x < x0 + 2; ++x) map.at(x % width, y) = colour;
  }
  return map;
}

/// Σ radiance · solid angle, in double.
inline glm::dvec3 energy_of(const Image& map) {
  glm::dvec3 sum(0);
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x)
      sum += texel_solid_angle(y, map.width, map.height) * glm::dvec3(map.at(x, y));
  return sum;
}

/// Random points of every BRDF, wide and narrow.
inline std::vector<ShadingPoint> points_of_all_materials(int count, Random& random) {
  auto points = support::random_points(support::wide_materials, count, random);
  const auto narrow = support::random_points(support::narrow_materials, count, random);
  points.insert(points.end(), narrow.begin(), narrow.end());
  return points;
}

/// |a - b| over |b|; |a| where b is 0.
inline double apart(const glm::dvec3& a, const glm::dvec3& b) {
  const double size = glm::length(b);
  return glm::length(a - b) / (size > 0 ? size : 1);
}

inline bool is_never_negative(const vec3& v) { return is_finite(v) && v.x >= 0 && v.y >= 0 && v.z >= 0; }

/// Root mean square of relative errors, and the greatest.
struct Deviation {
  double squares = 0, most = 0;
  int count = 0;
  void add(double error) { squares += error * error, most = std::max(most, error), ++count; }
  double rms() const { return count > 0 ? std::sqrt(squares / count) : 0; }
};

/// √(Σ |value - expected|²/Σ |expected|²).
struct RelativeRms {
  double errors = 0, squares = 0;
  void add(const vec3& value, const glm::dvec3& expected) {
    const glm::dvec3 d = glm::dvec3(value) - expected;
    errors += glm::dot(d, d), squares += glm::dot(expected, expected);
  }
  double value() const { return std::sqrt(errors / squares); }
};

}  // namespace sg_test
