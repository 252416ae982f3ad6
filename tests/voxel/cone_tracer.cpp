// The visibility of cones through voxels: against many exact rays, at the extremes, and however it is
// computed.
#include <coppice/voxel/cone_tracer.hpp>
//
#include <doctest/doctest.h>

#include <bit>
#include <coppice/reference/voxel.hpp>

#include "support/executors.hpp"
#include "support/occluders.hpp"
#include "voxel/scenes.hpp"

using namespace coppice;

namespace {

ConeReceiver receiver_at(const vec3& position, const vec3& normal) {
  return {position + 1e-4f * normal, 1, normal, 0, normal};
}

template <Occluder O>
float trace_one(const BrickGrid& g, const O& occluder, const ConeReceiver& r, const SgShape& cone,
                const ConeTracerOptions& options = {}) {
  float visibility = -1;
  ConeTracer(g, options)
      .trace(occluder, std::span(&r, 1), std::span(&cone, 1), std::span(&visibility, 1), Serial{});
  return visibility;
}

float march_only(const BrickGrid& g, const ConeReceiver& r, const SgShape& cone) {
  return trace_one(g, OpenSpace{}, r, cone, {.contact = 0});
}

/// Nothing is in the way, but it is counted who asked.
struct CountingSpace {
  std::size_t* rays;

  bool occluded(const vec3&, const vec3&, float) const { return ++*rays, false; }
  std::uint32_t occluded(const ShadowPacket&, std::uint32_t lanes) const {
    *rays += std::size_t(std::popcount(lanes));
    return 0;
  }
};
static_assert(Occluder<CountingSpace>);

/// Receivers on the ground and the things of a still life, seven cones each.
struct StillLife {
  Mesh mesh = support::still_life().mesh;
  VoxelBox box{vec3(-2, 0, -2), vec3(2, 1, 2)};
  std::vector<ConeReceiver> receivers;
  std::vector<SgShape> cones;

  StillLife(std::uint64_t seed, std::size_t count, float sharpness) {
    Random random(seed);
    for (std::uint32_t i = 0; i < count; ++i) {
      const auto t = support::corners_of(mesh, random.below(std::uint32_t(mesh.triangles.size())));
      const vec3 n = normalize(cross(t.b - t.a, t.c - t.a));
      ConeReceiver r = receiver_at(support::point_of(random, t), n);
      r.cones_end = 7 * (i + 1), r.index = i;
      receivers.push_back(r);
      for (int k = 0; k < 7; ++k) cones.push_back({normalize(random.direction() + n), sharpness});
    }
  }
  std::vector<float> trace(const BrickGrid& g, const ConeTracerOptions& options) const {
    std::vector<float> visibility(cones.size(), -1);
    ConeTracer(g, options).trace(support::TriangleTracer(mesh), receivers, cones, visibility, Serial{});
    return visibility;
  }
  std::vector<float> exact(std::uint32_t strata) const {
    const support::TriangleTracer tracer(mesh);
    Random random(9);
    std::vector<float> visibility;
    for (std::size_t i = 0; i < cones.size(); ++i)
      visibility.push_back(reference::cone_visibility(tracer, receivers[i / 7].position,
                                                      receivers[i / 7].normal, cones[i], strata, random));
    return visibility;
  }
};

struct Errors {
  double mean = 0;         ///< |V - exact|
  double leak = 0;         ///< V where nothing is visible
  double self_shadow = 0;  ///< 1 - V where all is
};

Errors errors_of(std::span<const float> v, std::span<const float> exact) {
  Errors e;
  double hidden = 1e-9, open = 1e-9;
  for (std::size_t i = 0; i < v.size(); ++i) {
    e.mean += double(std::abs(v[i] - exact[i])) / double(v.size());
    if (exact[i] == 0) hidden += 1, e.leak += double(v[i]);
    if (exact[i] == 1) open += 1, e.self_shadow += 1 - double(v[i]);
  }
  REQUIRE(hidden > 20);
  REQUIRE(open > 20);
  e.leak /= hidden, e.self_shadow /= open;
  return e;
}

}  // namespace

TEST_CASE("the visibility of cones is near that of many rays, and exact rays at contact halve the error") {
  const StillLife scene(1, 200, 50);
  BrickBuilder builder(scene.box, 128);
  builder.build(scene.mesh, Serial{});
  const auto exact = scene.exact(12);
  const Errors with = errors_of(scene.trace(builder.grid(), {}), exact);
  const Errors without = errors_of(scene.trace(builder.grid(), {.contact = 0}), exact);
  MESSAGE("with contact: mean " << with.mean << " leak " << with.leak << " self-shadow " << with.self_shadow);
  MESSAGE("without: mean " << without.mean << " leak " << without.leak << " self-shadow "
                           << without.self_shadow);
  CHECK(with.mean < 0.03);
  CHECK(with.leak < 0.01);
  CHECK(with.self_shadow < 0.01);
  CHECK(with.mean < 0.7 * without.mean);
}

