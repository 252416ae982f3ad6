// One sweep up the tree, and moments that hold on data on which E[x²] - E[x]² fails.
#include <doctest/doctest.h>

#include <coppice/tree/aggregate.hpp>
#include <numeric>
#include <string>
#include <vector>

#include "support/generators.hpp"

using namespace coppice;
using namespace test_support;

namespace {

/// The lights in their own order, with padding after them.
LightTree tree_in_order(std::uint32_t lights) {
  LightTree tree;
  tree.light_of_leaf.assign(leaf_count_for(lights), no_light);
  std::iota(tree.light_of_leaf.begin(), tree.light_of_leaf.begin() + lights, 0u);
  return tree;
}

struct ExactMoments {
  long double count = 0, mean = 0, squared_deviations = 0;
};

/// Two passes in long double over the values [begin, end).
ExactMoments exact_moments(const std::vector<float>& values, std::size_t begin, std::size_t end) {
  ExactMoments m;
  m.count = end - begin;
  for (std::size_t i = begin; i < end; ++i) m.mean += values[i];
  m.mean /= m.count;
  for (std::size_t i = begin; i < end; ++i)
    m.squared_deviations += (values[i] - m.mean) * (values[i] - m.mean);
  return m;
}

std::vector<float> values_around(float centre, std::uint32_t count) {
  Random random(1);
  std::vector<float> values(count);
  for (float& v : values) v = centre + random_value<float>(random);
  return values;
}

}  // namespace

TEST_CASE("each node combines its left child with its right, entry 0 is a default value") {
  const auto words = aggregate(
      8, [](std::uint32_t leaf) { return std::string(1, char('a' + leaf)); },
      [](const std::string& a, const std::string& b) { return a + b; });
  REQUIRE(words.size() == 16);
  CHECK(words[0].empty());
  CHECK(words[1] == "abcdefgh");
  CHECK(words[2] == "abcd");
  CHECK(words[5] == "cd");
  CHECK(words[15] == "h");
}

TEST_CASE("a tree of one leaf or none aggregates too") {
  const auto leaf = [](std::uint32_t i) { return i + 7; };
  CHECK(aggregate(0, leaf, std::plus<>()).empty());
  CHECK(aggregate(1, leaf, std::plus<>()) == std::vector<std::uint32_t>{0, 7});
}

TEST_CASE("float sums of 10^6 values lose no more than a rounding a level") {
  Random random(2);
  const std::uint32_t n = 1u << 20;
  std::vector<float> values(n);
  for (const bool hard : {false, true}) {
    for (float& v : values) v = hard ? std::exp(138 * random.uniform() - 69) : random.uniform();
    const auto sums = aggregate(
        n, [&](std::uint32_t i) { return values[i]; }, std::plus<>());
    const long double exact = std::accumulate(values.begin(), values.end(), 0.0L);
    CHECK(close(sums[1], exact, 20 * 0x1p-24));
  }
}

TEST_CASE("moments of 10^6 values hold from centre / radius 0 to 10^6") {
  const std::uint32_t count = 1000000;
  const LightTree tree = tree_in_order(count);
  for (const float centre : {0.0f, 1.0f, 1e3f, 1e4f, 1e5f, 1e6f}) {
    CAPTURE(centre);
    const auto values = values_around(centre, count);
    const auto moments = aggregate_moments(tree, values);
    for (const std::uint32_t h : {1u, 2u, 3u, 100u, 1000u, 99999u, 600000u}) {
      const LeafRange r = leaves_below(tree.leaf_count(), h);
      if (r.begin >= count) continue;
      const ExactMoments exact = exact_moments(values, r.begin, std::min(r.end, count));
      CHECK(moments[h].count == double(exact.count));
      CHECK(std::abs(moments[h].mean - exact.mean) < 1e-13 * (1 + double(centre)));
      CHECK(close(moments[h].squared_deviations, exact.squared_deviations, 1e-9));
    }
  }
}

TEST_CASE("moments of values from 1e-45 to 1e38 are finite and right") {
  for (const float scale : {1e-45f, 1e-38f, 1e-20f, 1e20f, 1e38f}) {
    CAPTURE(scale);
    const std::vector<float> values{0, scale, 2 * scale, scale};
    const auto moments = aggregate_moments(tree_in_order(4), values);
    const ExactMoments exact = exact_moments(values, 0, 4);
    CHECK(close(moments[1].mean, exact.mean, 1e-14));
    CHECK(close(moments[1].squared_deviations, exact.squared_deviations, 1e-13));
  }
}

TEST_CASE("equal values have no deviations at all") {
  for (const float value : {0.0f, 0.1f, 1e30f, 1e-45f})
    for (const std::uint32_t count : {1u, 3u, 1000u}) {
      const auto moments = aggregate_moments(tree_in_order(count), std::vector<float>(count, value));
      CHECK(moments[1].squared_deviations == 0);
      CHECK(moments[1].mean == double(value));
      CHECK(moments[1].count == count);
    }
}

TEST_CASE("padding counts for nothing, whole nodes of it are neutral") {
  LightTree tree = tree_in_order(3);
  tree.light_of_leaf = {no_light, 2, no_light, no_light, 0, 1, no_light, no_light};
  const auto moments = aggregate_moments(tree, std::vector<float>{1, 2, 6});
  CHECK(moments[1].count == 3);
  CHECK(moments[1].mean == doctest::Approx(3));
  CHECK(moments[1].squared_deviations == doctest::Approx(14));
  CHECK(moments[5].count == 0);
  CHECK(moments[5].mean == 0);
  CHECK(moments[5].squared_deviations == 0);
  CHECK((Moments{} + Moments{}).count == 0);
}

TEST_CASE("deviations never shrink on the way up") {
  CHECK(rc::check([] {
    Random random = any_random();
    const std::uint32_t count = *rc::gen::inRange(1u, 500u);
    std::vector<float> values(count);
    for (float& v : values) v = random_value<float>(random) + 1000;
    const LightTree tree = tree_in_order(count);
    const auto moments = aggregate_moments(tree, values);
    for (std::uint32_t h = 1; h < tree.leaf_count(); ++h)
      RC_ASSERT(moments[h].squared_deviations >=
                moments[2 * h].squared_deviations + moments[2 * h + 1].squared_deviations);
  }));
}
