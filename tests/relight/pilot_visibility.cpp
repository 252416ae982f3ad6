// Pilot receivers, what they tell about lights, and that no ray is traced twice.
#include <doctest/doctest.h>

#include <coppice/relight/cut_relighting.hpp>
#include <coppice/relight/local_relighting.hpp>
#include <coppice/trade/errors.hpp>
#include <set>
#include <support/executors.hpp>
#include <support/occluders.hpp>
#include <support/scenes.hpp>

#include "relight/lights.hpp"

using namespace coppice;
using namespace relight_test;
using namespace support;

namespace {

const SphereOccluder three_spheres{{{{1, 0, 0}, 0.5f}, {{-1, 0.5f, 0}, 0.8f}, {{0, -1, 1}, 0.6f}}};

std::vector<LightSample> samples_of(const Lights& lights) {
  std::vector<LightSample> samples;
  for (const vec3& d : lights.directions) samples.push_back({d, vec3(0)});
  return samples;
}

/// By light, whatever the order of the row.
std::vector<bool> seen_lights(const LightTree& tree, std::span<const std::uint64_t> row) {
  std::vector<bool> seen(tree.light_count[1]);
  for (std::uint32_t leaf = 0; leaf < tree.leaf_count(); ++leaf)
    if (tree.light_of_leaf[leaf] != no_light) seen[tree.light_of_leaf[leaf]] = bit_at(row.data(), leaf);
  return seen;
}

constexpr PilotOptions few{16, 4, 0, {8, 4}};

Scene ball_and_box() {
  Scene scene;
  scene.materials = {dielectric({0.6f, 0.6f, 0.55f}, 0.9f), dielectric({0.7f, 0.3f, 0.2f}, 0.6f)};
  add_ground(scene.mesh, 2, 0, 0);
  add_ball(scene.mesh, {0.3f, 0.6f, 0}, 0.5f, 5, 1);
  add_box(scene.mesh, {-1, 0, -0.5f}, {-0.4f, 0.9f, 0.3f}, 1);
  scene.camera = look_at({0.5f, 2, 3.5f}, {0, 0.35f, 0}, 0.7f);
  return scene;
}

CutRelighting<> relighting_with(const Scene& scene, const TriangleTracer& tracer, float beta) {
  CutRelightingOptions o;
  o.raster = {48, 36, 1};
  o.light_count = 2048;
  o.pilot_stride = 4;
  o.refine.max_receivers = 1500;
  o.cuts = {{1, 1000, CutWeight::uniform, CutSearch::threshold}};
  o.keep_bits = true;
  o.beta = beta;
  o.pilots.clusters = 128;
  return CutRelighting<>(scene, tracer, *scene.camera, {Image(8, 4, vec3(1))}, o, Serial());
}

}  // namespace

TEST_CASE("pilots are receivers of every cluster, each once") {
  const auto receivers = random_receivers(5000, 1);
  const PilotReceivers pilots = choose_pilots(receivers, {64, 8, 0, {}});
  REQUIRE(pilots.ends.size() == 64);
  for (std::size_t c = 0; c < 64; ++c) CHECK(pilots.ends[c] == 8 * (c + 1));
  const std::set<std::uint32_t> each(pilots.receivers.begin(), pilots.receivers.end());
  CHECK(each.size() == 64 * 8);
  CHECK(*each.rbegin() < 5000);
}

TEST_CASE("few receivers are all pilots, in as many clusters as they fill") {
  for (const std::uint32_t count : {1u, 2u, 3u, 20u, 100u}) {
    const auto receivers = random_receivers(count, 2);
    const PilotReceivers pilots = choose_pilots(receivers, {64, 8, 0, {}});
    CHECK(pilots.receivers.size() == count);
    CHECK(std::set(pilots.receivers.begin(), pilots.receivers.end()).size() == count);
    CHECK(pilots.ends.size() <= 64);
    CHECK(pilots.ends.back() == count);
    CHECK(std::ranges::adjacent_find(pilots.ends, std::greater_equal()) == pilots.ends.end());
  }
  CHECK(choose_pilots({}, {}).receivers.empty());
}

