// Refinement of receivers: conforming, within its limits, and good for shadows.
#include <doctest/doctest.h>

#include <coppice/core/random.hpp>
#include <coppice/light/directions.hpp>
#include <coppice/relight/refine.hpp>
#include <set>
#include <support/executors.hpp>
#include <support/occluders.hpp>
#include <support/scenes.hpp>

#include "relight/receiver_meshes.hpp"

using namespace coppice;
using namespace relight_test;
using namespace support;

namespace {

const SphereOccluder two_balls{{{{0.5f, 0.4f, -0.5f}, 0.2f}, {{0.1f, 0.5f, -0.2f}, 0.15f}}};

const auto no_limits = [](const vec3&) { return EdgeLimits{}; };

ReceiverMesh refined(const Mesh& mesh, const RefineOptions& options, EdgeLimits limits = {}) {
  ReceiverMesh receivers(mesh, all_fronts(mesh));
  const DirectionPackets pilot(even_directions(256));
  refine_receivers(
      receivers, two_balls, pilot, options, [&](const vec3&) { return limits; }, Serial());
  return receivers;
}

template <class Visit>
void for_each_edge(const ReceiverMesh& mesh, std::uint32_t face, Visit&& visit) {
  const uvec3 c = mesh.faces()[face].corners;
  for (int k = 0; k < 3; ++k) visit(mesh.corners()[c[k]].position, mesh.corners()[c[(k + 1) % 3]].position);
}

float longest_edge(const ReceiverMesh& mesh, std::uint32_t face) {
  float longest = 0;
  for_each_edge(mesh, face,
                [&](const vec3& a, const vec3& b) { longest = std::max(longest, length(a - b)); });
  return longest;
}

/// No corner stands in the middle of an undivided face's edge.
void check_conforming(const ReceiverMesh& mesh) {
  const auto key = [](const vec3& p) { return std::array{p.x, p.y, p.z}; };
  std::set<std::array<float, 3>> corners;
  for (const auto& c : mesh.corners()) corners.insert(key(c.position));
  for (std::uint32_t f = 0; f < mesh.faces().size(); ++f)
    if (mesh.is_leaf(f))
      for_each_edge(
          mesh, f, [&](const vec3& a, const vec3& b) { CHECK_FALSE(corners.contains(key(0.5f * (a + b)))); });
}

/// Children tile their face: areas in (u, v) add up, all turn the same way.
void check_tiling(const ReceiverMesh& mesh) {
  const auto area = [](const ReceiverMesh::Face& f) {
    const vec2 a = f.uv[1] - f.uv[0], b = f.uv[2] - f.uv[0];
    return double(a.x) * b.y - double(a.y) * b.x;
  };
  for (const auto& face : mesh.faces()) {
    double sum = 0;
    for (std::uint32_t c = 0; c < face.child_count; ++c) {
      const auto& child = mesh.faces()[face.first_child + c];
      CHECK(area(child) > 0);
      CHECK(child.normal == face.normal);
      sum += area(child);
    }
    if (face.child_count > 0) CHECK(std::abs(sum - area(face)) < 1e-6 * area(face));
  }
}

Mesh coarse_ground() {
  Mesh mesh;
  add_ground(mesh, 2);
  return mesh;
}

/// Mean over random points of the plane of |interpolated - exact| irradiance, as a share of the unoccluded.
double interpolation_error(const Mesh& scene, const ReceiverMesh& mesh, const TriangleTracer& tracer) {
  const auto directions = even_directions(500, 2);
  const DirectionPackets lights(directions);
  const auto receivers = corner_receivers(mesh);
  const std::uint32_t words = words_for_bits(500);
  std::vector<std::uint64_t> bits(receivers.size() * words);
  for (std::size_t i = 0; i < receivers.size(); ++i)
    trace_visibility(tracer, lights, receivers[i], std::span(bits).subspan(i * words, words));
  Random random(7);
  double error = 0, total = 0;
  for (int i = 0; i < 300; ++i) {
    const std::uint32_t t = random.below(2);
    const float u = random.uniform(), v = (1 - u) * random.uniform();
    const auto at = mesh.locate({t, true}, {u, v});
    const uvec3 corners = mesh.faces()[at.face].corners, r = scene.triangles[t];
    const vec3 p = (1 - u - v) * scene.positions[r.x] + u * scene.positions[r.y] + v * scene.positions[r.z];
    for (std::uint32_t l = 0; l < directions.size(); ++l) {
      const float cosine = directions[l].y;
      if (cosine <= 0) continue;
      float seen = 0;
      for (int k = 0; k < 3; ++k) seen += at.weights[k] * float(bit_at(bits.data() + corners[k] * words, l));
      const bool exact = !tracer.occluded(p + vec3(0, 1e-4f, 0), directions[l], 1e30f);
      error += cosine * std::abs(seen - float(exact));
      total += cosine;
    }
  }
  return error / total;
}

}  // namespace

