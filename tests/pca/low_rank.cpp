// Products of low rank against the least error that any can have.
#include <doctest/doctest.h>

#include "rows_for_tests.hpp"
//
#include <coppice/pca/low_rank.hpp>

#include "support/generators.hpp"

using namespace coppice;
using namespace test_support;

namespace {

Rows product_of(const LowRank& product, std::size_t count, std::size_t width) {
  Rows rows(count, width);
  for (std::size_t i = 0; i < count; ++i) reconstruct(product, i, rows[i]);
  return rows;
}

}  // namespace

TEST_CASE("a product of low rank loses the singular values that it leaves out, and no more") {
  Random random(31);
  const Rows rows = rows_of_rank(random, 40, 30, 20, 0.8f);
  const auto twin = reference::singular_vectors(in_double(rows));
  double total = 0;
  for (const double value : twin.values) total += value * value;
  for (const std::size_t rank : {1, 4, 10}) {
    PcaOptions options;
    options.rank = rank;
    const LowRank product = low_rank(rows, options);
    double lost = 0;
    for (std::size_t j = rank; j < twin.values.size(); ++j) lost += twin.values[j] * twin.values[j];
    CHECK(product.rank() == rank);
    CHECK(close(product.loss * total, lost, 1e-6));
    CHECK(close(squared_error(rows, product_of(product, 40, 30)), lost, 1e-4));
  }
}

TEST_CASE("heavy rows are met better than without weights") {
  Random random(32);
  const Rows rows = random_rows(random, 30, 25);
  PcaOptions options;
  options.rank = 5;
  const Rows plain = product_of(low_rank(rows, options), 30, 25);
  options.weights.assign(30, 1.0f);
  options.weights[7] = 100;
  const Rows weighted = product_of(low_rank(rows, options), 30, 25);
  const auto row_error = [&](const Rows& again) {
    double sum = 0;
    for (std::size_t k = 0; k < 25; ++k) sum += std::pow(double(rows[7][k]) - double(again[7][k]), 2);
    return sum;
  };
  CHECK(row_error(weighted) < 0.01 * row_error(plain));
}

TEST_CASE("zeros and matrices without rows have rank 0") {
  const LowRank zeros = low_rank(Rows(20, 40), {});
  CHECK((zeros.rank() == 0 && zeros.loss == 0));
  CHECK(product_of(zeros, 20, 40).values == Rows(20, 40).values);
  CHECK(low_rank(Rows(0, 40), {}).rank() == 0);
}