TEST_CASE("the entries of a light's vector are the shares of each cluster that see it") {
  for (const std::uint32_t count : {100u, 256u}) {
    const Lights lights(count);
    const auto receivers = random_receivers(300, 3);
    const auto pilot = trace_pilots(three_spheres, lights.packets, receivers, few, Backwards{5});
    const LightVisibility vectors = light_visibility(pilot, lights.tree, Backwards{1});
    REQUIRE(vectors.length == 16);
    REQUIRE(vectors.size() == count);
    bool all_right = true, some_partly = false;
    for (std::uint32_t l = 0; l < count; ++l)
      for (std::size_t c = 0; c < 16; ++c) {
        int seen = 0;
        for (std::size_t i = 4 * c; i < 4 * c + 4; ++i) {
          const Receiver& r = receivers[pilot.pilots.receivers[i]];
          const vec3 d = lights.directions[l];
          seen += dot(r.normal, d) > r.horizon && !three_spheres.occluded(r.position, d, 1e30f);
        }
        all_right = all_right && vectors.of(l)[c] == float(seen) / 4;
        some_partly = some_partly || (seen > 0 && seen < 4);
      }
    CHECK(all_right);
    CHECK(some_partly);
  }
}

TEST_CASE("rows in the order of another tree say the same about every light, and back again") {
  const Lights lights(100);
  Random random(4);
  const std::vector<std::uint32_t> named{7, 2, 9};
  VisibilityRows rows(lights.tree.leaf_count(), named);
  for (std::size_t i = 0; i < 3; ++i)
    std::ranges::copy(bits_of(lights.tree, random_visibility(lights, random, 0.3f)), rows[i].begin());
  const VisibilityRows before = rows;
  const LightTree other = build_tree(GeometricMetric(samples_of(lights)), {0});
  REQUIRE(other.light_of_leaf != lights.tree.light_of_leaf);
  reorder(rows, lights.tree, other, Backwards{2});
  for (std::size_t i = 0; i < 3; ++i)
    CHECK(seen_lights(other, rows[i]) == seen_lights(lights.tree, before[i]));
  CHECK_FALSE(std::ranges::equal(rows[0], before[0]));
  reorder(rows, other, lights.tree, Serial());
  for (std::size_t i = 0; i < 3; ++i) CHECK(std::ranges::equal(rows[i], before[i]));
}

TEST_CASE("rows are found by receiver, and only those that were named") {
  const std::vector<std::uint32_t> named{7, 2, 9};
  VisibilityRows rows(100, named);
  rows[1][0] = 5;
  CHECK(rows.size() == 3);
  CHECK(rows.find(2).size() == 2);
  CHECK(rows.find(2)[0] == 5);
  CHECK(rows.find(7)[0] == 0);
  for (const std::size_t other : {0u, 8u, 10u, 1000u}) CHECK(rows.find(other).empty());
  CHECK(VisibilityRows().find(0).empty());
}

TEST_CASE("what the pilots saw is not traced again, and the cuts are as if it had been") {
  const Lights lights(200);
  const auto receivers = random_receivers(visibility_block + 300, 5);
  auto pilot = trace_pilots(three_spheres, lights.packets, receivers, few, TwoThreads());
  const LightTree tree =
      build_data_driven_tree(samples_of(lights), lights.tree, pilot, 0.5f, few, TwoThreads());
  CHECK(tree.light_of_leaf != lights.tree.light_of_leaf);
  const DirectionPackets packets(leaf_directions(tree, lights.directions));
  const std::vector<VisibilityCutOptions> options{{1}, {1, 20, CutWeight::uniform, CutSearch::threshold}};
  const auto all =
      precompute_visibility<std::uint8_t>(three_spheres, tree, packets, receivers, options, true, Serial());
  const auto rest = precompute_visibility<std::uint8_t>(three_spheres, tree, packets, receivers, options,
                                                        true, TwoThreads(), {}, pilot.rows);
  CHECK(rest.bits == all.bits);
  for (std::size_t o = 0; o < options.size(); ++o) {
    CHECK(std::ranges::equal(rest.cuts[o].masks(), all.cuts[o].masks()));
    CHECK(std::ranges::equal(rest.cuts[o].values(), all.cuts[o].values()));
  }
  CHECK(pilot.rays > 0);
  CHECK(rest.rays + pilot.rays == all.rays);
}