TEST_CASE("the error of an edge is a share of the unoccluded irradiance") {
  const DirectionPackets pilot(even_directions(4096));
  const std::vector<std::uint64_t> no_bits(64, 0), all_bits(64, ~std::uint64_t{0});
  const PilotView none{vec3(0), no_bits}, all{vec3(0), all_bits};
  const vec3 up(0, 1, 0);
  CHECK(edge_error(pilot, up, all, all, all) == 0);
  CHECK(edge_error(pilot, up, none, none, none) == 0);
  CHECK(std::abs(edge_error(pilot, up, all, all, none) - 1) < 1e-3);
  CHECK(std::abs(edge_error(pilot, up, none, none, all) - 1) < 1e-3);
  CHECK(std::abs(edge_error(pilot, up, all, none, all) - 0.5) < 1e-3);
  CHECK(std::abs(edge_error(pilot, up, none, all, none) - 0.5) < 1e-3);
}

TEST_CASE("refinement ends, conforms and tiles, on flat and on bumpy ground") {
  for (const float amplitude : {0.0f, 0.1f}) {
    const Mesh mesh = bumpy_mesh(3, amplitude, 3);
    const ReceiverMesh receivers = refined(mesh, {0.02, 20000}, {0.02f, 1});
    CHECK(receivers.corners().size() > 100);
    CHECK(receivers.corners().size() < 20000);
    check_conforming(receivers);
    check_tiling(receivers);
  }
}

TEST_CASE("an edge within the limits meets the tolerance or is too short") {
  const RefineOptions options{0.05, 100000};
  const ReceiverMesh receivers = refined(bumpy_mesh(2, 0.0f, 1), options, {0.05f, 1});
  std::vector<std::uint64_t> rows[3];
  const DirectionPackets pilot(even_directions(256));
  const auto trace = [&](const vec3& p) {
    Receiver r;
    r.position = p + vec3(0, 1e-4f, 0), r.normal = {0, 1, 0}, r.horizon = 0;
    std::vector<std::uint64_t> bits(words_for_bits(256));
    trace_visibility(two_balls, pilot, r, bits);
    return bits;
  };
  std::size_t edges = 0, failing = 0;
  for (std::uint32_t f = 0; f < receivers.faces().size(); ++f)
    if (receivers.is_leaf(f))
      for_each_edge(receivers, f, [&](const vec3& a, const vec3& b) {
        if (length(a - b) <= 0.05f) return;
        ++edges;
        failing += edge_error(pilot, {0, 1, 0}, {a, trace(a)}, {b, trace(b)},
                              {0.5f * (a + b), trace(0.5f * (a + b))}) > 0.08;
      });
  REQUIRE(edges > 100);
  CHECK(failing * 20 < edges);  // receivers stand a little inside, so some edges are judged elsewhere
}

TEST_CASE("a budget of receivers is spent exactly, and the mesh conforms then too") {
  for (const std::size_t budget : {17u, 18u, 19u, 25u, 57u, 100u, 333u}) {
    const ReceiverMesh receivers = refined(bumpy_mesh(3, 0.1f, 3), {1e-6, budget});
    CHECK(receivers.corners().size() == budget);
    check_conforming(receivers);
    check_tiling(receivers);
  }
}

