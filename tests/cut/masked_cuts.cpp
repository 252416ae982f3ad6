// Cuts as masks over granules: they come back as they went in, and granules never hide an end.
#include <doctest/doctest.h>

#include <bit>
#include <coppice/cut/masked_cuts.hpp>
#include <coppice/cut/select.hpp>
#include <coppice/tree/aggregate.hpp>
#include <numeric>
#include <vector>

#include "support/generators.hpp"

using namespace coppice;
using namespace test_support;

namespace {

template <Quantised Value>
void check_round_trip() {
  const std::uint32_t n = any_leaf_count(11);
  const auto granule_log2 = std::uint32_t(*rc::gen::inRange(0, std::min(6, int(std::bit_width(n)))));
  Random random = any_random();
  std::vector<Cut<Value>> cuts(*rc::gen::inRange<std::size_t>(0, 20));
  MaskedCuts<Value> store(n, granule_log2);
  for (auto& cut : cuts) {
    cut = random_cut<Value>(random, n, random.uniform(), 1u << granule_log2);
    store.append(CutView<Value>(cut));
  }
  RC_ASSERT(store.size() == cuts.size());
  std::size_t pieces = 0;
  for (std::size_t i = 0; i < cuts.size(); pieces += cuts[i++].size()) {
    RC_ASSERT(store.unpack(i).ends == cuts[i].ends);
    RC_ASSERT(store.unpack(i).values == cuts[i].values);
    RC_ASSERT(store.piece_count(i) == cuts[i].size());
    RC_ASSERT(store.first_value()[i] == pieces);
  }
  RC_ASSERT(store.values().size() == pieces);
  RC_ASSERT(store.masks().size() == cuts.size() * store.words_per_cut());
}

/// Moments at the root of m leaves whose values are the lowest m bits.
Moments moments_of_bits(std::uint32_t bits, std::uint32_t m) {
  return aggregate(
      m, [&](std::uint32_t i) { return Moments::of(bits >> i & 1); },
      [](const Moments& a, const Moments& b) { return a + b; })[1];
}

}  // namespace

TEST_CASE("cuts come back from their masks as they went in") {
  CHECK(rc::check([] { check_round_trip<std::uint8_t>(); }));
  CHECK(rc::check([] { check_round_trip<std::uint16_t>(); }));
}

TEST_CASE("bit k of a mask is the end of granule k, and values follow in order") {
  MaskedCuts<std::uint8_t> store(256, 2);
  CHECK(store.leaf_count() == 256);
  CHECK(store.granule_log2() == 2);
  CHECK(store.words_per_cut() == 2);
  const Cut<std::uint8_t> cut{{4, 8, 16, 32, 64, 128, 256}, {1, 2, 3, 4, 5, 6, 7}};
  store.append(CutView<std::uint8_t>(Cut<std::uint8_t>{{256}, {9}}));
  store.append(CutView<std::uint8_t>(cut));
  CHECK(store[0].mask[0] == 0);
  CHECK(store[0].mask[1] == 0x80000000u);
  CHECK(store[0].values[0] == 9);
  CHECK(store[1].mask[0] == (1u << 0 | 1u << 1 | 1u << 3 | 1u << 7 | 1u << 15 | 1u << 31));
  CHECK(store[1].mask[1] == 0x80000000u);
  CHECK(store[1].values[6] == 7);
  CHECK(store.byte_count() == 4 * 4 + 8 + 3 * 4 + 2 * 16);
}

TEST_CASE("each cut keeps the horizon it came with, or none") {
  MaskedCuts<std::uint8_t> store(64, 0);
  const Cut<std::uint8_t> cut{{64}, {1}};
  store.append(CutView<std::uint8_t>(cut), {vec3(0, 0.6f, 0.8f), -0.25f});
  store.append(CutView<std::uint8_t>(cut));
  REQUIRE(store.horizons().size() == 2);
  CHECK(store[0].horizon.normal == vec3(0, 0.6f, 0.8f));
  CHECK(store[0].horizon.cosine == -0.25f);
  CHECK(store[1].horizon.normal == vec3(0));
  CHECK(store[1].horizon.cosine == -1);
}

