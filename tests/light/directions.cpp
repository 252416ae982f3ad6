// Even directions: unit, without favourites, neighbours at about equal distance, and turned by a seed as a
// whole.
#include <doctest/doctest.h>

#include <algorithm>
#include <coppice/light/directions.hpp>
#include <coppice/light/environment_cells.hpp>
#include <vector>

using namespace coppice;

namespace {

/// Distance of each direction to its nearest neighbour, times √count, by looking at all pairs.
std::vector<double> neighbour_distances(const std::vector<vec3>& directions) {
  std::vector<double> distances;
  for (std::size_t i = 0; i < directions.size(); ++i) {
    float nearest = 4;
    for (std::size_t j = 0; j < directions.size(); ++j)
      if (j != i)
        nearest = std::min(nearest, dot(directions[i] - directions[j], directions[i] - directions[j]));
    distances.push_back(std::sqrt(double(nearest) * double(directions.size())));
  }
  return distances;
}

bool all_unit(const std::vector<vec3>& directions) {
  return std::ranges::all_of(directions, [](const vec3& d) { return std::abs(length(d) - 1) < 3e-7f; });
}

}  // namespace

TEST_CASE("directions are as many as asked for, and unit") {
  for (const std::uint32_t count : {0u, 1u, 2u, 3u, 1000u, 32768u, 1000000u})
    for (const std::uint64_t seed : {0u, 5u}) {
      const auto directions = even_directions(count, seed);
      CHECK(directions.size() == count);
      CHECK(all_unit(directions));
    }
}

TEST_CASE("nearest neighbours are at nearly equal distance") {
  for (const std::uint32_t count : {100u, 1000u, 4000u}) {
    CAPTURE(count);
    const auto distances = neighbour_distances(even_directions(count));
    const auto [least, greatest] = std::ranges::minmax(distances);
    CHECK(least > 2.9);  // 3.81 in a hexagonal lattice, near 0 for random directions
    CHECK(greatest < 3.81);
    CHECK(greatest / least < 1.25);
  }
}

TEST_CASE("cells have nearly equal solid angles that add up to the sphere") {
  const auto directions = even_directions(500);
  const EnvironmentCells cells(directions, 2048, 1024);
  const auto lights = cells.gather({Image(2048, 1024, vec3(1)), 0});
  double sum = 0, worst = 0;
  const double fair = 4 * std::numbers::pi / 500;
  for (const auto& light : lights) {
    sum += double(light.solid_angle);
    worst = std::max(worst, std::abs(double(light.solid_angle) / fair - 1));
  }
  CHECK(sum == doctest::Approx(4 * std::numbers::pi).epsilon(1e-6));
  CHECK(worst < 0.1);
}

TEST_CASE("no direction is preferred: the mean is zero, the second moments are a third each") {
  const std::uint32_t count = 5000;
  for (const std::uint64_t seed : {0u, 1u, 2u}) {
    glm::dvec3 sum(0);
    glm::dmat3 moments(0);
    for (const vec3& d : even_directions(count, seed))
      sum += glm::dvec3(d), moments += glm::outerProduct(glm::dvec3(d), glm::dvec3(d));
    CHECK(glm::length(sum) / count < 1e-3);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) CHECK(std::abs(moments[i][j] / count - (i == j ? 1.0 / 3 : 0)) < 1e-3);
  }
}

TEST_CASE("a seed turns the lattice as a whole, another seed otherwise, the same seed alike") {
  const auto plain = even_directions(200), turned = even_directions(200, 1), other = even_directions(200, 2);
  CHECK(turned == even_directions(200, 1));
  CHECK(length(turned[0] - plain[0]) > 1e-3f);
  CHECK(length(turned[0] - other[0]) > 1e-3f);
  float worst = 0, orientation = 0;
  for (std::size_t i = 2; i < plain.size(); ++i) {
    worst = std::max(worst, std::abs(dot(plain[0], plain[i]) - dot(turned[0], turned[i])));
    orientation = std::max(orientation, std::abs(dot(cross(plain[0], plain[1]), plain[i]) -
                                                 dot(cross(turned[0], turned[1]), turned[i])));
  }
  CHECK(worst < 1e-6f);
  CHECK(orientation < 1e-6f);
}
