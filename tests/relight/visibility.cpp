// Shadow rays in packets against shadow rays one by one, and what the horizon leaves out.
#include <doctest/doctest.h>

#include <coppice/core/random.hpp>
#include <coppice/light/directions.hpp>
#include <coppice/relight/receivers.hpp>
#include <coppice/relight/visibility.hpp>
#include <support/occluders.hpp>
#include <support/scenes.hpp>

#include "relight/receiver_meshes.hpp"

using namespace coppice;
using namespace relight_test;
using namespace support;

namespace {

SphereOccluder random_spheres(Random& random, int count) {
  SphereOccluder occluder;
  for (int i = 0; i < count; ++i)
    occluder.spheres.push_back(
        {(1 + 2 * random.uniform()) * random.direction(), 0.2f + 0.6f * random.uniform()});
  return occluder;
}

void check_horizon_hides_nothing(const Mesh& mesh) {
  const ReceiverMesh receivers(mesh, all_fronts(mesh));
  const auto normals = normals_around(receivers);
  const auto placed = corner_receivers(receivers);
  const auto directions = even_directions(2000, 3);
  for (std::size_t c = 0; c < placed.size(); ++c)
    for (const vec3& d : directions) {
      const bool faces_a_side =
          std::ranges::any_of(normals[c], [&](const vec3& n) { return dot(n, d) > 1e-3f; });
      if (faces_a_side && !(dot(placed[c].normal, d) > placed[c].horizon))
        FAIL_CHECK("corner " << c << " leaves out a light above one of its faces");
    }
}

}  // namespace

TEST_CASE("visibility in packets equals one ray after the other, whatever the number of lights") {
  Random random(1);
  for (const std::uint32_t count : {1u, 15u, 16u, 17u, 63u, 64u, 65u, 1000u}) {
    auto directions = even_directions(count, 5);
    if (count > 20) directions[3] = directions[count - 1] = vec3(0);  // padding
    const DirectionPackets lights(directions);
    const SphereOccluder occluder = random_spheres(random, 6);
    for (int r = 0; r < 10; ++r) {
      Receiver receiver;
      receiver.position = 0.3f * random.direction();
      receiver.normal = random.direction();
      receiver.horizon = -random.uniform();
      std::vector<std::uint64_t> bits(words_for_bits(count), ~std::uint64_t{0});
      const std::size_t traced = trace_visibility(occluder, lights, receiver, bits);
      std::size_t expected_rays = 0;
      for (std::uint32_t i = 0; i < 64 * bits.size(); ++i) {
        const vec3 d = i < count ? directions[i] : vec3(0);
        const bool above = d != vec3(0) && dot(receiver.normal, d) > receiver.horizon;
        const bool visible = above && !occluder.occluded(receiver.position, d, 1e30f);
        expected_rays += above;
        REQUIRE(bit_at(bits.data(), i) == visible);
      }
      CHECK(traced == expected_rays);
    }
  }
}

TEST_CASE("no light above a face is below its receivers' horizon") {
  Mesh flat;
  add_ground(flat, 1);
  check_horizon_hides_nothing(flat);
  Mesh ball;
  add_ball(ball, vec3(0), 1, 6);
  check_horizon_hides_nothing(ball);
  for (const float amplitude : {0.02f, 0.1f, 0.5f}) check_horizon_hides_nothing(bumpy_mesh(8, amplitude, 11));
}

TEST_CASE("leaving out lights below the horizon changes no bit that a ray would set") {
  Mesh mesh;
  add_ball(mesh, vec3(0), 1, 6);
  add_ground(mesh, 2, -1.5f);
  const TriangleTracer tracer(mesh);
  const ReceiverMesh receivers(mesh, all_fronts(mesh));
  const auto normals = normals_around(receivers);
  const auto directions = even_directions(512);
  const DirectionPackets lights(directions);
  std::vector<std::uint64_t> culled(words_for_bits(512)), full = culled;
  const auto placed = corner_receivers(receivers);
  std::size_t saved = 0;
  for (std::size_t c = 0; c < placed.size(); ++c) {
    Receiver all_round = placed[c];
    all_round.horizon = -2;
    saved -= trace_visibility(tracer, lights, placed[c], culled);
    saved += trace_visibility(tracer, lights, all_round, full);
    for (std::uint32_t i = 0; i < 512; ++i) {
      // A ray that grazes the surface from its clearance above may pass the surface's border.
      float highest = -1;
      for (const vec3& n : normals[c]) highest = std::max(highest, dot(n, directions[i]));
      if (highest < -0.1f || highest > 1e-3f) CHECK(bit_at(culled.data(), i) == bit_at(full.data(), i));
    }
  }
  CHECK(saved > placed.size() * 512 / 4);
}

TEST_CASE("directions of leaves follow the tree, zero where no light is") {
  const auto directions = even_directions(3);
  LightTree tree;
  tree.light_of_leaf = {2, no_light, 0, 1};
  const auto leaves = leaf_directions(tree, directions);
  CHECK(leaves == std::vector<vec3>{directions[2], vec3(0), directions[0], directions[1]});
}
