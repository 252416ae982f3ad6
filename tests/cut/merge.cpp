// Any number of merged cuts against their evaluation leaf by leaf.
#include <doctest/doctest.h>

#include <coppice/cut/merge.hpp>
#include <coppice/reference/merge_per_leaf.hpp>
#include <set>
#include <vector>

#include "support/generators.hpp"

using namespace coppice;
using namespace test_support;
using reference::expand;
using reference::product_integral_per_leaf;

namespace {

using Leaves = std::vector<double>;

/// Collects what a merge visits and checks it against the cuts spelled out by leaf.
class Visits {
 public:
  explicit Visits(std::vector<Leaves> functions) : functions_(std::move(functions)) {}

  void visit(LeafRange r, const std::vector<double>& values) {
    RC_ASSERT(values.size() == functions_.size());
    for (std::size_t j = 0; j < values.size(); ++j)
      for (std::uint32_t leaf = r.begin; leaf < r.end; ++leaf) RC_ASSERT(functions_[j][leaf] == values[j]);
    RC_ASSERT(r.begin == (ends.empty() ? 0 : ends.back()));
    ends.push_back(r.end);
  }

  std::vector<std::uint32_t> ends;

 private:
  std::vector<Leaves> functions_;
};

template <class... Values>
std::vector<std::uint32_t> union_of_ends(const Cut<Values>&... cuts) {
  std::set<std::uint32_t> ends;
  (ends.insert(cuts.ends.begin(), cuts.ends.end()), ...);
  return {ends.begin(), ends.end()};
}

/// Merges cuts of these value types and holds every visit against the leaves.
template <class... Values>
void check_merge(std::uint32_t n, const Cut<Values>&... cuts) {
  const std::vector<Leaves> functions{expand(CutView<Values>(cuts))...};
  Visits visits(functions);
  merge_cuts([&](LeafRange r, Values... values) { visits.visit(r, {double(values)...}); }, cuts...);
  RC_ASSERT(visits.ends == union_of_ends(cuts...));
  RC_ASSERT(is_cut(n, visits.ends));
  double scale = 1;
  for (const auto& f : functions)
    for (double largest = 1; const double v : f)
      largest = std::max(largest, std::abs(v)), scale = std::max(scale, largest);
  const double tolerance = 1e-12 * n * std::pow(scale, double(sizeof...(cuts)));
  RC_ASSERT(std::abs(product_integral(cuts...) - product_integral_per_leaf(functions)) <= tolerance);
}

std::vector<Cut<float>> any_cuts(Random& random, std::uint32_t n) {
  std::vector<Cut<float>> cuts(*rc::gen::inRange<std::size_t>(1, 12));
  for (auto& cut : cuts) cut = any_cut<float>(random, n);
  return cuts;
}

std::vector<CutView<float>> views_of(const std::vector<Cut<float>>& cuts) {
  return {cuts.begin(), cuts.end()};
}

std::vector<Leaves> expand_all(const std::vector<Cut<float>>& cuts) {
  std::vector<Leaves> functions;
  for (const auto& cut : cuts) functions.push_back(expand(CutView<float>(cut)));
  return functions;
}

std::span<const CutView<float>> span_of(const std::vector<CutView<float>>& views) { return views; }

double product_of_list(const std::vector<CutView<float>>& views) {
  double sum = 0;
  merge_cut_list(span_of(views), [&](LeafRange r, std::span<const float> values) {
    double product = 1;
    for (const float v : values) product *= double(v);
    sum += r.size() * product;
  });
  return sum;
}

}  // namespace

TEST_CASE(
    "one to six cuts of mixed types merge to the union of their ends, with every cut's value at each leaf") {
  CHECK(rc::check([] {
    const std::uint32_t n = any_leaf_count(9);
    Random random = any_random();
    const auto a = any_cut<float>(random, n), b = any_cut<float>(random, n);
    const auto c = any_cut<std::uint8_t>(random, n);
    const auto d = any_cut<double>(random, n), f = any_cut<double>(random, n);
    const auto e = any_cut<std::uint16_t>(random, n);
    check_merge(n, a);
    check_merge(n, a, b);
    check_merge(n, a, b, c);
    check_merge(n, a, b, c, d);
    check_merge(n, a, b, c, d, e);
    check_merge(n, a, b, c, d, e, f);
  }));
}

