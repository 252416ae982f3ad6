// Sparse rows keep the largest entries and no others.
#include <doctest/doctest.h>
#include <rapidcheck.h>

#include "rows_for_tests.hpp"
//
#include <coppice/pca/sparse_rows.hpp>

#include "support/generators.hpp"

using namespace coppice;
using namespace test_support;

TEST_CASE("the kept entries are the largest over all rows, and come back exactly as floats") {
  rc::check([] {
    Random random = any_random();
    Rows rows(*rc::gen::inRange<std::size_t>(1, 9), *rc::gen::inRange<std::size_t>(1, 40));
    for (float& x : rows.values) x = float(random.below(7)) - 3;  // ties and zeros
    const double share = double(*rc::gen::inRange(0, 11)) / 10;
    const auto sparse = sparsify<float>(rows, share);
    const Rows again = dequantise(sparse);
    float least_kept = 4, largest_dropped = 0;
    std::size_t kept = 0, dropped = 0;
    for (std::size_t i = 0; i < rows.values.size(); ++i) {
      const float x = rows.values[i], y = again.values[i];
      RC_ASSERT(y == x || y == 0);
      if (y != 0) ++kept, least_kept = std::min(least_kept, std::abs(x));
      if (y == 0 && x != 0) ++dropped, largest_dropped = std::max(largest_dropped, std::abs(x));
    }
    const auto allowed = std::size_t(std::llround(share * double(rows.values.size())));
    RC_ASSERT(kept == std::min(allowed, kept + dropped));
    RC_ASSERT(largest_dropped <= least_kept);
    RC_ASSERT(sparse.bytes() == 4 * (rows.count() + 1) + 6 * kept);
  });
}

TEST_CASE_TEMPLATE("kept entries come back within 0.503 steps, and dot agrees with them", Value, std::int8_t,
                   std::int16_t, float) {
  Random random(51);
  const Rows rows = random_rows(random, 20, 130), x = random_rows(random, 1, 130);
  const auto sparse = sparsify<Value>(rows, 0.2);
  CHECK(sparse.values.size() == 520);
  const Rows again = dequantise(sparse);
  for (std::size_t i = 0; i < 20; ++i) {
    double exact = 0;
    for (std::size_t k = 0; k < 130; ++k) {
      exact += double(again[i][k]) * double(x[0][k]);
      const double step = std::same_as<Value, float> ? 0 : double(sparse.scales[i]);
      if (again[i][k] != 0) CHECK(std::abs(double(again[i][k]) - double(rows[i][k])) <= 0.503 * step);
    }
    CHECK(std::abs(double(dot(sparse, i, x[0])) - exact) < 1e-5);
  }
}

TEST_CASE("a share of 1 keeps all but zeros, a share of 0 nothing") {
  Rows rows(2, 3);
  rows.values = {1, 0, -2, 0, 0, 0};
  CHECK(sparsify<std::int8_t>(rows, 0).values.empty());
  const auto all = sparsify<std::int8_t>(rows, 1);
  CHECK(all.columns == std::vector<std::uint16_t>{0, 2});
  CHECK(all.begins == std::vector<std::uint32_t>{0, 2, 2});
  CHECK(dot(all, 1, std::vector<float>{1, 1, 1}) == 0);
  CHECK(sparsify<float>(Rows(0, 4), 0.5).count() == 0);
}
