// Direct light at VPLs against the plain double loop: how much, from where, from how many sides.
#include <doctest/doctest.h>

#include <algorithm>
#include <coppice/light/vpl_lighting.hpp>

#include "support/executors.hpp"
#include "support/occluders.hpp"

using namespace coppice;

namespace {

const support::SphereOccluder nothing{}, balls{{{{0.5f, 1, 0}, 0.6f}, {{-1, 1.5f, 0.3f}, 0.5f}}};

SurfaceSample sample_at(const vec3& position, const vec3& normal) {
  return {.position = position, .area = 1, .normal = normal, .side = {}};
}

std::vector<SurfaceSample> samples_around(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<SurfaceSample> samples;
  while (samples.size() < count)
    samples.push_back(
        sample_at({2 * random.uniform() - 1, 0.3f * random.uniform(), random.uniform()}, random.direction()));
  return samples;
}

/// Points, spots, patches and suns on all sides.
std::vector<LocalLight> lights_around(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<LocalLight> lights;
  while (lights.size() < count) {
    const vec3 p = 3.0f * random.direction(), colour(random.uniform(), random.uniform(), random.uniform());
    switch (random.below(4)) {
      case 0:
        lights.push_back(point_light(p, colour));
        break;
      case 1:
        lights.push_back(spot_light(p, colour, random.direction(), 0.4f, 1.2f));
        break;
      case 2:
        lights.push_back(surface_light(p, random.direction(), colour, 0.3f));
        break;
      default:
        lights.push_back(distant_light(p / 3.0f, 0.1f * colour, 3));
    }
  }
  return lights;
}

template <Occluder O, Executor E = Serial>
std::vector<VplLight> light(std::span<const SurfaceSample> vpls, std::span<const LocalLight> lights,
                            const O& occluder, std::size_t most_rays = 1024, const E& executor = {}) {
  std::vector<VplLight> out(vpls.size());
  light_vpls(vpls, lights, occluder, executor, std::span(out), most_rays);
  return out;
}

/// Irradiance, Σ w ω and Σ w by the definition of LocalLight, in double.
struct Plain {
  glm::dvec3 irradiance{0}, arriving{0};
  double weight = 0;
};
template <Occluder O>
Plain plain(const SurfaceSample& vpl, std::span<const LocalLight> lights, const O& occluder) {
  Plain sum;
  const vec3 x = ray_origin(vpl);
  for (const LocalLight& light : lights) {
    const glm::dvec3 across = glm::dvec3(light.position) - double(light.w) * glm::dvec3(x);
    const double distance = length(across), cosine = dot(across, glm::dvec3(vpl.normal)) / distance;
    const vec3 direction(across / distance);
    const float t_max = light.w > 0 ? float(distance) * 0.9999f : std::numeric_limits<float>::infinity();
    if (cosine <= 0 || occluder.occluded(x, direction, t_max)) continue;
    const glm::dvec3 e = glm::dvec3(light.intensity) * double(emission_towards(light, -direction)) * cosine /
                         (distance * distance + double(light.area) / std::numbers::pi);
    const double w = dot(e, glm::dvec3(0.2126, 0.7152, 0.0722));
    sum.irradiance += e, sum.weight += w, sum.arriving += w * across / distance;
  }
  return sum;
}

bool same(const VplLight& a, const VplLight& b) {
  return a.irradiance == b.irradiance && a.shortfall == b.shortfall && a.direction == b.direction;
}

}  // namespace

TEST_CASE("VPLs receive what the plain sum over all lights says") {
  const auto vpls = samples_around(200, 1);
  for (const std::size_t count : {1u, 2u, 15u, 40u, 500u}) {
    const auto lights = lights_around(count, count);
    const auto out = light(vpls, lights, balls);
    for (std::size_t i = 0; i < vpls.size(); ++i) {
      const Plain expected = plain(vpls[i], lights, balls);
      if (expected.weight == 0) {
        CHECK(same(out[i], {vec3(0), 1, vpls[i].normal}));
        continue;
      }
      CHECK(length(glm::dvec3(out[i].irradiance) - expected.irradiance) <=
            1e-5 * length(expected.irradiance));
      const double size = length(expected.arriving);
      CHECK(std::abs(double(out[i].shortfall) - (1 - size / expected.weight)) < 1e-5);
      CHECK(length(glm::dvec3(out[i].direction) - expected.arriving / size) < 2e-5);
    }
  }
}

