// One frame's light up the tree: exact sums and sane directions on the hardest lighting, and the illumination
// cut.
#include <doctest/doctest.h>

#include <bit>
#include <coppice/light/directions.hpp>
#include <coppice/relight/frame_lighting.hpp>
#include <coppice/tree/build.hpp>
#include <vector>

#include "support/generators.hpp"

using namespace coppice;
using namespace test_support;

namespace {

using glm::dvec3;

struct Sky {
  std::vector<vec3> directions;
  std::vector<CellLight> lights;
  LightTree tree;
};

/// A black sky of even directions, each with its share of the sphere.
Sky black_sky(std::uint32_t count) {
  Sky sky{even_directions(count), {}, {}};
  sky.lights.assign(count, {vec3(0), count > 0 ? 4 * pi / float(count) : 0});
  std::vector<LightSample> samples;
  for (const vec3& d : sky.directions) samples.push_back({d, vec3(0)});
  sky.tree = build_tree(GeometricMetric(samples));
  return sky;
}

/// Radiance over 24 orders of magnitude, a tenth of the sky black.
Sky hard_sky(std::uint32_t count) {
  Sky sky = black_sky(count);
  Random random(1);
  for (auto& light : sky.lights)
    for (int c = 0; random.uniform() < 0.9f && c < 3; ++c)
      light.power[c] = std::pow(10.0f, 24 * random.uniform() - 12);
  return sky;
}

FrameLighting lit(const Sky& sky, std::size_t max_nodes = 64, std::uint32_t granule_log2 = 0) {
  return light_frame(sky.tree, sky.lights, sky.directions, max_nodes, granule_log2);
}

/// A node's sums by visiting all its lights in long double.
struct Exact {
  long double power[3] = {0, 0, 0}, direction[3] = {0, 0, 0}, luminance = 0, solid_angle = 0;

  void add(const CellLight& light, const vec3& direction_of_light) {
    const dvec3 d = glm::normalize(dvec3(direction_of_light));
    const long double lum = 0.2126L * light.power.x + 0.7152L * light.power.y + 0.0722L * light.power.z;
    luminance += lum;
    solid_angle += light.solid_angle;
    for (int c = 0; c < 3; ++c) power[c] += light.power[c], direction[c] += lum * d[c];
  }
  long double mean_length() const {
    return std::sqrt(direction[0] * direction[0] + direction[1] * direction[1] +
                     direction[2] * direction[2]) /
           luminance;
  }
};

Exact exact_sums(const Sky& sky, std::uint32_t h) {
  Exact sum;
  const LeafRange r = leaves_below(sky.tree.leaf_count(), h);
  for (std::uint32_t leaf = r.begin; leaf < r.end; ++leaf)
    if (const std::uint32_t l = sky.tree.light_of_leaf[leaf]; l != no_light)
      sum.add(sky.lights[l], sky.directions[l]);
  return sum;
}

void check_against_exact(const LightNode& node, const Exact& exact) {
  for (int c = 0; c < 3; ++c) CHECK(close(node.power[c], exact.power[c], 2e-7));
  CHECK(close(node.solid_angle, exact.solid_angle, 2e-7));
  if (exact.luminance == 0 || exact.mean_length() < 1e-3L) return;
  CHECK(std::abs(node.spread - (1 - exact.mean_length())) < 2e-7L);
  for (int c = 0; c < 3; ++c)
    CHECK(std::abs(node.direction[c] - exact.direction[c] / exact.luminance / exact.mean_length()) < 3e-7L);
}

bool is_sane(const LightNode& node) {
  return is_finite(node.power) && std::abs(length(node.direction) - 1) < 3e-7f && node.spread >= 0 &&
         node.spread <= 1 && node.solid_angle >= 0;
}

void check_sane(const FrameLighting& frame, const Sky& sky) {
  REQUIRE(frame.nodes.size() == 2 * std::size_t(sky.tree.leaf_count()));
  CHECK(std::ranges::all_of(frame.nodes, is_sane));
  CHECK(is_cut(sky.tree.leaf_count(), frame.ends));
}

std::vector<std::uint32_t> ends_of_mask(const std::vector<std::uint32_t>& mask, std::uint32_t granule_log2) {
  std::vector<std::uint32_t> ends;
  for (std::uint32_t bit = 0; bit < 32 * mask.size(); ++bit)
    if (mask[bit / 32] >> (bit % 32) & 1) ends.push_back((bit + 1) << granule_log2);
  return ends;
}

}  // namespace

