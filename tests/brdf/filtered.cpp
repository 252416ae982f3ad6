// The mean of a BRDF over a cluster of lights, against the sum over its lights.
#include <doctest/doctest.h>

#include <array>
#include <coppice/brdf/with_brdf.hpp>
#include <coppice/core/simd.hpp>
#include <random>
#include <vector>

#include "brdf/directions.hpp"

using namespace coppice;
using namespace brdf_test;

namespace {

struct Light {
  dvec3 direction;
  double power;
};

/// What a light tree keeps of the lights below a node.
struct Cluster {
  vec3 direction;
  float spread;  ///< 1 - mean length
};

Cluster cluster_of(const std::vector<Light>& lights) {
  dvec3 sum(0);
  double power = 0;
  for (const Light& light : lights) sum += light.power * light.direction, power += light.power;
  return {vec3(glm::normalize(sum)), float(1 - std::min(1.0, glm::length(sum) / power))};
}

/// specular + fresnel, averaged over the lights.
template <class B>
double mean_lobe(const B& brdf, const std::vector<Light>& lights) {
  double sum = 0, power = 0;
  for (const auto& [direction, weight] : lights) {
    const auto terms = brdf(float(direction.x), float(direction.y), float(direction.z));
    sum += weight * (double(terms.specular) + double(terms.fresnel)), power += weight;
  }
  return sum / power;
}

template <class B>
double filtered_lobe(const B& brdf, const vec3& wi, float spread) {
  const auto terms = brdf.filtered(wi.x, wi.y, wi.z, light_spread(spread));
  return double(terms.specular) + double(terms.fresnel);
}

/// side² lights about `axis`, evenly over the azimuth, the cosine of the angle to it given by `cosine(u)` of
/// midpoints u in (0, 1).
template <class F>
std::vector<Light> lights_about(const dvec3& axis, int side, F cosine) {
  vec3 tangent, bitangent;
  make_frame(vec3(axis), tangent, bitangent);
  std::vector<Light> lights;
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      const double c = cosine((i + 0.5) / side), azimuth = 2 * std::numbers::pi * (j + 0.5 * (i % 2)) / side;
      const double s = std::sqrt(std::max(0.0, 1 - c * c));
      const dvec3 across = dvec3(tangent) * std::cos(azimuth) + dvec3(bitangent) * std::sin(azimuth);
      lights.push_back({glm::normalize(axis * c + across * s), 1});
    }
  return lights;
}

/// Lights as a von Mises-Fisher lobe of sharpness 1/widening has them; it is at least 2.
std::vector<Light> fisher_lights(const dvec3& axis, double widening, int side) {
  const double sharpness = 1 + 1 / widening;  // of mean length 1 - 1/sharpness, to exp(-2 sharpness)
  return lights_about(
      axis, side, [&](double u) { return 1 + std::log(u + (1 - u) * std::exp(-2 * sharpness)) / sharpness; });
}

/// Lights evenly over a cap of mean length 1/(1 + widening).
std::vector<Light> cap_lights(const dvec3& axis, double widening, int side) {
  const double height = 2 * widening / (1 + widening);
  return lights_about(axis, side, [&](double u) { return 1 - height * u; });
}

using MakeLights = std::vector<Light> (*)(const dvec3& axis, double widening, int side);

vec3 mirror_of(const vec3& wo) { return {-wo.x, -wo.y, wo.z}; }

/// Where lobes are compared: viewers from above to 66° from the normal, and for each the mirror direction of
/// half vectors tilted by up to twice the lobe's width, all round.
struct Place {
  vec3 viewer;
  dvec3 axis;
};

std::vector<Place> places(double width) {
  std::vector<Place> all;
  for (const double cosine : {0.95, 0.8, 0.6, 0.4}) {
    const dvec3 viewer = spherical(cosine, 0.7);
    for (const double offset : {0.0, 0.5, 1.0, 1.5, 2.0})
      for (int turn = 0; turn < 8; ++turn) {
        const double tilt = std::atan(offset * width);
        const dvec3 h = spherical(std::cos(tilt), 0.3 + turn * std::numbers::pi / 4);
        const dvec3 axis = 2 * glm::dot(viewer, h) * h - viewer;
        if (axis.z > 0.2) all.push_back({vec3(viewer), axis});
      }
  }
  return all;
}