TEST_CASE("the shortfall keeps its digits where two lights nearly agree") {
  const std::vector<SurfaceSample> vpls{sample_at({0, 0, 0}, {0, 1, 0})};
  for (const double angle : {1e-1, 1e-2, 1e-3, 3e-4}) {
    const std::vector<LocalLight> lights{point_light({0, 1, 0}, vec3(1)),
                                         point_light({float(std::tan(angle)), 1, 0}, vec3(1))};
    const Plain expected = plain(vpls[0], lights, nothing);
    const double wa = 1 / (1 + std::pow(std::cos(angle), 3)), wb = 1 - wa;  // cosine / distance²
    const double squared = 2 * wa * wb * (1 - std::cos(angle));             // 1 - |mean|²
    const double exact = squared / (1 + std::sqrt(1 - squared));
    const float shortfall = light(vpls, lights, nothing)[0].shortfall;
    CAPTURE(angle);
    CHECK(double(shortfall) == doctest::Approx(exact).epsilon(2e-4));  // the float positions' own rounding
    CHECK(double(shortfall) ==
          doctest::Approx(1 - length(expected.arriving) / expected.weight).epsilon(1e-5));
  }
  const std::vector<LocalLight> one{point_light({0.3f, 1, -0.2f}, vec3(3, 2, 1))};
  CHECK(light(vpls, one, nothing)[0].shortfall < 1e-14f);
}

TEST_CASE("under an even sky a VPL's light comes from above, a third of its mean direction lost") {
  std::vector<LocalLight> sky;
  Random random(3);
  for (int i = 0; i < 4000; ++i) sky.push_back(distant_light(random.direction(), vec3(1), 1));
  const auto out = light(std::vector{sample_at({0, 0, 0}, {0, 1, 0})}, sky, nothing, 4000)[0];
  CHECK(double(out.shortfall) == doctest::Approx(1.0 / 3).epsilon(0.03));  // mean cosine by cosine: 2/3
  CHECK(out.direction.y > 0.999f);
}

TEST_CASE("drawn lights: the same bits each time, and right on the mean") {
  const auto vpls = samples_around(300, 5);
  const auto lights = lights_around(2000, 6);
  const auto all = light(vpls, lights, balls, 2000), drawn = light(vpls, lights, balls, 100),
             again = light(vpls, lights, balls, 100);
  double error = 0, bias = 0, total = 0;
  for (std::size_t i = 0; i < vpls.size(); ++i) {
    CHECK(same(drawn[i], again[i]));
    const double expected = double(luminance(all[i].irradiance)), e = double(luminance(drawn[i].irradiance));
    error += std::abs(e - expected), bias += e - expected, total += expected;
  }
  CHECK(error > 1e-4 * total);  // it did draw
  CHECK(error < 0.05 * total);
  CHECK(std::abs(bias) < 0.01 * total);
}

TEST_CASE("any executor lights VPLs with the same bits") {
  const auto vpls = samples_around(300, 7);
  const auto lights = lights_around(300, 8);
  for (const std::size_t most_rays : {50u, 1024u}) {
    const auto a = light(vpls, lights, balls, most_rays);
    const auto b = light(vpls, lights, balls, most_rays, support::Backwards());
    const auto c = light(vpls, lights, balls, most_rays, support::TwoThreads());
    for (std::size_t i = 0; i < a.size(); ++i) CHECK((same(a[i], b[i]) && same(a[i], c[i])));
  }
}

TEST_CASE("the lit VPLs are those that any light reaches") {
  const auto vpls = samples_around(300, 9);
  const std::vector<LocalLight> bulb{point_light({0, 3, 0}, vec3(1))}, none,
      inside{point_light({0.5f, 1, 0}, vec3(9))};  // within a ball
  const auto is_lit = [](const VplLight& l) { return l.irradiance != vec3(0); };
  const auto out = light(vpls, bulb, balls);
  const auto count = std::ranges::count_if(out, is_lit);
  CHECK(count > 50);
  CHECK(count < 200);
  for (std::size_t i = 0; i < vpls.size(); ++i)
    CHECK(is_lit(out[i]) == (plain(vpls[i], bulb, balls).weight > 0));
  CHECK(std::ranges::none_of(light(vpls, none, balls), is_lit));
  CHECK(std::ranges::none_of(light(vpls, inside, balls), is_lit));
}

TEST_CASE("lights at the VPL, huge or tiny: finite, unit directions") {
  const std::vector<SurfaceSample> vpls{sample_at({0, 0, 0}, {0, 1, 0})};
  for (const LocalLight& l : {point_light({0, 0, 0}, vec3(1)), point_light({0, 1e-6f, 0}, vec3(1e6f)),
                              point_light({0, 2, 0}, vec3(1e30f)), point_light({0, 2, 0}, vec3(1e-30f))}) {
    const VplLight out = light(vpls, std::vector{l}, nothing)[0];
    CHECK((is_finite(out.irradiance) && out.shortfall >= 0 && out.shortfall <= 1));
    CHECK(length(out.direction) == doctest::Approx(1));
  }
}
