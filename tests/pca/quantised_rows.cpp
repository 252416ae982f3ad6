// Rows of 8 and 16 bits: the stated error, and values at the ends of float.
#include <doctest/doctest.h>
#include <rapidcheck.h>

#include "rows_for_tests.hpp"
//
#include <coppice/pca/quantised_rows.hpp>

#include "support/generators.hpp"

using namespace coppice;
using namespace test_support;

namespace {

/// Rows of very different magnitudes, some entries 0.
Rows any_rows() {
  Random random = any_random();
  Rows rows(*rc::gen::inRange<std::size_t>(1, 9), *rc::gen::inRange<std::size_t>(1, 90));
  for (std::size_t i = 0; i < rows.count(); ++i) {
    const float scale = std::pow(10.0f, float(random.below(76)) - 37.0f);
    for (float& x : rows[i]) x = random.below(5) == 0 ? 0 : scale * (2 * random.uniform() - 1);
  }
  return rows;
}

}  // namespace

TEST_CASE_TEMPLATE("entries come back within 0.503 steps, and a step is the stated share of the largest",
                   Value, std::int8_t, std::int16_t) {
  rc::check([] {
    const Rows rows = any_rows();
    const auto small = quantise<Value>(rows);
    const Rows again = dequantise(small);
    RC_ASSERT(small.bytes() == rows.values.size() * sizeof(Value) + 4 * rows.count());
    for (std::size_t i = 0; i < rows.count(); ++i) {
      double largest = 0;
      for (std::size_t k = 0; k < rows.width; ++k) {
        largest = std::max(largest, std::abs(double(rows[i][k])));
        RC_ASSERT(std::abs(double(again[i][k]) - double(rows[i][k])) <= 0.503 * double(small.scales[i]));
      }
      const double least = std::numeric_limits<float>::min();
      RC_ASSERT(double(small.scales[i]) <= std::max(largest / std::numeric_limits<Value>::max(), least));
    }
  });
}

TEST_CASE_TEMPLATE("dot and add_scaled agree with the dequantised rows for every width", Value, std::int8_t,
                   std::int16_t) {
  Random random(41);
  for (std::size_t width = 1; width < 150; ++width) {
    const Rows rows = random_rows(random, 2, width, 3), x = random_rows(random, 1, width);
    const auto small = quantise<Value>(rows);
    const auto again = in_double(dequantise(small));
    double exact = 0, magnitude = 0;
    std::vector<float> to(x[0].begin(), x[0].end());
    add_scaled(0.5f, small, 1, to);
    for (std::size_t k = 0; k < width; ++k) {
      exact += again[1][k] * double(x[0][k]);
      magnitude += std::abs(again[1][k] * double(x[0][k]));
      CHECK(std::abs(double(to[k]) - (double(x[0][k]) + 0.5 * again[1][k])) < 5e-7);
    }
    CHECK(std::abs(double(dot(small, 1, x[0])) - exact) <= (double(width) / 4 + 2) * 6e-8 * magnitude);
  }
}

TEST_CASE_TEMPLATE("zeros stay zeros, the least subnormal vanishes, the greatest float stays finite", Value,
                   std::int8_t, std::int16_t) {
  Rows rows(3, 2);
  rows[1][0] = std::numeric_limits<float>::denorm_min();
  rows[2][0] = std::numeric_limits<float>::max(), rows[2][1] = -std::numeric_limits<float>::max();
  const auto small = quantise<Value>(rows);
  const Rows again = dequantise(small);
  CHECK((again[0][0] == 0 && again[0][1] == 0 && again[1][0] == 0 && small.scales[0] == 0));
  CHECK(again[2][0] <= std::numeric_limits<float>::max());
  CHECK(again[2][0] == -again[2][1]);
  CHECK(again[2][0] > 0.999999f * std::numeric_limits<float>::max());
}

TEST_CASE("quantised rows that are empty say so") {
  CHECK(quantise<std::int8_t>(Rows()).count() == 0);
  CHECK(dequantise(quantise<std::int8_t>(Rows(0, 7))).width == 7);
}
