// The product of cuts leaf by leaf, worked out by hand.
#include <doctest/doctest.h>

#include <coppice/reference/cut_product.hpp>

using namespace coppice;
using namespace coppice::reference;

TEST_CASE("without factors the product is the base itself") {
  const Cut<std::uint8_t> base{{2, 4}, {7, 200}};
  CHECK(product_per_leaf(base, {}) == std::vector<double>{7, 7, 200, 200});
}

TEST_CASE("factors are means of cuts, 255 stands for 1") {
  const Cut<std::uint8_t> base{{2, 4}, {100, 200}};
  const std::vector<MeanOfCuts> factors{
      {{{{4}, {255}}}, {1}},
      {{{{1, 2, 4}, {0, 255, 51}}, {{4}, {255}}}, {0.5f, 0.5f}},
  };
  const std::vector<double> expected{50, 100, 120, 120};
  const std::vector<double> product = product_per_leaf(base, factors);
  REQUIRE(product.size() == 4);
  for (std::size_t i = 0; i < 4; ++i) CHECK(product[i] == doctest::Approx(expected[i]));
}
