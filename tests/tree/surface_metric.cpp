// The distance of points of surfaces against Filtering Eq. 5, written out, and the trees that it makes.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <coppice/tree/build.hpp>
#include <coppice/tree/surface_metric.hpp>
#include <vector>

#include "support/generators.hpp"

using namespace coppice;
using namespace test_support;

namespace {

using Point = std::array<float, SurfaceMetric::dimension()>;

Point point(const SurfaceMetric& metric, std::uint32_t light) {
  Point result;
  metric.write_point(light, result);
  return result;
}

double diagonal(const std::vector<LightSample>& lights) {
  glm::dvec3 low(lights[0].position), high = low;
  for (const auto& l : lights)
    low = glm::min(low, glm::dvec3(l.position)), high = glm::max(high, glm::dvec3(l.position));
  return glm::length(high - low);
}

/// Eq. 5 between two samples, in double.
double equation_5(const std::vector<LightSample>& lights, std::size_t a, std::size_t b) {
  const glm::dvec3 n = glm::normalize(glm::dvec3(lights[a].normal)),
                   m = glm::normalize(glm::dvec3(lights[b].normal));
  const double cosine = glm::dot(n, m);
  return glm::length(glm::dvec3(lights[a].position) - glm::dvec3(lights[b].position)) /
             (diagonal(lights) / 2) +
         std::sqrt(std::max(0.0, 2 - 2 * cosine)) / 4;
}

/// Mean of the points of some samples.
Point mean(const SurfaceMetric& metric, std::span<const std::uint32_t> lights) {
  Point sum{};
  for (const std::uint32_t i : lights)
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += point(metric, i)[k] / float(lights.size());
  return sum;
}

}  // namespace

TEST_CASE("the distance of two samples is Eq. 5") {
  Random random(1);
  const auto lights = scattered_lights(random, 60, vec3(3, -2, 5));
  const SurfaceMetric metric(lights);
  REQUIRE(metric.size() == 60);
  for (std::uint32_t a = 0; a < 60; ++a)
    for (std::uint32_t b = 0; b < 60; ++b) {
      const double distance = double(metric.distance(point(metric, a).data(), point(metric, b).data()));
      CHECK(std::abs(distance - equation_5(lights, a, b)) < 2e-6);
    }
}

TEST_CASE("opposite corners with opposite normals are 2.5 apart, a sample and itself 0") {
  std::vector<LightSample> lights{{vec3(-1, 2, 5), vec3(0, 1, 0)}, {vec3(3, 4, -7), vec3(0, -1, 0)}};
  const SurfaceMetric metric(lights);
  CHECK(metric.distance(point(metric, 0).data(), point(metric, 1).data()) == doctest::Approx(2.5));
  CHECK(metric.distance(point(metric, 0).data(), point(metric, 0).data()) == 0);
}

TEST_CASE("coincident samples differ by their normals alone") {
  std::vector<LightSample> lights(5, {vec3(7, 8, 9), vec3(0, 1, 0)});
  lights[3].normal = vec3(1, 0, 0);
  const SurfaceMetric metric(lights);
  CHECK(metric.distance(point(metric, 0).data(), point(metric, 1).data()) == 0);
  CHECK(metric.distance(point(metric, 0).data(), point(metric, 3).data()) ==
        doctest::Approx(std::sqrt(2.0) / 4));
}

TEST_CASE("the metric does not depend on the unit of length") {
  Random random(2);
  const auto lights = scattered_lights(random, 20);
  const SurfaceMetric expected(lights);
  for (const float unit : {1e-20f, 1e-3f, 1e3f, 1e30f}) {
    auto scaled = lights;
    for (auto& l : scaled) l.position *= unit;
    const SurfaceMetric metric(scaled);
    for (std::uint32_t i = 0; i < 20; ++i)
      for (std::size_t k = 0; k < 6; ++k)
        CHECK(std::abs(point(metric, i)[k] - point(expected, i)[k]) < 1e-5f);
  }
}

TEST_CASE("its trees hold every sample once") {
  Random random(3);
  for (const std::uint32_t count : {0u, 1u, 2u, 3u, 100u, 257u}) {
    const auto lights = scattered_lights(random, count);
    const LightTree tree = build_tree(SurfaceMetric(lights));
    CHECK(are_leaves(tree.light_of_leaf, count));
  }
}

TEST_CASE("the samples of a settled half are nearer to its centre, as far as halves must be equal") {
  Random random(4);
  for (int round = 0; round < 10; ++round) {
    const auto lights = scattered_lights(random, 64);
    const SurfaceMetric metric(lights);
    const LightTree tree = build_tree(metric, {.iterations = 200});
    const std::span<const std::uint32_t> leaves(tree.light_of_leaf);
    const auto left = leaves.first(32), right = leaves.subspan(32);
    const Point a = mean(metric, left), b = mean(metric, right);
    const auto key = [&](std::uint32_t i) {
      return metric.distance(point(metric, i).data(), a.data()) -
             metric.distance(point(metric, i).data(), b.data());
    };
    float most = -1e30f, least = 1e30f;
    for (const std::uint32_t i : left) most = std::max(most, key(i));
    for (const std::uint32_t i : right) least = std::min(least, key(i));
    CHECK(most <= least + 1e-5f);
  }
}

TEST_CASE("two walls apart are told apart, and so are the sides of one") {
  for (const bool are_sides : {false, true}) {
    Random random(5);
    std::vector<LightSample> lights;
    for (std::uint32_t i = 0; i < 128; ++i) {
      const float y = random.uniform(), z = random.uniform();
      const bool second = i % 2 == 1;
      lights.push_back(
          {vec3(!are_sides && second ? 9.0f : 0.0f, y, z), vec3(are_sides && second ? -1.0f : 1.0f, 0, 0)});
    }
    for (auto& l : lights) l.position.y *= are_sides ? 0.1f : 1.0f, l.position.z *= are_sides ? 0.1f : 1.0f;
    if (are_sides) lights.push_back({vec3(0, 4, 4), vec3(1, 0, 0)});  // the box is far wider than the wall
    const LightTree tree = build_tree(SurfaceMetric(lights));
    std::size_t mixed = 0;
    for (std::uint32_t i = 0; i < tree.leaf_count() / 2; ++i)
      if (tree.light_of_leaf[i] < 128) mixed += tree.light_of_leaf[i] % 2 != tree.light_of_leaf[0] % 2;
    CHECK(mixed <= 1);
  }
}