/// Of the filtered lobe and of the lobe at the mean direction, against the mean over the lights.
struct Comparison {
  double filtered = 0, centre = 0;  ///< relative RMS
};

/// LightSpread::widening of a cluster that widens the lobe by this share of its squared width, at its peak.
template <class B>
double widening_for(const B& brdf, double growth) {
  const vec3 peak = mirror_of(brdf.viewer);
  return growth / double(brdf.filtered(peak.x, peak.y, peak.z, LightSpread<float>{1, 1}).growth);
}

/// Over the places, by clusters whose widening is `growth` of the lobe's squared width at its peak.
template <class MakeBrdf>
Comparison compare(MakeBrdf make_brdf, double width, double growth, MakeLights make_lights) {
  double filtered = 0, centre = 0, total = 0;
  for (const auto& [viewer, axis] : places(width)) {
    const auto brdf = make_brdf(SeenSurface{viewer, vec3(0), vec3(1), vec3(1)});
    const auto lights = make_lights(axis, widening_for(brdf, growth), 40);
    const Cluster cluster = cluster_of(lights);
    const double mean = mean_lobe(brdf, lights);
    filtered += std::pow(filtered_lobe(brdf, cluster.direction, cluster.spread) - mean, 2);
    centre += std::pow(filtered_lobe(brdf, cluster.direction, 0) - mean, 2);
    total += mean * mean;
  }
  return {std::sqrt(filtered / total), std::sqrt(centre / total)};
}

constexpr double growths[] = {0.03, 0.1, 0.3, 1, 3};

/// The relative RMS that the filtered lobe may have at each of the growths, and as a share of what the lobe
/// at the mean direction has.
struct Limit {
  std::array<double, std::size(growths)> error;
  double share;
};

template <class MakeBrdf>
void check_filtering(MakeBrdf make_brdf, double width, const Limit& limit) {
  CAPTURE(width);
  for (const MakeLights make_lights : {&fisher_lights, &cap_lights})
    for (std::size_t i = 0; i < std::size(growths); ++i) {
      CAPTURE(growths[i]);
      const Comparison relative_rms = compare(make_brdf, width, growths[i], make_lights);
      CHECK(relative_rms.filtered <= limit.error[i]);
      CHECK(relative_rms.filtered <= limit.share * relative_rms.centre);
    }
}

SeenSurface white(const vec3& viewer) { return {viewer, vec3(0), vec3(1), vec3(1)}; }

/// The albedo of the lobe widened everywhere by `growth` of its squared width, over that of the lobe.
template <class B>
double energy_kept(const B& brdf, double width, double growth) {
  const auto albedo = [&](float widening) {
    const double wider = std::min(1.0, width * std::sqrt(1 + (widening > 0 ? growth : 0)));
    return integral_over_half_vectors(brdf.viewer, wider, 200, [&](const vec3& wi) {
      const auto terms = brdf.filtered(wi.x, wi.y, wi.z, LightSpread<float>{1 / (1 + widening), widening});
      return terms.specular + terms.fresnel;
    });
  };
  return albedo(float(widening_for(brdf, growth))) / albedo(0);
}

/// How far the albedo may move when the lobe grows by 0.1, 0.3 and 1.
using EnergyLimit = std::array<double, 3>;

template <class MakeBrdf>
void check_energy(MakeBrdf make_brdf, double width, const EnergyLimit& limit) {
  CAPTURE(width);
  for (const double cosine : {1.0, 0.8, 0.6, 0.4})
    for (std::size_t i = 0; i < limit.size(); ++i) {
      const double growth = std::array{0.1, 0.3, 1.0}[i];
      CAPTURE(cosine);
      CAPTURE(growth);
      const auto brdf = make_brdf(white(vec3(spherical(cosine, 0.7))));
      CHECK(std::abs(energy_kept(brdf, width, growth) - 1) <= limit[i]);
    }
}

/// Calls f(brdf) with BRDFs of every kind but Lambert, from smooth to rough.
template <class F>
void for_each_lobe(const SeenSurface& surface, F f) {
  for (const float alpha : {1e-3f, 0.05f, 0.3f, 1.0f}) {
    f(Ggx(surface, alpha));
    f(Ward(surface, alpha, 0.3f));
  }
  for (const float exponent : {1.0f, 20.0f, 500.0f, 1e5f}) {
    f(Phong(surface, exponent));
    f(BlinnPhong(surface, exponent));
  }
}

