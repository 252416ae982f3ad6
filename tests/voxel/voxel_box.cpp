// The box that is worth voxels holds all of a room, and leaves out a ground that goes on to the horizon.
#include <doctest/doctest.h>

#include <coppice/core/random.hpp>
#include <coppice/voxel/voxel_box.hpp>
#include <vector>

namespace {

using namespace coppice;

std::vector<vec3> ball_of_points(std::size_t count) {
  Random random(1);
  std::vector<vec3> points(count);
  for (vec3& p : points) p = random.direction() + vec3(0, 1, 0);
  return points;
}

void add_ground(std::vector<vec3>& points, float half) {
  for (const float x : {-half, half})
    for (const float z : {-half, half}) points.emplace_back(x, 0, z);
}

}  // namespace

TEST_CASE("a box of all vertices where they lie together") {
  std::vector<vec3> points = ball_of_points(10000);
  add_ground(points, 3);
  const VoxelBox box = box_worth_voxels(points);
  CHECK(box.low == vec3(-3, 0, -3));
  CHECK(box.high.x == 3);
  for (const vec3& p : points)
    CHECK((glm::all(glm::greaterThanEqual(p, box.low)) && glm::all(glm::lessThanEqual(p, box.high))));
}

TEST_CASE("a ground that goes on far beyond all else is clipped") {
  std::vector<vec3> points = ball_of_points(10000);
  add_ground(points, 100);
  const VoxelBox box = box_worth_voxels(points);
  CHECK(box.high.x - box.low.x < 4.2f);
  CHECK(box.high.x - box.low.x > 3.5f);
  CHECK(box.low.y == 0);  // no further than there is something
}

TEST_CASE("few vertices, one or none have the box that holds them") {
  const std::vector<vec3> two{vec3(0), vec3(100, 1, 1)};
  CHECK(box_worth_voxels(two).high == vec3(100, 1, 1));
  CHECK(box_worth_voxels(std::span(two).first(1)).high == vec3(0));
  CHECK(box_worth_voxels({}).low == vec3(0));
  CHECK(box_worth_voxels({}).high == vec3(0));
}