TEST_CASE("wide cones are told to a few percent") {
  const StillLife scene(2, 200, 6);
  const BrickGrid g = support::grid_of(scene.mesh, scene.box, 128);
  std::vector<float> exact = scene.exact(16), v = scene.trace(g, {});
  double mean = 0;
  for (std::size_t i = 0; i < v.size(); ++i) mean += double(std::abs(v[i] - exact[i])) / double(v.size());
  MESSAGE("mean error " << mean);
  CHECK(mean < 0.05);
}

TEST_CASE("nothing shines through a thin wall, however it stands and wherever the march begins") {
  CHECK(rc::check([] {
    Random random = test_support::any_random();
    const vec3 n = random.direction();
    vec3 a, b;
    make_frame(n, a, b);
    Mesh mesh;
    support::add_quad(mesh, -3.0f * (a + b), 6.0f * a, 6.0f * b);
    const BrickGrid g = support::grid_of(mesh, support::unit_box(), 64);
    const vec3 p = (0.12f + 0.4f * random.uniform()) * n + 0.2f * random.direction();
    const SgShape cone{-n, std::exp(5 + 6 * random.uniform())};
    if (dot(p, n) > 0.1f) RC_ASSERT(march_only(g, receiver_at(p, -n), cone) <= 0.05f);
    if (dot(p, n) > 0.1f) RC_ASSERT(march_only(g, receiver_at(p, n), {n, cone.sharpness}) == 1.0f);
  }));
}

TEST_CASE("a plane and a ball do not shadow themselves, at any angle, sharpness and softness") {
  Random random(4);
  Mesh plane, ball;
  support::add_quad(plane, {-1.2f, -0.4f, 1}, {2.4f, 0.7f, 0.1f}, {0.1f, 0.2f, -2.1f});
  support::add_ball(ball, vec3(0), 0.8f, 64);
  for (const Mesh* mesh : {&plane, &ball}) {
    const BrickGrid g = support::grid_of(*mesh, support::unit_box(), 128);
    VoxelTrace soft = default_voxel_trace;
    soft.softness = 2;
    double lost = 0, lost_soft = 0, count = 0;
    for (int i = 0; i < 2000; ++i) {
      const auto t = support::corners_of(*mesh, random.below(std::uint32_t(mesh->triangles.size())));
      const vec3 n = normalize(cross(t.b - t.a, t.c - t.a)), p = support::point_of(random, t);
      const SgShape cone{random.direction(), std::exp(8 * random.uniform())};
      if (dot(cone.axis, n) <= 0) continue;
      const ConeReceiver r = receiver_at(p, n);
      lost += 1 - double(march_only(g, r, cone)), ++count;
      lost_soft += 1 - double(trace_one(g, OpenSpace{}, r, cone, {soft, 0}));
    }
    MESSAGE("self-shadow " << lost / count << ", of softer rays " << lost_soft / count);
    CHECK(lost / count < 0.01);
    CHECK(lost_soft / count < 0.01);
  }
}

TEST_CASE("a half plane hides half of a cone whose axis meets its edge") {
  Mesh mesh;
  support::add_quad(mesh, {-3, -3, 0.7f}, {3, 0, 0}, {0, 6, 0});
  const BrickGrid g = support::grid_of(mesh, support::unit_box(), 256);
  VoxelTrace trace = default_voxel_trace;
  trace.rays = 64;
  const ConeReceiver r = receiver_at(vec3(0, 0.01f, 0.4f), vec3(0, 0, 1));
  for (const float sharpness : {6.0f, 50.0f, 500.0f}) {
    const float v = trace_one(g, OpenSpace{}, r, {r.normal, sharpness}, {trace, 0});
    // The edge counts as a voxel thick, in front of the half of the cone that is open.
    CHECK(v < 0.53f);
    CHECK(v > 0.47f - 0.4f * std::sqrt(sharpness) * g.grid.voxel / 0.3f);
  }
}

