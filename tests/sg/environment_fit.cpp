// The fit of an environment: its convolutions, its energy, its turns, and maps that are hardly one.
#include <doctest/doctest.h>

#include <coppice/light/directions.hpp>
#include <coppice/reference/environment_fit.hpp>
#include <coppice/sg/environment_fit.hpp>

#include "support/executors.hpp"
#include "support/generators.hpp"

using namespace coppice;
using namespace test_support;

namespace {

glm::dvec3 energy_of(const Image& map) {
  glm::dvec3 sum(0);
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x)
      sum += texel_solid_angle(y, map.width, map.height) * glm::dvec3(map.at(x, y));
  return sum;
}

/// A sky that is blue above and brown below, with clouds, and a sun that is `sun` times as bright.
Image sky(int width, int height, float sun, const vec3& sun_direction = normalize(vec3(1, 0.6f, -0.4f))) {
  Image map(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const vec3 d = texel_direction(x, y, width, height);
      const float clouds = 1 + 0.5f * std::sin(9 * d.x + 3 * d.z) * std::sin(7 * d.y - 2 * d.x);
      map.at(x, y) = clouds * (d.y > 0 ? vec3(0.4f, 0.6f, 1.0f) : vec3(0.3f, 0.2f, 0.1f));
      if (dot(d, sun_direction) > std::cos(0.012f)) map.at(x, y) = sun * vec3(1, 0.9f, 0.8f);
    }
  return map;
}

/// Relative RMS error of the convolution with max(0, cosine)^exponent over 60 directions.
double convolved_error(const EnvironmentFit& fit, const Environment& environment, double exponent) {
  const std::vector<vec3> axes = even_directions(60, 3);
  std::vector<glm::dvec3> expected;
  for (const vec3& axis : axes) expected.push_back(reference::convolve(environment, axis, exponent));
  return reference::relative_rms(reference::convolve(fit.lights, axes, exponent), expected);
}

double energy_error(const EnvironmentFit& fit, const Image& map) {
  const glm::dvec3 expected = energy_of(map);
  return glm::length(sg_energy(fit.lights) - expected) / std::max(glm::length(expected), 1e-300);
}

bool all_finite(const EnvironmentFit& fit) {
  for (const SgLight& light : fit.lights)
    if (!is_finite(light.axis) || !is_finite(light.amplitude) || !std::isfinite(light.luminance) ||
        std::abs(length(light.axis) - 1) > 1e-6f)
      return false;
  return true;
}

}  // namespace

TEST_CASE("cells keep a map's energy, and cover the sphere, whatever its size") {
  rc::check([] {
    Random random = any_random();
    const int width = *rc::gen::inRange(1, 90), height = *rc::gen::inRange(1, 60);
    const Image map = random_map(random, width, height);
    const EnvironmentGrid grid(*rc::gen::inRange(1, 7), width, height);
    glm::dvec3 energy(0);
    double areas = 0;
    for (const EnvironmentCell& cell : grid.gather(map)) energy += glm::dvec3(cell.energy);
    for (const float area : grid.areas()) areas += double(area);
    RC_ASSERT(glm::length(energy - energy_of(map)) <= 1e-6 * glm::length(energy));
    RC_ASSERT(std::abs(areas - 4 * std::numbers::pi) < 1e-5);
  });
}

TEST_CASE("the one light of a cell is where the cell's centre is said to be") {
  const EnvironmentGrid grid(4, 256, 128);
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    Image map(256, 128);
    const int x = int(random.below(256)), y = int(random.below(128));
    map.at(x, y) = vec3(5, 6, 7);
    const vec3 d = texel_direction(x, y, 256, 128);
    const auto cells = grid.gather(map);
    const EnvironmentCell& cell = cells[grid.healpix().pixel(d)];
    REQUIRE(length(cell.centre - d) < 1e-6f);
    REQUIRE(close(double(cell.energy.z), 7 * texel_solid_angle(y, 256, 128), 1e-6));
  }
}

