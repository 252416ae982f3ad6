// Gathering keeps energy, loses no sun, and turns as the environment does.
#include <doctest/doctest.h>

#include <algorithm>
#include <coppice/light/directions.hpp>
#include <coppice/light/environment_cells.hpp>
#include <cstdlib>
#include <vector>

#include "support/generators.hpp"

using namespace coppice;
using namespace test_support;

namespace {

glm::dvec3 energy_of(const Image& map) {
  glm::dvec3 sum(0);
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x)
      sum += texel_solid_angle(y, map.width, map.height) * glm::dvec3(map.at(x, y));
  return sum;
}

glm::dvec3 energy_of(const std::vector<CellLight>& lights) {
  glm::dvec3 sum(0);
  for (const auto& l : lights) sum += glm::dvec3(l.power);
  return sum;
}

void check_energy(const EnvironmentCells& cells, const Environment& environment) {
  const auto lights = cells.gather(environment);
  const glm::dvec3 expected = energy_of(environment.map), actual = energy_of(lights);
  for (int c = 0; c < 3; ++c) CHECK(close(actual[c], expected[c], 1e-6));
  double solid_angle = 0;
  for (const auto& l : lights) solid_angle += double(l.solid_angle);
  CHECK(std::abs(solid_angle - 4 * std::numbers::pi) < 1e-5);
}

std::size_t nearest(const std::vector<vec3>& directions, const vec3& d) {
  return std::size_t(std::ranges::max_element(directions, {}, [&](const vec3& o) { return dot(o, d); }) -
                     directions.begin());
}

Image sun_at(int x, int y, int width, int height) {
  Image map(width, height);
  map.at(x, y) = vec3(1e5f, 2e5f, 3e5f);
  return map;
}

/// Mean direction over texel (x, y) of a width × height map, by 64 × 64 parts.
vec3 mean_direction(int x, int y, int width, int height) {
  glm::dvec3 sum(0);
  for (int j = 64 * y; j < 64 * (y + 1); ++j)
    for (int i = 64 * x; i < 64 * (x + 1); ++i)
      sum += texel_solid_angle(j, 64 * width, 64 * height) *
             glm::dvec3(texel_direction(i, j, 64 * width, 64 * height));
  return vec3(glm::normalize(sum));
}

/// Column x of the result is column x + columns of the map.
Image rolled(const Image& map, int columns) {
  Image result(map.width, map.height);
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) result.at(x, y) = map.at((x + columns) % map.width, y);
  return result;
}

/// Radiance that varies slowly over the sphere.
vec3 smooth(const vec3& d) { return vec3(2 + d.x, 2 + d.y * d.z, 2 + d.z); }

Image smooth_map(int width, int height) {
  Image map(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) map.at(x, y) = smooth(texel_direction(x, y, width, height));
  return map;
}

/// d turned right-handed about +Y: +X towards -Z.
vec3 turned(const vec3& d, float angle) {
  const float c = std::cos(angle), s = std::sin(angle);
  return {c * d.x + s * d.z, d.y, c * d.z - s * d.x};
}

double angle_between(const vec3& a, const vec3& b) {
  return std::atan2(glm::length(glm::cross(glm::dvec3(a), glm::dvec3(b))),
                    glm::dot(glm::dvec3(a), glm::dvec3(b)));
}

constexpr std::uint32_t count = 1000;
/// Cells of an even lattice reach less far than this from their direction: a disc of two cells' area.
const double cell_radius = std::sqrt(2 * 4.0 / count);

}  // namespace

TEST_CASE("energy is kept for random maps of any size under any rotation") {
  Random random(1);
  for (const auto& [width, height] : {std::pair(1, 1), std::pair(2, 1), std::pair(3, 2), std::pair(7, 5),
                                      std::pair(64, 32), std::pair(1, 600), std::pair(1024, 512)}) {
    CAPTURE(width);
    const auto directions = even_directions(count);
    const EnvironmentCells cells(directions, width, height);
    for (const float rotation : {0.0f, 1.0f, -0.3f, 100.0f, -1e-9f, 2 * pi})
      check_energy(cells, {random_map(random, width, height), rotation});
  }
}

TEST_CASE("energy is kept by one light, and by more lights than texels") {
  Random random(2);
  for (const std::uint32_t lights : {1u, 2u, 3u, 100000u}) {
    const auto directions = even_directions(lights);
    const EnvironmentCells cells(directions, 64, 32);
    const Environment environment{random_map(random, 64, 32), 0.5f};
    check_energy(cells, environment);
    for (const vec3& d : cells.centroids(environment, directions)) REQUIRE(std::abs(length(d) - 1) < 3e-7f);
  }
}

TEST_CASE("radiance of 1e30 and denormal radiance are kept, black stays black") {
  const auto directions = even_directions(100);
  const EnvironmentCells cells(directions, 64, 32);
  for (const float radiance : {1e30f, 1e-30f, 1e-38f, 0.0f}) {
    CAPTURE(radiance);
    const Environment environment{Image(64, 32, vec3(radiance)), 0};
    for (const auto& light : cells.gather(environment)) {
      CHECK(std::abs(double(light.power.x) - double(radiance) * double(light.solid_angle)) <=
            1e-6 * double(radiance) + 1e-45);
      CHECK(is_finite(light.power));
    }
    for (const vec3& d : cells.centroids(environment, directions)) CHECK(std::abs(length(d) - 1) < 3e-7f);
  }
}

