// The stated errors of the forms of lobes: float and Lanes against long double at the same inputs.
#include <coppice/shared/lobe.h>
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <coppice/core/random.hpp>
#include <coppice/core/simd.hpp>
#include <coppice/reference/lobe.hpp>
#include <vector>

using namespace coppice;
using real = long double;
using rvec3 = glm::vec<3, real>;

namespace {

/// -1 to 1e6: both ends, 0, steps of 1/8 below 2 and of a tenth of a decade from 1e-3 on.
std::vector<float> exponents() {
  std::vector<float> all{-1, -0.9999999f, -0.5f, -1e-3f, 0, 1e-6f, 1e6f};
  for (int i = -8; i < 16; ++i) all.push_back(float(i) / 8);
  for (int i = -30; i < 60; ++i) all.push_back(float(std::pow(10.0, i / 10.0)));
  return all;
}

vec3 turned(const vec3& direction, float angle, Random& random) {
  vec3 u, v;
  make_frame(direction, u, v);
  const float turn = 2 * pi * random.uniform();
  return normalize(direction * std::cos(angle) + (u * std::cos(turn) + v * std::sin(turn)) * std::sin(angle));
}

/// Pairs of unit directions: equal, 1e-6 to 1e-1 apart, at a right angle, opposite to 1e-3, and random.
std::vector<std::array<vec3, 2>> pairs_of_directions() {
  Random random(3);
  std::vector<std::array<vec3, 2>> pairs;
  for (int i = 0; i < 12; ++i) {
    const vec3 a = normalize(random.direction());
    for (const float angle : {0.0f, 1e-6f, 1e-4f, 1e-2f, 0.1f, 0.5f * pi, pi - 1e-3f, pi})
      pairs.push_back({a, turned(a, angle, random)});
    pairs.push_back({a, -a});
    pairs.push_back({a, normalize(random.direction())});
  }
  return pairs;
}

struct Mean {
  rvec3 direction;
  real shortfall;  ///< 1 - its length
};

/// The mean of two lobes' directions, as unit as long double can tell; its shortfall without cancellation.
Mean exact_sum(const LobeShape& a, real wa, const LobeShape& b, real wb) {
  const rvec3 da = glm::normalize(rvec3(a.direction)), db = glm::normalize(rvec3(b.direction));
  const real qa = 1 / (real(a.exponent) + 2), qb = 1 / (real(b.exponent) + 2);
  const real ra = wa * (1 - qa), rb = wb * (1 - qb), below = wa * qa + wb * qb;
  const rvec3 mean = ra * da + rb * db;
  const real squared = below * (2 - below) + ra * rb * glm::dot(da - db, da - db);
  return {mean, squared / (1 + glm::length(mean))};
}

real off(real value, real exact) { return std::abs(value / exact - 1); }

float first(Lanes x) {
  std::array<float, Lanes::width> all;
  x.store(all.data());
  return all[0];
}

/// Calls f(a, wa, b, wb) over the domain of lobe_sum.
template <class F>
void for_each_sum(F f) {
  const auto all = exponents();
  for (const auto& [da, db] : pairs_of_directions())
    for (std::size_t i = 0; i < all.size(); i += 3)
      for (std::size_t j = 1; j < all.size(); j += 5)
        for (const float wa : {0.0f, 1e-6f, 0.1f, 0.5f, 0.7f, 1 - 1e-6f, 1.0f})
          f(LobeShape{da, all[i]}, wa, LobeShape{db, all[j]}, 1 - wa);
}

bool is_sound(const LobeShape& lobe) {
  return is_finite(lobe.direction) && std::isfinite(lobe.exponent) && lobe.exponent >= -1;
}

}  // namespace

