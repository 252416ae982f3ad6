// Selection of visibility cuts against sums of the same bits leaf by leaf in double precision.
#include <doctest/doctest.h>

#include <coppice/reference/optimal_cut.hpp>
#include <coppice/relight/visibility_cut_selector.hpp>
#include <coppice/tree/aggregate.hpp>

#include "relight/lights.hpp"

using namespace coppice;
using namespace relight_test;

namespace {

/// Options as the paper has them: Eq. 6, every light alike.
VisibilityCutOptions by_equation_6(double sigma, std::size_t max_size = unlimited) {
  return {sigma, max_size, CutWeight::uniform, CutSearch::threshold};
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

/// Σ w and Σ w v below each node, from the definition of the weights.
struct WeightedSums {
  std::vector<double> all, visible;  // a heap id

  WeightedSums(const Lights& lights, std::span<const std::uint64_t> bits, const ReceiverHorizon& horizon) {
    const auto weight = [&](std::uint32_t leaf) {
      const std::uint32_t light = lights.tree.light_of_leaf[leaf];
      if (light == no_light) return 0.0;
      if (horizon.normal == vec3(0)) return 1.0;
      double cosine = 0;
      for (int k = 0; k < 3; ++k) cosine += double(horizon.normal[k]) * double(lights.directions[light][k]);
      return std::max(0.0, (cosine - horizon.cosine) / (1 - double(horizon.cosine)));
    };
    const std::uint32_t n = lights.tree.leaf_count();
    all = aggregate(n, weight, std::plus<>());
    visible = aggregate(
        n, [&](std::uint32_t leaf) { return bit_at(bits.data(), leaf) ? weight(leaf) : 0.0; }, std::plus<>());
  }

  double mean(std::uint32_t h) const { return all[h] > 0 ? visible[h] / all[h] : 0; }
  double error(std::uint32_t h) const { return all[h] > 0 ? visible[h] * (all[h] - visible[h]) / all[h] : 0; }
};

/// Every piece keeps Eq. 6 and no parent of a piece does, both but for the rounding of floats.
void check_threshold_cut(const WeightedSums& sums, std::uint32_t n, std::span<const std::uint32_t> ends,
                         double sigma2) {
  for_each_piece(ends, [&](LeafRange r, std::size_t) {
    const std::uint32_t h = node_of_range(n, r.begin, r.end);
    CHECK((h >= n || sums.error(h) <= sigma2 + 1e-4));
    CHECK((h == 1 || sums.error(h / 2) > sigma2 - 1e-4));
  });
}

/// The cut costs no more than the best one over the granules, but for the rounding of floats.
void check_optimal_cut(const WeightedSums& sums, std::uint32_t n, std::span<const std::uint32_t> ends,
                       std::uint32_t granule_log2, double sigma) {
  const auto error = [&](std::uint32_t h) { return sums.error(h); };
  auto best = select_optimal(n >> granule_log2, error, price_of_piece(sigma));
  for (std::uint32_t& end : best) end <<= granule_log2;
  const double least = reference::cut_cost(n, best, error, price_of_piece(sigma));
  CHECK(reference::cut_cost(n, ends, error, price_of_piece(sigma)) <= least * (1 + 1e-4));
}

void check_values(const WeightedSums& sums, std::uint32_t n, const Cut<std::uint16_t>& cut) {
  for_each_piece(cut.ends, [&](LeafRange r, std::size_t i) {
    const double mean = sums.mean(node_of_range(n, r.begin, r.end));
    const double tiny_weights = sums.all[node_of_range(n, r.begin, r.end)] < 1e-3 ? 1 : 1e-3;
    CHECK(std::abs(double(dequantise(cut.values[i])) - mean) <= tiny_weights);
  });
}

void check_against_twin(const Lights& lights, const VisibilityCutOptions& options,
                        std::span<const std::uint64_t> bits, const ReceiverHorizon& horizon) {
  const std::uint32_t n = lights.tree.leaf_count();
  VisibilityCutSelector selector(lights.tree, lights.packets, options);
  const auto cut = selector.select<std::uint16_t>(bits, horizon);
  REQUIRE(is_cut(n, cut.ends));
  for (const std::uint32_t end : cut.ends) CHECK(end % (1u << selector.granule_log2()) == 0);
  const WeightedSums sums(lights, bits, horizon);
  check_values(sums, n, cut);
  const double sigma2 = options.sigma * options.sigma;
  if (options.search == CutSearch::threshold)
    check_threshold_cut(sums, n, cut.ends, sigma2);
  else
    check_optimal_cut(sums, n, cut.ends, selector.granule_log2(), options.sigma);
}

constexpr std::array<CutWeight, 2> weights{CutWeight::uniform, CutWeight::cosine};
constexpr std::array<CutSearch, 2> searches{CutSearch::threshold, CutSearch::optimal};

}  // namespace

TEST_CASE("selection by popcounts equals selection by moments, for any threshold and any padding") {
  Random random(2);
  for (const std::uint32_t count : {1u, 3u, 64u, 1000u, 1024u}) {
    const Lights lights(count);
    for (const double sigma : {0.3, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 6.0}) {
      VisibilityCutSelector selector(lights.tree, lights.packets, by_equation_6(sigma));
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
      const auto cut = VisibilityCutSelector(lights.tree, lights.packets, by_equation_6(sigma, cap))
                           .select<std::uint8_t>(bits);
      CHECK(cut.size() == cap);
      const auto error = [&](std::uint32_t h) { return slow_error(lights.tree, bits, h); };
      CHECK(cut.ends == refine_cut(lights.tree.leaf_count(), error, sigma * sigma, cap));
    }
  }
}

TEST_CASE("all four kinds of cuts are those of the twin, for any horizon, threshold and padding") {
  Random random(5);
  for (const std::uint32_t count : {1u, 3u, 200u, 1000u, 2048u}) {
    const Lights lights(count);
    const auto receivers = random_receivers(3, count);
    for (const double sigma : {0.1, 0.5, 1.0, 2.0, 3.0, 30.0, 1000.0})
      for (const Receiver& receiver : receivers) {
        const auto bits = bits_of(lights.tree, random_visibility(lights, random, 0.05f));
        for (const CutWeight weight : weights)
          for (const CutSearch search : searches)
            check_against_twin(lights, {sigma, unlimited, weight, search}, bits,
                               horizon_of(receiver, weight));
      }
  }
}

TEST_CASE("a selector that is used again, or copied, selects what a new one does") {
  Random random(6);
  const Lights lights(1000);
  const auto receivers = random_receivers(5, 1);
  VisibilityCutSelector kept(lights.tree, lights.packets, {0.7});
  for (const Receiver& receiver : receivers) {
    const auto bits = bits_of(lights.tree, random_visibility(lights, random, 0.1f));
    const ReceiverHorizon horizon = horizon_of(receiver, CutWeight::cosine);
    const auto fresh =
        VisibilityCutSelector(lights.tree, lights.packets, {0.7}).select<std::uint8_t>(bits, horizon);
    VisibilityCutSelector copy = kept;
    for (const auto& cut :
         {kept.select<std::uint8_t>(bits, horizon), copy.select<std::uint8_t>(bits, horizon)}) {
      CHECK(cut.ends == fresh.ends);
      CHECK(cut.values == fresh.values);
    }
  }
}

TEST_CASE("all or nothing visible is one piece, exactly 1 or 0, whatever the kind and the horizon") {
  const Lights lights(1000);
  const auto all = bits_of(lights.tree, std::vector<float>(1000, 1.0f));
  const auto none = bits_of(lights.tree, std::vector<float>(1000, 0.0f));
  for (const CutWeight weight : weights)
    for (const CutSearch search : searches) {
      VisibilityCutSelector selector(lights.tree, lights.packets, {0.3, 1000, weight, search});
      for (const Receiver& receiver : random_receivers(20, 3)) {
        const auto bright = selector.select<std::uint8_t>(all, horizon_of(receiver, weight));
        const auto dark = selector.select<std::uint8_t>(none, horizon_of(receiver, weight));
        CHECK(bright.ends == std::vector<std::uint32_t>{1024});
        CHECK(bright.values == std::vector<std::uint8_t>{255});
        CHECK(dark.ends == std::vector<std::uint32_t>{1024});
        CHECK(dark.values == std::vector<std::uint8_t>{0});
      }
    }
}

TEST_CASE("where all lights are below the horizon the cut is one piece without light") {
  std::vector<vec3> below;
  for (const vec3& d : even_directions(500))
    if (d.y < -0.01f) below.push_back(d);
  const LightTree tree = tree_over(below);
  const DirectionPackets packets(leaf_directions(tree, below));
  const auto bits = bits_of(tree, std::vector<float>(below.size(), 1.0f));
  for (const CutSearch search : searches) {
    VisibilityCutSelector selector(tree, packets, {0.1, 1000, CutWeight::cosine, search});
    const auto dark = selector.select<std::uint8_t>(bits, {vec3(0, 1, 0), 0});
    CHECK(dark.ends == std::vector<std::uint32_t>{tree.leaf_count()});
    CHECK(dark.values == std::vector<std::uint8_t>{0});
    const auto bright = selector.select<std::uint8_t>(bits, {vec3(0, 1, 0), -1});
    CHECK(bright.values == std::vector<std::uint8_t>{255});
  }
}

TEST_CASE("values are means weighted by the cosine above the horizon") {
  // Two lights, cosines 1 and 0.5; the second is visible.
  const std::vector<vec3> directions{{0, 1, 0}, {std::sqrt(0.75f), 0.5f, 0}};
  const LightTree tree = tree_over(directions);
  const DirectionPackets packets(leaf_directions(tree, directions));
  const auto bits = bits_of(tree, std::vector<float>{0, 1});
  const auto value = [&](float horizon) {
    VisibilityCutSelector selector(tree, packets, {2, 1000});
    const auto cut = selector.select<std::uint16_t>(bits, {vec3(0, 1, 0), horizon});
    REQUIRE(cut.size() == 1);
    return dequantise(cut.values[0]);
  };
  CHECK(value(0) == doctest::Approx(0.5 / 1.5).epsilon(1e-4));
  CHECK(value(-0.2f) == doctest::Approx(0.7 / 1.9).epsilon(1e-4));
  CHECK(value(-1) == doctest::Approx(1.5 / 3.5).epsilon(1e-4));
}

TEST_CASE("an optimal cut keeps to its cap") {
  Random random(7);
  const Lights lights(1000);
  const auto bits = bits_of(lights.tree, random_visibility(lights, random, 0.3f));
  for (const std::size_t cap : {1u, 2u, 7u, 40u}) {
    VisibilityCutSelector selector(lights.tree, lights.packets, {0.4, cap});
    const auto cut = selector.select<std::uint8_t>(bits, {vec3(0, 1, 0), 0});
    CHECK(is_cut(1024, cut.ends));
    CHECK(cut.size() <= cap);
  }
}

TEST_CASE("the horizon is the lower of the faces' and of the bend, and uniform weights have none") {
  Receiver receiver;
  receiver.normal = {0.6f, 0.8f, 0};
  const auto cosine_of = [&](float horizon, float bend) {
    receiver.horizon = horizon, receiver.bend = bend;
    const ReceiverHorizon h = horizon_of(receiver, CutWeight::cosine);
    CHECK(h.normal == receiver.normal);
    return h.cosine;
  };
  CHECK(cosine_of(0, 0) == 0);
  CHECK(cosine_of(-0.1f, 0) == -0.1f);
  CHECK(cosine_of(-0.1f, 0.2f) == -0.2f);
  CHECK(cosine_of(-0.5f, 0.2f) == -0.5f);
  CHECK(cosine_of(-1, 0) == -1);
  CHECK(cosine_of(-2, 0) == -1);
  CHECK(cosine_of(0.5f, 0) == 0);
  CHECK(horizon_of(receiver, CutWeight::uniform).normal == vec3(0));
  CHECK(horizon_of(receiver, CutWeight::uniform).cosine == -1);
}
