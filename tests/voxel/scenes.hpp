// Meshes and poses for the tests of voxels.
#pragma once

#include <coppice/scene/mesh.hpp>
#include <coppice/voxel/brick_builder.hpp>

#include "support/generators.hpp"
#include "support/scenes.hpp"

namespace support {

/// Triangles of all sizes, some of them degenerate, in a box of 2 × 2 × 2 round the origin; a few stick out.
inline coppice::Mesh triangle_soup(coppice::Random& random, std::uint32_t count) {
  coppice::Mesh mesh;
  const auto any = [&] { return test_support::random_value<float>(random); };
  for (std::uint32_t i = 0; i < count; ++i) {
    const vec3 p(any(), any(), any());
    const float size = std::exp(-5 * random.uniform());
    const vec3 a = size * random.direction(), b = i % 16 == 0 ? 2.0f * a : size * random.direction();
    const std::uint32_t first = add_vertex(mesh, p, vec3(0, 1, 0));
    add_vertex(mesh, p + a, vec3(0, 1, 0)), add_vertex(mesh, p + b, vec3(0, 1, 0));
    add_triangle(mesh, {first, first + 1, first + 2});
  }
  return mesh;
}

inline coppice::VoxelBox unit_box() { return {vec3(-1), vec3(1)}; }

inline coppice::TriangleCorners corners_of(const coppice::Mesh& mesh, std::size_t i) {
  const uvec3 t = mesh.triangles[i];
  return {mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]};
}

/// A point of a triangle, uniform over it.
inline vec3 point_of(coppice::Random& random, const coppice::TriangleCorners& t) {
  float u = random.uniform(), v = random.uniform();
  if (u + v > 1) u = 1 - u, v = 1 - v;
  return t.a + u * (t.b - t.a) + v * (t.c - t.a);
}

inline coppice::BrickGrid grid_of(const coppice::Mesh& mesh, const coppice::VoxelBox& box,
                                  std::uint32_t resolution) {
  coppice::BrickBuilder builder(box, resolution);
  builder.build(mesh, coppice::Serial{});
  return builder.grid();
}

}  // namespace support
