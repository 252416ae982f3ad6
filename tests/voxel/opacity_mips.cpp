// Surface voxels and their pyramid.
#include <doctest/doctest.h>

#include <coppice/voxel/cone_visibility.hpp>
#include <coppice/voxel/opacity_mips.hpp>

#include "support/executors.hpp"
#include "voxel/scenes.hpp"

using namespace coppice;

TEST_CASE("surface voxels are those that a triangle meets, each tested alone") {
  Random random(5);
  const Mesh mesh = support::triangle_soup(random, 40);
  BrickBuilder builder(support::unit_box(), 24);
  builder.build(mesh, Serial{});
  const BrickGrid& g = builder.grid();
  const OpacityMips mips(g, builder.triangles(), mesh, support::TwoThreads{});
  std::size_t opaque = 0;
  for (std::uint32_t i = 0; i < 24 * 24 * 24; ++i) {
    const uvec3 v(i % 24, i / 24 % 24, i / 576);
    bool meets = false;
    for (std::size_t t = 0; t < mesh.triangles.size() && !meets; ++t) {
      const auto c = support::corners_of(mesh, t);
      meets = triangle_meets_box({g.place(c.a), g.place(c.b), g.place(c.c)}, vec3(v) + 0.5f, vec3(0.5f));
    }
    CHECK(mips.is_surface(v) == meets);
    opaque += meets;
  }
  CHECK(opaque > 100);
  CHECK(opaque < 24 * 24 * 24 / 2);
}

TEST_CASE("a thin wall leaks through opacity that is averaged, and not through distances") {
  Mesh mesh;
  support::add_quad(mesh, {-1, -1, 0.5f}, {2, 0, 0}, {0, 2, 0});
  BrickBuilder builder(support::unit_box(), 128);
  builder.build(mesh, Serial{});
  const OpacityMips mips(builder.grid(), builder.triangles(), mesh, Serial{});
  const SgShape cone{vec3(0, 0, 1), 60};
  const vec3 origin(0.013f, 0.021f, -0.1f);
  int steps = 0;
  CHECK(mips.cone_visibility(origin, cone.axis, cone, steps) > 0.2f);
  CHECK(steps > 5);
  CHECK(cone_visibility(builder.grid(), origin, cone.axis, cone) < 0.01f);
  CHECK(mips.cone_visibility(origin, -cone.axis, {-cone.axis, 60}, steps) > 0.99f);
}
