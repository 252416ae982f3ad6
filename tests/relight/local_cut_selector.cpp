// Cuts of V·G against the values light by light.
#include <doctest/doctest.h>

#include <coppice/reference/local.hpp>
#include <coppice/relight/local_cut_selector.hpp>
#include <coppice/relight/local_relighting.hpp>
#include <support/executors.hpp>
#include <support/local_lights.hpp>
#include <support/occluders.hpp>

#include "relight/lights.hpp"

using namespace coppice;

namespace {

constexpr VisibilityCutOptions fine{1e-9, unlimited, CutWeight::uniform, CutSearch::threshold};

/// Lights with their tree, and a random half of them visible.
struct Room {
  std::vector<LocalLight> lights;
  LightTree tree;
  LocalLightPackets packets;
  std::vector<std::uint64_t> bits;

  Room(std::vector<LocalLight> l, Random& random)
      : lights(std::move(l)),
        tree(build_local_tree(lights)),
        packets(leaf_lights(tree, lights)),
        bits(words_for_bits(tree.leaf_count()), 0) {
    for (std::uint32_t i = 0; i < tree.leaf_count(); ++i)
      if (tree.light_of_leaf[i] != no_light && random.below(2)) bits[i / 64] |= std::uint64_t{1} << (i % 64);
  }

  std::vector<double> values_at(const vec3& point) const {
    std::vector<double> values;
    for (std::uint32_t i = 0; i < tree.leaf_count(); ++i)
      values.push_back(bit_at(bits.data(), i) ? double(packets.geometry(i, point)) : 0.0);
    return values;
  }
};

Receiver receiver_at(const vec3& position) {
  Receiver r;
  r.position = position, r.normal = vec3(0, 1, 0), r.horizon = -1;
  return r;
}

double value_of(const LocalCut& local, double q) { return double(local.scale) * q * q; }

/// Of values that are rounded to half a level of their square roots; both in units of the greatest.
double rounding_of(double value) {
  const double half = 0.501 / 65535;
  return value >= 0 ? half * (2 * std::sqrt(value) + half) : 0;  // 0/0: nothing is seen
}

double sum_of(const LocalCut& local, const LightTree& tree) {
  double sum = 0;
  for_each_piece(local.cut.ends, [&](LeafRange r, std::size_t i) {
    const double count = tree.light_count[node_of_range(tree.leaf_count(), r.begin, r.end)];
    sum += count * value_of(local, local.cut.values[i]);
  });
  return sum;
}

}  // namespace

TEST_CASE("with a threshold near zero the cut holds V·G of every light to half a level of its root") {
  Random random(1);
  for (const std::uint32_t count : {1u, 2u, 3u, 100u, 1000u}) {
    const Room room(support::random_local_lights(random, count), random);
    LocalCutSelector selector(room.tree, room.packets, fine);
    CHECK(selector.granule_log2() == 0);
    const Receiver r = receiver_at(2.0f * support::in_box(random));
    const LocalCut local = selector.select(room.bits, r);
    REQUIRE(is_cut(room.tree.leaf_count(), local.cut.ends));
    const auto stored = reference::expand(CutView<std::uint16_t>(local.cut));
    const auto expected = room.values_at(r.position);
    const double greatest = *std::ranges::max_element(expected);
    CHECK(value_of(local, 65535) == doctest::Approx(greatest));
    for (std::size_t leaf = 0; leaf < stored.size(); ++leaf)
      if (room.tree.light_of_leaf[leaf] != no_light)
        CHECK(std::abs(value_of(local, stored[leaf]) - expected[leaf]) <=
              greatest * rounding_of(expected[leaf] / greatest) + 1e-6 * expected[leaf]);
  }
}

TEST_CASE("any cut keeps the sum of V·G to rounding, padding counting for nothing") {
  Random random(2);
  for (const std::uint32_t count : {5u, 597u, 5000u})
    for (const double sigma : {0.1, 1.0, 3.0})
      for (const CutSearch search : {CutSearch::threshold, CutSearch::optimal}) {
        const Room room(support::random_local_lights(random, count), random);
        LocalCutSelector selector(room.tree, room.packets, {sigma, unlimited, CutWeight::uniform, search});
        const Receiver r = receiver_at(2.0f * support::in_box(random));
        const LocalCut local = selector.select(room.bits, r);
        REQUIRE(is_cut(room.tree.leaf_count(), local.cut.ends));
        const auto expected = room.values_at(r.position);
        const double sum = std::accumulate(expected.begin(), expected.end(), 0.0);
        CHECK(std::abs(sum_of(local, room.tree) - sum) <= value_of(local, 65535) * rounding_of(1) * count);
      }
}

TEST_CASE("a larger threshold makes coarser cuts, and a budget is kept") {
  Random random(3);
  const Room room(support::random_local_lights(random, 1000), random);
  const auto size = [&](double sigma, std::size_t max_size, CutSearch search) {
    LocalCutSelector selector(room.tree, room.packets, {sigma, max_size, CutWeight::uniform, search});
    return selector.select(room.bits, receiver_at(vec3(0, -2, 0))).cut.size();
  };
  for (const CutSearch search : {CutSearch::threshold, CutSearch::optimal}) {
    CHECK(size(0.5, unlimited, search) > size(1, unlimited, search));
    CHECK(size(1, unlimited, search) > size(4, unlimited, search));
    CHECK(size(0.5, 20, search) <= 20);
  }
}

