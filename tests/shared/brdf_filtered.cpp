// The stated errors of the BRDFs' means over clusters: float and Lanes against long double at the same
// inputs.
#include <coppice/shared/brdf_filtered.h>
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <coppice/core/simd.hpp>
#include <random>
#include <vector>

#include "brdf/directions.hpp"

using namespace coppice;
using brdf_test::spherical;

namespace {

/// A cluster and a viewer; `spread` is 1 - mean length.
struct Sample {
  vec3 wi, wo;
  float spread;
};

/// The mirror image of v about a half vector tilted from the normal by atan(tilt); below the horizon at
/// times.
vec3 mirrored(const vec3& v, double tilt, double azimuth) {
  const glm::dvec3 viewer(v);
  const auto h = glm::normalize(glm::dvec3(tilt * std::cos(azimuth), tilt * std::sin(azimuth), 1.0));
  return vec3(glm::normalize(2 * glm::dot(viewer, h) * h - viewer));
}

/// Viewers down to z = 1e-4 and, for each, clusters down to z = 1e-6, within the lobes of every width,
/// exactly in the mirror direction, and at the viewer; each as one light, as the widest cluster, and between.
std::vector<Sample> samples_of_the_domain() {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> unit(0, 1);
  const auto azimuth = [&] { return 2 * std::numbers::pi * unit(random); };
  std::vector<Sample> samples;
  for (int i = 0; i < 600; ++i) {
    const double z = i % 2 ? std::pow(10.0, -4 * unit(random)) : unit(random);
    const vec3 wo(spherical(i < 10 ? BRDF_MIN_COSINE : std::max(1.001e-4, z), azimuth()));
    std::vector<vec3> lights{vec3(-wo.x, -wo.y, wo.z), wo, vec3(spherical(unit(random), azimuth())),
                             vec3(spherical(std::pow(10.0, -6 * unit(random)), azimuth()))};
    for (int j = 0; j < 3; ++j)
      lights.push_back(mirrored(wo, std::pow(10.0, -5 + 6 * unit(random)), azimuth()));
    for (const vec3& wi : lights)
      for (const float spread : {0.0f, 1e-7f, float(std::pow(10.0, -7 * unit(random))), float(unit(random)),
                                 1 - float(std::pow(10.0, -7 * unit(random))), 1.0f})
        if (wi.z > 0) samples.push_back({wi, wo, spread});
  }
  return samples;
}

const std::vector<Sample>& domain() {
  static const std::vector<Sample> samples = samples_of_the_domain();
  return samples;
}

float first(float x) { return x; }
float first(Lanes x) {
  std::array<float, Lanes::width> all;
  x.store(all.data());
  return all[0];
}

/// form(x, y, z, spread, wo) of a sample, all in R.
template <class R, class Form>
FilteredTerms<R> terms_of(const Form& form, const Sample& sample) {
  return form(R(sample.wi.x), R(sample.wi.y), R(sample.wi.z), light_spread(R(sample.spread)), sample.wo);
}

struct Errors {
  double diffuse = 0;  ///< relative to cos/π
  double lobe = 0;     ///< of specular and fresnel, relative to their sum, where that is at least the floor
  double below = 0;    ///< absolute, elsewhere
  double growth = 0;   ///< relative
};

void raise(double& worst, long double error) {
  worst = std::isnan(error) ? INFINITY : std::max(worst, double(std::abs(error)));
}

using Predicate = bool (*)(const Sample&);

bool any_sample(const Sample&) { return true; }

/// Not on the edge of a Phong lobe, 90° from the mirror direction, which is a step once it is widened enough.
bool off_the_edge(const Sample& sample) {
  const glm::dvec3 mirror(-sample.wi.x, -sample.wi.y, sample.wi.z);
  return std::abs(glm::dot(mirror, glm::dvec3(sample.wo))) >= 0.01;
}

template <class REAL, class Form>
Errors worst_errors(const Form& form, double floor, Predicate counts) {
  Errors worst;
  for (const Sample& sample : domain()) {
    if (!counts(sample)) continue;
    const auto exact = terms_of<long double>(form, sample);
    const auto terms = terms_of<REAL>(form, sample);
    const long double sum = exact.specular + exact.fresnel;
    const long double specular = first(terms.specular) - exact.specular;
    const long double fresnel = first(terms.fresnel) - exact.fresnel;
    const long double error = std::max(std::abs(specular), std::abs(fresnel));
    raise(worst.diffuse,
          (first(terms.diffuse) - exact.diffuse) * std::numbers::pi_v<long double> / sample.wi.z);
    raise(sum >= floor ? worst.lobe : worst.below, sum >= floor ? error / sum : error);
    if (exact.growth > 0) raise(worst.growth, first(terms.growth) / exact.growth - 1);
  }
  return worst;
}

struct Limit {
  double diffuse, lobe, floor, below, growth;
};

template <class Form>
void check_errors(const Form& form, const Limit& limit, Predicate counts = any_sample) {
  for (const Errors& worst :
       {worst_errors<float>(form, limit.floor, counts), worst_errors<Lanes>(form, limit.floor, counts)}) {
    CHECK(worst.diffuse <= limit.diffuse);
    CHECK(worst.lobe <= limit.lobe);
    CHECK(worst.below <= limit.below);
    CHECK(worst.growth <= limit.growth);
  }
}

constexpr float alphas[] = {1e-3f, 3e-3f, 1e-2f, 0.1f, 0.5f, 1};
constexpr float exponents[] = {1, 2, 5, 20, 100, 1e3f, 1e4f, 1e5f};

struct Kind {
  uint brdf;
  float alpha_x, alpha_y;
};

std::vector<Kind> all_kinds() {
  std::vector<Kind> kinds{{BRDF_LAMBERT, 1, 1}};
  for (const float alpha : alphas) {
    kinds.push_back({BRDF_GGX, alpha, alpha});
    kinds.push_back({BRDF_WARD, alpha, alpha});
    kinds.push_back({BRDF_WARD, alpha, 1});
  }
  for (const float exponent : exponents)
    for (const uint brdf : {BRDF_PHONG, BRDF_BLINN_PHONG}) kinds.push_back({brdf, exponent, exponent});
  return kinds;
}

FilteredTerms<float> filtered(const Kind& kind, const Sample& sample) {
  return brdf_filtered_terms(kind.brdf, kind.alpha_x, kind.alpha_y, sample.wi.x, sample.wi.y, sample.wi.z,
                             light_spread(sample.spread), sample.wo);
}

bool is_sound(float x) { return std::isfinite(x) && x >= 0; }

bool is_sound(const FilteredTerms<float>& terms) {
  return is_sound(terms.diffuse) && is_sound(terms.specular) && is_sound(terms.fresnel) &&
         is_sound(terms.growth);
}

/// Within 2e-6 of `whole`: what compilers differ by, who contract the two forms as they see fit. Far out in a
/// lobe an exponential makes more of that.
bool is_near(float a, float b, float whole) { return std::abs(a - b) <= 2e-6f * whole + 1e-9f; }

}  // namespace

