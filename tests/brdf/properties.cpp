// What every BRDF promises: reciprocity, symmetry, and finite, non-negative values however extreme the input.
#include <doctest/doctest.h>
#include <rapidcheck.h>

#include <array>
#include <coppice/brdf/with_brdf.hpp>
#include <limits>
#include <random>
#include <vector>

#include "brdf/directions.hpp"

using namespace coppice;
using namespace brdf_test;

namespace {

/// A point seen from straight above with one of our BRDFs, its width at place s of the range (0 smooth, 1
/// rough).
ShadingPoint point_of(uint kind, double s, double anisotropy = 0) {
  ShadingPoint point{};
  point.normal = point.to_viewer = vec3(0, 0, 1);
  point.tangent = vec3(1, 0, 0);
  const vec3 half(0.5f);
  const float exponent = float(std::pow(10.0, 5 * (1 - s)));
  const float alpha = float(std::pow(10.0, -3 * (1 - s))), across = float(std::pow(alpha, 1 - anisotropy));
  if (kind == BRDF_LAMBERT) set_lambert(point, half);
  if (kind == BRDF_GGX) set_metallic_roughness(point, half, 0.5f, std::sqrt(alpha));
  if (kind == BRDF_PHONG) set_phong(point, half, half, exponent);
  if (kind == BRDF_BLINN_PHONG) set_blinn_phong(point, half, half, exponent);
  if (kind == BRDF_WARD) set_ward(point, half, half, alpha, across);
  return point;
}

vec3 evaluate(const ShadingPoint& point, const vec3& wi, const vec3& wo) {
  return with_brdf(point, [&](const auto& brdf) { return brdf.evaluate(wi, wo); });
}

constexpr std::array<uint, 5> kinds{BRDF_LAMBERT, BRDF_GGX, BRDF_PHONG, BRDF_BLINN_PHONG, BRDF_WARD};

/// Draws a unit direction above the horizon.
vec3 any_direction() {
  const int z = *rc::gen::inRange(10, 1001), azimuth = *rc::gen::inRange(0, 6284);
  return vec3(spherical(z * 1e-3, azimuth * 1e-3));
}

double any_place() { return *rc::gen::inRange(0, 101) * 0.01; }

}  // namespace

TEST_CASE("light and viewer may be exchanged") {
  CHECK(rc::check([] {
    const ShadingPoint point = point_of(*rc::gen::elementOf(kinds), any_place(), any_place());
    const vec3 wi = any_direction(), wo = any_direction();
    const float there = evaluate(point, wi, wo).x, back = evaluate(point, wo, wi).x;
    RC_ASSERT(std::abs(there - back) <= 2e-5f * there + 1e-6f);
  }));
}

TEST_CASE("isotropic BRDFs do not change when both directions turn about the normal") {
  CHECK(rc::check([] {
    const ShadingPoint point = point_of(*rc::gen::elementOf(kinds), any_place());
    const double z_i = *rc::gen::inRange(10, 1001) * 1e-3, z_o = *rc::gen::inRange(10, 1001) * 1e-3;
    const double between = *rc::gen::inRange(0, 6284) * 1e-3, turn = *rc::gen::inRange(0, 6284) * 1e-3;
    const float before = evaluate(point, vec3(spherical(z_i, between)), vec3(spherical(z_o, 0))).x;
    const float after = evaluate(point, vec3(spherical(z_i, between + turn)), vec3(spherical(z_o, turn))).x;
    // Both are evaluated at rounded directions, 1e-7 from the exact ones: a thousandth of the sharpest lobe.
    RC_ASSERT(std::abs(before - after) <= 2e-3f * before + 1e-6f);
  }));
}

TEST_CASE("Ward's lobe is anisotropic where its widths differ, and mirrored in the tangent") {
  const ShadingPoint point = [] {
    ShadingPoint p = point_of(BRDF_WARD, 0.5);
    set_ward(p, vec3(0), vec3(1), 0.4f, 0.1f);
    return p;
  }();
  const vec3 wo(0, 0, 1);
  const float along = evaluate(point, vec3(spherical(0.9, 0)), wo).x;
  const float across = evaluate(point, vec3(spherical(0.9, std::numbers::pi / 2)), wo).x;
  CHECK(along > 2 * across);
  CHECK(evaluate(point, vec3(spherical(0.9, 0.5)), wo).x ==
        doctest::Approx(evaluate(point, vec3(spherical(0.9, -0.5)), wo).x));
}