/// Up to 50 lights of random power and direction, more or less about a random direction; z above `lowest`.
std::vector<Light> random_lights(std::mt19937& random, double lowest) {
  std::uniform_real_distribution<double> unit(0, 1);
  const double scatter = unit(random);
  const dvec3 axis(random_direction(random));
  std::vector<Light> lights;
  for (int i = 0, tries = 1 + int(50 * unit(random)); i < tries || lights.empty(); ++i) {
    const dvec3 any = spherical(2 * unit(random) - 1, 2 * std::numbers::pi * unit(random));
    const dvec3 direction = glm::normalize(axis + scatter * any);
    if (direction.z > lowest) lights.push_back({direction, std::pow(unit(random), 4) + 1e-3});
  }
  return lights;
}

double mean_cosine(const std::vector<Light>& lights) {
  double sum = 0, power = 0;
  for (const Light& light : lights)
    sum += light.power * std::max(0.0, light.direction.z), power += light.power;
  return sum / power;
}

template <class B>
double filtered_diffuse(const B& brdf, const Cluster& cluster) {
  const vec3& d = cluster.direction;
  return double(brdf.filtered(d.x, d.y, d.z, light_spread(cluster.spread)).diffuse) * std::numbers::pi;
}

using Array = std::array<float, Lanes::width>;

Array stored(const Lanes& lanes) {
  Array array;
  lanes.store(array.data());
  return array;
}

template <class B>
void check_lanes_equal_float(const B& brdf) {
  std::mt19937 random(8);
  for (int i = 0; i < 50; ++i) {
    Array x, y, z, spread;
    for (std::size_t lane = 0; lane < Lanes::width; ++lane) {
      const vec3 wi = normalize(random_direction(random) * float(i % 5) * 0.02f + mirror_of(brdf.viewer));
      x[lane] = wi.x, y[lane] = wi.y, z[lane] = lane % 4 == 3 ? -wi.z : wi.z;
      spread[lane] = i % 10 == 9 ? 0 : float(std::pow(10.0, -double((i + lane) % 8)));
    }
    const auto terms = brdf.filtered(Lanes::load(x.data()), Lanes::load(y.data()), Lanes::load(z.data()),
                                     light_spread(Lanes::load(spread.data())));
    const Array diffuse = stored(terms.diffuse), specular = stored(terms.specular);
    const Array fresnel = stored(terms.fresnel), growth = stored(terms.growth);
    for (std::size_t lane = 0; lane < Lanes::width; ++lane) {
      const auto expected = brdf.filtered(x[lane], y[lane], z[lane], light_spread(spread[lane]));
      const float lobe = expected.specular + expected.fresnel;
      CHECK(std::abs(diffuse[lane] - expected.diffuse) <= 5e-7f);
      CHECK(std::abs(specular[lane] - expected.specular) <= 2e-5f * lobe + 1e-12f);
      CHECK(std::abs(fresnel[lane] - expected.fresnel) <= 2e-6f * lobe);
      CHECK(std::abs(growth[lane] - expected.growth) <= 1e-6f * expected.growth);
    }
  }
}

}  // namespace

TEST_CASE("the diffuse term of a cluster above the horizon is the mean over its lights") {
  std::mt19937 random(1);
  const SeenSurface surface = white(vec3(spherical(0.5, 1)));
  for (int i = 0; i < 300; ++i) {
    const auto lights = random_lights(random, 0);
    const double mean = mean_cosine(lights);
    const Cluster cluster = cluster_of(lights);
    CHECK(std::abs(filtered_diffuse(Lambert(surface), cluster) - mean) <= 3e-7);
    CHECK(std::abs(filtered_diffuse(Phong(surface, 20), cluster) - mean) <= 3e-7);
    CHECK(std::abs(filtered_diffuse(BlinnPhong(surface, 20), cluster) - mean) <= 3e-7);
    CHECK(std::abs(filtered_diffuse(Ward(surface, 0.1f, 0.2f), cluster) - mean) <= 3e-7);
  }
}