TEST_CASE("nodes hold the sums of their lights to float rounding, over 24 orders of magnitude") {
  for (const std::uint32_t count : {1u, 2u, 3u, 100u, 1000u, 4096u}) {
    CAPTURE(count);
    const Sky sky = hard_sky(count);
    const FrameLighting frame = lit(sky);
    check_sane(frame, sky);
    for (std::uint32_t h = 1; h < 2 * sky.tree.leaf_count(); h += 1 + h / 8)
      check_against_exact(frame.nodes[h], exact_sums(sky, h));
  }
}

TEST_CASE("32,768 lights of radiance up to 1e30 or denormal are summed without NaN") {
  for (const float power : {1e30f, 1e-30f, 1e-38f, 1e-44f}) {
    CAPTURE(power);
    Sky sky = black_sky(32768);
    for (auto& light : sky.lights) light.power = vec3(power);
    const FrameLighting frame = lit(sky, 256);
    check_sane(frame, sky);
    CHECK(frame.ends.size() == 256);
    CHECK(close(frame.nodes[1].power.y, 32768 * static_cast<long double>(power), 1e-6));
    CHECK(frame.nodes[1].spread > 0.999f);
  }
}

TEST_CASE("one light of 1e30 among denormal ones gives every node above it its own direction") {
  Sky sky = black_sky(1024);
  for (auto& light : sky.lights) light.power = vec3(1e-44f);
  const std::uint32_t leaf = 300, sun = sky.tree.light_of_leaf[leaf];
  sky.lights[sun].power = vec3(1e30f);
  const FrameLighting frame = lit(sky);
  check_sane(frame, sky);
  for (std::uint32_t h = 1024 + leaf; h >= 1; h /= 2) {
    CHECK(length(frame.nodes[h].direction - sky.directions[sun]) < 3e-7f);
    CHECK(frame.nodes[h].spread < 2e-7f);
    CHECK(frame.nodes[h].power == vec3(1e30f));
  }
}

TEST_CASE("one-hot lighting: the cut follows the light down to its leaf and then stops") {
  Sky sky = black_sky(1000);
  const std::uint32_t leaf = 517;
  REQUIRE(sky.tree.light_of_leaf[leaf] != no_light);
  sky.lights[sky.tree.light_of_leaf[leaf]].power = vec3(0, 0, 2);
  const FrameLighting frame = lit(sky);
  check_sane(frame, sky);
  CHECK(frame.ends.size() == 11);  // ten levels of siblings, and the leaf
  CHECK(std::ranges::count(frame.ends, leaf) == 1);
  CHECK(std::ranges::count(frame.ends, leaf + 1) == 1);
  CHECK(lit(sky, 5).ends.size() == 5);
}

TEST_CASE("black lighting: one piece, directions still those of the cells") {
  const Sky sky = black_sky(1000);
  const FrameLighting frame = lit(sky);
  check_sane(frame, sky);
  CHECK(frame.ends == std::vector<std::uint32_t>{1024});
  for (std::uint32_t leaf = 0; leaf < 1024; ++leaf) {
    const LightNode& node = frame.nodes[1024 + leaf];
    CHECK(node.power == vec3(0));
    if (const std::uint32_t l = sky.tree.light_of_leaf[leaf]; l != no_light)
      CHECK(length(node.direction - sky.directions[l]) < 3e-7f);
  }
}

TEST_CASE("lights that point opposite ways leave a unit direction and the spread 1") {
  Sky sky = black_sky(2);
  sky.directions = {{1, 0, 0}, {-1, 0, 0}};
  for (const float power : {0.0f, 1.0f, 1e30f}) {
    for (auto& light : sky.lights) light.power = vec3(power);
    const FrameLighting frame = lit(sky);
    check_sane(frame, sky);
    CHECK(frame.nodes[1].spread == 1);
  }
}

TEST_CASE("lights in the same place have no spread") {
  Sky sky = black_sky(1000);
  for (auto& d : sky.directions) d = normalize(vec3(1, 2, 3));
  for (auto& light : sky.lights) light.power = vec3(3);
  const FrameLighting frame = lit(sky);
  check_sane(frame, sky);
  CHECK(frame.nodes[1].spread < 2e-7f);
  CHECK(length(frame.nodes[1].direction - sky.directions[0]) < 3e-7f);
}

TEST_CASE("no lights, and one light") {
  const Sky none = black_sky(0);
  const FrameLighting empty = lit(none);
  CHECK(empty.nodes.empty());
  CHECK(empty.ends.empty());
  CHECK(empty.mask.empty());
  Sky one = black_sky(1);
  one.lights[0].power = vec3(1, 2, 3);
  const FrameLighting frame = lit(one);
  check_sane(frame, one);
  CHECK(frame.ends == std::vector<std::uint32_t>{1});
  CHECK(frame.nodes[1].power == vec3(1, 2, 3));
}

