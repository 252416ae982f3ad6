// The stated errors of the BRDFs' closed forms: float and Lanes against long double at the same inputs.
#include <coppice/shared/brdf.h>
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <coppice/core/simd.hpp>
#include <random>
#include <vector>

using namespace coppice;

namespace {

struct Pair {
  vec3 wi, wo;
};

vec3 direction(double z, double azimuth) {
  const double r = std::sqrt(std::max(0.0, 1 - z * z));
  return vec3(float(r * std::cos(azimuth)), float(r * std::sin(azimuth)), float(z));
}

/// The mirror image of v about the half vector tilted from the normal by atan(tilt); below the horizon at
/// times.
vec3 mirrored(const glm::dvec3& v, double tilt, double azimuth) {
  const auto h = glm::normalize(glm::dvec3(tilt * std::cos(azimuth), tilt * std::sin(azimuth), 1.0));
  return vec3(glm::normalize(2 * glm::dot(v, h) * h - v));
}

/// Viewers down to z = 1e-4 and, for each, lights anywhere down to z = 1e-6, within the lobes of every width
/// in the domain, exactly in the mirror direction, and at the viewer.
std::vector<Pair> directions_of_the_domain() {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  const auto azimuth = [&] { return 2 * std::numbers::pi * unit(random); };
  std::vector<Pair> pairs;
  for (int i = 0; i < 3000; ++i) {
    const double z = i % 2 ? std::pow(10.0, -4 * unit(random)) : unit(random);
    const vec3 wo = direction(std::max(1.001e-4, z), azimuth());
    std::vector<vec3> lights{vec3(-wo.x, -wo.y, wo.z), wo, direction(unit(random), azimuth()),
                             direction(std::pow(10.0, -6 * unit(random)), azimuth())};
    for (int j = 0; j < 4; ++j)
      lights.push_back(mirrored(wo, std::pow(10.0, -5 + 6 * unit(random)), azimuth()));
    for (const vec3& wi : lights)
      if (wi.z > 0) pairs.push_back({wi, wo});
  }
  return pairs;
}

float first(float x) { return x; }
float first(Lanes x) {
  std::array<float, Lanes::width> all;
  x.store(all.data());
  return all[0];
}

struct Worst {
  double diffuse = 0;  ///< relative to cos/π
  double lobe = 0;     ///< of specular and fresnel, relative to their sum, where that is at least `floor`
  double below = 0;    ///< absolute, elsewhere
};

void raise(double& worst, long double error) {
  worst = std::isnan(error) ? INFINITY : std::max(worst, double(std::abs(error)));
}

template <class REAL, class Form>
Worst worst_error(const Form& form, double floor) {
  static const std::vector<Pair> pairs = directions_of_the_domain();
  const auto terms_of = [&]<class R>(const Pair& pair, R) {
    return form(R(pair.wi.x), R(pair.wi.y), R(pair.wi.z), pair.wo);
  };
  Worst worst;
  for (const Pair& pair : pairs) {
    const auto exact = terms_of(pair, 0.0L);
    const auto terms = terms_of(pair, REAL(0.0f));
    const long double sum = exact.specular + exact.fresnel;
    const long double specular = first(terms.specular) - exact.specular;
    const long double fresnel = first(terms.fresnel) - exact.fresnel;
    const long double error = std::max(std::abs(specular), std::abs(fresnel));
    raise(worst.diffuse,
          (first(terms.diffuse) - exact.diffuse) * std::numbers::pi_v<long double> / pair.wi.z);
    raise(sum >= floor ? worst.lobe : worst.below, sum >= floor ? error / sum : error);
  }
  return worst;
}

struct Limit {
  double diffuse, lobe, floor, below;
};

template <class Form>
void check_errors(const Form& form, const Limit& limit) {
  for (const Worst& worst : {worst_error<float>(form, limit.floor), worst_error<Lanes>(form, limit.floor)}) {
    CHECK(worst.diffuse <= limit.diffuse);
    CHECK(worst.lobe <= limit.lobe);
    CHECK(worst.below <= limit.below);
  }
}

constexpr float alphas[] = {1e-3f, 3e-3f, 1e-2f, 0.1f, 0.5f, 1};
constexpr float exponents[] = {1, 2, 5, 20, 100, 1e3f, 1e4f, 1e5f};

}  // namespace