TEST_CASE("weights of at most 1 make no granule of m <= 4 sigma^2 leaves err by more than sigma^2") {
  Random random(4);
  double worst = 0;
  for (int i = 0; i < 20000; ++i) {
    double all = 0, visible = 0;
    for (int leaf = 0; leaf < 16; ++leaf) {
      const double weight = std::min(1.0f, 2 * random.uniform());
      all += weight;
      if (random.bits() & 1) visible += weight;
    }
    worst = std::max(worst, visible * (all - visible) / all);
  }
  CHECK(worst <= 4);  // σ = 2
  CHECK(worst > 3);
}

TEST_CASE("a store of a tree without leaves holds cuts without pieces") {
  MaskedCuts<std::uint8_t> store(0, 0);
  store.append(CutView<std::uint8_t>());
  CHECK(store.size() == 1);
  CHECK(store.piece_count(0) == 0);
  CHECK(store.unpack(0).size() == 0);
  CHECK(MaskedCuts<std::uint8_t>().size() == 0);
}

TEST_CASE("granules have 1 to 32 leaves, at most 4 sigma^2, and never more than the tree") {
  CHECK(granule_log2_for(0, 1024) == 0);
  CHECK(granule_log2_for(0.5, 1024) == 0);
  CHECK(granule_log2_for(0.7, 1024) == 0);
  CHECK(granule_log2_for(1, 1024) == 2);
  CHECK(granule_log2_for(std::sqrt(2.0), 1024) == 3);
  CHECK(granule_log2_for(1.99, 1024) == 3);
  CHECK(granule_log2_for(2, 1024) == 4);
  CHECK(granule_log2_for(3, 1024) == 5);
  CHECK(granule_log2_for(1e6, 1u << 31) == 5);
  CHECK(granule_log2_for(3, 8) == 3);
  CHECK(granule_log2_for(3, 1) == 0);
  CHECK(granule_log2_for(3, 0) == 0);
}

TEST_CASE("no bits whatever make a granule of m <= 4 sigma^2 leaves violate Eq. 6") {
  for (const std::uint32_t m : {1u, 2u, 4u, 8u, 16u}) {
    const double sigma2 = m / 4.0;
    REQUIRE((1u << granule_log2_for(std::sqrt(sigma2), 1024)) == m);
    double worst = 0;
    for (std::uint32_t bits = 0; bits < 1u << m; ++bits)
      worst = std::max(worst, moments_of_bits(bits, m).squared_deviations);
    CHECK(worst <= sigma2);
    if (m > 1) CHECK(worst == sigma2);  // half of them set: the bound is reached
  }
  Random random(1);
  double worst = 0;
  for (int i = 0; i < 20000; ++i)
    worst = std::max(worst, moments_of_bits(std::uint32_t(random.bits()), 32).squared_deviations);
  worst = std::max(worst, moments_of_bits(0x55555555u, 32).squared_deviations);
  CHECK(worst == 8.0);
}

TEST_CASE("cuts of binary functions end on granules only, whatever the bits, the threshold and the padding") {
  CHECK(rc::check([] {
    Random random = any_random();
    const std::uint32_t count = *rc::gen::inRange(1u, 2000u);
    const double sigma =
        *rc::gen::elementOf(std::vector<double>{0.5, std::sqrt(0.5), 1, std::sqrt(2.0), 1.5, 2, 2.9, 10});
    const int period = *rc::gen::inRange(1, 40);
    const bool noise = *rc::gen::arbitrary<bool>();
    LightTree tree;
    tree.light_of_leaf.assign(leaf_count_for(count), no_light);
    const auto place = shuffled(random, tree.leaf_count());
    std::vector<float> bits(count);
    for (std::uint32_t i = 0; i < count; ++i) {
      tree.light_of_leaf[place[i]] = i;
      bits[i] = noise ? float(random.bits() & 1) : float(int(place[i]) / period % 2);
    }
    const auto moments = aggregate_moments(tree, bits);
    const std::uint32_t granule = 1u << granule_log2_for(sigma, tree.leaf_count());
    const auto error = [&](std::uint32_t h) { return moments[h].squared_deviations; };
    for (const std::size_t cap : {std::size_t(10), unlimited})
      for (const std::uint32_t end : select_by_threshold(tree.leaf_count(), error, sigma * sigma, cap))
        RC_ASSERT(end % granule == 0);
  }));
}