TEST_CASE("the cut splits the node of greatest luminance first, and has as many nodes as it may") {
  const Sky sky = hard_sky(1024);
  const FrameLighting frame = lit(sky, 100);
  CHECK(frame.ends.size() == 100);
  std::vector<double> luminances(2048);
  for (std::uint32_t h = 1; h < 2048; ++h) luminances[h] = double(exact_sums(sky, h).luminance);
  // What was split is brighter than what is left: no inner piece beats the least parent of a piece.
  double brightest_left = 0, faintest_split = 1e300;
  for_each_piece(frame.ends, [&](LeafRange r, std::size_t) {
    const std::uint32_t h = node_of_range(1024, r.begin, r.end);
    if (h < 1024) brightest_left = std::max(brightest_left, luminances[h]);
    faintest_split = std::min(faintest_split, luminances[h / 2]);
  });
  CHECK(brightest_left <= faintest_split);
}

TEST_CASE("the masks are the cut's ends, those of the granules leave out what falls inside one") {
  for (const std::uint32_t granule_log2 : {0u, 3u, 5u}) {
    const Sky sky = hard_sky(1000);
    const FrameLighting frame = lit(sky, 300, granule_log2);
    CHECK(frame.mask.size() == 32);
    CHECK(frame.granule_mask.size() == 32u >> granule_log2);
    CHECK(ends_of_mask(frame.mask, 0) == frame.ends);
    std::vector<std::uint32_t> on_granules;
    for (const std::uint32_t end : frame.ends)
      if (end % (1u << granule_log2) == 0) on_granules.push_back(end);
    CHECK(ends_of_mask(frame.granule_mask, granule_log2) == on_granules);
  }
}

TEST_CASE("the parts of granules are listed by granule, each node of the cut below one once") {
  const Sky sky = hard_sky(1000);
  for (const std::uint32_t granule_log2 : {0u, 1u, 3u, 5u}) {
    CAPTURE(granule_log2);
    const FrameLighting frame = lit(sky, 300, granule_log2);
    std::vector<std::uint32_t> fine;
    for_each_piece(frame.ends, [&](LeafRange r, std::size_t) {
      if (r.size() < 1u << granule_log2) fine.push_back(node_of_range(1024, r.begin, r.end));
    });
    CHECK(frame.fine_nodes == fine);
    CHECK(fine.empty() == (granule_log2 == 0));
    std::uint32_t at = 0;
    for (const FineGranule& g : frame.fine_granules) {
      REQUIRE(g.first == at);
      for (std::uint32_t k = 0; k < g.count; ++k)
        CHECK((leaves_below(1024, fine[at++]).begin >> granule_log2) == g.granule);
    }
    CHECK(at == fine.size());
    CHECK(std::ranges::adjacent_find(frame.fine_granules, {}, &FineGranule::granule) ==
          frame.fine_granules.end());
  }
}

TEST_CASE("setting another illumination cut leaves nothing of the last one") {
  const Sky sky = hard_sky(1000);
  FrameLighting frame = lit(sky, 700, 3);
  REQUIRE_FALSE(frame.fine_nodes.empty());
  const FrameLighting other = lit(sky, 90, 2);
  set_illumination_cut(frame, 1024, other.ends, 2);
  CHECK(frame.ends == other.ends);
  CHECK(frame.mask == other.mask);
  CHECK(frame.granule_mask == other.granule_mask);
  CHECK(frame.fine_nodes == other.fine_nodes);
  CHECK(frame.fine_granules.size() == other.fine_granules.size());
}

TEST_CASE("a leaf has no spread at all, whatever rounding says: nothing tries to split it") {
  const Sky sky = hard_sky(1000);
  const FrameLighting frame = lit(sky);
  for (std::uint32_t leaf = 0; leaf < 1024; ++leaf) CHECK(frame.nodes[1024 + leaf].spread == 0);
  CHECK(std::ranges::count(frame.nodes, 0.0f, &LightNode::spread) < 1024 + 200);
}

TEST_CASE("the root's power is the environment's energy, whatever the number of lights") {
  Random random(2);
  const Environment environment{random_map(random, 64, 32), 0.3f};
  double first = 0;
  for (const std::uint32_t count : {1u, 10u, 1000u, 5000u}) {
    Sky sky = black_sky(count);
    sky.lights = EnvironmentCells(sky.directions, 64, 32).gather(environment);
    const double total = double(luminance(lit(sky).nodes[1].power));
    if (first == 0) first = total;
    CHECK(close(total, first, 1e-6));
  }
}