TEST_CASE("ends do not depend on the unit of length, values do by its square") {
  Random random(4);
  const auto lights = support::random_local_lights(random, 597);
  auto larger = lights;
  for (auto& l : larger) l.position *= 8.0f, l.area *= 64.0f;
  Random same(5), again(5);
  const Room room(lights, same), large(larger, again);
  REQUIRE(room.tree.light_of_leaf == large.tree.light_of_leaf);
  for (const CutSearch search : {CutSearch::threshold, CutSearch::optimal}) {
    const VisibilityCutOptions options{1, unlimited, CutWeight::uniform, search};
    LocalCutSelector selector(room.tree, room.packets, options);
    LocalCutSelector in_large(large.tree, large.packets, options);
    const LocalCut a = selector.select(room.bits, receiver_at(vec3(0.1f, -2, 0.3f)));
    const LocalCut b = in_large.select(large.bits, receiver_at(8.0f * vec3(0.1f, -2, 0.3f)));
    CHECK(a.cut.ends == b.cut.ends);
    CHECK(a.cut.values == b.cut.values);
    CHECK(a.scale == 64 * b.scale);
  }
}

TEST_CASE("where nothing is visible the cut is one piece of 0; without lights there is none") {
  Random random(6);
  Room room(support::random_local_lights(random, 100), random);
  std::ranges::fill(room.bits, std::uint64_t{0});
  for (const CutSearch search : {CutSearch::threshold, CutSearch::optimal}) {
    LocalCutSelector selector(room.tree, room.packets, {1, unlimited, CutWeight::uniform, search});
    const LocalCut local = selector.select(room.bits, receiver_at(vec3(0)));
    CHECK(local.cut.ends == std::vector<std::uint32_t>{128});
    CHECK(local.cut.values == std::vector<std::uint16_t>{0});
    CHECK(local.scale == 0);
  }
  const Room empty({}, random);
  const LocalCut none = LocalCutSelector(empty.tree, empty.packets, {}).select({}, receiver_at(vec3(0)));
  CHECK(none.cut.size() == 0);
  CHECK(none.scale == 0);
}

TEST_CASE("lights very near and very far give finite cuts") {
  Random random(7);
  auto lights = support::random_local_lights(random, 64);
  for (auto& l : lights) l.position *= std::pow(10.0f, 16 * random.uniform() - 8);
  const Room room(lights, random);
  LocalCutSelector selector(room.tree, room.packets, {});
  const LocalCut local = selector.select(room.bits, receiver_at(vec3(0)));
  CHECK(is_cut(64, local.cut.ends));
  CHECK(std::isfinite(local.scale));
  CHECK(local.scale > 0);
}

TEST_CASE("a tree of 4,096 lights has no granules; larger ones have, up to 32 leaves") {
  CHECK(local_granule_log2(0) == 0);
  CHECK(local_granule_log2(1) == 0);
  CHECK(local_granule_log2(4096) == 0);
  CHECK(local_granule_log2(8192) == 1);
  CHECK(local_granule_log2(1u << 20) == 5);
}

TEST_CASE("precomputed cuts are those of every receiver's own bits, on any executor") {
  Random random(8);
  const Room room(support::random_local_lights(random, 200), random);
  const support::SphereOccluder balls{{{vec3(0.3f, 0.2f, 0), 0.4f}, {vec3(-0.6f, 0, 0.4f), 0.3f}}};
  auto receivers = relight_test::random_receivers(40, 3);
  const auto on = [&](const auto& executor) {
    return precompute_local_cuts(balls, room.tree, room.packets, receivers, {}, executor);
  };
  const LocalCuts cuts = on(Serial());
  REQUIRE(cuts.cuts.size() == 40);
  LocalCutSelector selector(room.tree, room.packets, {});
  std::vector<std::uint64_t> bits(words_for_bits(room.tree.leaf_count()));
  std::size_t rays = 0;
  for (std::size_t i = 0; i < 40; ++i) {
    rays += trace_visibility(balls, room.packets, receivers[i], bits);
    const LocalCut expected = selector.select(bits, receivers[i]);
    CHECK(cuts.cuts.unpack(i).ends == expected.cut.ends);
    CHECK(cuts.cuts.unpack(i).values == expected.cut.values);
    CHECK(cuts.scales[i] == expected.scale);
  }
  CHECK(cuts.rays == rays);
  for (const LocalCuts& other : {on(support::Backwards()), on(support::TwoThreads())}) {
    CHECK(std::ranges::equal(other.cuts.values(), cuts.cuts.values()));
    CHECK(std::ranges::equal(other.cuts.masks(), cuts.cuts.masks()));
    CHECK(other.scales == cuts.scales);
    CHECK(other.rays == cuts.rays);
  }
}
