// Shadow fields of balls against what a ball hides in closed form.
#include <doctest/doctest.h>

#include <coppice/reference/merge_per_leaf.hpp>
#include <coppice/relight/shadow_field.hpp>
#include <support/executors.hpp>
#include <support/occluders.hpp>

#include "relight/lights.hpp"

using namespace coppice;
using relight_test::Lights;

namespace {

const support::SphereOccluder ball{{{vec3(0), 1}}};
const support::SphereOccluder nothing{};

template <class O, class E = Serial>
ShadowField field_of(const O& occluder, const Lights& lights, const FieldSamples& samples,
                     double sigma = 0.01, const E& executor = {}) {
  return precompute_field(occluder, lights.tree, lights.packets, samples, {sigma, unlimited}, executor);
}

/// Share of all lights seen, interpolated.
double openness(const ShadowField& field, const vec3& point) {
  const SampleBlend blend = field.locate(point);
  double sum = 0;
  for (std::uint32_t i = 0; i < blend.count; ++i) {
    const auto cut = field.cuts.unpack(blend.samples[i]);
    const auto values = reference::expand(CutView<std::uint8_t>(cut));
    sum += double(blend.weights[i]) * std::accumulate(values.begin(), values.end(), 0.0) /
           (255.0 * double(values.size()));
  }
  return sum;
}

}  // namespace

TEST_CASE("a ball hides its solid angle, at samples and between them") {
  const Lights lights(1024);
  const ShadowField field = field_of(ball, lights, ShellSamples(vec3(0), 1.01f, 16, 4, 8));
  Random random(1);
  for (int i = 0; i < 40; ++i) {
    const float r = 1.2f + 10 * random.uniform();
    const double hidden = 0.5 * (1 - std::sqrt(1 - 1 / double(r * r)));
    const double found = openness(field, r * random.direction());
    CHECK(std::abs(found - (1 - hidden)) < 0.012);
  }
}

TEST_CASE("samples see to all sides, below any horizon too") {
  const Lights lights(256);
  const ShadowField field = field_of(nothing, lights, GridSamples(vec3(0), vec3(1), 1));
  REQUIRE(field.cuts.size() == 8);
  for (std::size_t s = 0; s < 8; ++s) {
    CHECK(field.cuts.unpack(s).values == std::vector<std::uint8_t>{255});
    CHECK(field.cuts[s].horizon.cosine == -1);
    CHECK(field.blind[s] == 0);
  }
  CHECK(field.is_clear(field.locate(vec3(0.3f))));
}

TEST_CASE("samples inside the object are blind and do not darken what is outside") {
  const Lights lights(256);
  const ShadowField field = field_of(ball, lights, ShellSamples(vec3(0), 0.6f, 8, 2, 6));
  const auto positions = positions_of(field.samples);
  std::size_t blind = 0;
  for (std::size_t s = 0; s < positions.size(); ++s) {
    CHECK(bool(field.blind[s]) == (length(positions[s]) < 1));
    blind += field.blind[s];
  }
  CHECK(blind == 2 * 49);  // on shells of radius 0.6 and 0.85
  Random random(2);
  for (int i = 0; i < 50; ++i) {
    const SampleBlend outside = field.locate((0.87f + random.uniform()) * random.direction());
    double sum = 0;
    for (std::uint32_t k = 0; k < outside.count; ++k) {
      CHECK_FALSE(field.blind[outside.samples[k]]);
      sum += double(outside.weights[k]);
    }
    CHECK(sum == doctest::Approx(1));
    const SampleBlend inside = field.locate(0.4f * random.direction());
    REQUIRE(inside.count > 0);
    for (std::uint32_t k = 0; k < inside.count; ++k) CHECK(field.blind[inside.samples[k]]);
  }
}

TEST_CASE("a blend is clear only where every sample sees all; beyond the field it is") {
  const Lights lights(256);
  const ShadowField field = field_of(ball, lights, ShellSamples(vec3(0), 1.1f, 8, 2, 6));
  CHECK_FALSE(field.is_clear(field.locate(vec3(2, 0, 0))));
  CHECK(field.locate(vec3(9, 0, 0)).count == 0);
  CHECK(field.is_clear(field.locate(vec3(9, 0, 0))));
}

TEST_CASE("fields do not depend on the executor") {
  const Lights lights(256);
  const FieldSamples samples = ShellSamples(vec3(0.2f), 1.1f, 8, 2, 5);
  const ShadowField one = field_of(ball, lights, samples, 1);
  const auto same = [&](const ShadowField& other) {
    return std::ranges::equal(one.cuts.masks(), other.cuts.masks()) &&
           std::ranges::equal(one.cuts.values(), other.cuts.values()) && one.blind == other.blind;
  };
  CHECK(same(field_of(ball, lights, samples, 1, support::Backwards())));
  CHECK(same(field_of(ball, lights, samples, 1, support::TwoThreads())));
}
