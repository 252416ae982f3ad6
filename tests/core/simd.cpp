// Lanes against the same function of one float, lane by lane.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <coppice/core/simd.hpp>
#include <limits>
#include <random>

using namespace coppice;

namespace {

using Array = std::array<float, Lanes::width>;

Array array_of(Lanes x) {
  Array all;
  x.store(all.data());
  return all;
}

Array random_array(std::mt19937& random, float low, float high) {
  Array all;
  for (float& x : all) x = std::uniform_real_distribution<float>(low, high)(random);
  return all;
}

/// The greatest relative error of f over the range, each lane against `exact` in double.
template <class F, class Exact>
double worst_error(float low, float high, F f, Exact exact) {
  std::mt19937 random(1);
  double worst = 0;
  for (int i = 0; i < 200000; ++i) {
    const Array x = random_array(random, low, high), y = array_of(f(Lanes::load(x.data())));
    for (std::size_t lane = 0; lane < Lanes::width; ++lane) {
      const double expected = exact(double(x[lane]));
      worst = std::max(worst, std::abs(double(y[lane]) - expected) / std::abs(expected));
    }
  }
  return worst;
}

template <class F>
void check_each_lane(F f) {
  std::mt19937 random(2);
  for (int i = 0; i < 100; ++i) {
    const Array a = random_array(random, -4, 4), b = random_array(random, 0.5f, 4);
    const Array result = array_of(f(Lanes::load(a.data()), Lanes::load(b.data())));
    for (std::size_t lane = 0; lane < Lanes::width; ++lane)
      CHECK(result[lane] == doctest::Approx(f(a[lane], b[lane])).epsilon(1e-6));
  }
}

}  // namespace

TEST_CASE("arithmetic and selection are those of one float in every lane") {
  check_each_lane([](auto a, auto b) { return a + b * a - b / (-a); });
  check_each_lane([](auto a, auto b) { return max(a, b) - min(a, b * b) + abs(a) * sqrt(b); });
  check_each_lane([](auto a, auto b) { return mul_add(a, b, a); });
  check_each_lane([](auto a, auto b) { return select(a < b, a, b) + select(a >= b, b * b, a); });
  check_each_lane([](auto a, auto b) { return select(a > b, a, -b) + select(a <= b, a * a, b); });
  check_each_lane([](auto a, auto b) { return select(a == a, a, b) * select(a != a, a, b); });
}

TEST_CASE("compound assignment is the operator") {
  Lanes x = 3.0f;
  x += 2.0f;
  x *= 4.0f;
  x -= 6.0f;
  x /= 7.0f;
  for (const float lane : array_of(x)) CHECK(lane == 2.0f);
}

TEST_CASE("masks combine lane by lane") {
  Array numbers;
  for (std::size_t lane = 0; lane < Lanes::width; ++lane) numbers[lane] = float(lane);
  const Lanes x = Lanes::load(numbers.data());
  CHECK(all(x >= 0.0f));
  CHECK(any(x == 0.0f));
  CHECK(all(x == 0.0f) == (Lanes::width == 1));
  CHECK_FALSE(any((x >= 0.0f) & (x < 0.0f)));
  CHECK(all((x > 0.0f) | (x == 0.0f)));
  CHECK_FALSE(any(!(x >= 0.0f)));
}

TEST_CASE("numbers on either side of an operator stand for all lanes") {
  check_each_lane([](auto a, auto b) { return 2.0f * a + (1.0f - b) / 3.0f - 4.0f * (a * 0.5f - 1.5f); });
  check_each_lane([](auto a, auto b) { return select(1.0f < a, a, b) + select(b >= 2.0f, b, a); });
}

TEST_CASE("NaN compares as in one float: unequal to itself, and in no order") {
  const Lanes nan = std::numeric_limits<float>::quiet_NaN();
  CHECK(all(nan != nan));
  CHECK(all(nan != Lanes(0.0f)));
  CHECK_FALSE(any(nan == nan));
  CHECK_FALSE(any((nan < 0.0f) | (nan <= 0.0f) | (nan > 0.0f) | (nan >= 0.0f)));
}