TEST_CASE("Lambert keeps its stated error") {
  check_errors([](auto, auto, auto z, vec3 wo) { return brdf_lambert(z, wo); }, {1.2e-7, 0, 1, 0});
}

TEST_CASE("GGX keeps its stated error from alpha 1e-3 to 1") {
  for (const float alpha : alphas) {
    CAPTURE(alpha);
    check_errors([&](auto x, auto y, auto z, vec3 wo) { return brdf_ggx(x, y, z, wo, alpha); },
                 {3e-7, 1e-6, 1e-25, 1e-30});
  }
}

TEST_CASE("Phong keeps its stated error from exponent 1 to 1e5") {
  for (const float exponent : exponents) {
    CAPTURE(exponent);
    check_errors([&](auto x, auto y, auto z, vec3 wo) { return brdf_phong(x, y, z, wo, exponent); },
                 {1.2e-7, 5e-5, 1e-3, 5e-8});
  }
}

TEST_CASE("Blinn-Phong keeps its stated error from exponent 1 to 1e5") {
  for (const float exponent : exponents) {
    CAPTURE(exponent);
    check_errors([&](auto x, auto y, auto z, vec3 wo) { return brdf_blinn_phong(x, y, z, wo, exponent); },
                 {1.2e-7, 3e-5, 1e-25, 1e-25});
  }
}

TEST_CASE("Ward keeps its stated error from alpha 1e-3 to 1, isotropic and not") {
  for (const float alpha_x : alphas)
    for (const float alpha_y : alphas) {
      CAPTURE(alpha_x);
      CAPTURE(alpha_y);
      check_errors([&](auto x, auto y, auto z, vec3 wo) { return brdf_ward(x, y, z, wo, alpha_x, alpha_y); },
                   {1.2e-7, 3e-5, 1e-10, 1e-12});
    }
}

TEST_CASE("the switch gives the terms of each kind") {
  const vec3 wi = direction(0.8, 1), wo = direction(0.6, 3.5);
  const auto same = [&](uint kind, const BrdfTerms<float>& expected) {
    const auto terms = brdf_terms(kind, 0.3f, 0.7f, wi.x, wi.y, wi.z, wo);
    CHECK(terms.diffuse == expected.diffuse);
    CHECK(terms.specular == expected.specular);
    CHECK(terms.fresnel == expected.fresnel);
  };
  same(BRDF_LAMBERT, brdf_lambert(wi.z, wo));
  same(BRDF_GGX, brdf_ggx(wi.x, wi.y, wi.z, wo, 0.3f));
  same(BRDF_PHONG, brdf_phong(wi.x, wi.y, wi.z, wo, 0.3f));
  same(BRDF_BLINN_PHONG, brdf_blinn_phong(wi.x, wi.y, wi.z, wo, 0.3f));
  same(BRDF_WARD, brdf_ward(wi.x, wi.y, wi.z, wo, 0.3f, 0.7f));
}

TEST_CASE(
    "the local frame is right-handed about the normal, and a viewer behind it is lifted above the horizon") {
  const vec3 normal = normalize(vec3(1, 2, -2));
  vec3 tangent, bitangent;
  make_frame(normal, tangent, bitangent);
  const vec3 local(0.48f, 0.6f, 0.64f);
  const vec3 world = tangent * local.x + bitangent * local.y + normal * local.z;
  CHECK(length(brdf_to_local(normal, tangent, world) - local) < 1e-6f);
  CHECK(length(brdf_viewer_to_local(normal, tangent, world) - local) < 1e-6f);
  const vec3 lifted = brdf_viewer_to_local(normal, tangent, tangent * 0.8f - normal * 0.6f);
  CHECK(lifted.z >= BRDF_MIN_COSINE);
  CHECK(length(lifted) == doctest::Approx(1));
}
