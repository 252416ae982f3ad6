// Triangles against boxes and points, compared with many points of the triangle.
#include <doctest/doctest.h>

#include <set>

#include "voxel/scenes.hpp"

using namespace coppice;

namespace {

TriangleCorners any_triangle(Random& random) {
  return support::corners_of(support::triangle_soup(random, 1 + random.below(2)), 0);
}

}  // namespace

TEST_CASE("a lattice's cells that hold a point of a triangle are all visited, and none that it is far from") {
  CHECK(rc::check([] {
    Random random = test_support::any_random();
    const TriangleCorners t = any_triangle(random);
    const float edge = 0.05f + 0.4f * random.uniform();
    const int end = int(2 / edge);
    std::set<std::array<int, 3>> visited;
    for_each_cell(t, edge, glm::ivec3(-end), glm::ivec3(end), [&](int x, int y, int z) {
      visited.insert({x, y, z});
    });
    for (const auto& [x, y, z] : visited) {
      const vec3 centre = edge * (vec3(x, y, z) + 0.5f);
      RC_ASSERT(length(nearest_on_triangle(t, centre) - centre) <= 0.5f * edge * 1.7321f * 1.001f);
    }
    for (int i = 0; i < 200; ++i) {
      const vec3 cell = glm::floor(support::point_of(random, t) / edge);
      if (glm::all(glm::lessThan(glm::abs(cell + 0.5f), vec3(float(end)))))
        RC_ASSERT(visited.count({int(cell.x), int(cell.y), int(cell.z)}) == 1);
    }
  }));
}

TEST_CASE("the axes across edges separate boxes that the other axes do not") {
  const TriangleCorners t{{1.2f, 0.5f, 0}, {0.5f, 1.2f, 0}, {0.9f, 0.9f, 3}};
  CHECK(triangle_meets_box(t, vec3(0), vec3(1)));
  const vec3 out(0.3f, 0.3f, 0);
  CHECK_FALSE(triangle_meets_box({t.a + out, t.b + out, t.c + out}, vec3(0), vec3(1)));
}

TEST_CASE("no point of a triangle is nearer than the nearest one, which lies on it") {
  CHECK(rc::check([] {
    Random random = test_support::any_random();
    const TriangleCorners t = any_triangle(random);
    const vec3 p = 2.0f * random.uniform() * random.direction();
    const vec3 nearest = nearest_on_triangle(t, p);
    const float distance = length(nearest - p);
    float best = std::min({length(t.a - p), length(t.b - p), length(t.c - p)});
    for (int i = 0; i < 2000; ++i) best = std::min(best, length(support::point_of(random, t) - p));
    const float size = std::max(length(t.b - t.a), length(t.c - t.a));
    RC_ASSERT(distance <= best + 1e-5f);
    RC_ASSERT(best - distance <= 0.2f * size);
    RC_ASSERT(length(nearest_on_triangle(t, nearest) - nearest) <= 1e-3f * size);
  }));
}
