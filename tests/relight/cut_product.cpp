// Products of cuts against the product leaf by leaf.
#include <doctest/doctest.h>

#include <coppice/reference/cut_product.hpp>
#include <coppice/relight/cut_product.hpp>
#include <support/shading.hpp>

#include "support/generators.hpp"

using namespace coppice;
using reference::MeanOfCuts;

namespace {

using Store = MaskedCuts<std::uint8_t>;

/// Up to three factors of up to eight cuts each, with weights that sum to 1.
std::vector<MeanOfCuts> random_factors(std::uint32_t leaf_count, std::uint32_t granule_log2, Random& random) {
  std::vector<MeanOfCuts> factors(random.below(4));
  for (MeanOfCuts& factor : factors) {
    float sum = 0;
    for (std::uint32_t i = 0, count = 1 + random.below(8); i < count; ++i) {
      factor.cuts.push_back(support::random_visibility_cut<std::uint8_t>(leaf_count, granule_log2, random));
      factor.weights.push_back(random.uniform() + 0.01f);
      sum += factor.weights.back();
    }
    for (float& w : factor.weights) w /= sum;
  }
  return factors;
}

/// A product as a cut, and what it was made of.
struct Product {
  Cut<std::uint8_t> cut;
  std::vector<double> exact;

  Product(const Cut<std::uint8_t>& base, std::span<const MeanOfCuts> factors, std::uint32_t leaf_count,
          std::uint32_t granule_log2, CutMultiplier& multiplier)
      : exact(reference::product_per_leaf(base, factors)) {
    Store store(leaf_count, granule_log2);
    store.append(base);
    for (const MeanOfCuts& f : factors)
      for (const auto& c : f.cuts) store.append(c);
    std::vector<std::vector<MaskedCutView<std::uint8_t>>> views;
    std::vector<CutFactor> given;
    std::size_t next = 1;
    for (const MeanOfCuts& f : factors) {
      views.emplace_back();
      for (std::size_t s = 0; s < f.cuts.size(); ++s) views.back().push_back(store[next++]);
    }
    for (std::size_t k = 0; k < factors.size(); ++k) given.push_back({views[k], factors[k].weights});
    multiplier.multiply(store[0], given, store.words_per_cut());
    const auto made =
        Store::from_arrays(leaf_count, granule_log2, {multiplier.mask().begin(), multiplier.mask().end()},
                           {multiplier.values().begin(), multiplier.values().end()}, {no_horizon});
    REQUIRE(made.has_value());
    cut = made->unpack(0);
  }
};

bool is_rounded(const Product& p) {
  const auto values = reference::expand(CutView<std::uint8_t>(p.cut));
  for (std::size_t leaf = 0; leaf < values.size(); ++leaf)
    if (std::abs(values[leaf] - p.exact[leaf]) > 0.5001) return false;
  return values.size() == p.exact.size();
}

/// Every end is one of the base's or a factor's, and no piece where the base is 0 is split.
bool has_only_needed_ends(const Product& p, const Cut<std::uint8_t>& base,
                          std::span<const MeanOfCuts> factors) {
  std::vector<std::uint32_t> wanted = base.ends;
  const auto base_values = reference::expand(CutView<std::uint8_t>(base));
  for (const MeanOfCuts& f : factors)
    for (const auto& c : f.cuts)
      for (const std::uint32_t end : c.ends)
        if (base_values[end - 1] != 0) wanted.push_back(end);
  std::ranges::sort(wanted);
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
  return wanted == p.cut.ends;
}

}  // namespace

TEST_CASE("products equal those leaf by leaf to the rounding of 8 bits, and are cuts") {
  CutMultiplier multiplier;
  CHECK(rc::check([&] {
    Random random = test_support::any_random();
    const std::uint32_t granule_log2 = random.below(5), leaf_count = 32u << random.below(8);
    const auto base = support::random_visibility_cut<std::uint8_t>(leaf_count, granule_log2, random);
    const auto factors = random_factors(leaf_count, granule_log2, random);
    const Product product(base, factors, leaf_count, granule_log2, multiplier);
    RC_ASSERT(is_cut(leaf_count, product.cut.ends));
    RC_ASSERT(is_rounded(product));
    RC_ASSERT(has_only_needed_ends(product, base, factors));
  }));
}

TEST_CASE("without factors the base comes back; factors of 1 keep its values, factors of 0 darken all") {
  Random random(1);
  CutMultiplier multiplier;
  const auto base = support::random_visibility_cut<std::uint8_t>(256, 1, random);
  const auto with = [&](std::uint8_t value) {
    const MeanOfCuts factor{{{{256}, {value}}, {{256}, {value}}}, {0.25f, 0.75f}};
    return Product(base, std::span(&factor, 1), 256, 1, multiplier).cut;
  };
  const Product alone(base, {}, 256, 1, multiplier);
  CHECK(alone.cut.ends == base.ends);
  CHECK(alone.cut.values == base.values);
  CHECK(with(255).values == base.values);
  CHECK(with(0).values == std::vector<std::uint8_t>(base.size(), 0));
}

TEST_CASE("some cuts of a store are replaced, the others and the order stay") {
  Random random(2);
  Store store(512, 2);
  const ReceiverHorizon horizon{vec3(0, 1, 0), -0.25f};
  for (int i = 0; i < 5; ++i)
    store.append(support::random_visibility_cut<std::uint8_t>(512, 2, random), horizon);
  Store other(512, 2);
  for (int i = 0; i < 5; ++i) other.append(support::random_visibility_cut<std::uint8_t>(512, 2, random));
  std::vector<CutReplacement> replacements(5);
  for (const std::size_t i : {0u, 3u}) {
    const auto cut = other.unpack(i);
    replacements[i].mask.assign(other[i].mask, other[i].mask + other.words_per_cut());
    replacements[i].values = cut.values;
  }
  const glm::quat turn = glm::angleAxis(pi / 2, vec3(1, 0, 0));
  const Store made = replace_cuts(store, replacements, turn);
  for (std::size_t i = 0; i < 5; ++i) {
    const Store& source = i == 0 || i == 3 ? other : store;
    CHECK(made.unpack(i).ends == source.unpack(i).ends);
    CHECK(made.unpack(i).values == source.unpack(i).values);
    CHECK(length(made[i].horizon.normal - vec3(0, 0, 1)) < 1e-6f);
    CHECK(made[i].horizon.cosine == -0.25f);
  }
}
