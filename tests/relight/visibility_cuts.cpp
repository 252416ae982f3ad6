// Selection of visibility cuts against moments of the same bits, and the precomputation against its parts.
#include <doctest/doctest.h>

#include <coppice/core/random.hpp>
#include <coppice/light/directions.hpp>
#include <coppice/relight/visibility_cuts.hpp>
#include <coppice/tree/aggregate.hpp>
#include <coppice/tree/build.hpp>
#include <support/executors.hpp>
#include <support/occluders.hpp>

using namespace coppice;
using namespace support;

namespace {

LightTree tree_over(std::span<const vec3> directions) {
  std::vector<LightSample> samples;
  for (const vec3& d : directions) samples.push_back({d, vec3(0)});
  return build_tree(GeometricMetric(samples));
}

struct Lights {
  std::vector<vec3> directions;
  LightTree tree;

  explicit Lights(std::uint32_t count) : directions(even_directions(count, 9)), tree(tree_over(directions)) {}
};

/// Visibility by light: a half space, with some lights flipped at random.
std::vector<float> random_visibility(const Lights& lights, Random& random, float noise) {
  const vec3 axis = random.direction();
  const float level = random.uniform() - 0.5f;
  std::vector<float> values;
  for (const vec3& d : lights.directions)
    values.push_back((dot(d, axis) > level) != (random.uniform() < noise) ? 1.0f : 0.0f);
  return values;
}

std::vector<std::uint64_t> bits_of(const LightTree& tree, std::span<const float> visibility) {
  std::vector<std::uint64_t> bits(words_for_bits(tree.leaf_count()), 0);
  for (std::uint32_t i = 0; i < tree.leaf_count(); ++i)
    if (tree.light_of_leaf[i] != no_light && visibility[tree.light_of_leaf[i]] > 0)
      bits[i / 64] |= std::uint64_t{1} << (i % 64);
  return bits;
}

/// The cut that Eq. 6 asks for, without granules or popcounts.
Cut<std::uint8_t> slow_cut(const LightTree& tree, std::span<const float> visibility, double sigma) {
  const auto moments = aggregate_moments(tree, visibility);
  const std::uint32_t n = tree.leaf_count();
  auto ends = select_by_threshold(
      n, [&](std::uint32_t h) { return moments[h].squared_deviations; }, sigma * sigma);
  return cut_with_values(n, std::move(ends),
                         [&](std::uint32_t h) { return quantise<std::uint8_t>(float(moments[h].mean)); });
}

/// |C|·var of a node, counted leaf by leaf.
double slow_error(const LightTree& tree, std::span<const std::uint64_t> bits, std::uint32_t h) {
  double visible = 0, count = 0;
  const LeafRange leaves = leaves_below(tree.leaf_count(), h);
  for (std::uint32_t i = leaves.begin; i < leaves.end; ++i) {
    visible += bit_at(bits.data(), i);
    count += tree.light_of_leaf[i] != no_light;
  }
  return count == 0 ? 0 : visible * (count - visible) / count;
}

void check_equal(const Cut<std::uint8_t>& cut, const Cut<std::uint8_t>& expected) {
  CHECK(cut.ends == expected.ends);
  REQUIRE(cut.values.size() == expected.values.size());
  for (std::size_t i = 0; i < cut.size(); ++i)
    CHECK(std::abs(int(cut.values[i]) - int(expected.values[i])) <= 1);
}

std::vector<Receiver> random_receivers(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<Receiver> receivers(count);
  for (Receiver& r : receivers) {
    r.position = 2 * random.uniform() * random.direction();
    r.normal = random.direction();
    r.horizon = -0.3f * random.uniform();
  }
  return receivers;
}

const SphereOccluder three_spheres{{{{1, 0, 0}, 0.5f}, {{-1, 0.5f, 0}, 0.8f}, {{0, -1, 1}, 0.6f}}};

void check_same(const VisibilityCuts<std::uint8_t>& a, const VisibilityCuts<std::uint8_t>& b) {
  CHECK(a.bits == b.bits);
  CHECK(a.rays == b.rays);
  REQUIRE(a.cuts.size() == b.cuts.size());
  for (std::size_t o = 0; o < a.cuts.size(); ++o) {
    CHECK(std::ranges::equal(a.cuts[o].masks(), b.cuts[o].masks()));
    CHECK(std::ranges::equal(a.cuts[o].values(), b.cuts[o].values()));
    CHECK(std::ranges::equal(a.cuts[o].first_value(), b.cuts[o].first_value()));
  }
}

}  // namespace

