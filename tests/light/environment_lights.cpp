// An environment as distant lights: its power, its sun's place, its irradiance, its turn.
#include <doctest/doctest.h>

#include <coppice/core/random.hpp>
#include <coppice/light/environment_lights.hpp>

#include "support/scenes.hpp"

using namespace coppice;

namespace {

/// The map's irradiance at a surface, texel by texel; the total where the normal is zero.
glm::dvec3 irradiance_of(const Environment& environment, const vec3& normal) {
  glm::dvec3 sum(0);
  const Image& map = environment.map;
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) {
      const vec3 d = texel_direction(x, y, map.width, map.height);
      const double cosine = normal == vec3(0) ? 1 : std::max(0.0, double(dot(d, normal)));
      sum += cosine * texel_solid_angle(y, map.width, map.height) * glm::dvec3(map.at(x, y));
    }
  return sum;
}

/// Of lights that stand at the distance 1.
glm::dvec3 irradiance_of(const std::vector<LocalLight>& lights, const vec3& normal) {
  glm::dvec3 sum(0);
  for (const LocalLight& light : lights)
    sum += (normal == vec3(0) ? 1 : std::max(0.0, double(dot(light.position, normal)))) *
           glm::dvec3(light.intensity);
  return sum;
}

double relative(const glm::dvec3& a, const glm::dvec3& b) { return length(a - b) / length(b); }

/// Root mean square error of the irradiance at surfaces of all directions, over that of the irradiance.
double irradiance_error(const std::vector<LocalLight>& lights, const Environment& environment) {
  Random random(4);
  double error = 0, total = 0;
  for (int i = 0; i < 100; ++i) {
    const vec3 n = random.direction();
    const glm::dvec3 expected = irradiance_of(environment, n), off = irradiance_of(lights, n) - expected;
    error += dot(off, off), total += dot(expected, expected);
  }
  return std::sqrt(error / total);
}

}  // namespace

TEST_CASE("environment lights keep the power, whatever their number and the map's size") {
  for (const int height : {1, 2, 16, 64, 513, 1100}) {
    const Environment sky = support::sky(normalize(vec3(1, 1.2f, 0.6f)), 2 * height, height);
    const glm::dvec3 power = irradiance_of(sky, vec3(0));
    for (const std::size_t count : {1u, 2u, 7u, 300u}) {
      CAPTURE(height);
      CAPTURE(count);
      const auto lights = environment_lights(sky, count, 1);
      CHECK(lights.size() <= count);
      CHECK(lights.size() + (height < 3 ? count : 0) >= count);
      CHECK(relative(irradiance_of(lights, vec3(0)), power) < 1e-6);
    }
  }
}

TEST_CASE("irradiance is right to the second order of the cells: its error falls as 1 / lights") {
  const Environment sky = support::sky();
  double before = 1;
  for (const auto& [count, bound] : {std::pair<std::size_t, double>{16, 0.03}, {64, 8e-3}, {256, 2e-3}}) {
    const double error = irradiance_error(environment_lights(sky, count, 1), sky);
    CAPTURE(count);
    CHECK(error < bound);
    CHECK(error < 0.4 * before);
    before = error;
  }
}

TEST_CASE("a sun of two texels keeps its place and power, in any turn and in large maps") {
  for (const int height : {64, 512, 1200})
    for (const float rotation : {0.0f, 1.3f, -2.9f}) {
      CAPTURE(height);
      CAPTURE(rotation);
      Environment environment = support::constant_environment(vec3(1e-5f), 2 * height, height);
      environment.rotation = rotation;
      const int x = height / 3, y = height / 4;
      environment.map.at(x, y) = environment.map.at(x + 1, y) = vec3(1e6f);
      glm::dvec3 sun(0), towards(0);
      for (const LocalLight& light : environment_lights(environment, 40, 1))
        if (radiance(environment, light.position).x > 1e5f)  // where a look-up finds it
          sun += glm::dvec3(light.intensity),
              towards += double(light.intensity.x) * glm::dvec3(light.position);
      CHECK(sun.x == doctest::Approx(2e6 * texel_solid_angle(y, 2 * height, height)).epsilon(1e-4));
      const double azimuth = 2 * std::numbers::pi * ((x + 1.0) / (2 * height) - 0.5) - double(rotation),
                   elevation = std::numbers::pi * (0.5 - (y + 0.5) / height);
      const glm::dvec3 place(std::cos(elevation) * std::cos(azimuth), std::sin(elevation),
                             std::cos(elevation) * std::sin(azimuth));
      CHECK(length(normalize(towards) - place) < 0.05 * std::numbers::pi / height);  // a 20th of a texel
    }
}

TEST_CASE("a turned environment's lights are the turned lights") {
  Environment environment = support::sky();
  const auto still = environment_lights(environment, 50, 1);
  environment.rotation = pi / 2;  // +X turns towards -Z
  const auto turned = environment_lights(environment, 50, 1);
  REQUIRE(still.size() == turned.size());
  for (std::size_t i = 0; i < still.size(); ++i) {
    const vec3& p = still[i].position;
    CHECK(length(turned[i].position - vec3(p.z, p.y, -p.x)) < 1e-6f);
    CHECK(turned[i].intensity == still[i].intensity);
  }
}

TEST_CASE("distant lights: nowhere near, and dark cells give none") {
  for (const LocalLight& light : environment_lights(support::sky(), 30, 7)) {
    CHECK((light.w == 0 && light.area == 0 && is_finite(light.position) && is_finite(light.intensity)));
    CHECK(length(light.position) == doctest::Approx(7));
    CHECK(luminance(light.intensity) > 0);
  }
  CHECK(environment_lights(support::constant_environment(vec3(0)), 30, 1).empty());
  CHECK(environment_lights(support::sky(), 0, 1).empty());
  Environment spot = support::constant_environment(vec3(0), 64, 32);
  spot.map.at(9, 11) = vec3(1, 2, 3);
  const auto lights = environment_lights(spot, 1000, 1);
  CHECK(lights.size() <= 256);  // the one texel's parts
  for (const LocalLight& light : lights) CHECK(radiance(spot, light.position) == vec3(1, 2, 3));
}
