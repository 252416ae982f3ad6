// Optimal cuts are those of the exhaustive search, and in large trees no single change makes them cheaper.
#include <doctest/doctest.h>

#include <coppice/cut/select.hpp>
#include <coppice/reference/optimal_cut.hpp>
#include <coppice/tree/aggregate.hpp>
#include <vector>

#include "support/generators.hpp"

using namespace coppice;
using namespace test_support;

namespace {

using Ends = std::vector<std::uint32_t>;

/// Errors by heap id. Multiples of 1/8, so that sums are exact and ties happen; a parent may err less than
/// its children.
std::vector<double> any_errors(Random& random, std::uint32_t leaf_count) {
  std::vector<double> errors(2 * std::size_t(leaf_count));
  for (double& e : errors) e = random.below(64) / 8.0;
  return errors;
}

/// Squared deviations of bits in runs, as visibility has them.
std::vector<double> errors_of_bits(Random& random, std::uint32_t leaf_count) {
  double bit = 0;
  const auto moments = aggregate(
      leaf_count,
      [&](std::uint32_t) {
        if (random.uniform() < 0.1f) bit = 1 - bit;
        return Moments::of(bit);
      },
      [](const Moments& a, const Moments& b) { return a + b; });
  std::vector<double> errors;
  for (const Moments& m : moments) errors.push_back(m.squared_deviations);
  return errors;
}

double any_price() { return *rc::gen::elementOf(std::vector<double>{0, 0.125, 0.5, 1, 2, 3, 8, 100}); }

/// The least cost of the cuts below h, by the recursion that defines it.
double least_cost(std::uint32_t leaf_count, const std::vector<double>& errors, double price,
                  std::uint32_t h = 1) {
  if (h >= leaf_count) return errors[h] + price;
  return std::min(errors[h] + price, least_cost(leaf_count, errors, price, 2 * h) +
                                         least_cost(leaf_count, errors, price, 2 * h + 1));
}

}  // namespace

TEST_CASE("in small trees the optimal cut is the one that the exhaustive search finds") {
  CHECK(rc::check([] {
    Random random = any_random();
    const std::uint32_t n = any_leaf_count(4);
    const auto errors = any_errors(random, n);
    const auto error = [&](std::uint32_t h) { return errors[h]; };
    const double price = any_price();
    RC_ASSERT(select_optimal(n, error, price) == reference::optimal_cut(n, error, price));
  }));
}

TEST_CASE("in large trees the cost is the least, and no single split or merge improves it") {
  CHECK(rc::check([] {
    Random random = any_random();
    const std::uint32_t n = any_leaf_count(11);
    const auto errors = *rc::gen::arbitrary<bool>() ? any_errors(random, n) : errors_of_bits(random, n);
    const double price = any_price();
    const auto error = [&](std::uint32_t h) { return errors[h]; };
    const Ends ends = select_optimal(n, error, price);
    RC_ASSERT(is_cut(n, ends));
    const double cost = reference::cut_cost(n, ends, error, price);
    RC_ASSERT(close(cost, least_cost(n, errors, price), 1e-12));
    std::vector<std::uint8_t> is_piece(errors.size(), 0);
    for_each_piece(ends, [&](LeafRange r, std::size_t) { is_piece[node_of_range(n, r.begin, r.end)] = 1; });
    for (std::uint32_t h = 1; h < n; ++h) {
      const double split = errors[2 * h] + errors[2 * h + 1] + price;
      if (is_piece[h]) RC_ASSERT(split >= errors[h]);
      if (is_piece[2 * h] && is_piece[2 * h + 1]) RC_ASSERT(split < errors[h]);
    }
  }));
}

TEST_CASE("an optimal cut errs no more than the threshold cut of as many pieces") {
  Random random(5);
  for (int round = 0; round < 20; ++round) {
    const auto errors = errors_of_bits(random, 1024);
    const auto error = [&](std::uint32_t h) { return errors[h]; };
    const Ends by_threshold = select_by_threshold(1024, error, 2.0);
    std::size_t pieces = 0;
    for (double price = 0.25; price < 8; price *= 1.1) {
      const Ends optimal = select_optimal(1024, error, price);
      if (optimal.size() > by_threshold.size()) continue;
      pieces = std::max(pieces, optimal.size());
      const double slack = price * double(by_threshold.size() - optimal.size());
      CHECK(reference::cut_cost(1024, optimal, error, 0) <=
            reference::cut_cost(1024, by_threshold, error, 0) + slack + 1e-9);
    }
    CHECK(pieces > by_threshold.size() / 2);
  }
}

TEST_CASE("a higher price never gives more pieces") {
  Random random(6);
  const auto errors = errors_of_bits(random, 4096);
  const auto error = [&](std::uint32_t h) { return errors[h]; };
  std::size_t last = unlimited;
  for (double price = 1e-3; price < 2000; price *= 1.5) {
    const std::size_t size = select_optimal(4096, error, price).size();
    CHECK(size <= last);
    last = size;
  }
  CHECK(last == 1);
}

TEST_CASE("beyond its cap the price doubles until the cut fits") {
  Random random(7);
  const auto errors = errors_of_bits(random, 1024);
  const auto error = [&](std::uint32_t h) { return errors[h]; };
  const Ends free = select_optimal(1024, error, 0.25);
  REQUIRE(free.size() > 100);
  CHECK(select_optimal(1024, error, 0.25, free.size()) == free);
  CHECK(select_optimal(1024, error, 0.25, 1) == Ends{1024});
  for (const std::size_t cap : {2u, 7u, 40u, 100u}) {
    const Ends capped = select_optimal(1024, error, 0.25, cap);
    CHECK(is_cut(1024, capped));
    CHECK(capped.size() <= cap);
    double price = 0.5;
    while (select_optimal(1024, error, price).size() > cap) price *= 2;
    CHECK(capped == select_optimal(1024, error, price));
  }
}

TEST_CASE("a cap holds where pieces are free of charge, whatever the scale of the errors") {
  for (const double scale : {1e-300, 1.0, 1e300}) {
    const auto error = [&](std::uint32_t h) {
      return h < 64 ? scale * (64 >> (std::bit_width(h) - 1)) : 0.0;
    };
    CHECK(select_optimal(64, error, 0).size() == 64);
    for (const std::size_t cap : {1u, 5u, 63u}) CHECK(select_optimal(64, error, 0, cap).size() <= cap);
  }
}

TEST_CASE("where splitting gains nothing the cut is the root, without leaves there is none") {
  const auto nothing = [](std::uint32_t) { return 0.0; };
  CHECK(select_optimal(64, nothing, 0) == Ends{64});
  CHECK(select_optimal(64, nothing, 1) == Ends{64});
  CHECK(select_optimal(1, nothing, 1) == Ends{1});
  CHECK(select_optimal(0, nothing, 1).empty());
}

TEST_CASE("scratch of one call does not show in the next") {
  Random random(8);
  OptimalCutSelector kept;
  for (const std::uint32_t n : {64u, 1u, 1024u, 0u, 16u, 1024u}) {
    const auto errors = any_errors(random, n);
    const auto error = [&](std::uint32_t h) { return errors[h]; };
    CHECK(kept.select(n, error, 1) == select_optimal(n, error, 1));
  }
}
