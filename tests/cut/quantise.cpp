// The stated error of quantised values, at every level and between levels.
#include <doctest/doctest.h>

#include <cmath>
#include <coppice/cut/quantise.hpp>
#include <limits>

#include "support/generators.hpp"

using namespace coppice;
using namespace test_support;

namespace {

/// The greatest |dequantise(quantise(v)) - v| over v at, half way between, and close to half way between
/// levels.
template <Quantised Q>
double worst_error() {
  const int one = int(quantised_one<Q>);
  double worst = 0;
  for (int half_steps = 0; half_steps <= 2 * one; ++half_steps) {
    float v = float(double(half_steps) / (2 * one));
    for (int i = 0; i < 2; ++i) v = std::nextafter(v, 0.0f);
    for (int i = 0; i < 5; ++i, v = std::nextafter(v, 2.0f))
      if (v <= 1) worst = std::max(worst, std::abs(double(dequantise(quantise<Q>(v))) - double(v)));
  }
  return worst;
}

template <Quantised Q>
void check_levels() {
  CHECK(quantise<Q>(0.0f) == 0);
  CHECK(quantise<Q>(1.0f) == std::numeric_limits<Q>::max());
  CHECK(dequantise(Q(0)) == 0.0f);
  CHECK(dequantise(std::numeric_limits<Q>::max()) == 1.0f);
  bool kept = true, increasing = true;
  for (int q = 0; q <= int(quantised_one<Q>); ++q) {
    kept = kept && quantise<Q>(dequantise(Q(q))) == Q(q);
    increasing = increasing && (q == 0 || dequantise(Q(q)) > dequantise(Q(q - 1)));
  }
  CHECK(kept);
  CHECK(increasing);
}

}  // namespace

TEST_CASE("0 and 1 are exact, every level comes back as itself, and levels increase") {
  check_levels<std::uint8_t>();
  check_levels<std::uint16_t>();
}

TEST_CASE("the error is at most half a level, to the rounding of floats") {
  CHECK(worst_error<std::uint8_t>() <= 1.0 / 510 + 1.2e-7);
  CHECK(worst_error<std::uint16_t>() <= 1.0 / 131070 + 1.2e-7);
}

TEST_CASE("values outside (0, 1) are clamped") {
  for (const float v : {-1e-45f, -0.1f, -1e30f, -std::numeric_limits<float>::infinity()}) {
    CHECK(quantise<std::uint8_t>(v) == 0);
    CHECK(quantise<std::uint16_t>(v) == 0);
  }
  for (const float v : {1.0000001f, 2.0f, 1e30f, std::numeric_limits<float>::infinity()}) {
    CHECK(quantise<std::uint8_t>(v) == 255);
    CHECK(quantise<std::uint16_t>(v) == 65535);
  }
}

TEST_CASE("quantising keeps the order") {
  CHECK(rc::check([] {
    Random random = any_random();
    const float a = random.uniform(), b = random.uniform();
    RC_ASSERT((quantise<std::uint8_t>(std::min(a, b)) <= quantise<std::uint8_t>(std::max(a, b))));
    RC_ASSERT((quantise<std::uint16_t>(std::min(a, b)) <= quantise<std::uint16_t>(std::max(a, b))));
  }));
}
