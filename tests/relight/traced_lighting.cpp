// Cuts a point with traced visibility against the sum over all lights.
#include <doctest/doctest.h>

#include <coppice/reference/local.hpp>
#include <coppice/relight/local_relighting.hpp>
#include <coppice/relight/traced_lighting.hpp>
#include <support/executors.hpp>
#include <support/local_lights.hpp>
#include <support/occluders.hpp>
#include <support/shading.hpp>

using namespace coppice;
using support::LightKind;

namespace {

const support::SphereOccluder nothing{};
const support::SphereOccluder balls{
    {{vec3(0.4f, 0.3f, 0), 0.35f}, {vec3(-0.6f, 0, 0.4f), 0.3f}, {vec3(0, -0.5f, -0.5f), 0.4f}}};

/// Lights on their tree, with the illumination cut from which estimates begin.
struct LitRoom {
  std::vector<LocalLight> lights;
  LightTree tree;
  LocalLighting lighting;

  explicit LitRoom(std::vector<LocalLight> l, std::size_t nodes = 64)
      : lights(std::move(l)), tree(build_local_tree(lights)), lighting(tree, lights) {
    lighting.set_cut(nodes, 0);
  }
  LitRoom(LitRoom&&) = delete;
};

/// Points of the materials, each at its own place.
ShadingBuffer points_of(std::span<const support::SetMaterial> materials, int count, Random& random) {
  ShadingBuffer buffer;
  buffer.points = support::random_points(materials, count, random);
  for (std::size_t p = 0; p < buffer.points.size(); ++p)
    buffer.positions.push_back(1.2f * support::in_box(random));
  return buffer;
}

template <class O>
void check_exact(const ShadingBuffer& buffer, const LitRoom& room, const O& occluder) {
  const auto radiance = shade_traced(buffer, room.lighting, occluder, {1e-9f}, Serial());
  for (std::size_t p = 0; p < buffer.points.size(); ++p) {
    const vec3 expected =
        reference::local_radiance(buffer.points[p], buffer.positions[p], room.lights, occluder);
    CAPTURE(p);
    CHECK(length(radiance[p] - expected) <= 2e-4f * length(expected));
  }
}

/// White Lambert: brightness is that of the light.
ShadingPoint grey_point(Random& random) {
  ShadingPoint point = support::random_point(random);
  set_lambert(point, vec3(0.8f));
  return point;
}

/// What the lights below a node add to a point where nothing is in between, as luminance.
double contribution(const LitRoom& room, std::uint32_t h, const ShadingPoint& point, const vec3& position) {
  std::vector<LocalLight> below;
  const LeafRange range = leaves_below(room.tree.leaf_count(), h);
  for (std::uint32_t leaf = range.begin; leaf < range.end; ++leaf)
    if (room.tree.light_of_leaf[leaf] != no_light)
      below.push_back(room.lights[room.tree.light_of_leaf[leaf]]);
  return double(luminance(reference::local_radiance(point, position, below, nothing)));
}

void check_bounds(const LitRoom& room, Random& random, int points, float far) {
  for (int i = 0; i < points; ++i) {
    const ShadingPoint point = grey_point(random);
    const vec3 position = far * support::in_box(random);
    const NodeBounds bounds(room.lighting, point, position, Lambert(point));
    for (std::uint32_t h = 1; h < 2 * room.tree.leaf_count(); ++h)
      CHECK(contribution(room, h, point, position) <= double(bounds.bound(h)) * 1.0002 + 1e-12);
  }
}

}  // namespace

TEST_CASE("with a tolerance near zero every point gets the sum over all lights, of every BRDF") {
  Random random(1);
  for (const std::uint32_t count : {1u, 2u, 3u, 100u, 400u}) {
    CAPTURE(count);
    const LitRoom room(support::random_local_lights(random, count));
    const ShadingBuffer buffer = points_of(support::wide_materials, 8, random);
    check_exact(buffer, room, nothing);
    check_exact(buffer, room, balls);
  }
}

TEST_CASE("narrow lobes find their lights too") {
  Random random(2);
  const LitRoom room(support::random_local_lights(random, 200));
  check_exact(points_of(support::narrow_materials, 8, random), room, balls);
}

TEST_CASE("bounds of nodes hold for points, spots, surfaces and suns, alone and together") {
  Random random(3);
  for (int round = 0; round < 6; ++round) {
    for (const LightKind kind : support::all_light_kinds) {
      const LitRoom room(support::random_local_lights(random, 60, std::array{kind}));
      check_bounds(room, random, 12, 3);
    }
    const LitRoom room(support::random_local_lights(random, 100));
    check_bounds(room, random, 12, 3);
    check_bounds(room, random, 4, 0.8f);
  }
}

