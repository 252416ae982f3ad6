// Welding of corners, and the way from a hit to the face that interpolates there.
#include <doctest/doctest.h>

#include <coppice/core/random.hpp>
#include <coppice/light/directions.hpp>
#include <coppice/relight/receiver_mesh.hpp>
#include <coppice/relight/refine.hpp>
#include <support/occluders.hpp>
#include <support/scenes.hpp>

#include "relight/receiver_meshes.hpp"

using namespace coppice;
using namespace relight_test;
using namespace support;

namespace {

vec3 point_of(const Mesh& mesh, std::uint32_t triangle, vec2 uv) {
  const uvec3 t = mesh.triangles[triangle];
  return (1 - uv.x - uv.y) * mesh.positions[t.x] + uv.x * mesh.positions[t.y] + uv.y * mesh.positions[t.z];
}

vec3 interpolated_position(const ReceiverMesh& mesh, const ReceiverMesh::Location& l) {
  const uvec3 c = mesh.faces()[l.face].corners;
  return l.weights.x * mesh.corners()[c.x].position + l.weights.y * mesh.corners()[c.y].position +
         l.weights.z * mesh.corners()[c.z].position;
}

void check_location(const Mesh& mesh, const ReceiverMesh& receivers, SidedTriangle side, vec2 uv) {
  const auto found = receivers.locate(side, uv);
  REQUIRE(receivers.is_leaf(found.face));
  CHECK(std::min({found.weights.x, found.weights.y, found.weights.z}) >= 0);
  CHECK(std::abs(found.weights.x + found.weights.y + found.weights.z - 1) < 1e-6f);
  CHECK(length(interpolated_position(receivers, found) - point_of(mesh, side.triangle, uv)) < 1e-5f);
}

vec2 random_uv(Random& random) {
  const vec2 uv(random.uniform(), random.uniform());
  return uv.x + uv.y > 1 ? vec2(1) - uv : uv;
}

}  // namespace

TEST_CASE("corners are welded where position and normal agree, and nowhere else") {
  Mesh mesh;
  add_box(mesh, vec3(-1), vec3(1));
  CHECK(ReceiverMesh(mesh, all_fronts(mesh)).corners().size() == 24);
  Mesh two;  // the same edge given twice, once with negative zeros
  const vec3 up(0, 1, 0);
  add_vertex(two, {0, 0, 0}, up), add_vertex(two, {1, 0, 0}, up), add_vertex(two, {0, 0, -1}, up);
  add_vertex(two, {-0.0f, -0.0f, -0.0f}, {-0.0f, 1, -0.0f}), add_vertex(two, {-1, 0, 0}, up),
      add_vertex(two, {0, 0, -1}, up);
  add_triangle(two, {0, 1, 2}), add_triangle(two, {3, 5, 4});
  CHECK(ReceiverMesh(two, all_fronts(two)).corners().size() == 4);
  const std::vector<SidedTriangle> both{{0, true}, {0, false}};
  const ReceiverMesh sides(two, both);
  CHECK(sides.corners().size() == 6);
  CHECK(length(sides.faces()[0].normal + sides.faces()[1].normal) < 1e-6f);
  CHECK(sides.corners()[sides.faces()[1].corners.x].normal == -up);
}

TEST_CASE("the front is where the vertex normals are, whatever the winding") {
  Mesh mesh;
  add_ground(mesh, 1);
  std::swap(mesh.triangles[0].y, mesh.triangles[0].z);
  const ReceiverMesh receivers(mesh, all_fronts(mesh));
  for (const auto& face : receivers.faces()) CHECK(face.normal.y > 0.99f);
}

TEST_CASE("weights reproduce the position of any hit, before and after refinement") {
  const Mesh mesh = bumpy_mesh(3, 0.2f, 4);
  const SphereOccluder balls{{{{0.5f, 0.5f, -0.5f}, 0.2f}, {{0.2f, 0.4f, -0.3f}, 0.1f}}};
  const DirectionPackets pilot(even_directions(128));
  Random random(1);
  for (const std::size_t budget : {0u, 40u, 200u, 1500u}) {
    ReceiverMesh receivers(mesh, all_fronts(mesh));
    refine_receivers(
        receivers, balls, pilot, {0.01, budget}, [](const vec3&) { return EdgeLimits{}; }, Serial());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      for (const vec2& uv :
           {vec2(0, 0), vec2(1, 0), vec2(0, 1), vec2(0.5f, 0.5f), vec2(0.5f, 0), vec2(1 / 3.0f)})
        check_location(mesh, receivers, {t, true}, uv);
      for (int i = 0; i < 60; ++i) check_location(mesh, receivers, {t, true}, random_uv(random));
      check_location(mesh, receivers, {t, true}, vec2(-1e-7f, 1 + 1e-7f));  // as rounding puts hits outside
      check_location(mesh, receivers, {t, true}, vec2(0.7f, 0.3f + 2e-7f));
    }
  }
}