TEST_CASE("a budget smaller than the mesh splits nothing") {
  const ReceiverMesh receivers = refined(bumpy_mesh(3, 0.1f, 3), {1e-6, 5});
  CHECK(receivers.corners().size() == 16);
  CHECK(receivers.faces().size() == 18);
}

TEST_CASE("edges shorter than the limit stay whole, longer ones than the other are split") {
  const ReceiverMesh fine = refined(bumpy_mesh(3, 0.0f, 3), {1e-6, 100000}, {0.1f, 1});
  for (std::uint32_t f = 0; f < fine.faces().size(); ++f)
    if (!fine.is_leaf(f)) CHECK(longest_edge(fine, f) > 0.1f);
  const ReceiverMesh even = refined(coarse_ground(), {1.0, 100000}, {0, 0.3f});
  for (std::uint32_t f = 0; f < even.faces().size(); ++f)
    if (even.is_leaf(f)) CHECK(longest_edge(even, f) <= 0.3f);
  CHECK(refined(coarse_ground(), {1.0, 100000}).corners().size() == 4);
}

TEST_CASE("nothing to refine is left as it is") {
  ReceiverMesh empty;
  refine_receivers(empty, two_balls, DirectionPackets(even_directions(8)), {}, no_limits, Serial());
  CHECK(empty.faces().empty());
  const Mesh mesh = coarse_ground();
  ReceiverMesh receivers(mesh, all_fronts(mesh));
  refine_receivers(receivers, two_balls, DirectionPackets({}), {}, no_limits, Serial());
  CHECK(receivers.faces().size() == 2);
}

TEST_CASE("a degenerate triangle ends refinement") {
  Mesh mesh;
  for (const float x : {0.0f, 1.0f, 2.0f}) add_vertex(mesh, {x, 0, -0.5f}, {0, 1, 0});
  for (int i = 0; i < 3; ++i) add_vertex(mesh, {0.2f, 0, -0.3f}, {0, 1, 0});
  add_triangle(mesh, {0, 1, 2}), add_triangle(mesh, {3, 4, 5});
  const ReceiverMesh receivers = refined(mesh, {0.01, 500}, {0.01f, 1});
  CHECK(receivers.corners().size() <= 500);
  for (const Receiver& r : corner_receivers(receivers)) CHECK(is_finite(r.position));
}

TEST_CASE("refinement does not depend on who traces") {
  const Mesh mesh = bumpy_mesh(3, 0.1f, 5);
  const auto run = [&](const auto& executor) {
    ReceiverMesh receivers(mesh, all_fronts(mesh));
    refine_receivers(receivers, two_balls, DirectionPackets(even_directions(128)), {0.02, 2000}, no_limits,
                     executor);
    std::vector<vec3> positions;
    for (const auto& c : receivers.corners()) positions.push_back(c.position);
    return positions;
  };
  const auto serial = run(Serial());
  CHECK(serial == run(TwoThreads()));
  CHECK(serial == run(Backwards{3}));
}

TEST_CASE("the shadow of a box on two triangles is there only after refinement") {
  Mesh scene = coarse_ground();
  add_box(scene, {-0.3f, 0.3f, -0.3f}, {0.3f, 0.7f, 0.3f});
  const TriangleTracer tracer(scene);
  const Mesh ground = coarse_ground();
  ReceiverMesh coarse(ground, all_fronts(ground)), fine = coarse;
  const auto limits = [](const vec3&) { return EdgeLimits{0.05f, 0.5f}; };
  refine_receivers(fine, tracer, DirectionPackets(even_directions(256)), {0.02, 4000}, limits, Serial());
  const double without = interpolation_error(scene, coarse, tracer),
               with = interpolation_error(scene, fine, tracer);
  CHECK(without > 0.03);
  CHECK(with < 0.01);
}