TEST_CASE("a lobe's exponent and its shortfall keep their stated errors, both ways") {
  for (const float k : exponents()) {
    const real exact = 1 / (real(k) + 2);
    CHECK(off(lobe_shortfall(k), exact) <= 1.2e-7L);
    CHECK(off(real(lobe_exponent(float(exact))) + 2, 1 / real(float(exact))) <= 1.2e-7L);
  }
  CHECK(lobe_shortfall(-1) == 1);
  CHECK(lobe_exponent(1) == -1);
  CHECK(lobe_exponent(lobe_shortfall(0)) == 0);
}

TEST_CASE("the sum of two lobes has their mean direction and its length, to the stated error") {
  real worst = 0, worst_direction = 0;
  for_each_sum([&](const LobeShape& a, float wa, const LobeShape& b, float wb) {
    const LobeShape sum = lobe_sum(a, wa, b, wb);
    const Mean exact = exact_sum(a, wa, b, wb);
    REQUIRE(is_sound(sum));
    worst = std::max(worst, off(real(sum.exponent) + 2, 1 / exact.shortfall));
    // What is left of lobes that cancel has the direction of rounding.
    const real length = glm::length(exact.direction);
    const real turned = glm::length(rvec3(sum.direction) * length - exact.direction);
    if (length > 1e-9L) worst_direction = std::max(worst_direction, turned);
  });
  CAPTURE(worst);
  CAPTURE(worst_direction);
  CHECK(worst <= 1e-6L);
  CHECK(worst > 1e-8L);
  CHECK(worst_direction <= 3e-7L);
}

TEST_CASE("a lobe and itself are itself, a share of 0 leaves the other, and opposite lobes cancel") {
  Random random(4);
  for (const float k : exponents()) {
    const LobeShape lobe{normalize(random.direction()), k}, other{normalize(random.direction()), 7};
    for (const LobeShape& same :
         {lobe_sum(lobe, 0.25f, lobe, 0.75f), lobe_sum(lobe, 1, other, 0), lobe_sum(other, 0, lobe, 1)}) {
      CHECK(off(real(same.exponent) + 2, real(k) + 2) <= 5e-7L);
      if (k > -1) CHECK(length(same.direction - lobe.direction) <= 3e-7f);
    }
    const LobeShape opposite{-lobe.direction, k};
    const LobeShape none = lobe_sum(lobe, 0.5f, opposite, 0.5f);
    CHECK(none.exponent == doctest::Approx(-1).epsilon(1e-6));
    CHECK(none.direction == lobe.direction);
  }
}

TEST_CASE("lobes without a direction, and of no width at all, make no NaN") {
  const LobeShape dark{vec3(0), 0}, lobe{vec3(0, 0, 1), 20}, mirror{vec3(0, 0, 1), INFINITY};
  for (const auto& a : {dark, lobe, mirror})
    for (const auto& b : {dark, lobe, mirror})
      for (const float wa : {0.0f, 0.5f, 1.0f}) CHECK(is_sound(lobe_sum(a, wa, b, 1 - wa)));
  CHECK(lobe_sum(dark, 0, lobe, 1).exponent == doctest::Approx(20));
  CHECK(lobe_sum(mirror, 0.5f, mirror, 0.5f).exponent == doctest::Approx(1e7).epsilon(1e-3));
}

TEST_CASE("a thousand lobes summed in any order have the mean of all") {
  Random random(5);
  struct Part {
    LobeShape lobe;
    float energy;
  };
  for (const float scatter : {1e-3f, 0.03f, 0.3f, 3.0f}) {
    std::vector<Part> parts;
    std::vector<reference::Lobe> all;
    for (int i = 0; i < 1000; ++i) {
      const vec3 d = normalize(vec3(0.6f, 0, 0.8f) + scatter * random.direction());
      const Part part{{d, std::pow(10.0f, 7 * random.uniform() - 1) - 1}, random.uniform()};
      parts.push_back(part);
      all.push_back({glm::normalize(glm::dvec3(d)), double(part.lobe.exponent), double(part.energy)});
    }
    while (parts.size() > 1) {  // two at random
      const std::size_t i = random.below(std::uint32_t(parts.size()));
      std::swap(parts[i], parts.back());
      const Part b = parts.back();
      parts.pop_back();
      Part& a = parts[random.below(std::uint32_t(parts.size()))];
      const float energy = a.energy + b.energy;
      a = {lobe_sum(a.lobe, a.energy / energy, b.lobe, b.energy / energy), energy};
    }
    const glm::dvec3 mean = reference::mean_direction(all);
    const double shortfall = 1 - glm::length(mean);
    CAPTURE(scatter);
    CHECK(off(real(parts[0].lobe.exponent) + 2, real(1 / shortfall)) <= 1e-5L);
    CHECK(glm::length(glm::dvec3(parts[0].lobe.direction) - glm::normalize(mean)) <= 2e-6);
  }
}