TEST_CASE("convolutions of a sky with a sun of 1e5 are those of the map") {
  for (const FitScheme scheme : {FitScheme::one_level, FitScheme::pyramid}) {
    EnvironmentFitOptions options;
    options.scheme = scheme;
    const EnvironmentFitter fitter(options, 512, 256);
    const Environment environment{sky(512, 256, 1e5f), 0};
    const EnvironmentFit fit = fitter.fit(environment);
    CHECK((fit.peak_count >= 1 && fit.peak_count <= 3));
    CHECK(fit.rest().size() == fitter.rest_count());
    CHECK(convolved_error(fit, environment, 1) < 0.001);
    CHECK(convolved_error(fit, environment, 50) < 0.004);
    CHECK(energy_error(fit, environment.map) < 1e-6);
    const double peak = double(luminance(vec3(sg_energy(fit.peaks()))));
    CHECK(peak > 0.8 * double(luminance(vec3(energy_of(environment.map)))));
  }
}

TEST_CASE("both schemes have as many Gaussians as they say, at the sharpness of their overlap") {
  EnvironmentFitOptions options;
  CHECK(EnvironmentFitter(options, 64, 32).rest_count() == 768);
  options.scheme = FitScheme::pyramid;
  const EnvironmentFitter fitter(options, 64, 32);
  CHECK(fitter.rest_count() == 12 + 48 + 192 + 768);
  const EnvironmentFit fit = fitter.fit({sky(64, 32, 1), 0});
  CHECK(fit.rest()[0].sharpness == sg_grid_sharpness(1, options.overlap));
  CHECK(fit.rest().back().sharpness == sg_grid_sharpness(8, options.overlap));
  // Half of the mean distance away a Gaussian has fallen to the overlap.
  const double half = std::sqrt(4 * std::numbers::pi / 768) / 2;
  CHECK(std::exp(double(fit.rest().back().sharpness) * (std::cos(half) - 1)) == doctest::Approx(0.6));
}

TEST_CASE("more passes come nearer") {
  EnvironmentFitOptions options;
  const Environment environment{sky(256, 128, 1), 0};
  double last = 1;
  for (const int passes : {1, 4, 16}) {
    options.passes = passes;
    const double error =
        convolved_error(EnvironmentFitter(options, 256, 128).fit(environment), environment, 50);
    CHECK(error < 0.6 * last);
    last = error;
  }
}

TEST_CASE("a turned environment has the same Gaussians, turned") {
  rc::check([] {
    Random random = any_random();
    static const EnvironmentFitter fitter(
        [] {
          EnvironmentFitOptions options;
          options.nside = 3, options.grid_nside = 12;
          return options;
        }(),
        48, 24);
    const Image map = random_map(random, 48, 24);
    const float rotation = 20 * random.uniform() - 10;
    const EnvironmentFit still = fitter.fit({map, 0}), turned = fitter.fit({map, rotation});
    RC_ASSERT(still.lights.size() == turned.lights.size());
    for (std::size_t i = 0; i < still.lights.size(); ++i) {
      RC_ASSERT(still.lights[i].amplitude == turned.lights[i].amplitude);
      RC_ASSERT(still.lights[i].sharpness == turned.lights[i].sharpness);
    }
    const vec3 d = random.direction();
    const double scale = glm::length(reference::radiance(still.lights, d)) + 1e-3;
    const vec3 there = turned_direction(d, rotation);
    RC_ASSERT(glm::length(reference::radiance(turned.lights, there) - reference::radiance(still.lights, d)) <
              1e-2 * scale);
  });
}

TEST_CASE("turning the axes is turning the environment") {
  const Image map = sky(256, 128, 1e4f);
  const EnvironmentFitter fitter({}, 256, 128);
  for (const float rotation : {0.7f, -2.5f, 40.0f}) {
    const Environment environment{map, rotation};
    CHECK(convolved_error(fitter.fit(environment), environment, 1) < 0.002);
    CHECK(convolved_error(fitter.fit(environment), environment, 50) < 0.01);
  }
}