TEST_CASE("selection by popcounts equals selection by moments, for any threshold and any padding") {
  Random random(2);
  for (const std::uint32_t count : {1u, 3u, 64u, 1000u, 1024u}) {
    const Lights lights(count);
    for (const double sigma : {0.3, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 6.0}) {
      VisibilityCutSelector selector(lights.tree, {sigma, unlimited});
      for (const float noise : {0.0f, 0.02f, 0.5f}) {
        const auto visibility = random_visibility(lights, random, noise);
        const auto cut = selector.select<std::uint8_t>(bits_of(lights.tree, visibility));
        CHECK(is_cut(lights.tree.leaf_count(), cut.ends));
        check_equal(cut, slow_cut(lights.tree, visibility, sigma));
      }
    }
  }
}

TEST_CASE("a capped cut splits the worst nodes first and holds no more pieces than allowed") {
  Random random(3);
  for (const std::uint32_t count : {1000u, 1024u}) {
    const Lights lights(count);
    const auto bits = bits_of(lights.tree, random_visibility(lights, random, 0.3f));
    for (const std::size_t cap : {1u, 2u, 7u, 40u}) {
      const double sigma = 0.4;
      const auto cut = VisibilityCutSelector(lights.tree, {sigma, cap}).select<std::uint8_t>(bits);
      CHECK(cut.size() == cap);
      const auto error = [&](std::uint32_t h) { return slow_error(lights.tree, bits, h); };
      CHECK(cut.ends == refine_cut(lights.tree.leaf_count(), error, sigma * sigma, cap));
    }
  }
}

TEST_CASE("all or nothing visible is one piece, exactly 1 or 0") {
  const Lights lights(1000);
  VisibilityCutSelector selector(lights.tree, {});
  const std::vector<float> all(1000, 1.0f), none(1000, 0.0f);
  const auto bright = selector.select<std::uint8_t>(bits_of(lights.tree, all));
  const auto dark = selector.select<std::uint8_t>(bits_of(lights.tree, none));
  CHECK(bright.ends == std::vector<std::uint32_t>{1024});
  CHECK(bright.values == std::vector<std::uint8_t>{255});
  CHECK(dark.ends == std::vector<std::uint32_t>{1024});
  CHECK(dark.values == std::vector<std::uint8_t>{0});
}

TEST_CASE("the precomputation is the trace and the selection of each receiver, for every set of options") {
  const Lights lights(100);
  const DirectionPackets packets(leaf_directions(lights.tree, lights.directions));
  const auto receivers = random_receivers(visibility_block + 5, 4);
  const std::vector<VisibilityCutOptions> options{{0.4, 1000}, {2, 1000}, {0.4, 3}};
  const auto made = precompute_visibility<std::uint8_t>(three_spheres, lights.tree, packets, receivers,
                                                        options, true, Serial());
  const std::uint32_t words = words_for_bits(lights.tree.leaf_count());
  REQUIRE(made.bits.size() == receivers.size() * words);
  std::vector<std::uint64_t> bits(words);
  std::size_t rays = 0;
  for (std::size_t i = 0; i < receivers.size(); ++i) {
    rays += trace_visibility(three_spheres, packets, receivers[i], bits);
    REQUIRE(std::ranges::equal(bits, std::span(made.bits).subspan(i * words, words)));
    for (std::size_t o = 0; o < options.size(); ++o) {
      const auto expected = VisibilityCutSelector(lights.tree, options[o]).select<std::uint8_t>(bits);
      const auto stored = made.cuts[o].unpack(i);
      REQUIRE(stored.ends == expected.ends);
      REQUIRE(stored.values == expected.values);
    }
  }
  CHECK(made.rays == rays);
}

TEST_CASE("the precomputation does not depend on who runs it") {
  const Lights lights(200);
  const DirectionPackets packets(leaf_directions(lights.tree, lights.directions));
  const auto receivers = random_receivers(2 * visibility_block + 100, 6);
  const std::vector<VisibilityCutOptions> options{{}, {1, 20}};
  const auto run = [&](const auto& executor) {
    return precompute_visibility<std::uint8_t>(three_spheres, lights.tree, packets, receivers, options, true,
                                               executor);
  };
  const auto serial = run(Serial());
  check_same(serial, run(TwoThreads()));
  check_same(serial, run(Backwards{1}));
  check_same(serial, run(Backwards{333}));
}

TEST_CASE("progress grows block by block to the end, without receivers there is none") {
  const Lights lights(8);
  const DirectionPackets packets(leaf_directions(lights.tree, lights.directions));
  std::vector<std::size_t> told;
  const Progress progress = [&](std::size_t done, std::size_t total) {
    CHECK(total == visibility_block + 1);
    told.push_back(done);
  };
  const auto receivers = random_receivers(visibility_block + 1, 7);
  const std::vector<VisibilityCutOptions> options{{}};
  const auto made = precompute_visibility<std::uint8_t>(three_spheres, lights.tree, packets, receivers,
                                                        options, false, Serial(), progress);
  CHECK(told == std::vector<std::size_t>{visibility_block, visibility_block + 1});
  CHECK(made.bits.empty());
  const auto none =
      precompute_visibility<std::uint8_t>(three_spheres, lights.tree, packets, {}, options, true, Serial());
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