TEST_CASE("a list of cuts merges as the same cuts in a pack, and as their leaves") {
  CHECK(rc::check([] {
    const std::uint32_t n = any_leaf_count(9);
    Random random = any_random();
    const auto cuts = any_cuts(random, n);
    const auto views = views_of(cuts);
    Visits visits(expand_all(cuts));
    merge_cut_list(span_of(views), [&](LeafRange r, std::span<const float> values) {
      visits.visit(r, {values.begin(), values.end()});
    });
    RC_ASSERT(is_cut(n, visits.ends));
    if (cuts.size() >= 3) {
      Visits three(expand_all({cuts[0], cuts[1], cuts[2]})), listed(expand_all({cuts[0], cuts[1], cuts[2]}));
      merge_cuts([&](LeafRange r, auto... v) { three.visit(r, {double(v)...}); }, views[0], views[1],
                 views[2]);
      merge_cut_list(span_of(views).first(3), [&](LeafRange r, std::span<const float> v) {
        listed.visit(r, {v.begin(), v.end()});
      });
      RC_ASSERT(three.ends == listed.ends);
    }
  }));
}

TEST_CASE("the order of the cuts changes neither the pieces nor the sums") {
  CHECK(rc::check([] {
    const std::uint32_t n = any_leaf_count(9);
    Random random = any_random();
    const auto cuts = any_cuts(random, n);
    std::vector<Cut<float>> permuted;
    for (const std::uint32_t i : shuffled(random, std::uint32_t(cuts.size()))) permuted.push_back(cuts[i]);
    const auto views = views_of(cuts), permuted_views = views_of(permuted);
    RC_ASSERT(sum_cuts(span_of(views)).ends == sum_cuts(span_of(permuted_views)).ends);
    RC_ASSERT(std::abs(product_of_list(views) - product_of_list(permuted_views)) <= 1e-12 * n);
    RC_ASSERT(std::abs(product_of_list(views) - product_integral_per_leaf(expand_all(cuts))) <= 1e-12 * n);
  }));
}

TEST_CASE("weighted and plain sums of cuts are those of their leaves") {
  CHECK(rc::check([] {
    const std::uint32_t n = any_leaf_count(9);
    Random random = any_random();
    const auto cuts = any_cuts(random, n);
    const auto views = views_of(cuts);
    const auto functions = expand_all(cuts);
    std::vector<float> weights(cuts.size());
    for (float& w : weights) w = random_value<float>(random);
    const auto mixed = interpolate_cuts(std::span<const float>(weights), span_of(views));
    const auto summed = sum_cuts(span_of(views));
    RC_ASSERT(is_cut(n, mixed.ends));
    RC_ASSERT(mixed.ends == summed.ends);
    const auto mixed_leaves = expand(CutView<float>(mixed)), summed_leaves = expand(CutView<float>(summed));
    for (std::uint32_t leaf = 0; leaf < n; ++leaf) {
      double weighted = 0, sum = 0;
      for (std::size_t j = 0; j < cuts.size(); ++j)
        weighted += double(weights[j]) * functions[j][leaf], sum += functions[j][leaf];
      RC_ASSERT(std::abs(mixed_leaves[leaf] - weighted) <= 1e-5);
      RC_ASSERT(std::abs(summed_leaves[leaf] - sum) <= 1e-5);
    }
  }));
}

TEST_CASE("values of a type of their own reach the visitor untouched") {
  struct Opaque {
    int id;
  };
  const Cut<Opaque> a{{2, 4}, {{10}, {20}}};
  const Cut<float> b{{1, 2, 4}, {0.5f, 0.25f, 0.125f}};
  std::vector<int> ids;
  merge_cuts([&](LeafRange, const Opaque& opaque, float) { ids.push_back(opaque.id); }, a, b);
  CHECK(ids == std::vector<int>{10, 10, 20});
}

TEST_CASE("without leaves, or without cuts, nothing is visited") {
  const Cut<float> none;
  merge_cuts([](LeafRange, float, float) { FAIL("visited"); }, none, none);
  CHECK(product_integral(none, none, none) == 0);
  const std::vector<CutView<float>> views{none, none};
  CHECK(sum_cuts(span_of(views)).size() == 0);
  CHECK(sum_cuts(std::span<const CutView<float>>()).size() == 0);
}