TEST_CASE("the lobes peak in the mirror direction at their known heights") {
  const vec3 straight(0, 0, 1);
  const SeenSurface white{straight, vec3(0), vec3(1), vec3(0)};
  const float alpha = 0.1f, exponent = 50;
  CHECK(Ggx(white, alpha).evaluate(straight, straight).x ==
        doctest::Approx(1 / (4 * std::numbers::pi * alpha * alpha)));
  CHECK(Ward(white, alpha, 2 * alpha).evaluate(straight, straight).x ==
        doctest::Approx(1 / (4 * std::numbers::pi * alpha * 2 * alpha)));
  CHECK(Phong(white, exponent).evaluate(straight, straight).x ==
        doctest::Approx((exponent + 2) / (2 * std::numbers::pi)));
  CHECK(BlinnPhong(white, exponent).evaluate(straight, straight).x ==
        doctest::Approx(52 * 54 / (8 * std::numbers::pi * 50)));
}

TEST_CASE("the lobes are the textbook's, written with normalised half vectors and mirror directions") {
  std::mt19937 random(7);
  const double ax = 0.5, ay = 0.3, exponent = 8;
  for (int i = 0; i < 200; ++i) {
    const vec3 wi = random_direction(random), wo = random_direction(random);
    const SeenSurface white{wo, vec3(0), vec3(1), vec3(0)};
    const dvec3 h = glm::normalize(dvec3(wi) + dvec3(wo));
    const double tangents = (h.x * h.x / (ax * ax) + h.y * h.y / (ay * ay)) / (h.z * h.z);
    const double ward = std::exp(-tangents) / (4 * std::numbers::pi * ax * ay) /
                        (std::pow(glm::dot(h, dvec3(wo)), 2) * std::pow(h.z, 4));
    const double mirror = glm::dot(dvec3(-wi.x, -wi.y, wi.z), dvec3(wo));
    const double phong = std::pow(std::max(0.0, mirror), exponent) * (exponent + 2) / (2 * std::numbers::pi);
    const double blinn = std::pow(h.z, exponent) * 10 * 12 / (8 * std::numbers::pi * (std::pow(2, -4) + 8));
    CHECK(std::abs(double(Ward(white, 0.5f, 0.3f).evaluate(wi, wo).x) - ward) <= 1e-5 * ward + 1e-12);
    CHECK(std::abs(double(Phong(white, 8).evaluate(wi, wo).x) - phong) <= 1e-5 * phong + 1e-7);
    CHECK(std::abs(double(BlinnPhong(white, 8).evaluate(wi, wo).x) - blinn) <= 1e-5 * blinn);
    CHECK((Phong(white, 1).evaluate(wi, wo).x == 0) == (mirror <= 0));
  }
}

TEST_CASE("values are finite and not negative at the extremes of direction and width") {
  std::vector<vec3> directions;
  for (const double z : {1.0, 0.5, 1e-2, 1e-4, 1e-7, 1e-30})
    for (const double azimuth : {0.0, 1.0, std::numbers::pi})
      directions.push_back(vec3(spherical(z, azimuth)));
  for (const uint kind : kinds)
    for (const double place : {0.0, 0.5, 1.0})
      for (const vec3& wo : directions)
        for (const vec3& wi : directions) {
          const vec3 value = evaluate(point_of(kind, place), wi, wo);
          CHECK(is_finite(value));
          CHECK(std::min({value.x, value.y, value.z}) >= 0);
        }
}

TEST_CASE("terms are exactly 0 below the horizon of the light or of the viewer") {
  std::mt19937 random(4);
  for (const uint kind : kinds)
    for (int i = 0; i < 300; ++i) {
      const vec3 above = random_direction(random), other = random_direction(random);
      const vec3 below(other.x, other.y, -other.z);
      for (const auto& [wi, wo] : {std::pair(below, above), std::pair(above, below), std::pair(below, other),
                                   std::pair(vec3(1, 0, 0), above), std::pair(-above, above)}) {
        const auto terms = brdf_terms(kind, 0.1f, 0.1f, wi.x, wi.y, wi.z, wo);
        CHECK(terms.diffuse == 0);
        CHECK(terms.specular == 0);
        CHECK(terms.fresnel == 0);
        CHECK(evaluate(point_of(kind, 0.5), wi, wo) == vec3(0));
      }
    }
}

TEST_CASE("terms that a BRDF does not count are 0") {
  std::mt19937 random(5);
  for (const uint kind : kinds) {
    const vec3 wi = random_direction(random), wo = random_direction(random);
    const auto terms = brdf_terms(kind, 0.5f, 0.5f, wi.x, wi.y, wi.z, wo);
    const int count = with_brdf(point_of(kind, 0.5), [](const auto& brdf) { return brdf.terms; });
    CHECK((terms.specular != 0) == (count > 1));
    CHECK((terms.fresnel != 0) == (count > 2));
  }
}
