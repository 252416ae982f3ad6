// The oracle of all merges, on sums worked out by hand.
#include <doctest/doctest.h>

#include <coppice/reference/merge_per_leaf.hpp>

using namespace coppice;
using namespace coppice::reference;

TEST_CASE("a cut spells out one value a leaf") {
  const Cut<float> cut{{2, 3, 4}, {0.5f, -1, 4}};
  CHECK(expand(CutView<float>(cut)) == std::vector<double>{0.5, 0.5, -1, 4});
  CHECK(expand(CutView<float>()).empty());
}

TEST_CASE("the product integral is the sum of products over the leaves") {
  const std::vector<std::vector<double>> functions{{1, 2, 3}, {4, 5, 6}, {1, 0, -1}};
  CHECK(product_integral_per_leaf(functions) == 4 - 18);
  CHECK(product_integral_per_leaf({functions.data(), 1}) == 6);
  CHECK(product_integral_per_leaf({functions.data(), 0}) == 0);
}
