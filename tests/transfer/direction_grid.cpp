// The table of nearest directions against a look at all of them.
#include <coppice/reference/depth_visibility.hpp>
//
#include <doctest/doctest.h>

#include <support/generators.hpp>

using namespace coppice;

namespace {

vec3 any_direction(Random& random, Dome dome) {
  vec3 d = random.direction();
  if (dome == Dome::hemisphere) d.y = std::abs(d.y);
  return d;
}

}  // namespace

TEST_CASE("the four nearest directions are those that a look at all directions finds") {
  for (const Dome dome : {Dome::hemisphere, Dome::sphere})
    for (const std::uint32_t count : {4u, 5u, 60u, 2016u}) {
      const DirectionGrid grid(count, dome);
      rc::check([&] {
        Random random = test_support::any_random();
        const vec3 d = any_direction(random, dome);
        const auto fast = grid.nearest(d), slow = reference::nearest_directions(grid, d);
        for (std::size_t i = 0; i < 4; ++i)
          RC_ASSERT(dot(grid.directions()[fast[i]], d) >= dot(grid.directions()[slow[i]], d) - 2e-7f);
      });
    }
}

TEST_CASE("a direction of the grid is nearest to itself, also on the axes, the folds and the horizon") {
  for (const Dome dome : {Dome::hemisphere, Dome::sphere}) {
    const DirectionGrid grid(500, dome);
    for (std::size_t i = 0; i < grid.size(); ++i) CHECK(grid.nearest(grid.directions()[i])[0] == i);
    for (const vec3 d : {vec3(0, 1, 0), vec3(1, 0, 0), vec3(-1, 0, 0), vec3(0, 0, 1), vec3(0, 0, -1)})
      CHECK(dot(grid.directions()[grid.nearest(d)[0]], d) >=
            dot(grid.directions()[reference::nearest_directions(grid, d)[0]], d) - 2e-7f);
  }
  const DirectionGrid sphere(500, Dome::sphere);
  CHECK(sphere.directions()[sphere.nearest({0, -1, 0})[0]].y < -0.99f);
}

TEST_CASE("directions of the look-up in one read are hardly farther away than the nearest") {
  for (const Dome dome : {Dome::hemisphere, Dome::sphere}) {
    const DirectionGrid grid(dome == Dome::sphere ? 4032 : 2016, dome);
    Random random(1);
    for (int i = 0; i < 2000; ++i) {
      const vec3 d = any_direction(random, dome);
      const float nearest = std::acos(std::min(1.0f, dot(grid.directions()[grid.nearest(d)[3]], d)));
      for (const std::uint16_t k : grid.nearly_nearest(d))
        CHECK(std::acos(std::min(1.0f, dot(grid.directions()[k], d))) < nearest + 0.05f);
    }
  }
}

TEST_CASE("directions of the hemisphere are above the horizon, unit and even") {
  const DirectionGrid grid(2016);
  glm::dvec3 sum(0);
  for (const vec3& d : grid.directions()) {
    CHECK(d.y > 0);
    CHECK(length(d) == doctest::Approx(1).epsilon(1e-6));
    sum += glm::dvec3(d);
  }
  CHECK(glm::length(sum / 2016.0 - glm::dvec3(0, 0.5, 0)) < 1e-3);
}