TEST_CASE("bounds are close where lights are far and alike: a cluster seen from afar is not split") {
  Random random(4);
  auto lights = support::random_local_lights(random, 64, std::array{LightKind::point});
  for (auto& l : lights) l.position *= 0.01f;
  const LitRoom room(lights);
  ShadingPoint point = grey_point(random);
  point.normal = vec3(0, 1, 0);
  const NodeBounds bounds(room.lighting, point, vec3(0, -2, 0), Lambert(point));
  const double exact = contribution(room, 1, point, vec3(0, -2, 0));
  CHECK(bounds.bound(1) < 1.05 * exact);
  CHECK(bounds.estimate(1) == doctest::Approx(exact).epsilon(0.01));
}

TEST_CASE("a coarse cut is right in the mean") {
  Random random(5);
  const LitRoom room(support::random_local_lights(random, 300));
  const ShadingBuffer buffer = points_of(support::wide_materials, 4, random);
  const std::size_t count = buffer.points.size();
  const int draws = 1500;
  std::vector<double> sum(count), squares(count);
  for (int i = 0; i < draws; ++i) {
    const auto radiance = shade_traced(buffer, room.lighting, balls, {0.3f, std::uint64_t(i)}, Serial());
    for (std::size_t p = 0; p < count; ++p) {
      const double y = luminance(radiance[p]);
      sum[p] += y, squares[p] += y * y;
    }
  }
  for (std::size_t p = 0; p < count; ++p) {
    const double mean = sum[p] / draws, variance = std::max(0.0, squares[p] / draws - mean * mean);
    const double exact =
        luminance(reference::local_radiance(buffer.points[p], buffer.positions[p], room.lights, balls));
    CAPTURE(p);
    CAPTURE(exact);
    CHECK(std::abs(mean - exact) <= 4 * std::sqrt(variance / draws) + 1e-4 * exact);
  }
}

TEST_CASE("fewer rays than lights, the more the finer, and all are counted") {
  Random random(6);
  const LitRoom room(support::random_local_lights(random, 1000, std::array{LightKind::point}));
  const ShadingBuffer buffer = points_of(std::span(support::wide_materials).first(1), 30, random);
  std::vector<std::uint32_t> rays(buffer.points.size());
  const auto total = [&](float tolerance) {
    shade_traced(buffer, room.lighting, nothing, {tolerance}, Serial(), rays);
    return std::accumulate(rays.begin(), rays.end(), 0u);
  };
  const std::uint32_t coarse = total(0.1f), fine = total(0.01f);
  CHECK(coarse > 0);
  CHECK(fine > 1.5 * coarse);
  CHECK(coarse < 30 * 500);
  total(1e-12f);
  for (std::size_t p = 0; p < buffer.points.size(); ++p) {
    std::uint32_t above = 0;
    for (const auto& l : room.lights)
      above += dot(l.position - buffer.positions[p], buffer.points[p].normal) > 0;
    CHECK(rays[p] % above == 0);
  }
}

TEST_CASE("the seed decides, not the executor") {
  Random random(7);
  const LitRoom room(support::random_local_lights(random, 500));
  const ShadingBuffer buffer = points_of(support::wide_materials, 60, random);
  const auto on = [&](const auto& executor, std::uint64_t seed) {
    return shade_traced(buffer, room.lighting, balls, {0.1f, seed}, executor);
  };
  const auto one = on(Serial(), 1);
  CHECK(on(support::Backwards(), 1) == one);
  CHECK(on(support::TwoThreads(), 1) == one);
  CHECK(on(Serial(), 2) != one);
}

TEST_CASE("without lights, above none, and at a light itself points are finite and as dark as they must be") {
  Random random(8);
  const ShadingBuffer buffer = points_of(support::wide_materials, 3, random);
  const LitRoom empty({});
  std::vector<std::uint32_t> rays(buffer.points.size(), 7);
  for (const vec3& r : shade_traced(buffer, empty.lighting, nothing, {}, Serial(), rays)) CHECK(r == vec3(0));
  std::vector<LocalLight> off = support::random_local_lights(random, 20);
  for (auto& l : off) l.intensity = vec3(0);
  const LitRoom dark(off);
  for (const vec3& r : shade_traced(buffer, dark.lighting, nothing, {}, Serial())) CHECK(r == vec3(0));
  ShadingBuffer above = buffer;
  for (std::size_t p = 0; p < above.points.size(); ++p) above.positions[p] = 9.0f * above.points[p].normal;
  const LitRoom below(support::random_local_lights(random, 50, std::array{LightKind::point}));
  for (const vec3& r : shade_traced(above, below.lighting, nothing, {}, Serial(), rays)) CHECK(r == vec3(0));
  CHECK(std::ranges::all_of(rays, [](std::uint32_t r) { return r == 0; }));
  ShadingBuffer at_light = buffer;
  for (vec3& p : at_light.positions) p = below.lights[13].position;
  for (const vec3& r : shade_traced(at_light, below.lighting, nothing, {}, Serial())) CHECK(is_finite(r));
  check_exact(at_light, below, balls);
}
