// From materials to shading points to BRDFs, for one light and for a register of lights.
#include <doctest/doctest.h>

#include <array>
#include <coppice/brdf/with_brdf.hpp>
#include <coppice/core/simd.hpp>
#include <random>

#include "brdf/directions.hpp"

using namespace coppice;
using namespace brdf_test;

namespace {

using Array = std::array<float, Lanes::width>;

ShadingPoint tilted_point() {
  ShadingPoint point{};
  vec3 bitangent;
  point.normal = normalize(vec3(1, -2, 3));
  make_frame(point.normal, point.tangent, bitangent);
  point.to_viewer = normalize(point.normal + 0.7f * point.tangent - 0.4f * bitangent);
  return point;
}

void check_lane(float lane, float expected) { CHECK(std::abs(lane - expected) <= 2e-5f * expected + 1e-12f); }

template <class B>
void check_lanes_equal_float(const B& brdf) {
  std::mt19937 random(6);
  for (int i = 0; i < 50; ++i) {
    Array x, y, z, diffuse, specular, fresnel;
    for (std::size_t lane = 0; lane < Lanes::width; ++lane) {
      const vec3 near_mirror(-brdf.viewer.x, -brdf.viewer.y, brdf.viewer.z);
      const vec3 wi = normalize(random_direction(random) * float(i % 5) * 0.02f + near_mirror);
      x[lane] = wi.x, y[lane] = wi.y, z[lane] = lane % 4 == 3 ? -wi.z : wi.z;
    }
    const auto terms = brdf(Lanes::load(x.data()), Lanes::load(y.data()), Lanes::load(z.data()));
    terms.diffuse.store(diffuse.data());
    terms.specular.store(specular.data());
    terms.fresnel.store(fresnel.data());
    for (std::size_t lane = 0; lane < Lanes::width; ++lane) {
      const auto expected = brdf(x[lane], y[lane], z[lane]);
      check_lane(diffuse[lane], expected.diffuse);
      check_lane(specular[lane], expected.specular);
      CHECK(std::abs(fresnel[lane] - expected.fresnel) <= 2e-6f * (expected.fresnel + expected.specular));
    }
  }
}

}  // namespace

TEST_CASE("a register of lights gets the terms of each light") {
  ShadingPoint point = tilted_point();
  const auto check = [&] { with_brdf(point, [](const auto& brdf) { check_lanes_equal_float(brdf); }); };
  set_lambert(point, vec3(1));
  check();
  for (const float roughness : {0.0f, 0.2f, 1.0f}) {
    set_metallic_roughness(point, vec3(1), 0.5f, roughness);
    check();
    set_ward(point, vec3(0.5f), vec3(0.5f), roughness, 0.5f);
    check();
  }
  for (const float exponent : {1.0f, 50.0f, 1e5f}) {
    set_phong(point, vec3(0.5f), vec3(0.5f), exponent);
    check();
    set_blinn_phong(point, vec3(0.5f), vec3(0.5f), exponent);
    check();
  }
}

TEST_CASE("with_brdf gives what the switch of the shaders gives") {
  ShadingPoint point = tilted_point();
  const vec3 wi = vec3(spherical(0.8, 2));
  const vec3 wo = brdf_viewer_to_local(point.normal, point.tangent, point.to_viewer);
  const auto check = [&](uint kind) {
    CHECK(point.brdf == kind);
    const auto expected = brdf_terms(kind, point.alpha_x, point.alpha_y, wi.x, wi.y, wi.z, wo);
    const auto terms = with_brdf(point, [&](const auto& brdf) { return brdf(wi.x, wi.y, wi.z); });
    CHECK(terms.diffuse == expected.diffuse);
    CHECK(terms.specular == expected.specular);
    CHECK(terms.fresnel == expected.fresnel);
  };
  set_lambert(point, vec3(1));
  check(BRDF_LAMBERT);
  set_metallic_roughness(point, vec3(1), 0.5f, 0.4f);
  check(BRDF_GGX);
  set_phong(point, vec3(0.5f), vec3(0.5f), 30);
  check(BRDF_PHONG);
  set_blinn_phong(point, vec3(0.5f), vec3(0.5f), 30);
  check(BRDF_BLINN_PHONG);
  set_ward(point, vec3(0.5f), vec3(0.5f), 0.2f, 0.3f);
  check(BRDF_WARD);
}

TEST_CASE("metallic-roughness is the material of glTF's appendix B, channel by channel") {
  ShadingPoint point = tilted_point();
  const vec3 base(0.9f, 0.5f, 0.1f), wi = vec3(spherical(0.6, 1)), wo = vec3(spherical(0.4, 3));
  const float metallic = 0.3f, roughness = 0.5f, alpha = roughness * roughness;
  set_metallic_roughness(point, base, metallic, roughness);
  const dvec3 h = glm::normalize(dvec3(wi) + dvec3(wo));
  const double a2 = double(alpha) * alpha, c2 = h.z * h.z;
  const double d = a2 / (std::numbers::pi * std::pow(c2 * (a2 - 1) + 1, 2));
  const auto smith = [&](double z) { return std::sqrt(a2 + (1 - a2) * z * z); };
  const double v = 0.5 / (wi.z * smith(wo.z) + wo.z * smith(wi.z));
  const vec3 value = Ggx(point).evaluate(wi, wo);
  for (int channel = 0; channel < 3; ++channel) {
    const double f0 = 0.04 * (1 - metallic) + double(base[channel]) * metallic;
    const double f = f0 + (1 - f0) * std::pow(1 - glm::dot(h, dvec3(wo)), 5);
    const double expected = (1 - f) * double(base[channel]) * (1 - metallic) / std::numbers::pi + f * d * v;
    CHECK(double(value[channel]) == doctest::Approx(expected).epsilon(1e-5));
  }
}

TEST_CASE("parameters are kept where the closed forms hold") {
  ShadingPoint point = tilted_point();
  set_metallic_roughness(point, vec3(1), 0, 0);
  CHECK(point.alpha_x == BRDF_MIN_ALPHA);
  set_ward(point, vec3(0), vec3(1), 0, 3);
  CHECK(point.alpha_x == BRDF_MIN_ALPHA);
  CHECK(point.alpha_y == 1);
  set_phong(point, vec3(0), vec3(1), 1e9f);
  CHECK(point.alpha_x == BRDF_MAX_EXPONENT);
  set_blinn_phong(point, vec3(0), vec3(1), 0);
  CHECK(point.alpha_x == 1);
}

TEST_CASE("the BRDF of a point sees the viewer in the point's frame, and has its colours") {
  ShadingPoint point = tilted_point();
  set_lambert(point, vec3(0.2f, 0.4f, 0.8f));
  const Lambert lambert(point);
  CHECK(double(lambert.viewer.z) == doctest::Approx(double(dot(point.to_viewer, point.normal))));
  CHECK(double(lambert.viewer.x) == doctest::Approx(double(dot(point.to_viewer, point.tangent))));
  const vec3 colour = lambert.colour(lambert(0.6f, 0.0f, 0.8f)) * pi;
  CHECK(length(colour - 0.8f * vec3(0.2f, 0.4f, 0.8f)) < 1e-6f);
}
