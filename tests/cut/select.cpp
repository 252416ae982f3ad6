// Chosen cuts honour Eq. 6, are no finer than it asks for, and stop at the cap with the worst nodes split
// first.
#include <doctest/doctest.h>

#include <coppice/cut/merge.hpp>
#include <coppice/cut/select.hpp>
#include <coppice/tree/aggregate.hpp>
#include <numeric>
#include <vector>

#include "support/generators.hpp"

using namespace coppice;
using namespace test_support;

namespace {

using Ends = std::vector<std::uint32_t>;

/// A function known at the lights and its moments at the nodes.
struct Sampled {
  std::uint32_t leaf_count;
  std::vector<float> values;  // by light = leaf
  std::vector<Moments> moments;

  double error(std::uint32_t h) const { return moments[h].squared_deviations; }
  auto errors() const {
    return [this](std::uint32_t h) { return error(h); };
  }
};

Sampled sampled(std::vector<float> values) {
  LightTree tree;
  tree.light_of_leaf.assign(leaf_count_for(values.size()), no_light);
  std::iota(tree.light_of_leaf.begin(), tree.light_of_leaf.begin() + std::ptrdiff_t(values.size()), 0u);
  auto moments = aggregate_moments(tree, values);
  return {tree.leaf_count(), std::move(values), std::move(moments)};
}

/// Smooth, noisy, or bits in runs, with padding where the count is no power of two.
Sampled any_function() {
  Random random = any_random();
  const std::uint32_t count = *rc::gen::inRange(1u, 600u);
  const int kind = *rc::gen::inRange(0, 3);
  std::vector<float> values(count);
  float bit = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    if (random.uniform() < 0.1f) bit = 1 - bit;
    values[i] = kind == 0 ? bit : kind == 1 ? random.uniform() : std::sin(0.02f * float(i)) * 10;
  }
  return sampled(std::move(values));
}

double any_threshold() { return *rc::gen::elementOf(std::vector<double>{0, 0.01, 0.25, 1, 2, 4, 100}); }

/// The definition of a capped cut: look through all pieces, split the worst, begin again.
Ends split_worst_first(std::uint32_t leaf_count, const std::vector<double>& priority, double threshold,
                       std::size_t max_size) {
  std::vector<std::uint32_t> nodes{1};
  while (nodes.size() < max_size) {
    auto worst = nodes.end();
    for (auto i = nodes.begin(); i != nodes.end(); ++i) {
      if (*i >= leaf_count || priority[*i] <= threshold) continue;
      if (worst == nodes.end() || priority[*i] > priority[*worst] ||
          (priority[*i] == priority[*worst] && *i < *worst))
        worst = i;
    }
    if (worst == nodes.end()) break;
    const std::uint32_t h = *worst;
    *worst = 2 * h;
    nodes.push_back(2 * h + 1);
  }
  Ends ends;
  for (const std::uint32_t h : nodes) ends.push_back(leaves_below(leaf_count, h).end);
  std::ranges::sort(ends);
  return ends;
}

std::vector<std::uint32_t> nodes_of(std::uint32_t leaf_count, const Ends& ends) {
  std::vector<std::uint32_t> nodes;
  for_each_piece(
      ends, [&](LeafRange r, std::size_t) { nodes.push_back(node_of_range(leaf_count, r.begin, r.end)); });
  return nodes;
}

/// Priorities with many ties, not monotone in the depth.
std::vector<double> any_priorities(Random& random, std::uint32_t leaf_count) {
  std::vector<double> priority(2 * std::size_t(leaf_count));
  for (double& p : priority) p = random.below(8);
  return priority;
}

}  // namespace

TEST_CASE("every piece of a threshold cut that is no leaf honours Eq. 6") {
  CHECK(rc::check([] {
    const Sampled f = any_function();
    const double threshold = any_threshold();
    const Ends ends = select_by_threshold(f.leaf_count, f.errors(), threshold);
    RC_ASSERT(is_cut(f.leaf_count, ends));
    for (const std::uint32_t h : nodes_of(f.leaf_count, ends))
      RC_ASSERT(h >= f.leaf_count || f.error(h) <= threshold);
  }));
}

TEST_CASE("Eq. 6 holds for the variance computed from the lights themselves") {
  CHECK(rc::check([] {
    const Sampled f = any_function();
    const double threshold = any_threshold();
    for_each_piece(select_by_threshold(f.leaf_count, f.errors(), threshold), [&](LeafRange r, std::size_t) {
      const auto end = std::min(std::size_t(r.end), f.values.size());
      if (r.size() == 1 || r.begin >= end) return;
      long double mean = 0, deviations = 0;
      for (std::size_t i = r.begin; i < end; ++i)
        mean += static_cast<long double>(f.values[i]) / (end - r.begin);
      for (std::size_t i = r.begin; i < end; ++i) deviations += (f.values[i] - mean) * (f.values[i] - mean);
      RC_ASSERT(deviations <= threshold * (1 + 1e-12) + 1e-12);
    });
  }));
}

TEST_CASE("a threshold cut is the coarsest: the parent of any piece violates Eq. 6") {
  CHECK(rc::check([] {
    const Sampled f = any_function();
    const double threshold = any_threshold();
    const Ends ends = select_by_threshold(f.leaf_count, f.errors(), threshold);
    for (const std::uint32_t h : nodes_of(f.leaf_count, ends))
      RC_ASSERT(h == 1 || f.error(h / 2) > threshold);
  }));
}