TEST_CASE("a widened lobe keeps its stated error") {
  for (const float k : exponents()) {
    if (k < 0) continue;
    for (const float variance : {0.0f, 1e-7f, 1e-4f, 0.1f, 1.0f, 30.0f, 1e6f}) {
      const real exact = real(k) / (1 + real(k) * real(variance));
      CHECK(std::abs(real(lobe_widened(k, variance)) - exact) <= 2e-7L * exact);
      CHECK(std::abs(real(first(lobe_widened(Lanes(k), Lanes(variance)))) - exact) <= 2e-7L * exact);
    }
    CHECK(lobe_widened(k, 0.0f) == k);
  }
}

TEST_CASE("a lobe shines as itself from exponent 1 on, below as something between") {
  for (const float k : exponents()) {
    const float shining = lobe_shining(k);
    CHECK(shining == first(lobe_shining(Lanes(k))));
    CHECK(shining >= std::max(k, 0.0f));
    CHECK((k < 1 || shining == k));
  }
}

TEST_CASE("the variance of directions rises from 0 without end, and stays a number") {
  for (const float shortfall : {0.0f, 1e-7f, 1e-3f, 0.5f, 0.9f, 1 - 1e-3f}) {
    const real exact = real(shortfall) / (1 - real(shortfall));
    CHECK(std::abs(real(lobe_variance(shortfall)) - exact) <= 2e-7L * exact);
  }
  for (const float k : exponents())
    if (k >= 0) CHECK(lobe_widened(k, lobe_variance(1)) <= 1e-6f);
}

TEST_CASE("the power of a lobe keeps its stated error, to the edge of its half of the sphere") {
  real worst = 0, worst_below = 0;
  for (const float k : exponents())
    for (int i = 0; i <= 400; ++i) {
      if (k < 0) continue;
      const float drop = i == 400 ? 0.99999994f : float(std::pow(10.0, -8 + i / 50.0));
      const real exact = drop < 1 ? std::exp(real(k) * std::log1p(-real(drop))) : 0;
      for (const float power : {lobe_power(drop, k), first(lobe_power(Lanes(drop), Lanes(k)))}) {
        REQUIRE(std::isfinite(power));
        if (exact >= 1e-3L)
          worst = std::max(worst, off(power, exact));
        else
          worst_below = std::max(worst_below, std::abs(power - exact));
      }
    }
  CAPTURE(worst);
  CAPTURE(worst_below);
  CHECK(worst <= 2e-6L);
  CHECK(worst > 1e-8L);
  CHECK(worst_below <= 2e-9L);
}

TEST_CASE("a lobe shines in the middle as 1 and nothing beyond a quarter turn, even at exponent 0") {
  for (const float k : exponents()) {
    if (k < 0) continue;
    CHECK(lobe_power(0.0f, k) == 1);
    for (const float drop : {1.0f, 1.5f, 2.0f}) {
      CHECK(lobe_power(drop, k) == 0);
      CHECK(first(lobe_power(Lanes(drop), Lanes(k))) == 0);
    }
  }
  CHECK(lobe_power(0.999f, 0.0f) == 1);
}