TEST_CASE("the diffuse term of a cluster that the horizon cuts is at most the mean over its lights") {
  std::mt19937 random(2);
  const SeenSurface surface = white(vec3(spherical(0.5, 1)));
  double most = 0;
  for (int i = 0; i < 300; ++i) {
    const auto lights = random_lights(random, -1);
    const double lost = mean_cosine(lights) - filtered_diffuse(Lambert(surface), cluster_of(lights));
    CHECK(lost >= -3e-7);
    most = std::max(most, lost);
  }
  CHECK(most > 1e-3);
}

TEST_CASE("filtered GGX comes nearer to the mean over the lights than GGX at their mean direction") {
  for (const float alpha : {0.05f, 0.1f, 0.3f, 0.6f})
    check_filtering([&](const SeenSurface& s) { return Ggx(s, alpha); }, double(alpha),
                    {{0.021, 0.059, 0.13, 0.225, 0.28}, 0.48});
}

TEST_CASE("filtered Phong comes nearer to the mean over the lights than Phong at their mean direction") {
  for (const float exponent : {20.0f, 100.0f, 500.0f})
    check_filtering([&](const SeenSurface& s) { return Phong(s, exponent); },
                    0.5 / std::sqrt(double(exponent)), {{0.006, 0.021, 0.07, 0.27, 0.74}, 0.27});
}

TEST_CASE("filtered Blinn-Phong comes nearer to the mean over the lights than at their mean direction") {
  for (const float exponent : {20.0f, 100.0f, 500.0f})
    check_filtering([&](const SeenSurface& s) { return BlinnPhong(s, exponent); },
                    1 / std::sqrt(double(exponent)), {{0.0091, 0.03, 0.086, 0.238, 0.41}, 0.28});
}

TEST_CASE("filtered Ward comes nearer to the mean over the lights than Ward at their mean direction") {
  const Limit limit{{0.015, 0.052, 0.165, 0.27, 0.44}, 0.43};
  for (const float alpha : {0.05f, 0.1f, 0.3f, 0.6f})
    check_filtering([&](const SeenSurface& s) { return Ward(s, alpha, alpha); }, double(alpha), limit);
  check_filtering([](const SeenSurface& s) { return Ward(s, 0.1f, 0.3f); }, std::sqrt(0.03), limit);
}

TEST_CASE("a lobe keeps most of its energy when it is widened") {
  for (const float alpha : {0.05f, 0.1f, 0.3f}) {
    const double width(alpha);
    check_energy([&](const SeenSurface& s) { return Ggx(s, alpha); }, width, {0.012, 0.034, 0.105});
    check_energy([&](const SeenSurface& s) { return Ward(s, alpha, alpha); }, width, {0.02, 0.054, 0.14});
  }
  for (const float exponent : {20.0f, 100.0f, 500.0f}) {
    const double width = std::sqrt(2 / double(exponent));
    check_energy([&](const SeenSurface& s) { return BlinnPhong(s, exponent); }, width, {0.027, 0.077, 0.23});
    check_energy([&](const SeenSurface& s) { return Phong(s, exponent); }, width / 2, {0.002, 0.0066, 0.026});
  }
}

TEST_CASE("a lobe grows with the spread of the cluster, and not by one light") {
  std::mt19937 random(3);
  for (int i = 0; i < 50; ++i) {
    const vec3 wi = random_direction(random);
    for_each_lobe(white(random_direction(random)), [&](const auto& brdf) {
      const auto growth = [&](float spread) {
        return brdf.filtered(wi.x, wi.y, wi.z, light_spread(spread)).growth;
      };
      CHECK(growth(0) == 0);
      float last = 0;
      for (const float spread : {1e-30f, 1e-7f, 1e-6f, 1e-3f, 0.1f, 0.11f, 0.5f, 0.9f, 0.999f}) {
        CHECK(growth(spread) > last);
        last = growth(spread);
      }
    });
    CHECK(Lambert(white(wi)).filtered(wi.x, wi.y, wi.z, light_spread(0.5f)).growth == 0);
  }
}

TEST_CASE("a register of clusters gets the terms of each cluster") {
  const SeenSurface surface = white(vec3(spherical(0.7, 2)));
  check_lanes_equal_float(Lambert(surface));
  for_each_lobe(surface, [](const auto& brdf) { check_lanes_equal_float(brdf); });
}
