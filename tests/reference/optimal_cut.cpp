// The exhaustive search itself: it sees every cut once, and picks what a reader picks by hand.
#include <doctest/doctest.h>

#include <algorithm>
#include <coppice/reference/optimal_cut.hpp>
#include <vector>

using namespace coppice;
using namespace coppice::reference;

using Ends = std::vector<std::uint32_t>;

TEST_CASE("there are 1, 2, 5, 26 and 677 cuts, all different and all cuts") {
  const std::uint32_t expected[] = {1, 2, 5, 26, 677};
  for (std::uint32_t level = 0; level < 5; ++level) {
    const std::uint32_t n = 1u << level;
    auto cuts = all_cuts(n);
    CHECK(cuts.size() == expected[level]);
    for (const std::uint32_t mask : cuts) CHECK(is_cut(n, ends_of_mask(mask)));
    std::ranges::sort(cuts);
    CHECK(std::ranges::adjacent_find(cuts) == cuts.end());
  }
}

TEST_CASE("the cost of a cut is the errors of its pieces and the price of each") {
  const auto error = [](std::uint32_t h) { return 10.0 * h; };
  CHECK(cut_cost(4, Ends{4}, error, 3) == 13);
  CHECK(cut_cost(4, Ends{2, 4}, error, 3) == 20 + 30 + 6);
  CHECK(cut_cost(4, Ends{1, 2, 4}, error, 3) == 40 + 50 + 30 + 9);
}

TEST_CASE("a hidden gain below a useless split is found, a threshold on each node would miss it") {
  // Splitting the root alone gains nothing, splitting its children too gains all.
  const std::vector<double> errors{0, 4, 2, 2, 0, 0, 0, 0};
  const auto error = [&](std::uint32_t h) { return errors[h]; };
  CHECK(optimal_cut(4, error, 0.9) == Ends{1, 2, 3, 4});
  CHECK(optimal_cut(4, error, 1.5) == Ends{4});
  CHECK(optimal_cut(4, error, 4.0 / 3) == Ends{4});  // a tie: fewer pieces
}