TEST_CASE("the spread of a cluster keeps its digits from one light to light from all sides") {
  for (const Sample& sample : domain()) {
    const auto spread = light_spread(sample.spread);
    const auto exact = light_spread((long double)(sample.spread));
    CHECK(std::abs(spread.mean_length - exact.mean_length) <= 6e-8L);
    CHECK(std::abs(spread.widening - exact.widening) <= 2e-7L * exact.widening);
  }
  CHECK(light_spread(0.0f).mean_length == 1);
  CHECK(light_spread(0.0f).widening == 0);
  CHECK(light_spread(1.0f).widening == doctest::Approx(1e4));
}

TEST_CASE("filtered Lambert keeps its stated error") {
  check_errors([](auto, auto, auto z, const auto& spread,
                  const vec3& wo) { return brdf_lambert_filtered(z, spread, wo); },
               {2e-7, 0, 1, 0, 0});
}

TEST_CASE("filtered GGX keeps its stated error from alpha 1e-3 to 1") {
  for (const float alpha : alphas) {
    CAPTURE(alpha);
    check_errors([&](auto x, auto y, auto z, const auto& spread,
                     const vec3& wo) { return brdf_ggx_filtered(x, y, z, spread, wo, alpha); },
                 {3e-7, 1e-6, 1e-25, 1e-30, 5e-7});
  }
}

TEST_CASE("filtered Phong keeps its stated error from exponent 1 to 1e5") {
  for (const float exponent : exponents) {
    CAPTURE(exponent);
    check_errors([&](auto x, auto y, auto z, const auto& spread,
                     const vec3& wo) { return brdf_phong_filtered(x, y, z, spread, wo, exponent); },
                 {2e-7, 2e-5, 1e-3, 2e-8, 2e-7}, off_the_edge);
  }
}

