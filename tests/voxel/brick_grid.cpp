// Grids of distances against the distance to every triangle.
#include <doctest/doctest.h>

#include <coppice/reference/voxel.hpp>

#include "support/executors.hpp"
#include "voxel/scenes.hpp"

using namespace coppice;

namespace {

/// The world position of a place of a filled brick.
vec3 world_of(const BrickGrid& g, const vec3& place) { return g.grid.low + g.grid.voxel * place; }

bool same(const BrickGrid& a, const BrickGrid& b) { return a.slots == b.slots && a.distances == b.distances; }

struct Errors {
  float near = 0, far_share = 0;  ///< voxels; of the distance
};

/// The largest error at places of filled bricks, and of that at corners as a share of distance + 1 voxel.
Errors errors_of(const BrickGrid& g, const Mesh& mesh, Random& random) {
  Errors worst;
  const auto exact = [&](const vec3& p) {
    return reference::nearest_surface(mesh, world_of(g, p)) / g.grid.voxel;
  };
  for (int i = 0; i < 400; ++i) {
    const uvec3 b(random.below(g.grid.bricks.x), random.below(g.grid.bricks.y),
                  random.below(g.grid.bricks.z));
    if (g.slots[g.brick_index(b)] == 0) {
      const vec3 corner = vec3(b * 8u);
      if (const float d = exact(corner); d < 1000)
        worst.far_share = std::max(worst.far_share, std::abs(nearest_surface(g, corner) - d) / (d + 1));
      continue;
    }
    const vec3 within = (8.0f / 7.0f) * vec3(random.below(8), random.below(8), random.below(8));
    // A place on the upper face of a brick belongs to the next one.
    const vec3 p = glm::min(vec3(b * 8u) + within, vec3(b * 8u) + 7.9999f);
    worst.near = std::max(worst.near, std::abs(nearest_surface(g, p) - std::min(exact(p), 8.0f)));
  }
  return worst;
}

}  // namespace

TEST_CASE("distances in bricks are exact to a unit, those at corners to a few percent") {
  CHECK(rc::check([] {
    Random random = test_support::any_random();
    const Mesh mesh = support::triangle_soup(random, 1 + random.below(300));
    const BrickGrid g = support::grid_of(mesh, {vec3(-3), vec3(3)}, 8 * (2 + random.below(15)));
    const Errors worst = errors_of(g, mesh, random);
    RC_ASSERT(worst.near <= 0.6f * VOXEL_NEAR_UNIT + 1e-3f);
    RC_ASSERT(worst.far_share <= 0.3f);
  }));
}

TEST_CASE("bricks are filled where triangles meet them, and a plane costs what its area needs") {
  Mesh mesh;
  support::add_ground(mesh, 0.9f);
  const BrickGrid g = support::grid_of(mesh, support::unit_box(), 128);
  CHECK(g.grid.bricks == uvec3(16));
  CHECK(g.filled_bricks() >= 14 * 14);
  CHECK(g.filled_bricks() <= 2 * 16 * 16);
  CHECK(g.bytes() == 4 * 4096 + 2 * 17 * 17 * 17 + 2 + 512 * g.filled_bricks() + 4);
  CHECK(g.bytes() < g.dense_bytes() / 5);
}

TEST_CASE("outside of the box nothing is taken to be farther than it is") {
  Mesh mesh;
  support::add_ball(mesh, {0.3f, -0.2f, 0.1f}, 0.5f, 16);
  const BrickGrid g = support::grid_of(mesh, support::unit_box(), 64);
  Random random(8);
  for (int i = 0; i < 500; ++i) {
    const vec3 world = (2 + 20 * random.uniform()) * random.direction();
    const float exact = reference::nearest_surface(mesh, world) / g.grid.voxel;
    const float found = nearest_surface(g, g.place(world));
    CHECK(found < exact + 1.5f);
    CHECK(found > 0.5f * exact);
  }
}

TEST_CASE("any executor fills the same bytes") {
  Random random(3);
  const Mesh mesh = support::triangle_soup(random, 500);
  const BrickGrid serial = support::grid_of(mesh, support::unit_box(), 64);
  CHECK(serial.filled_bricks() > 50);
  BrickBuilder backwards(support::unit_box(), 64), threads(support::unit_box(), 64);
  backwards.build(mesh, support::Backwards{});
  threads.build(mesh, support::TwoThreads{});
  CHECK(same(serial, backwards.grid()));
  CHECK(same(serial, threads.grid()));
}

TEST_CASE("refreshing what moved leaves what building anew makes") {
  CHECK(rc::check([] {
    Random random = test_support::any_random();
    Mesh mesh = support::triangle_soup(random, 2 + random.below(200));
    BrickBuilder builder(support::unit_box(), 48);
    builder.build(mesh, Serial{});
    const std::size_t all = builder.refreshed();
    for (int frame = 0; frame < 3; ++frame) {
      std::vector<std::uint8_t> moved(mesh.triangles.size(), 0);
      for (std::uint32_t i = 0; i < 1 + mesh.triangles.size() / 20; ++i)
        moved[random.below(std::uint32_t(moved.size()))] = 1;
      const vec3 by = 0.3f * random.direction();
      for (std::size_t i = 0; i < moved.size(); ++i)
        for (int k = 0; moved[i] && k < 3; ++k) mesh.positions[mesh.triangles[i][k]] += by;
      builder.update(mesh, moved, support::TwoThreads{});
      RC_ASSERT(same(builder.grid(), support::grid_of(mesh, support::unit_box(), 48)));
    }
    RC_TAG(builder.refreshed() < all ? "some" : "all");
  }));
}

TEST_CASE("a small thing that moves refreshes only the bricks around it") {
  Mesh mesh;
  support::add_ground(mesh, 1, -0.9f);
  const std::size_t resting = mesh.triangles.size();
  support::add_ball(mesh, {0.5f, 0.5f, 0.5f}, 0.05f, 8);
  BrickBuilder builder(support::unit_box(), 128);
  builder.build(mesh, Serial{});
  const std::size_t all = builder.refreshed();
  std::vector<std::uint8_t> moved(mesh.triangles.size(), 1);
  std::fill_n(moved.begin(), resting, std::uint8_t(0));
  for (std::size_t i = 4; i < mesh.positions.size(); ++i) mesh.positions[i].x -= 0.4f;
  builder.update(mesh, moved, Serial{});
  CHECK(builder.refreshed() > 0);
  CHECK(builder.refreshed() < all / 20);
  CHECK(same(builder.grid(), support::grid_of(mesh, support::unit_box(), 128)));
}

TEST_CASE("grids without triangles, of flat boxes, and of things outside are valid and empty") {
  Mesh outside;
  support::add_ball(outside, {9, 9, 9}, 1, 4);
  for (const VoxelBox& box :
       {support::unit_box(), VoxelBox{vec3(0), vec3(1, 0, 1)}, VoxelBox{vec3(2), vec3(2)}})
    for (const Mesh& mesh : {Mesh{}, outside}) {
      const BrickGrid g = support::grid_of(mesh, box, 16);
      CHECK(g.filled_bricks() == 0);
      CHECK(nearest_surface(g, 0.5f * g.size()) > 1000);
      CHECK(nearest_surface(g, vec3(-1e6f, 0, 1e6f)) > 1000);
    }
  CHECK(nearest_surface(BrickGrid{}, vec3(4)) > 1);
}