TEST_CASE("visibility is a number in [0, 1] whatever is asked, and 0 below the horizon") {
  Random random(6);
  const Mesh mesh = support::triangle_soup(random, 60);
  const BrickGrid soup = support::grid_of(mesh, support::unit_box(), 32),
                  empty = support::grid_of({}, support::unit_box(), 32);
  for (int i = 0; i < 3000; ++i) {
    const vec3 n = random.direction(), axis = i % 7 == 0 ? (i % 2 == 0 ? n : -n) : random.direction();
    const float sharpness = i % 5 == 0 ? 0.0f : std::exp(30 * random.uniform() - 8);
    const float away = i % 3 == 0 ? 1e4f * random.uniform() : 1.5f;
    const vec3 p = i % 11 == 0 ? mesh.positions[random.below(180)] : away * random.direction();
    for (const float v : {march_only(soup, receiver_at(p, n), {axis, sharpness}),
                          cone_visibility(soup, p, n, {axis, sharpness})})
      CHECK((v >= 0 && v <= 1));
    const float open = march_only(empty, receiver_at(p, n), {axis, sharpness});
    CHECK((open == doctest::Approx(1) || (open == 0 && dot(axis, n) < 0.1f)));
  }
  CHECK(march_only(empty, receiver_at(vec3(0), vec3(0, 1, 0)), {vec3(0, -1, 0), 1000}) == 0);
  CHECK(march_only(empty, receiver_at(vec3(0), vec3(0, 1, 0)), {vec3(0, -1, 0), 0}) == doctest::Approx(1));
}

TEST_CASE("what the shading normal lights below the surface's horizon is hidden") {
  const BrickGrid empty = support::grid_of({}, support::unit_box(), 32);
  ConeReceiver r = receiver_at(vec3(0), vec3(0, 1, 0));
  r.shading_normal = normalize(vec3(1, 0.2f, 0));
  CHECK(march_only(empty, r, {normalize(vec3(1, -0.15f, 0)), 1e5f}) == 0);
  CHECK(march_only(empty, r, {vec3(1, 0, 0), 1000}) == doctest::Approx(0.5).epsilon(0.2));
  CHECK(march_only(empty, r, {normalize(vec3(1, 1, 0)), 1000}) == doctest::Approx(1));
}

TEST_CASE("registers of rays and one ray at a time agree") {
  const StillLife scene(7, 60, 20);
  const BrickGrid g = support::grid_of(scene.mesh, scene.box, 64);
  for (const std::uint32_t rays : {1u, 3u, 8u, 17u}) {
    VoxelTrace trace = default_voxel_trace;
    trace.rays = rays;
    double worst = 0;
    const auto v = scene.trace(g, {trace, 0});
    for (std::size_t i = 0; i < v.size(); ++i) {
      const ConeReceiver& r = scene.receivers[i / 7];
      worst = std::max(
          worst, double(std::abs(v[i] - cone_visibility(g, r.position, r.normal, scene.cones[i], trace))));
    }
    // Rounding may end a march a step sooner or later.
    CHECK(worst < 0.02);
  }
}

TEST_CASE("any executor traces the same bits") {
  const StillLife scene(8, 200, 30);
  const BrickGrid g = support::grid_of(scene.mesh, scene.box, 64);
  const support::TriangleTracer occluder(scene.mesh);
  const ConeTracer tracer(g);
  std::vector<float> serial(scene.cones.size(), -1), backwards(serial), threads(serial);
  tracer.trace(occluder, scene.receivers, scene.cones, serial, Serial{});
  tracer.trace(occluder, scene.receivers, scene.cones, backwards, support::Backwards{});
  tracer.trace(occluder, scene.receivers, scene.cones, threads, support::TwoThreads{});
  CHECK(serial == backwards);
  CHECK(serial == threads);
}

TEST_CASE("exact rays are traced where something may be near, and spared over an open plane") {
  Mesh mesh;
  support::add_ground(mesh, 1);
  support::add_quad(mesh, {0.5f, 0, 0.5f}, {0, 0, -1}, {0, 0.2f, 0});
  // The ground is low in its bricks: those hold what is five voxels above.
  const BrickGrid g = support::grid_of(mesh, {vec3(-1, 0, -1), vec3(1, 1.1f, 1)}, 128);
  const vec3 up(0, 1, 0);
  const auto rays_at = [&](const vec3& position, const SgShape& cone) {
    std::size_t rays = 0;
    trace_one(g, CountingSpace{&rays}, receiver_at(position, up), cone);
    return rays;
  };
  const SgShape steep{normalize(vec3(1, 1, 0)), 1000}, grazing{normalize(vec3(1, 0.2f, 0)), 1000};
  CHECK(rays_at({0.5f - 2 * g.grid.voxel, 0, 0.1f}, steep) == 8);
  CHECK(rays_at({-0.3f, 0, 0.1f}, grazing) == 8);
  CHECK(rays_at({-0.3f, 0, 0.1f}, steep) == 0);
}
