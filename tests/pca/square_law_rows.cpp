// Rows in steps that grow with the entry: the stated bound, at both widths and at the extremes.
#include <doctest/doctest.h>

#include <coppice/core/random.hpp>
#include <coppice/pca/square_law_rows.hpp>

using namespace coppice;

namespace {

/// Entries of magnitudes from 1 down to 1e-6 of the largest, of both signs.
Rows wide_rows(std::size_t count, std::size_t width, float largest, std::uint64_t seed) {
  Random random(seed);
  Rows rows(count, width);
  for (float& x : rows.values)
    x = largest * std::pow(10.0f, -6 * random.uniform()) * (random.below(2) ? 1 : -1);
  return rows;
}

template <class Value>
void check_bound(const Rows& rows) {
  const Rows back = dequantise(quantise_by_squares<Value>(rows));
  const double n = std::numeric_limits<Value>::max();
  for (std::size_t i = 0; i < rows.count(); ++i) {
    const double largest = double(detail::largest_magnitude(rows[i]));
    for (std::size_t k = 0; k < rows.width; ++k) {
      const double x = double(rows[i][k]), error = std::abs(double(back[i][k]) - x);
      REQUIRE(error <=
              1.001 * (std::sqrt(std::abs(x) * largest) / n + largest / (2 * n * n)) + 2e-7 * std::abs(x));
    }
  }
}

}  // namespace

TEST_CASE("square-law rows come back within the stated bound") {
  for (const float largest : {1.0f, 1e30f, 1e-20f}) {
    const Rows rows = wide_rows(20, 333, largest, 7);
    check_bound<std::int8_t>(rows);
    check_bound<std::int16_t>(rows);
  }
}

TEST_CASE("square-law rows keep small entries better than even steps do") {
  const Rows rows = wide_rows(40, 500, 1, 8);
  const Rows squares = dequantise(quantise_by_squares<std::int8_t>(rows)),
             even = dequantise(quantise<std::int8_t>(rows));
  double by_squares = 0, by_steps = 0;
  for (std::size_t k = 0; k < rows.values.size(); ++k) {
    const double x = double(rows.values[k]);
    if (std::abs(x) > 0.03) continue;
    by_squares += std::pow(double(squares.values[k]) - x, 2),
        by_steps += std::pow(double(even.values[k]) - x, 2);
  }
  CHECK(by_squares < 0.5 * by_steps);
}

TEST_CASE("the product of a square-law row is that of its entries") {
  for (const std::size_t width : {1u, 7u, 64u, 333u}) {
    const Rows rows = wide_rows(3, width, 2, width), x = wide_rows(1, width, 5, width + 1);
    const auto rounded = quantise_by_squares<std::int8_t>(rows);
    const Rows back = dequantise(rounded);
    for (std::size_t i = 0; i < rows.count(); ++i) {
      double sum = 0, magnitude = 0;
      for (std::size_t k = 0; k < width; ++k) {
        const double term = double(back[i][k]) * double(x[0][k]);
        sum += term, magnitude += std::abs(term);
      }
      CHECK(std::abs(double(dot(rounded, i, x[0])) - sum) <= (double(width) / 4 + 2) * 1e-7 * magnitude);
    }
  }
}

TEST_CASE("square-law rows of zeros, and none, are zeros and none") {
  const auto zeros = quantise_by_squares<std::int8_t>(Rows(2, 9));
  CHECK(dequantise(zeros).values == std::vector<float>(18, 0.0f));
  const std::vector<float> ones(9, 1.0f);
  CHECK(dot(zeros, 1, std::span<const float>(ones)) == 0);
  CHECK(quantise_by_squares<std::int16_t>(Rows()).count() == 0);
}
