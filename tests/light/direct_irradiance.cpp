// Irradiance by shadow rays against the plain sum, and what is drawn against what is exact.
#include <doctest/doctest.h>

#include <coppice/light/direct_irradiance.hpp>

#include "support/occluders.hpp"

using namespace coppice;

namespace {

/// Points, spots, patches and a sun above the plane y = 0, some of them dark.
std::vector<LocalLight> various_lights(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<LocalLight> lights{distant_light(normalize(vec3(1, 2, 0)), vec3(0.2f), 10)};
  while (lights.size() < count) {
    const vec3 p = 3.0f * random.direction(), colour(random.uniform(), random.uniform(), 0.1f);
    switch (random.below(4)) {
      case 0:
        lights.push_back(point_light(p, colour));
        break;
      case 1:
        lights.push_back(spot_light(p, colour, random.direction(), 0.4f, 1.2f));
        break;
      case 2:
        lights.push_back(surface_light(p, random.direction(), colour, 0.3f));
        break;
      default:
        lights.push_back(point_light(p, vec3(0)));
    }
  }
  lights.resize(count);
  return lights;
}

const support::SphereOccluder balls{{{{0.5f, 1, 0}, 0.6f}, {{-1, 1.5f, 0.3f}, 0.5f}, {{0, 2, -1}, 0.3f}}};

/// The definition of LocalLight, written out in double, a ray a light.
glm::dvec3 plain_sum(std::span<const LocalLight> lights, const vec3& x, const vec3& n) {
  glm::dvec3 sum(0);
  for (const LocalLight& light : lights) {
    const glm::dvec3 across = glm::dvec3(light.position) - double(light.w) * glm::dvec3(x);
    const double distance = glm::length(across), cosine = glm::dot(across, glm::dvec3(n)) / distance;
    const vec3 direction(across / distance);
    const float t_max = light.w > 0 ? float(distance) * 0.9999f : std::numeric_limits<float>::infinity();
    if (cosine <= 0 || balls.occluded(x, direction, t_max)) continue;
    sum += glm::dvec3(light.intensity) * double(emission_towards(light, -direction)) * cosine /
           (distance * distance + double(light.area) / std::numbers::pi);
  }
  return sum;
}

}  // namespace

TEST_CASE("up to the number of rays the irradiance is the plain sum") {
  for (const std::size_t count : {0u, 1u, 15u, 16u, 17u, 300u}) {
    const auto lights = various_lights(count, 3);
    const DirectIrradiance direct(lights);
    for (const vec3& x : {vec3(0), vec3(0.4f, 0, 0.3f), vec3(-2, 0, 1)}) {
      Random random(1);
      const vec3 n(0, 1, 0), e = direct.at(balls, x, n, random);
      const glm::dvec3 expected = plain_sum(lights, x, n);
      CHECK(glm::length(glm::dvec3(e) - expected) <= 1e-5 * glm::length(expected));
      CHECK(direct.reaches(balls, x, n, random) == (glm::length(expected) > 0));
    }
  }
}

TEST_CASE("beyond it, drawn lights are without bias and as near as stated") {
  const auto lights = various_lights(3000, 4);
  const DirectIrradiance direct(lights, 256);
  const vec3 x(0.2f, 0, 0.1f), n(0, 1, 0);
  const double expected = plain_sum(lights, x, n).y;
  double unshadowed = 0, sum = 0, square = 0;
  for (const LocalLight& light : lights)
    if (const auto path = path_to(light, x, n)) unshadowed += double(luminance(path->irradiance));
  Random random(5);
  const int runs = 200;
  for (int i = 0; i < runs; ++i) {
    const double error = double(direct.at(balls, x, n, random).y) - expected;
    sum += error, square += error * error;
  }
  const double deviation = std::sqrt(square / runs);
  CHECK(deviation < 1.1 * unshadowed / (2 * std::sqrt(256.0)));  // green and luminance differ by colour
  CHECK(deviation > 0);
  CHECK(std::abs(sum / runs) < 4 * deviation / std::sqrt(runs));
}

TEST_CASE("one light of many that reaches a point is found by its brightness there") {
  std::vector<LocalLight> lights;
  for (int i = 0; i < 500; ++i) lights.push_back(point_light({0.5f, 1, 0}, vec3(1)));  // within a ball
  lights.push_back(point_light({0.05f, 0.05f, 0}, vec3(0.2f)));
  const DirectIrradiance direct(lights);
  Random random(6);
  CHECK(direct.reaches(balls, {0, 0, 0}, {0, 1, 0}, random));
  lights.pop_back();
  CHECK(!DirectIrradiance(lights).reaches(balls, {0, 0, 0}, {0, 1, 0}, random));
}

TEST_CASE("lights at the point, huge, and tiny: finite, and dark stays dark") {
  const vec3 x(1, 2, 3), n(0, 1, 0);
  const support::SphereOccluder nothing{};
  Random random(1);
  const auto at = [&](const LocalLight& light) {
    const std::vector<LocalLight> lights(100, light);
    CHECK(is_finite(DirectIrradiance(lights, 10).at(nothing, x, n, random)));
    DirectIrradiance(lights).reaches(nothing, x, n, random);
    return DirectIrradiance(lights).at(nothing, x, n, random);
  };
  CHECK(at(point_light(x, vec3(1))) == vec3(0));
  CHECK(is_finite(at(point_light(x + vec3(0, 1e-6f, 0), vec3(1e6f)))));
  CHECK(is_finite(at(point_light(x + vec3(0, 3, 0), vec3(1e30f)))));
  CHECK(at(point_light(x + vec3(0, 3, 0), vec3(1e-30f))).x > 0);
  CHECK(at(point_light(x + vec3(0, 3, 0), vec3(0))) == vec3(0));
}
