// Receivers begin above the faces that meet at their corner.
#include <doctest/doctest.h>

#include <coppice/core/random.hpp>
#include <coppice/relight/receivers.hpp>
#include <support/scenes.hpp>

#include "relight/receiver_meshes.hpp"

using namespace coppice;
using namespace relight_test;
using namespace support;

namespace {

void check_above_all_faces(const Mesh& mesh) {
  const ReceiverMesh receivers(mesh, all_fronts(mesh));
  const auto normals = normals_around(receivers);
  const auto placed = corner_receivers(receivers);
  REQUIRE(placed.size() == receivers.corners().size());
  for (std::size_t c = 0; c < placed.size(); ++c) {
    CHECK(std::abs(length(placed[c].normal) - 1) < 1e-5f);
    CHECK(std::abs(dot(placed[c].inward, placed[c].normal)) <= 1e-5f * (1 + length(placed[c].inward)));
    CHECK(placed[c].horizon <= 0);
    CHECK(placed[c].horizon >= -1);
    const bool is_spike =
        std::ranges::any_of(normals[c], [&](const vec3& n) { return dot(n, placed[c].normal) < 0.1f; });
    for (const vec3& n : normals[c])
      if (!is_spike) CHECK(dot(n, placed[c].position - receivers.corners()[c].position) > 0);
  }
}

/// Two squares that share the z axis, both facing a viewer on +Y, and stand at `angle` radians to each other:
/// below π a valley, above it a ridge. Welded along the axis by a common normal.
Mesh crease(float angle) {
  Mesh mesh;
  const vec3 right(std::cos(pi / 2 - angle / 2), std::sin(pi / 2 - angle / 2), 0), left(-right.x, right.y, 0);
  const std::uint32_t a = add_vertex(mesh, {0, 0, 0}, {0, 1, 0}), b = add_vertex(mesh, {0, 0, -1}, {0, 1, 0});
  const vec3 right_normal(-right.y, right.x, 0), left_normal(right.y, right.x, 0);
  const std::uint32_t r = add_vertex(mesh, right, right_normal), l = add_vertex(mesh, left, left_normal);
  add_triangle(mesh, {a, r, b});
  add_triangle(mesh, {a, b, l});
  return mesh;
}

/// The corner of a room, seen from inside, or of a box, seen from outside; welded at the tip.
Mesh three_faces(float inside) {
  Mesh mesh;
  const vec3 diagonal = normalize(vec3(1)) * inside;
  const std::uint32_t tip = add_vertex(mesh, vec3(0), diagonal);
  std::uint32_t ends[3];
  for (int k = 0; k < 3; ++k) {
    vec3 axis(0);
    axis[k] = 1;
    ends[k] = add_vertex(mesh, axis, diagonal);
  }
  for (int k = 0; k < 3; ++k)
    add_triangle(
        mesh, inside > 0 ? uvec3(tip, ends[k], ends[(k + 1) % 3]) : uvec3(tip, ends[(k + 1) % 3], ends[k]));
  return mesh;
}

}  // namespace

TEST_CASE("on bumpy ground every receiver is above all faces at its corner") {
  for (const float amplitude : {0.0f, 0.01f, 0.1f, 0.3f})
    for (const std::uint64_t seed : {1u, 2u, 3u}) check_above_all_faces(bumpy_mesh(10, amplitude, seed));
}

TEST_CASE("in valleys and on ridges receivers are above both faces") {
  for (int degrees = 20; degrees <= 340; degrees += 10) {
    CAPTURE(degrees);
    check_above_all_faces(crease(glm::radians(float(degrees))));
  }
}

TEST_CASE("in the corner of a room and on that of a box receivers are above all three faces") {
  check_above_all_faces(three_faces(1));
  check_above_all_faces(three_faces(-1));
}

TEST_CASE("far from the origin receivers are still above their face") {
  Mesh mesh;
  add_quad(mesh, {1000, 1000, 1000}, {0, 0, 1e-3f}, {1e-3f, 0, 0});
  check_above_all_faces(mesh);
}

TEST_CASE("a flat receiver sees its half space, a ridge's sees beyond it") {
  Mesh flat;
  add_ground(flat, 1);
  for (const Receiver& r : corner_receivers(ReceiverMesh(flat, all_fronts(flat)))) {
    CHECK(length(r.normal - vec3(0, 1, 0)) < 1e-6f);
    CHECK(r.horizon > -1e-3f);
  }
  const Mesh ridge = crease(glm::radians(270.0f));
  const auto placed = corner_receivers(ReceiverMesh(ridge, all_fronts(ridge)));
  CHECK(std::abs(placed[0].horizon + std::sqrt(0.5f)) < 1e-3f);
}

TEST_CASE("a degenerate face gives a finite receiver") {
  Mesh mesh;
  for (int i = 0; i < 3; ++i) add_vertex(mesh, {1, 2, 3}, {0, 1, 0});
  add_triangle(mesh, {0, 1, 2});
  for (const Receiver& r : corner_receivers(ReceiverMesh(mesh, all_fronts(mesh)))) {
    CHECK(is_finite(r.position));
    CHECK(r.position.y > 2);
    CHECK(r.normal == vec3(0, 1, 0));
  }
}

TEST_CASE("receivers may be bent only at corners of faces with a normal map, the refined ones too") {
  Scene scene;
  scene.materials = {dielectric(vec3(1), 1), dielectric(vec3(1), 1)};
  scene.materials[1].normal_texture = 0;
  add_ground(scene.mesh, 1, 0, 0);
  add_quad(scene.mesh, {1, 0, 1}, {2, 0, 0}, {0, 0, -2}, 1);  // beside the ground, shares an edge with it
  ReceiverMesh mesh(scene.mesh, all_fronts(scene.mesh));
  const auto outer = mesh.faces()[3];
  const std::uint32_t m = mesh.add_corner({vec3(2, 0, 0), vec3(0, 1, 0)});
  const std::vector<ReceiverMesh::Face> children{
      {{outer.corners.x, outer.corners.y, m}, outer.uv, outer.normal, outer.triangle},
      {{outer.corners.y, outer.corners.z, m}, outer.uv, outer.normal, outer.triangle}};
  mesh.subdivide(3, children);
  auto receivers = corner_receivers(mesh);
  for (const Receiver& r : receivers) CHECK(r.bend == 0);
  mark_bumpy_receivers(scene, mesh, receivers);
  REQUIRE(receivers.size() == 7);
  for (std::size_t c = 0; c < receivers.size(); ++c)
    CHECK(receivers[c].bend == (mesh.corners()[c].position.x >= 1 ? bump_sine : 0.0f));
}