TEST_CASE("without receivers, and without lights, the data-driven tree is the geometric one") {
  const Lights lights(60);
  auto nobody = trace_pilots(three_spheres, lights.packets, {}, few, Serial());
  CHECK(build_data_driven_tree(samples_of(lights), lights.tree, nobody, 0.5f, few, Serial()).light_of_leaf ==
        lights.tree.light_of_leaf);
  auto darkness = trace_pilots(three_spheres, DirectionPackets({}), random_receivers(20, 6), few, Serial());
  CHECK(build_data_driven_tree({}, LightTree(), darkness, 0.5f, few, Serial()).empty());
}

TEST_CASE("the data-driven tree does not depend on who builds it, projected or not") {
  const Lights lights(500);
  const auto receivers = random_receivers(400, 7);
  for (const std::uint32_t length : {0u, 5u, 16u, 99u}) {
    PilotOptions options = few;
    options.length = length;
    const auto build = [&](const auto& executor) {
      auto pilot = trace_pilots(three_spheres, lights.packets, receivers, options, executor);
      return build_data_driven_tree(samples_of(lights), lights.tree, pilot, 0.4f, options, executor)
          .light_of_leaf;
    };
    const auto serial = build(Serial());
    CHECK(build(TwoThreads()) == serial);
    CHECK(build(Backwards{11}) == serial);
  }
}

TEST_CASE("pilots know lights at places too") {
  Random random(8);
  std::vector<LocalLight> points;
  for (int i = 0; i < 300; ++i) points.push_back(point_light(3.0f * random.direction(), vec3(1)));
  const LightTree tree = build_local_tree(points);
  const auto receivers = random_receivers(200, 9);
  auto pilot =
      trace_pilots(three_spheres, LocalLightPackets(leaf_lights(tree, points)), receivers, few, Serial());
  const LightTree driven = build_data_driven_tree(metric_samples(points), tree, pilot, 0.5f, few, Serial());
  const LocalLightPackets packets(leaf_lights(driven, points));
  std::vector<std::uint64_t> bits(words_for_bits(driven.leaf_count()));
  for (std::size_t i = 0; i < pilot.rows.size(); ++i) {
    trace_visibility(three_spheres, packets, receivers[pilot.pilots.receivers[i]], bits);
    CHECK(std::ranges::equal(bits, pilot.rows[i]));
  }
}

TEST_CASE(
    "relighting by a data-driven tree has smaller cuts, the same rays, and the same sum of all lights") {
  const Scene scene = ball_and_box();
  const TriangleTracer tracer(scene.mesh);
  CutRelighting<> geometric = relighting_with(scene, tracer, 1), mixed = relighting_with(scene, tracer, 0.5f);
  CHECK(geometric.report().pilot_rays == 0);
  CHECK(mixed.report().pilot_rays > 0);
  CHECK(mixed.report().pilot_receivers > 128);
  CHECK(mixed.report().rays == geometric.report().rays);
  REQUIRE(mixed.receivers().size() == geometric.receivers().size());
  const auto pieces = [](const CutRelighting<>& r) {
    std::size_t sum = 0;
    for (std::size_t i = 0; i < r.cuts().size(); ++i) sum += r.cuts().piece_count(i);
    return double(sum);
  };
  CHECK(pieces(mixed) < 0.97 * pieces(geometric));
  const Environment sky{Image(8, 4, vec3(1))};
  const auto all_lights = [&](CutRelighting<>& r) {
    return r.image(r.shade_by_brute_force<Skip::nothing>(r.light(sky, 1), Serial()));
  };
  const auto through_cuts = [&](CutRelighting<>& r) { return r.image(r.shade(r.light(sky, 256), Serial())); };
  const Image reference = all_lights(geometric);
  const std::vector<bool> counts(reference.pixels.size(), true);
  CHECK(image_errors(all_lights(mixed), reference, counts).rel_rmse < 1e-5);
  CHECK(image_errors(through_cuts(mixed), reference, counts).rel_rmse < 0.03);
}