TEST_CASE("a sun of one texel lands whole in the nearest cell, which moves to it: poles and seam too") {
  const auto directions = even_directions(count);
  const int width = 1024, height = 512;
  const EnvironmentCells cells(directions, width, height);
  for (const int y : {0, 1, 100, 255, 256, 510, 511})
    for (const int x : {0, 1, 511, 512, 700, 1022, 1023}) {
      const Environment environment{sun_at(x, y, width, height), 0};
      const auto lights = cells.gather(environment);
      const vec3 sun = texel_direction(x, y, width, height);
      const std::size_t i = nearest(directions, sun);
      CHECK(std::ranges::count_if(lights, [](const CellLight& l) { return l.power.y > 0; }) == 1);
      CHECK(close(lights[i].power.y, 2e5 * texel_solid_angle(y, width, height), 1e-6));
      const auto centroids = cells.centroids(environment, directions);
      CHECK(length(centroids[i] - sun) < 1e-6f);
      CHECK(centroids[(i + 1) % count] == directions[(i + 1) % count]);
    }
}

TEST_CASE("a sun in a coarse map keeps its energy and its mean place") {
  const auto directions = even_directions(count);
  const EnvironmentCells cells(directions, 64, 32);
  for (const int y : {0, 10, 31})
    for (const int x : {0, 20, 63}) {
      const Environment environment{sun_at(x, y, 64, 32), 0};
      const auto lights = cells.gather(environment);
      const auto centroids = cells.centroids(environment, directions);
      glm::dvec3 sum(0);
      for (std::size_t i = 0; i < count; ++i) sum += double(lights[i].power.x) * glm::dvec3(centroids[i]);
      CHECK(close(energy_of(lights).x, 1e5 * texel_solid_angle(y, 64, 32), 1e-6));
      CHECK(angle_between(vec3(glm::normalize(sum)), mean_direction(x, y, 64, 32)) < 1e-3);
    }
}

TEST_CASE("centroids stay in their own cells, whatever the map") {
  const auto directions = even_directions(count);
  Random random(3);
  for (const auto& [width, height] : {std::pair(64, 32), std::pair(1024, 512)}) {
    const EnvironmentCells cells(directions, width, height);
    const auto centroids = cells.centroids({random_map(random, width, height), 0.7f}, directions);
    for (std::size_t i = 0; i < count; ++i) {
      CHECK(std::abs(length(centroids[i]) - 1) < 3e-7f);
      CHECK(angle_between(centroids[i], directions[i]) < cell_radius);
      // Cells are convex: no other direction is nearer, to the width of the table's entries.
      const vec3 other = directions[nearest(directions, centroids[i])];
      CHECK(length(centroids[i] - directions[i]) < length(centroids[i] - other) + 0.006f);
    }
  }
}

TEST_CASE("cells without light keep their given directions") {
  const auto directions = even_directions(count);
  const EnvironmentCells cells(directions, 64, 32);
  CHECK(cells.centroids({Image(64, 32), 0}, directions) == directions);
}

TEST_CASE("turning a map by whole columns gathers what its rolled copy gathers") {
  const auto directions = even_directions(count);
  Random random(4);
  const int width = 64;
  const EnvironmentCells cells(directions, width, 32);
  const Image map = random_map(random, width, 32);
  for (const int columns : {0, 1, 13, 63}) {
    const auto rotation = float(2 * std::numbers::pi * columns / width);
    const auto by_turn = cells.gather({map, rotation}), by_roll = cells.gather({rolled(map, columns), 0});
    const auto back = cells.gather({map, rotation - 2 * pi});
    for (std::size_t i = 0; i < count; ++i) {
      CHECK(length(by_turn[i].power - by_roll[i].power) <= 1e-6f * length(by_roll[i].power));
      CHECK(length(back[i].power - by_roll[i].power) <= 1e-6f * length(by_roll[i].power));
    }
  }
}

TEST_CASE("on a smooth map the cells agree with the lookup under any rotation") {
  const auto directions = even_directions(4000);
  const EnvironmentCells cells(directions, 256, 128);
  for (const float rotation : {0.0f, pi / 2, -1.234f, 3.0f}) {
    CAPTURE(rotation);
    const Environment environment{smooth_map(256, 128), rotation};
    const auto lights = cells.gather(environment);
    double worst_lookup = 0, worst_formula = 0;
    for (std::size_t i = 0; i < directions.size(); ++i) {
      const vec3 mean = lights[i].power / lights[i].solid_angle;
      worst_lookup = std::max(worst_lookup, double(length(mean - radiance(environment, directions[i]))));
      worst_formula =
          std::max(worst_formula, double(length(mean - smooth(turned(directions[i], -rotation)))));
    }
    CHECK(worst_lookup < 0.03);
    CHECK(worst_formula < 0.015);
  }
}

TEST_CASE("centroids turn with the sun") {
  const auto directions = even_directions(count);
  const int width = 1024, height = 512;
  const EnvironmentCells cells(directions, width, height);
  const Image map = sun_at(300, 200, width, height);
  const vec3 sun = texel_direction(300, 200, width, height);
  for (const float rotation : {0.5f, -2.0f, 6.0f}) {
    const vec3 expected = turned(sun, rotation);
    const auto lights = cells.gather({map, rotation});
    const auto brightest = std::ranges::max_element(lights, {}, [](const CellLight& l) { return l.power.x; });
    const auto i = std::size_t(brightest - lights.begin());
    const auto centroids = cells.centroids({map, rotation}, directions);
    CHECK(angle_between(centroids[i], expected) < std::numbers::pi / width + 1e-6);
  }
}

TEST_CASE("one light that stands for an even sky keeps its given direction") {
  const std::vector<vec3> up{{0, 1, 0}};
  const EnvironmentCells cells(up, 64, 32);
  CHECK(cells.centroids({Image(64, 32, vec3(1)), 0}, up) == up);
}