TEST_CASE("a sun anywhere keeps its place: between cells, on the seam, at the poles, as a peak or not") {
  Random random(5);
  std::vector<vec3> places{vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, -1, 0), normalize(vec3(1, 2, 0))};
  for (int i = 0; i < 4; ++i) places.push_back(random.direction());
  EnvironmentFitOptions without;
  without.peaks.most = 0;
  const EnvironmentFitter with_peaks({}, 512, 256), no_peaks(without, 512, 256);
  for (const vec3& place : places) {
    const Environment environment{sky(512, 256, 3e3f, place), 0};
    const EnvironmentFit fit = with_peaks.fit(environment);
    CHECK((fit.peak_count >= 1 && fit.peak_count <= 3));
    CHECK(length(fit.lights[0].axis - place) < 0.012f);
    CHECK(convolved_error(fit, environment, 50) < 0.005);
    CHECK(convolved_error(no_peaks.fit(environment), environment, 50) < 0.08);
    CHECK(convolved_error(no_peaks.fit(environment), environment, 1) < 0.015);
  }
}

TEST_CASE("a constant map stays constant") {
  for (const FitScheme scheme : {FitScheme::one_level, FitScheme::pyramid})
    for (const int size : {1, 7, 64}) {
      EnvironmentFitOptions options;
      options.scheme = scheme;
      const Image map(2 * size, size, vec3(2, 1, 0.5f));
      const EnvironmentFit fit = EnvironmentFitter(options, map.width, map.height).fit({map, 0});
      CHECK(fit.peak_count == 0);
      CHECK(energy_error(fit, map) < 1e-6);
      Random random(6);
      for (int i = 0; i < 100; ++i) {
        const glm::dvec3 value = reference::radiance(fit.lights, random.direction());
        REQUIRE(glm::length(value - glm::dvec3(2, 1, 0.5)) < 0.2 * 2.3);  // the grid shows through
      }
      CHECK(convolved_error(fit, {Image(256, 128, vec3(2, 1, 0.5f)), 0}, 50) < 0.002);
    }
}

TEST_CASE("black, one-texel and huge maps give finite Gaussians of their energy") {
  EnvironmentFitOptions options;
  for (const auto& [width, height] : {std::pair(1, 1), std::pair(2, 1), std::pair(1, 9), std::pair(64, 32)}) {
    const EnvironmentFitter fitter(options, width, height);
    for (const float value : {0.0f, 1e-38f, 1.0f, 1e30f}) {
      Image map(width, height);
      map.at(width / 2, height / 2) = vec3(value, value / 2, 0);
      const EnvironmentFit fit = fitter.fit({map, 0});
      CHECK(all_finite(fit));
      CHECK(energy_error(fit, map) < (value < 1e-30f ? 1e-3 : 1e-6));  // amplitudes may be denormal
      CHECK(sg_energy(fit.lights).z == 0);
    }
  }
}

TEST_CASE("the number of threads changes no bit") {
  const Environment environment{sky(256, 128, 1e4f), 0.3f};
  const EnvironmentFitter fitter({}, 256, 128);
  const EnvironmentFit serial = fitter.fit(environment);
  const EnvironmentFit pieces = fitter.fit(environment, support::TwoThreads());
  REQUIRE(serial.lights.size() == pieces.lights.size());
  for (std::size_t i = 0; i < serial.lights.size(); ++i) {
    REQUIRE(serial.lights[i].amplitude == pieces.lights[i].amplitude);
    REQUIRE(serial.lights[i].axis == pieces.lights[i].axis);
  }
}

TEST_CASE("the twin's quadrature over a Gaussian is the sum over the texels of its picture") {
  for (const double sharpness : {4.0, 12.0, 60.0})
    for (const double exponent : {1.0, 50.0}) {
      const vec3 axis = normalize(vec3(1, 0.4f, -0.7f));
      const std::vector<SgLight> light{sg_light({axis, float(sharpness)}, vec3(1))};
      Image picture(800, 400);
      for (int y = 0; y < 400; ++y)
        for (int x = 0; x < 800; ++x)
          picture.at(x, y) = vec3(reference::radiance(light, texel_direction(x, y, 800, 400)));
      const double greatest = reference::convolve_gaussian(sharpness, 0, exponent);
      for (const vec3& d : even_directions(12)) {
        const double angle = std::acos(double(dot(axis, d)));
        const double expected = reference::convolve({picture, 0}, d, exponent).x;
        CHECK(std::abs(reference::convolve_gaussian(sharpness, angle, exponent) - expected) <
              2e-5 * greatest);
      }
    }
}
