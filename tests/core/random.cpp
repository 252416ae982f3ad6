// The generator against the published sequence, and its distributions against their moments.
#include <doctest/doctest.h>

#include <array>
#include <coppice/core/random.hpp>

using namespace coppice;

TEST_CASE("bits are SplitMix64's published sequence for seed 1234567") {
  Random random(1234567);
  for (const std::uint64_t expected : {6457827717110365317u, 3203168211198807973u, 9817491932198370423u,
                                       4593380528125082431u, 16408922859458223821u})
    CHECK(random.bits() == expected);
}

TEST_CASE("equal seeds repeat, others differ") {
  Random a(7), b(7), c(8);
  CHECK(a.bits() == b.bits());
  CHECK(a.bits() != c.bits());
}

TEST_CASE("uniform is at least 0 and below 1, with the mean and variance of the uniform distribution") {
  Random random(1);
  const int count = 100000;
  double sum = 0, squares = 0;
  bool inside = true;
  for (int i = 0; i < count; ++i) {
    const double u = random.uniform();
    inside = inside && u >= 0 && u < 1;
    sum += u;
    squares += (u - 0.5) * (u - 0.5);
  }
  CHECK(inside);
  CHECK(std::abs(sum / count - 0.5) < 0.004);
  CHECK(std::abs(squares / count - 1.0 / 12) < 0.002);
}

TEST_CASE("below reaches every number under its bound, evenly, and none above") {
  Random random(2);
  std::array<int, 7> hits{};
  for (int i = 0; i < 70000; ++i) {
    const std::uint32_t k = random.below(7);
    REQUIRE(k < 7);
    ++hits[k];
  }
  for (const int h : hits) CHECK(std::abs(h - 10000) < 400);
  CHECK(random.below(1) == 0);
  for (int i = 0; i < 1000; ++i) REQUIRE(random.below(~0u) < ~0u);
}

TEST_CASE("directions are unit and favour no axis") {
  Random random(3);
  const int count = 100000;
  glm::dvec3 sum(0), squares(0);
  double worst = 0;
  for (int i = 0; i < count; ++i) {
    const glm::dvec3 d(random.direction());
    worst = std::max(worst, std::abs(glm::length(d) - 1));
    sum += d;
    squares += d * d;
  }
  CHECK(worst < 4e-7);
  for (int axis = 0; axis < 3; ++axis) {
    CHECK(std::abs(sum[axis] / count) < 0.01);
    CHECK(std::abs(squares[axis] / count - 1.0 / 3) < 0.005);
  }
}