TEST_CASE("a back is located on the back") {
  Mesh mesh;
  add_ground(mesh, 1);
  const std::vector<SidedTriangle> sides{{0, true}, {1, false}};
  const ReceiverMesh receivers(mesh, sides);
  check_location(mesh, receivers, {1, false}, vec2(0.2f, 0.3f));
  CHECK(receivers.faces()[receivers.locate({1, false}, vec2(0.2f, 0.3f)).face].normal.y < 0);
}

TEST_CASE("every face knows its scene's triangle, refined ones that of their parent") {
  const Mesh mesh = bumpy_mesh(2, 0.2f, 4);
  const SphereOccluder ball{{{{0.5f, 0.5f, -0.5f}, 0.2f}}};
  ReceiverMesh receivers(mesh, all_fronts(mesh));
  refine_receivers(
      receivers, ball, DirectionPackets(even_directions(128)), {0.01, 200},
      [](const vec3&) { return EdgeLimits{}; }, Serial());
  REQUIRE(receivers.faces().size() > 100);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (const vec2& uv : {vec2(0.1f, 0.1f), vec2(0.8f, 0.1f), vec2(0.1f, 0.8f), vec2(0.3f, 0.3f)})
      CHECK(receivers.faces()[receivers.locate({t, true}, uv).face].triangle == t);
}

TEST_CASE("a mesh comes back from its arrays, and finds what it found") {
  const Mesh mesh = bumpy_mesh(2, 0.2f, 4);
  const SphereOccluder ball{{{{0.5f, 0.5f, -0.5f}, 0.2f}}};
  std::vector<SidedTriangle> sides = all_fronts(mesh);
  sides.push_back({1, false});
  ReceiverMesh receivers(mesh, sides);
  CHECK(receivers.sides().size() == sides.size());
  refine_receivers(
      receivers, ball, DirectionPackets(even_directions(128)), {0.01, 200},
      [](const vec3&) { return EdgeLimits{}; }, Serial());
  const ReceiverMesh copy =
      ReceiverMesh::from_arrays(receivers.corners(), receivers.faces(), receivers.sides());
  Random random(2);
  for (const SidedTriangle& side : sides)
    for (int i = 0; i < 50; ++i) {
      const vec2 uv = random_uv(random);
      const auto a = receivers.locate(side, uv), b = copy.locate(side, uv);
      CHECK(a.face == b.face);
      CHECK(a.weights == b.weights);
    }
}

TEST_CASE("faces have corners, and children of one face each behind it") {
  const auto face = [](std::uint32_t corner, std::uint32_t first_child = no_face,
                       std::uint32_t children = 0) {
    return ReceiverMesh::Face{uvec3(0, 1, corner), {}, vec3(0, 1, 0), 0, first_child, children};
  };
  using Faces = std::vector<ReceiverMesh::Face>;
  CHECK(ReceiverMesh::are_faces(0, {}, 0));
  CHECK(ReceiverMesh::are_faces(3, Faces{face(2)}, 1));
  CHECK(ReceiverMesh::are_faces(3, Faces{face(2, 1, 2), face(2), face(1)}, 1));
  CHECK_FALSE(ReceiverMesh::are_faces(2, Faces{face(2)}, 1));                          // no such corner
  CHECK_FALSE(ReceiverMesh::are_faces(3, Faces{face(2)}, 0));                          // whose child is it?
  CHECK_FALSE(ReceiverMesh::are_faces(3, Faces{face(2)}, 2));                          // a root is missing
  CHECK_FALSE(ReceiverMesh::are_faces(3, Faces{face(2, 1, 3), face(2), face(1)}, 1));  // a child is
  CHECK_FALSE(ReceiverMesh::are_faces(3, Faces{face(2, 0, 1)}, 1));                    // its own child
  CHECK_FALSE(ReceiverMesh::are_faces(3, Faces{face(2, 1, 1), face(2)}, 2));           // a root as a child
  CHECK_FALSE(ReceiverMesh::are_faces(3, Faces{face(2, 2, 1), face(1, 2, 1), face(2)}, 2));  // of two faces
  CHECK_FALSE(ReceiverMesh::are_faces(3, Faces{face(2, no_face, 2), face(1)}, 1));
}
