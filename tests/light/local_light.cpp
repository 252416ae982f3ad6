// Emission of points, spots, surfaces and suns against their definitions.
#include <doctest/doctest.h>

#include <coppice/core/random.hpp>
#include <coppice/light/local_light.hpp>

using namespace coppice;

namespace {

/// A unit direction at an angle from a unit axis.
vec3 at_angle(const vec3& axis, float angle, Random& random) {
  const vec3 across = normalize(cross(axis, random.direction()));
  return std::cos(angle) * axis + std::sin(angle) * across;
}

/// What KHR_lights_punctual asks of spots, in double.
double attenuation(double cosine, double inner, double outer) {
  const double ramp = (cosine - std::cos(outer)) / std::max(0.001, std::cos(inner) - std::cos(outer));
  const double s = std::clamp(ramp, 0.0, 1.0);
  return s * s;
}

}  // namespace

TEST_CASE("points shine alike to all sides") {
  Random random(1);
  const LocalLight light = point_light(vec3(1, 2, 3), vec3(4, 5, 6));
  CHECK(light.position == vec3(1, 2, 3));
  CHECK(light.intensity == vec3(4, 5, 6));
  CHECK(light.w == 1);
  CHECK(light.area == 0);
  for (int i = 0; i < 50; ++i) CHECK(emission_towards(light, random.direction()) == 1);
}

TEST_CASE("spots have the ramp of KHR_lights_punctual between their two cones") {
  Random random(2);
  for (int i = 0; i < 300; ++i) {
    const float outer = 0.02f + 1.55f * random.uniform(), inner = outer * 0.95f * random.uniform();
    const vec3 axis = random.direction();
    const LocalLight light = spot_light(vec3(0), vec3(1), axis, inner, outer);
    if (std::cos(inner) - std::cos(outer) > 0.0011f) CHECK(emission_towards(light, axis) == 1);
    CHECK(emission_towards(light, -axis) == 0);
    CHECK(emission_towards(light, at_angle(axis, outer + 0.01f, random)) == 0);
    CHECK(emission_towards(light, at_angle(axis, pi * random.uniform(), random)) >= 0);
    const vec3 d = at_angle(axis, 1.1f * outer * random.uniform(), random);
    const double expected = attenuation(glm::dot(glm::dvec3(axis), glm::dvec3(d)), inner, outer);
    const double slope = 2 / std::max(0.001, std::cos(double(inner)) - std::cos(double(outer)));
    CHECK(std::abs(double(emission_towards(light, d)) - expected) <= 1e-6 + 4e-7 * slope);
  }
}

TEST_CASE("surfaces shine by the cosine to their normal, and not behind") {
  Random random(3);
  const vec3 normal = random.direction();
  const LocalLight light = surface_light(vec3(0), normal, vec3(2, 4, 8), 0.5f);
  CHECK(light.intensity == vec3(1, 2, 4));
  CHECK(light.area == 0.5f);
  for (int i = 0; i < 100; ++i) {
    const vec3 d = random.direction();
    CHECK(emission_towards(light, d) == std::max(0.0f, dot(normal, d)));
  }
}

TEST_CASE("distant lights give their irradiance, whatever the reach") {
  for (const float reach : {0.01f, 1.0f, 300.0f}) {
    const LocalLight light = distant_light(vec3(0, 0.6f, 0.8f), vec3(1, 2, 3), reach);
    CHECK(light.w == 0);
    const vec3 given = emission_towards(light, vec3(0, -0.6f, -0.8f)) * light.intensity /
                       dot(light.position, light.position);
    CHECK(length(given - vec3(1, 2, 3)) < 1e-6f);
  }
}
