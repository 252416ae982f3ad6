// Cuts carried from a turned frame to the world against visibility traced in the world.
#include <doctest/doctest.h>

#include <coppice/light/environment_cells.hpp>
#include <coppice/reference/merge_per_leaf.hpp>
#include <coppice/relight/turned_cuts.hpp>
#include <coppice/relight/visibility_cuts.hpp>
#include <support/executors.hpp>
#include <support/occluders.hpp>

#include "relight/lights.hpp"

using namespace coppice;
using relight_test::Lights;

namespace {

using Store = MaskedCuts<std::uint8_t>;

/// The nearest lights, one after the other.
LeafTurn exact_turn(const Lights& lights, const glm::quat& frame_from_world) {
  const auto directions = leaf_directions(lights.tree, lights.directions);
  return turn_leaves(directions, frame_from_world, [&](const vec3& d) {
    const auto nearest = std::ranges::max_element(directions, {}, [&](const vec3& l) { return dot(l, d); });
    return std::uint32_t(nearest - directions.begin());
  });
}

Store visibility_of(const support::SphereOccluder& balls, const Lights& lights, double sigma,
                    std::size_t count = 6) {
  std::vector<Receiver> receivers(count);
  for (std::size_t i = 0; i < count; ++i) {
    receivers[i].position = vec3(0.1f * float(i), 0, 0);
    receivers[i].normal = vec3(0, 1, 0), receivers[i].horizon = -1;
  }
  const VisibilityCutOptions options{sigma, unlimited, CutWeight::uniform};
  return std::move(precompute_visibility<std::uint8_t>(balls, lights.tree, lights.packets, receivers,
                                                       std::span(&options, 1), false, Serial())
                       .cuts[0]);
}

std::vector<double> values_of(const Store& cuts, std::size_t i) {
  const auto cut = cuts.unpack(i);
  return reference::expand(CutView<std::uint8_t>(cut));
}

double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

template <class E = Serial>
Store turned(const Lights& lights, const Store& cuts, const glm::quat& world_from_frame, double sigma,
             const E& executor = {}) {
  const std::vector<std::uint8_t> all(cuts.size(), 1);
  return turn_cuts(lights.tree, cuts, exact_turn(lights, glm::conjugate(world_from_frame)), all, sigma,
                   world_from_frame, executor);
}

const support::SphereOccluder two_balls{{{vec3(0, 2, 0), 1}, {vec3(3, -1, 1), 1.5f}}};

}  // namespace

TEST_CASE("without a turn a fine cut says the same of every leaf, and horizons stay") {
  for (const std::uint32_t count : {64u, 597u, 1024u}) {
    const Lights lights(count);
    const Store cuts = visibility_of(two_balls, lights, 0.01);
    const Store same = turned(lights, cuts, glm::quat(1, 0, 0, 0), 0.01);
    for (std::size_t i = 0; i < cuts.size(); ++i) {
      const auto before = values_of(cuts, i), after = values_of(same, i);
      for (std::uint32_t leaf = 0; leaf < before.size(); ++leaf)
        if (lights.tree.light_of_leaf[leaf] != no_light) CHECK(after[leaf] == before[leaf]);
    }
  }
}

TEST_CASE("a turned cut agrees with tracing the turned occluder, to a cell's width along its edge") {
  Random random(1);
  const Lights lights(2048);
  for (int i = 0; i < 4; ++i) {
    const glm::quat turn = glm::angleAxis(2 * pi * random.uniform(), random.direction());
    support::SphereOccluder in_world = two_balls;
    for (auto& ball : in_world.spheres) ball.centre = turn * ball.centre;
    for (const double sigma : {0.01, 1.0}) {
      const Store made = turned(lights, visibility_of(two_balls, lights, sigma, 1), turn, sigma);
      const Store traced = visibility_of(in_world, lights, sigma, 1);
      const auto a = values_of(made, 0), b = values_of(traced, 0);
      double difference = 0;
      for (std::size_t leaf = 0; leaf < a.size(); ++leaf) difference += std::abs(a[leaf] - b[leaf]);
      difference /= 255 * double(a.size());
      CAPTURE(sigma);
      CHECK(difference < (sigma < 1 ? 0.03 : 0.05));
      CHECK(std::abs(sum(a) - sum(b)) < 0.01 * 255 * double(a.size()));
    }
  }
}

TEST_CASE("coarser cuts keep the mean of what they are made of") {
  Random random(2);
  const Lights lights(1000);
  const glm::quat turn = glm::angleAxis(1.0f, random.direction());
  const Store cuts = visibility_of(two_balls, lights, 0.01);
  const Store fine = turned(lights, cuts, turn, 0.01), coarse = turned(lights, cuts, turn, 3);
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    CHECK(coarse.piece_count(i) < fine.piece_count(i));
    double fine_sum = 0, coarse_sum = 0;
    const auto f = values_of(fine, i), c = values_of(coarse, i);
    for (std::uint32_t leaf = 0; leaf < f.size(); ++leaf)
      if (lights.tree.light_of_leaf[leaf] != no_light) fine_sum += f[leaf], coarse_sum += c[leaf];
    CHECK(std::abs(fine_sum - coarse_sum) <= 0.5 * 1000);
  }
}

TEST_CASE("only wanted cuts are turned; those of one piece and horizons' cosines stay as they are") {
  const Lights lights(256);
  Store cuts = visibility_of(two_balls, lights, 1, 3);
  cuts.append(Cut<std::uint8_t>{{256}, {77}}, {vec3(0, 1, 0), -0.3f});
  const glm::quat turn = glm::angleAxis(pi / 2, vec3(0, 0, 1));
  const Store made = turn_cuts(lights.tree, cuts, exact_turn(lights, glm::conjugate(turn)),
                               std::vector<std::uint8_t>{0, 1, 0, 1}, 1, turn, Serial());
  for (const std::size_t i : {0u, 2u, 3u}) {
    CHECK(made.unpack(i).ends == cuts.unpack(i).ends);
    CHECK(made.unpack(i).values == cuts.unpack(i).values);
  }
  CHECK(made.unpack(1).ends != cuts.unpack(1).ends);
  CHECK(length(made[3].horizon.normal - vec3(-1, 0, 0)) < 1e-6f);
  CHECK(made[3].horizon.cosine == -0.3f);
}

TEST_CASE("padding stays where it is, and every light comes from a light") {
  const Lights lights(597);
  const auto turn = exact_turn(lights, glm::angleAxis(2.0f, normalize(vec3(1, 2, 3))));
  REQUIRE(turn.size() == 1024);
  for (std::uint32_t leaf = 0; leaf < 1024; ++leaf)
    if (lights.tree.light_of_leaf[leaf] == no_light)
      CHECK(turn[leaf] == leaf);
    else
      CHECK(lights.tree.light_of_leaf[turn[leaf]] != no_light);
}

TEST_CASE("turning does not depend on the executor") {
  const Lights lights(512);
  const Store cuts = visibility_of(two_balls, lights, 1, 200);
  const glm::quat turn = glm::angleAxis(0.7f, normalize(vec3(3, 1, 2)));
  const Store one = turned(lights, cuts, turn, 1);
  for (const Store& other : {turned(lights, cuts, turn, 1, support::Backwards()),
                             turned(lights, cuts, turn, 1, support::TwoThreads())}) {
    CHECK(std::ranges::equal(one.masks(), other.masks()));
    CHECK(std::ranges::equal(one.values(), other.values()));
  }
}
