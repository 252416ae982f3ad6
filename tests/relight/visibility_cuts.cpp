// The precomputation of visibility cuts against its parts.
#include <doctest/doctest.h>

#include <coppice/relight/visibility_cuts.hpp>
#include <support/executors.hpp>
#include <support/occluders.hpp>

#include "relight/lights.hpp"

using namespace coppice;
using namespace relight_test;
using namespace support;

namespace {

const SphereOccluder three_spheres{{{{1, 0, 0}, 0.5f}, {{-1, 0.5f, 0}, 0.8f}, {{0, -1, 1}, 0.6f}}};

bool same_horizon(const ReceiverHorizon& a, const ReceiverHorizon& b) {
  return a.normal == b.normal && a.cosine == b.cosine;
}

void check_same(const VisibilityCuts<std::uint8_t>& a, const VisibilityCuts<std::uint8_t>& b) {
  CHECK(a.bits == b.bits);
  CHECK(a.rays == b.rays);
  REQUIRE(a.cuts.size() == b.cuts.size());
  for (std::size_t o = 0; o < a.cuts.size(); ++o) {
    CHECK(std::ranges::equal(a.cuts[o].masks(), b.cuts[o].masks()));
    CHECK(std::ranges::equal(a.cuts[o].values(), b.cuts[o].values()));
    CHECK(std::ranges::equal(a.cuts[o].first_value(), b.cuts[o].first_value()));
    CHECK(std::ranges::equal(a.cuts[o].horizons(), b.cuts[o].horizons(), same_horizon));
  }
}

}  // namespace

TEST_CASE("the precomputation is the trace and the selection of each receiver, for every set of options") {
  const Lights lights(100);
  const auto receivers = random_receivers(visibility_block + 5, 4);
  const std::vector<VisibilityCutOptions> options{{0.4, 1000},
                                                  {2, 1000, CutWeight::cosine, CutSearch::threshold},
                                                  {0.4, 3, CutWeight::uniform, CutSearch::threshold},
                                                  {1, 1000, CutWeight::uniform, CutSearch::optimal}};
  const auto made = precompute_visibility<std::uint8_t>(three_spheres, lights.tree, lights.packets, receivers,
                                                        options, true, Serial());
  const std::uint32_t words = words_for_bits(lights.tree.leaf_count());
  std::vector<VisibilityCutSelector> selectors;
  for (const auto& o : options) selectors.emplace_back(lights.tree, lights.packets, o);
  REQUIRE(made.bits.size() == receivers.size() * words);
  std::vector<std::uint64_t> bits(words);
  std::size_t rays = 0;
  for (std::size_t i = 0; i < receivers.size(); ++i) {
    rays += trace_visibility(three_spheres, lights.packets, receivers[i], bits);
    REQUIRE(std::ranges::equal(bits, std::span(made.bits).subspan(i * words, words)));
    for (std::size_t o = 0; o < options.size(); ++o) {
      const ReceiverHorizon horizon = horizon_of(receivers[i], options[o].weight);
      const auto expected = selectors[o].select<std::uint8_t>(bits, horizon);
      const auto stored = made.cuts[o].unpack(i);
      REQUIRE(stored.ends == expected.ends);
      REQUIRE(stored.values == expected.values);
      REQUIRE(made.cuts[o][i].horizon.normal == horizon.normal);
      REQUIRE(made.cuts[o][i].horizon.cosine == horizon.cosine);
    }
  }
  CHECK(made.rays == rays);
}

TEST_CASE("the precomputation does not depend on who runs it") {
  const Lights lights(200);
  const auto receivers = random_receivers(2 * visibility_block + 100, 6);
  const std::vector<VisibilityCutOptions> options{
      {}, {1, 20}, {2, 1000, CutWeight::uniform, CutSearch::threshold}};
  const auto run = [&](const auto& executor) {
    return precompute_visibility<std::uint8_t>(three_spheres, lights.tree, lights.packets, receivers, options,
                                               true, executor);
  };
  const auto serial = run(Serial());
  check_same(serial, run(TwoThreads()));
  check_same(serial, run(Backwards{1}));
  check_same(serial, run(Backwards{333}));
}

TEST_CASE("progress grows block by block to the end, without receivers there is none") {
  const Lights lights(8);
  std::vector<std::size_t> told;
  const Progress progress = [&](std::size_t done, std::size_t total) {
    CHECK(total == visibility_block + 1);
    told.push_back(done);
  };
  const auto receivers = random_receivers(visibility_block + 1, 7);
  const std::vector<VisibilityCutOptions> options{{}};
  const auto made = precompute_visibility<std::uint8_t>(three_spheres, lights.tree, lights.packets, receivers,
                                                        options, false, Serial(), progress);
  CHECK(told == std::vector<std::size_t>{visibility_block, visibility_block + 1});
  CHECK(made.bits.empty());
  const auto none = precompute_visibility<std::uint8_t>(three_spheres, lights.tree, lights.packets, {},
                                                        options, true, Serial());
  CHECK(none.cuts[0].size() == 0);
  CHECK(none.rays == 0);
}

TEST_CASE("a buried receiver moves as little as frees it, others stay where they are") {
  const SphereOccluder ball{{{{0, 0, 0}, 1}}};
  const DirectionPackets pilot(even_directions(64));
  Receiver free, slightly, deep, hopeless;
  for (Receiver* r : {&free, &slightly, &deep, &hopeless}) r->normal = {1, 0, 0}, r->horizon = 0;
  free.position = {1.5f, 0, 0}, free.inward = {4, 0, 0};
  slightly.position = {0.8f, 0, 0}, slightly.inward = {1, 0, 0};
  deep.position = {0.3f, 0, 0}, deep.inward = {1, 0, 0};
  hopeless.position = {0, 0, 0}, hopeless.inward = {0.5f, 0, 0};
  std::vector<Receiver> receivers{free, slightly, deep, hopeless};
  free_buried_receivers(ball, pilot, receivers, Backwards{2});
  CHECK(receivers[0].position == free.position);
  CHECK(length(receivers[1].position - vec3(1.05f, 0, 0)) < 1e-6f);
  CHECK(length(receivers[2].position - vec3(1.05f, 0, 0)) < 1e-6f);
  CHECK(receivers[3].position == hopeless.position);
}