TEST_CASE("cuts come back from their arrays") {
  Random random(9);
  for (const std::uint32_t leaf_count : {1u, 16u, 64u, 1024u})
    for (const std::uint32_t granule_log2 : {0u, 2u}) {
      if (leaf_count >> granule_log2 == 0) continue;
      MaskedCuts<std::uint16_t> cuts(leaf_count, granule_log2);
      for (int i = 0; i < 20; ++i)
        cuts.append(random_cut<std::uint16_t>(random, leaf_count, random.uniform(), 1u << granule_log2),
                    {random.direction(), -0.5f});
      const auto masks = cuts.masks();
      const auto values = cuts.values();
      const auto horizons = cuts.horizons();
      auto copy = MaskedCuts<std::uint16_t>::from_arrays(
          leaf_count, granule_log2, {masks.begin(), masks.end()}, {values.begin(), values.end()},
          {horizons.begin(), horizons.end()});
      REQUIRE(copy.has_value());
      REQUIRE(copy->size() == cuts.size());
      CHECK(std::ranges::equal(copy->first_value(), cuts.first_value()));
      CHECK(copy->byte_count() == cuts.byte_count());
      copy->append(Cut<std::uint16_t>{{leaf_count}, {7}});
      CHECK(copy->unpack(20).values == std::vector<std::uint16_t>{7});
      for (std::size_t i = 0; i < cuts.size(); ++i) {
        CHECK(copy->unpack(i).ends == cuts.unpack(i).ends);
        CHECK(copy->unpack(i).values == cuts.unpack(i).values);
        CHECK((*copy)[i].horizon.normal == cuts[i].horizon.normal);
      }
    }
}

TEST_CASE("arrays that are no cuts give none") {
  const auto is_accepted = [](std::uint32_t leaf_count, std::vector<std::uint32_t> masks, std::size_t values,
                              std::size_t cuts = 1) {
    return MaskedCuts<std::uint8_t>::from_arrays(leaf_count, 0, std::move(masks),
                                                 std::vector<std::uint8_t>(values),
                                                 std::vector<ReceiverHorizon>(cuts))
        .has_value();
  };
  CHECK(is_accepted(8, {0x80}, 1));
  CHECK(is_accepted(8, {0x8a}, 3));           // ends 2, 4, 8
  CHECK_FALSE(is_accepted(8, {0x8a}, 2));     // a value is missing
  CHECK_FALSE(is_accepted(8, {0x8a}, 4));     // one too many
  CHECK_FALSE(is_accepted(8, {0x0a}, 2));     // the last leaves are not covered
  CHECK_FALSE(is_accepted(8, {0x00}, 0));     // nothing is
  CHECK_FALSE(is_accepted(8, {0x84}, 2));     // three leaves are no node
  CHECK_FALSE(is_accepted(8, {0x85}, 3));     // 1, 3: two leaves, but not of one node
  CHECK_FALSE(is_accepted(8, {0x8080}, 2));   // an end beyond the tree
  CHECK_FALSE(is_accepted(8, {0x80, 0}, 1));  // words without a cut
  CHECK_FALSE(is_accepted(64, {0, 0x80000000u}, 1, 2));
  CHECK(is_accepted(64, {0, 0x80000000u}, 1));
  CHECK(is_accepted(0, {}, 0, 3));
  CHECK_FALSE(is_accepted(0, {}, 1, 3));
  CHECK(is_accepted(8, {}, 0, 0));
}
