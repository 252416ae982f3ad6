// Principal components of intervals: the violation falls, and what can be met is met.
#include <doctest/doctest.h>
#include <rapidcheck.h>

#include "rows_for_tests.hpp"
//
#include <coppice/core/error.hpp>
#include <coppice/pca/interval_pca.hpp>

#include "support/generators.hpp"

using namespace coppice;
using namespace test_support;

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

struct Intervals {
  Rows low, high;
};

/// Intervals round the rows, of random widths; a `share` of them has no upper end.
Intervals round(const Rows& rows, Random& random, float share) {
  Intervals result{rows, rows};
  for (std::size_t i = 0; i < rows.values.size(); ++i) {
    result.low.values[i] -= 0.3f * random.uniform();
    result.high.values[i] = random.uniform() < share ? infinity : rows.values[i] + 0.3f * random.uniform();
  }
  return result;
}

double violation(const Intervals& intervals, const Rows& rows) {
  double sum = 0;
  for (std::size_t i = 0; i < rows.values.size(); ++i) {
    const double x = rows.values[i], low = intervals.low.values[i], high = intervals.high.values[i];
    sum += std::pow(std::max({low - x, x - high, 0.0}), 2);
  }
  return sum;
}

}  // namespace

TEST_CASE("the violation of intervals never grows from round to round, and is what the result has") {
  rc::check([] {
    Random random = any_random();
    const auto count = *rc::gen::inRange<std::size_t>(1, 40), width = *rc::gen::inRange<std::size_t>(1, 40);
    IntervalPcaOptions options;
    options.centred = *rc::gen::arbitrary<bool>();
    options.rank = *rc::gen::inRange<std::size_t>(0, 12);
    options.rounds = 6;
    const Rows rows = random_rows(random, count, width);
    const Intervals intervals = round(rows, random, *rc::gen::element(0.0f, 0.2f, 1.0f));
    const IntervalPca result = interval_pca(intervals.low, intervals.high, options);
    for (std::size_t i = 1; i < result.violations.size(); ++i)
      RC_ASSERT(result.violations[i] <= result.violations[i - 1] * (1 + 1e-9) + 1e-12);
    RC_ASSERT(result.basis.rank() <= options.rank);
    RC_ASSERT(orthonormality_error(result.basis.vectors) < 1e-6);
    const double left = violation(intervals, reconstruct(result.basis, result.coefficients, count));
    RC_ASSERT(std::abs(left - result.violations.back()) <= 1e-5 * (1 + result.violations.back()));
  });
}

TEST_CASE("intervals that hold rows of low rank are met far better than by the basis of their lower ends") {
  Random random(21);
  const Rows rows = rows_of_rank(random, 120, 160, 6, 1.0f);
  const Intervals intervals = round(rows, random, 0.2f);
  IntervalPcaOptions options;
  options.rank = 8, options.rounds = 40;
  const IntervalPca result = interval_pca(intervals.low, intervals.high, options);
  CHECK(result.violations.size() == 41);
  CHECK(result.violations.back() < 0.03 * result.violations.front());
}

TEST_CASE("intervals of one value, and no rounds, give the principal components of that value") {
  Random random(22);
  const Rows rows = rows_of_rank(random, 40, 50, 20, 0.8f);
  PcaOptions options;
  options.rank = 5;
  const PcaBasis plain = pca(rows, options);
  for (const int rounds : {0, 4}) {
    const IntervalPca result = interval_pca(rows, rows, {true, 5, rounds, 1});
    REQUIRE(result.basis.rank() == 5);
    for (std::size_t j = 0; j < 5; ++j) {
      CHECK(close(result.basis.energies[j], plain.energies[j], 1e-6));
      CHECK(dot(result.basis.vectors[j], plain.vectors[j]) > 0.99999f);
    }
    const Rows coefficients = project(result.basis, rows);
    for (std::size_t i = 0; i < coefficients.values.size(); ++i)
      CHECK(std::abs(coefficients.values[i] - result.coefficients.values[i]) < 1e-4f);
  }
}

TEST_CASE("a start that lies in the intervals and has the rank is kept") {
  Random random(23);
  const Rows rows = rows_of_rank(random, 30, 40, 4);
  const Intervals intervals = round(rows, random, 0.5f);
  const IntervalPca result = interval_pca(intervals.low, intervals.high, {false, 4, 5, 1}, rows);
  CHECK(result.violations.back() < 1e-8);
  CHECK(squared_error(rows, reconstruct(result.basis, result.coefficients, 30)) < 1e-7);
}

TEST_CASE("a start of too low a rank does not keep the rank low") {
  Random random(24);
  const Rows rows = rows_of_rank(random, 30, 40, 4, 1.0f);
  const IntervalPca result = interval_pca(rows, rows, {true, 4, 1, 1}, Rows(30, 40));
  CHECK(result.basis.rank() == 4);
  CHECK(result.violations.back() < 1e-6);
}

TEST_CASE("intervals without ends, without rows, or that hold all sides are served") {
  Rows low(6, 4), high(6, 4);
  std::ranges::fill(low.values, -infinity);
  std::ranges::fill(high.values, infinity);
  const IntervalPca free = interval_pca(low, high);
  CHECK(free.violations == std::vector<double>{0});
  CHECK(free.basis.rank() == 0);
  const IntervalPca none = interval_pca(Rows(0, 4), Rows(0, 4));
  CHECK((none.basis.width() == 4 && none.basis.rank() == 0 && none.coefficients.count() == 0));
}

TEST_CASE("intervals without a number are refused by row and column") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const auto& [a, b] : {std::pair(nan, 1.0f), {0.0f, nan}, {2.0f, 1.0f}, {infinity, infinity}}) {
    Rows low(3, 3), high(3, 3);
    low[1][2] = a, high[1][2] = b;
    CHECK_THROWS_WITH_AS(interval_pca(low, high), doctest::Contains("row 1, column 2"), InputError);
  }
  Rows start(3, 3);
  start[0][1] = nan;
  CHECK_THROWS_WITH_AS(interval_pca(Rows(3, 3), Rows(3, 3), {}, start), doctest::Contains("row 0, column 1"),
                       InputError);
}