TEST_CASE("a mask and its bits are the same, and none are set beyond the lanes") {
  constexpr std::uint64_t every =
      Lanes::width == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << Lanes::width) - 1;
  std::mt19937_64 random(4);
  for (int i = 0; i < 100; ++i) {
    const std::uint64_t bits = random() & every;
    CHECK(bits_of(lane_mask(bits)) == bits);
    CHECK(bits_of(!lane_mask(bits)) == (~bits & every));
  }
  Array numbers;
  for (std::size_t lane = 0; lane < Lanes::width; ++lane) numbers[lane] = float(lane);
  for (std::size_t lane = 0; lane < Lanes::width; ++lane)
    CHECK(bits_of(Lanes::load(numbers.data()) == float(lane)) == std::uint64_t{1} << lane);
}

TEST_CASE("the first lanes are those below the count, at most all") {
  for (std::size_t count = 0; count < Lanes::width; ++count)
    CHECK(bits_of(first_lanes(count)) == (std::uint64_t{1} << count) - 1);
  for (const std::size_t count : {Lanes::width, Lanes::width + 1, std::size_t{1000}, std::size_t{1} << 20})
    CHECK(all(first_lanes(count)));
}

TEST_CASE("load and store take any alignment and touch nothing else") {
  std::array<float, Lanes::width + 3> from, to;
  for (std::size_t i = 0; i < from.size(); ++i) from[i] = float(i);
  to.fill(-1);
  Lanes::load(from.data() + 1).store(to.data() + 2);
  CHECK(to[0] == -1);
  CHECK(to[1] == -1);
  for (std::size_t i = 0; i < Lanes::width; ++i) CHECK(to[i + 2] == from[i + 1]);
  CHECK(to.back() == -1);
}

TEST_CASE("the sum of lanes is exact for integers and the same each time") {
  Array numbers;
  for (std::size_t lane = 0; lane < Lanes::width; ++lane) numbers[lane] = float(lane + 1);
  CHECK(sum_of_lanes(Lanes::load(numbers.data())) == float(Lanes::width * (Lanes::width + 1)) / 2);
  std::mt19937 random(3);
  const Array noise = random_array(random, -1, 1);
  CHECK(sum_of_lanes(Lanes::load(noise.data())) == sum_of_lanes(Lanes::load(noise.data())));
  CHECK(sum_of_lanes(2.5f) == 2.5f);
}

TEST_CASE("exp, log and log1p keep their stated errors") {
  const auto exponential = [](Lanes x) { return exp(x); };
  const auto logarithm = [](Lanes x) { return log(x); };
  const auto logarithm_of_one_plus = [](Lanes x) { return log1p(x); };
  CHECK(worst_error(-69, 88, exponential, [](double x) { return std::exp(x); }) < 1.2e-7);
  CHECK(worst_error(-1, 1, exponential, [](double x) { return std::exp(x); }) < 1.2e-7);
  for (const float high : {1e-30f, 1e-3f, 0.999f, 2.0f, 1e3f, 1e30f})
    CHECK(worst_error(high * 0.01f, high, logarithm, [](double x) { return std::log(x); }) < 1.2e-7);
  for (const float high : {-0.99999f, -1e-3f, 1e-30f, 1e-6f, 1e-3f, 2.0f, 1e6f})
    CHECK(worst_error(high * 0.01f, high, logarithm_of_one_plus, [](double x) { return std::log1p(x); }) <
          2.4e-7);
}

TEST_CASE("exp makes no denormals") {
  for (const float x : {-69.0f, -80.0f, -1e30f, -std::numeric_limits<float>::infinity()})
    for (const float lane : array_of(exp(Lanes(x)))) {
      CHECK(lane > 1.08e-30f);
      CHECK(lane < 1.081e-30f);
    }
}

TEST_CASE("pow_positive keeps its stated error and is 0 at 0") {
  for (const float n : {0.01f, 0.5f, 1.0f, 2.2f, 20.0f, 60.0f}) {
    CAPTURE(n);
    const float low = std::pow(1e-29f, 1 / std::max(n, 1.0f));
    const auto power = [n](Lanes x) { return pow_positive(x, Lanes(n)); };
    const auto exact = [n](double x) { return std::pow(x, double(n)); };
    const double allowed = 3e-7 * (1 + std::abs(n * std::log(low)));
    CHECK(worst_error(low, std::max(2 * low, 0.1f), power, exact) < allowed);
    CHECK(worst_error(std::max(low, 0.1f), 2, power, exact) < 3e-7 * (1 + n * std::log(10.0)));
    for (const float lane : array_of(pow_positive(Lanes(0.0f), Lanes(n)))) CHECK(lane == 0.0f);
    CHECK(pow_positive(0.0f, n) == 0.0f);
    CHECK(pow_positive(0.5f, n) == std::pow(0.5f, n));
  }
}
