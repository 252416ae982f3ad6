// The pre-convolved environment against direct sums over its lights.
#include <coppice/core/simd.hpp>
//
#include <doctest/doctest.h>

#include <coppice/light/directions.hpp>
#include <coppice/reference/environment_fit.hpp>
#include <coppice/sg/environment_fit.hpp>
#include <coppice/sg/preconvolved.hpp>

#include "support/executors.hpp"
#include "support/generators.hpp"

using namespace coppice;
using namespace test_support;

namespace {

/// Broad lights all over, a few of them negative.
std::vector<SgLight> some_lights(Random& random, std::size_t count, float sharpest) {
  std::vector<SgLight> lights;
  for (std::size_t i = 0; i < count; ++i) {
    const float sharpness = sharpest * random.uniform();
    const vec3 amplitude(random.uniform(), random.uniform(), random.uniform());
    lights.push_back(sg_light({random.direction(), sharpness}, i % 5 == 0 ? -0.3f * amplitude : amplitude));
  }
  return lights;
}

glm::dvec3 direct(std::span<const SgLight> lights, const SgShape& shape) {
  glm::dvec3 sum(0);
  for (const SgLight& light : lights)
    sum += double(sg_inner_product({light.axis, light.sharpness}, shape)) * glm::dvec3(light.amplitude);
  return sum;
}

/// Relative RMS error of lookups with this sharpness in random directions.
double lookup_error(const PreconvolvedEnvironment& table, std::span<const SgLight> lights, float sharpness) {
  std::vector<glm::dvec3> looked_up, expected;
  for (const vec3& axis : even_directions(400, 3)) {
    looked_up.push_back(glm::dvec3(table.lookup({axis, sharpness})));
    expected.push_back(direct(lights, {axis, sharpness}));
  }
  return reference::relative_rms(looked_up, expected);
}

}  // namespace

TEST_CASE("the octahedral square and the sphere are each other's inverse, and edges mirror") {
  rc::check([] {
    Random random = any_random();
    const vec3 d = random.direction();
    RC_ASSERT(length(octahedral_direction(octahedral_point(d)) - d) < 1e-6f);
    const float t = random.uniform();
    RC_ASSERT(length(octahedral_direction({t, 0}) - octahedral_direction({1 - t, 0})) < 1e-6f);
    RC_ASSERT(length(octahedral_direction({1, t}) - octahedral_direction({1, 1 - t})) < 1e-6f);
  });
  CHECK(octahedral_direction({0.5f, 0.5f}) == vec3(0, 1, 0));
  CHECK(octahedral_direction({0, 0}) == vec3(0, -1, 0));
  for (const vec3& axis : {vec3(1, 0, 0), vec3(-1, 0, 0), vec3(0, 0, 1), vec3(0, 0, -1), vec3(0, -1, 0)})
    CHECK(length(octahedral_direction(octahedral_point(axis)) - axis) < 1e-6f);
}

TEST_CASE("a lookup is the sum over all lights") {
  Random random(1);
  const auto lights = some_lights(random, 60, 100);
  const PreconvolvedEnvironment table(lights, {2, 4, 511});
  for (const float sharpness : {0.0f, 0.1f, 1.0f, 3.3f, 10.0f, 40.0f, 200.0f, 511.0f, 2000.0f, 1e8f})
    CHECK(lookup_error(table, lights, sharpness) < 0.01);
}

TEST_CASE("lights that are left out change the mean by less than the tolerance") {
  Random random(5);
  const auto lights = some_lights(random, 800, 300);
  coppice::detail::LightColumns columns;
  for (const SgLight& light : lights) columns.append(light);
  columns.pad();
  for (const float sharpness : {0.0f, 1.0f, 30.0f, 1000.0f}) {
    std::vector<glm::dvec3> all, exact;
    for (const vec3& axis : even_directions(200, 3)) {
      all.push_back(glm::dvec3(columns.mean(axis, sharpness, 1e-3f)));
      exact.push_back(direct(lights, {axis, sharpness}) * double(sg_normalisation(sharpness)));
    }
    CHECK(reference::relative_rms(all, exact) < 1e-3);
  }
}