TEST_CASE("a capped cut splits the worst nodes first and keeps to its cap") {
  CHECK(rc::check([] {
    const Sampled f = any_function();
    const double threshold = any_threshold();
    const std::size_t cap = *rc::gen::inRange<std::size_t>(1, 100);
    std::vector<double> priority;
    for (const auto& m : f.moments) priority.push_back(m.squared_deviations);
    const Ends ends = select_by_threshold(f.leaf_count, f.errors(), threshold, cap);
    RC_ASSERT(is_cut(f.leaf_count, ends));
    RC_ASSERT(ends.size() <= cap);
    RC_ASSERT(ends == split_worst_first(f.leaf_count, priority, threshold, cap));
  }));
}

TEST_CASE("refinement is the naive one for any priorities, ties to the smaller node") {
  CHECK(rc::check([] {
    Random random = any_random();
    const std::uint32_t n = any_leaf_count(8);
    const auto priority = any_priorities(random, n);
    const std::size_t cap = *rc::gen::inRange<std::size_t>(1, 300);
    const double threshold = *rc::gen::inRange(0, 8);
    const auto of = [&](std::uint32_t h) { return priority[h]; };
    RC_ASSERT(refine_cut(n, of, threshold, cap) == split_worst_first(n, priority, threshold, cap));
    RC_ASSERT(refine_cut(n, of, threshold, unlimited) == select_by_threshold(n, of, threshold));
    RC_ASSERT(select_by_budget(n, of, cap) == split_worst_first(n, priority, 0, cap));
  }));
}

TEST_CASE("a cap of the cut's own size changes nothing, one less costs one piece") {
  Random random(1);
  std::vector<float> values(1024);
  for (float& v : values) v = random.uniform();
  const Sampled f = sampled(values);
  const Ends ends = select_by_threshold(f.leaf_count, f.errors(), 1.0);
  REQUIRE(ends.size() > 2);
  CHECK(select_by_threshold(f.leaf_count, f.errors(), 1.0, ends.size()) == ends);
  CHECK(select_by_threshold(f.leaf_count, f.errors(), 1.0, ends.size() - 1).size() == ends.size() - 1);
  CHECK(select_by_threshold(f.leaf_count, f.errors(), 1.0, 1) == Ends{1024});
}

TEST_CASE("a budget goes to the brightest sums, not to the brightest means") {
  // One lamp among 8 leaves of sum 4, and 8 leaves of sum 8: the second half is split first.
  const std::vector<double> leaves{4, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1};
  const auto sums = aggregate(
      16, [&](std::uint32_t i) { return leaves[i]; }, std::plus<>());
  const auto of = [&](std::uint32_t h) { return sums[h]; };
  CHECK(select_by_budget(16, of, 1) == Ends{16});
  CHECK(select_by_budget(16, of, 2) == Ends{8, 16});
  CHECK(select_by_budget(16, of, 3) == Ends{8, 12, 16});
  CHECK(select_by_budget(16, of, 4) == Ends{4, 8, 12, 16});
}

TEST_CASE("nodes without intensity are never split, leaves neither") {
  CHECK(select_by_budget(
            64, [](std::uint32_t) { return 0.0; }, 1000) == Ends{64});
  CHECK(select_by_budget(
            8, [](std::uint32_t) { return 1.0; }, 1000) == Ends{1, 2, 3, 4, 5, 6, 7, 8});
  CHECK(select_by_budget(
            1, [](std::uint32_t) { return 1.0; }, 10) == Ends{1});
}

TEST_CASE("a tree without lights has a cut without pieces") {
  const auto any = [](std::uint32_t) { return 1.0; };
  CHECK(select_by_threshold(0, any, 0).empty());
  CHECK(select_by_budget(0, any, 5).empty());
}

TEST_CASE("the product of the means on the merged cut errs by at most sigma_a sigma_b a piece (Eq. 8)") {
  CHECK(rc::check([] {
    Random random = any_random();
    const std::uint32_t n = any_leaf_count(9);
    std::vector<float> a(n), b(n);
    for (std::uint32_t i = 0; i < n; ++i)
      a[i] = random.uniform() < 0.3f, b[i] = std::exp(random_value<float>(random));
    const Sampled f = sampled(a), g = sampled(b);
    const double sigma_a = std::sqrt(any_threshold()), sigma_b = std::sqrt(any_threshold());
    const auto cut_of = [](const Sampled& s, double sigma) {
      return cut_with_values(s.leaf_count, select_by_threshold(s.leaf_count, s.errors(), sigma * sigma),
                             [&](std::uint32_t h) { return s.moments[h].mean; });
    };
    merge_cuts(
        [&](LeafRange r, double, double) {
          const std::uint32_t h = node_of_range(n, r.begin, r.end);
          double exact = 0;
          for (std::uint32_t i = r.begin; i < r.end; ++i) exact += double(a[i]) * double(b[i]);
          const double approximate = r.size() * f.moments[h].mean * g.moments[h].mean;
          RC_ASSERT(r.size() == 1 || std::abs(exact - approximate) <= sigma_a * sigma_b + 1e-9);
        },
        cut_of(f, sigma_a), cut_of(g, sigma_b));
  }));
}
