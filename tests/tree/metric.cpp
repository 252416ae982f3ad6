// The geometric metric against Cuts Eq. 11, written out.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <coppice/tree/metric.hpp>
#include <vector>

#include "support/generators.hpp"

using namespace coppice;
using namespace test_support;

namespace {

double squared_length(const glm::dvec3& v) { return glm::dot(v, v); }

std::array<float, 6> point(const GeometricMetric& metric, std::uint32_t light) {
  std::array<float, GeometricMetric::dimension()> result;
  metric.write_point(light, result);
  return result;
}

double squared_distance(const GeometricMetric& metric, std::uint32_t a, std::uint32_t b) {
  const auto p = point(metric, a), q = point(metric, b);
  double sum = 0;
  for (std::size_t k = 0; k < p.size(); ++k)
    sum += (double(p[k]) - double(q[k])) * (double(p[k]) - double(q[k]));
  return sum;
}

/// Eq. 11 between two samples, in double.
double equation_11(const std::vector<LightSample>& lights, std::size_t a, std::size_t b, double weight) {
  glm::dvec3 low(lights[0].position), high = low;
  for (const auto& l : lights)
    low = glm::min(low, glm::dvec3(l.position)), high = glm::max(high, glm::dvec3(l.position));
  return weight * weight / squared_length(high - low) *
             squared_length(glm::dvec3(lights[a].position) - glm::dvec3(lights[b].position)) +
         squared_length(glm::dvec3(lights[a].normal) - glm::dvec3(lights[b].normal));
}

}  // namespace

TEST_CASE("squared distances between the metric's points are Eq. 11") {
  Random random(1);
  for (const float weight : {0.0f, 1.0f, 30.0f}) {
    const auto lights = scattered_lights(random, 50, vec3(3, -2, 5));
    const GeometricMetric metric(lights, weight);
    REQUIRE(metric.size() == 50);
    for (std::uint32_t i = 1; i < 50; ++i)
      CHECK(close(squared_distance(metric, 0, i), equation_11(lights, 0, i, double(weight)), 1e-5));
  }
}

TEST_CASE("the metric does not depend on the unit of length, from 1e-40 to 1e37") {
  Random random(2);
  const auto lights = scattered_lights(random, 20);
  const GeometricMetric expected(lights);
  for (const float unit : {1e-40f, 1e-37f, 1e-20f, 1e3f, 1e37f}) {
    auto scaled = lights;
    for (auto& l : scaled) l.position *= unit;
    const GeometricMetric metric(scaled);
    for (std::uint32_t i = 1; i < 20; ++i) {
      CAPTURE(unit);
      CHECK(close(squared_distance(metric, 0, i), squared_distance(expected, 0, i), 1e-3));
    }
  }
}

TEST_CASE("where all positions coincide only the normals count") {
  const std::vector<LightSample> lights{{vec3(1e6f), vec3(1, 0, 0)}, {vec3(1e6f), vec3(0, 1, 0)}};
  CHECK(squared_distance(GeometricMetric(lights), 0, 1) == doctest::Approx(2));
}

TEST_CASE("the metric of no lights and of one is defined") {
  CHECK(GeometricMetric({}).size() == 0);
  const std::vector<LightSample> one{{vec3(4, 5, 6), vec3(0, 0, 1)}};
  for (const float x : point(GeometricMetric(one), 0)) CHECK(std::isfinite(x));
}