TEST_CASE("finer tables err less") {
  Random random(2);
  const auto lights = some_lights(random, 60, 100);
  const auto worst = [&](const PreconvolvedOptions& options) {
    const PreconvolvedEnvironment table(lights, options);
    return std::max({lookup_error(table, lights, 1.2f), lookup_error(table, lights, 12),
                     lookup_error(table, lights, 90)});
  };
  const double coarse = worst({1, 1.5f, 511}), fine = worst({2, 3, 511}), finest = worst({4, 6, 511});
  CHECK(fine < 0.5 * coarse);
  CHECK(finest < 0.5 * fine);
}

TEST_CASE("the widest Gaussian sees the mean, the sharpest the radiance") {
  Random random(3);
  const auto lights = some_lights(random, 30, 50);
  const PreconvolvedEnvironment table(lights, {2, 8, 511});
  const glm::dvec3 energy = sg_energy(lights);
  for (int i = 0; i < 100; ++i) {
    const vec3 d = random.direction();
    CHECK(glm::length(glm::dvec3(table.lookup({d, 0})) - energy) < 1e-4 * glm::length(energy));
    const glm::dvec3 seen(table.mean({d, std::numeric_limits<float>::infinity()}));
    CHECK(glm::length(seen - reference::radiance(lights, d)) < 0.02);
  }
}

TEST_CASE("a table turns with its environment") {
  Random random(4);
  const EnvironmentFitter fitter({}, 64, 32);
  const Image map = random_map(random, 64, 32);
  const EnvironmentFit still = fitter.fit({map, 0}), turned = fitter.fit({map, 1.3f});
  PreconvolvedEnvironment table(still.rest(), {1, 2, 63});
  const std::vector<SgLight> lights(turned.rest().begin(), turned.rest().end());
  const PreconvolvedEnvironment expected(still.rest(), {1, 2, 63});
  table.turn(1.3f);
  for (int i = 0; i < 200; ++i) {
    const vec3 d = random.direction();
    const vec3 a = table.mean({turned_direction(d, 1.3f), 20}), b = expected.mean({d, 20});
    CHECK(length(a - b) < 1e-4f * length(b));
  }
  CHECK(lookup_error(table, lights, 10) < 0.05);
}

TEST_CASE("the cells of a map are its rest without a fit") {
  Random random(5);
  Image map(256, 128, vec3(0.5f, 0.4f, 0.3f));
  for (int x = 40; x < 80; ++x)
    for (int y = 30; y < 60; ++y) map.at(x, y) = vec3(3, 2, 1);
  const EnvironmentFitter fitter({}, 256, 128);
  const EnvironmentFit fit = fitter.fit({map, 0});
  const auto cells = cell_lights(fitter.grid(), fitter.grid().gather(map), fit.peaks());
  const glm::dvec3 left = sg_energy(cells) - sg_energy(fit.rest());
  CHECK(glm::length(left) < 1e-5 * glm::length(sg_energy(cells)));
  const PreconvolvedEnvironment from_cells(cells, {2, 3, 31}), from_fit(fit.rest(), {2, 3, 31});
  for (int i = 0; i < 200; ++i) {
    const vec3 d = random.direction();
    const vec3 a = from_cells.mean({d, 15}), b = from_fit.mean({d, 15});
    CHECK(length(a - b) < 0.02f * length(b));
  }
}

TEST_CASE("no lights make a black table, and huge ones no NaN") {
  Random random(6);
  const PreconvolvedEnvironment black(std::span<const SgLight>{});
  const std::vector<SgLight> bright{sg_light({vec3(0, 1, 0), 1e6f}, vec3(1e30f)),
                                    sg_light({vec3(1, 0, 0), 0}, vec3(1e30f))};
  const PreconvolvedEnvironment table(bright);
  for (int i = 0; i < 100; ++i) {
    const SgShape shape{random.direction(), std::exp(20 * random.uniform() - 5)};
    CHECK(black.lookup(shape) == vec3(0));
    CHECK(is_finite(table.lookup(shape)));
  }
}

TEST_CASE("the number of threads changes no bit of a table") {
  Random random(7);
  const auto lights = some_lights(random, 100, 200);
  const PreconvolvedEnvironment serial(lights), pieces(lights, {}, support::TwoThreads());
  for (int i = 0; i < 2000; ++i) {
    const SgShape shape{random.direction(), 600 * random.uniform()};
    REQUIRE(serial.lookup(shape) == pieces.lookup(shape));
  }
}