TEST_CASE("filtered Blinn-Phong keeps its stated error from exponent 1 to 1e5") {
  for (const float exponent : exponents) {
    CAPTURE(exponent);
    check_errors([&](auto x, auto y, auto z, const auto& spread,
                     const vec3& wo) { return brdf_blinn_phong_filtered(x, y, z, spread, wo, exponent); },
                 {2e-7, 3e-5, 1e-25, 1e-25, 4e-7});
  }
}

TEST_CASE("filtered Ward keeps its stated error from alpha 1e-3 to 1, isotropic and not") {
  for (const float alpha_x : alphas)
    for (const float alpha_y : alphas) {
      CAPTURE(alpha_x);
      CAPTURE(alpha_y);
      check_errors([&](auto x, auto y, auto z, const auto& spread,
                       const vec3& wo) { return brdf_ward_filtered(x, y, z, spread, wo, alpha_x, alpha_y); },
                   {2e-7, 2e-5, 1e-10, 1e-12, 4e-7});
    }
}

TEST_CASE("filtered terms are finite and not negative, to the horizon and at every spread") {
  std::vector<vec3> directions;
  for (const double z : {1.0, 0.5, 1e-2, 1e-4, 1e-7, 1e-30, 0.0, -0.1})
    for (const double azimuth : {0.0, 1.0, std::numbers::pi})
      directions.push_back(vec3(spherical(z, azimuth)));
  for (const Kind& kind : all_kinds()) {
    CAPTURE(kind.brdf);
    CAPTURE(kind.alpha_x);
    CHECK(std::ranges::all_of(domain(), [&](const Sample& s) { return is_sound(filtered(kind, s)); }));
    for (const vec3& wo : directions)
      for (const vec3& wi : directions)
        for (const float spread : {0.0f, 1e-7f, 1e-3f, 0.5f, 1 - 1e-7f, 1.0f}) {
          const auto terms = filtered(kind, {wi, wo, spread});
          CHECK(is_sound(terms));
          if (wi.z <= 0 || wo.z <= 0) CHECK(terms.diffuse + terms.specular + terms.fresnel == 0);
        }
  }
}

TEST_CASE("filtered terms of one light are those of the light") {
  for (const Kind& kind : all_kinds()) {
    CAPTURE(kind.brdf);
    CAPTURE(kind.alpha_x);
    CHECK(std::ranges::all_of(domain(), [&](const Sample& sample) {
      const auto expected =
          brdf_terms(kind.brdf, kind.alpha_x, kind.alpha_y, sample.wi.x, sample.wi.y, sample.wi.z, sample.wo);
      const auto terms = filtered(kind, {sample.wi, sample.wo, 0});
      const float lobe = expected.specular + expected.fresnel;
      return is_near(terms.diffuse, expected.diffuse, sample.wi.z) &&
             is_near(terms.specular, expected.specular, lobe) &&
             is_near(terms.fresnel, expected.fresnel, lobe) && terms.growth == 0;
    }));
  }
}

TEST_CASE("the switch gives the filtered terms of each kind") {
  const vec3 wi(spherical(0.8, 1)), wo(spherical(0.6, 3.5));
  const auto spread = light_spread(0.1f);
  const auto same = [&](uint kind, const FilteredTerms<float>& expected) {
    const auto terms = brdf_filtered_terms(kind, 0.3f, 0.7f, wi.x, wi.y, wi.z, spread, wo);
    CHECK(terms.diffuse == expected.diffuse);
    CHECK(terms.specular == expected.specular);
    CHECK(terms.fresnel == expected.fresnel);
    CHECK(terms.growth == expected.growth);
  };
  same(BRDF_LAMBERT, brdf_lambert_filtered(wi.z, spread, wo));
  same(BRDF_GGX, brdf_ggx_filtered(wi.x, wi.y, wi.z, spread, wo, 0.3f));
  same(BRDF_PHONG, brdf_phong_filtered(wi.x, wi.y, wi.z, spread, wo, 0.3f));
  same(BRDF_BLINN_PHONG, brdf_blinn_phong_filtered(wi.x, wi.y, wi.z, spread, wo, 0.3f));
  same(BRDF_WARD, brdf_ward_filtered(wi.x, wi.y, wi.z, spread, wo, 0.3f, 0.7f));
}
