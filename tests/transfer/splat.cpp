// Splats: rows of weights that sum to 1, exact for what is even, and never through a wall.
#include <doctest/doctest.h>

#include <coppice/transfer/splat.hpp>

#include "support/executors.hpp"
#include "support/occluders.hpp"
#include "support/scenes.hpp"

using namespace coppice;

namespace {

constexpr auto every_material = [](const Material&) { return true; };
const support::SphereOccluder nothing{};

/// A square of 2 × 2 m at y = 0, from above.
std::vector<SurfaceSample> ground_samples(std::size_t count) {
  Scene scene;
  scene.materials.resize(1);
  support::add_ground(scene.mesh, 1);
  const auto sides = triangle_sides(scene, every_material);
  return thin_samples(scatter_samples(scene.mesh, sides, 6 * count, Shares::by_area, 3), count);
}

std::vector<SplatPoint> points_above(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<SplatPoint> points(count);
  for (SplatPoint& p : points)
    p = {{1.8f * random.uniform() - 0.9f, 0, 1.8f * random.uniform() - 0.9f}, {0, 1, 0}};
  return points;
}

/// The weights by the formula, over all samples: what the search among the nearest must come to.
std::vector<float> all_weights(std::span<const SurfaceSample> samples, const SplatPoint& p) {
  std::vector<float> weights;
  float sum = 0;
  for (const SurfaceSample& s : samples) sum += weights.emplace_back(detail::splat_weight(s, p, {}));
  for (float& w : weights) w /= sum;
  return weights;
}

}  // namespace

TEST_CASE("the weights of splats are those of the formula over all samples, and sum to 1") {
  const auto samples = ground_samples(800);
  const auto points = points_above(200, 5);
  const SplatWeights splats = splat_weights(samples, points, nothing, Serial());
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::vector<float> found(samples.size(), 0.0f);
    double sum = 0;
    splats.for_each(i, [&](std::uint32_t s, float w) { found[s] = w, sum += double(w); });
    CHECK(sum == doctest::Approx(1).epsilon(1e-5));
    const std::vector<float> expected = all_weights(samples, points[i]);
    float worst = 0;
    for (std::size_t s = 0; s < samples.size(); ++s)
      worst = std::max(worst, std::fabs(found[s] - expected[s]));
    CHECK(worst < 0.01f);  // beyond the 24 nearest there is hardly anything
  }
}

TEST_CASE("splats keep what is even, and follow what is linear") {
  const auto samples = ground_samples(2000);
  const auto points = points_above(300, 6);
  const SplatWeights splats = splat_weights(samples, points, nothing, Serial());
  std::vector<vec2> values, out(points.size());
  for (const SurfaceSample& s : samples) values.emplace_back(0.7f, s.position.x);
  splat<vec2>(splats, values, out, Serial());
  const float spacing = 2 / std::sqrt(2000.0f);
  for (std::size_t i = 0; i < points.size(); ++i) {
    CHECK(out[i].x == doctest::Approx(0.7f).epsilon(1e-5));
    CHECK(std::fabs(out[i].y - points[i].position.x) < 0.6f * spacing);
  }
}

TEST_CASE("no light bleeds through a sheet, around an edge, or across a floor under a wall") {
  std::vector<SurfaceSample> samples;
  for (const float side : {-1.0f, 1.0f})
    for (int i = 0; i < 400; ++i) {
      const vec3 p(0.1f * float(i % 20), 0, 0.1f * float(i / 20));
      samples.push_back({p, 0.01f, vec3(0, side, 0), vec3(side), {}});
    }
  std::vector<vec3> sides, out(1);
  for (const SurfaceSample& s : samples) sides.push_back(s.colour);
  const auto light_at = [&](const SplatPoint& p, const auto& occluder) {
    splat<vec3>(splat_weights(samples, std::span(&p, 1), occluder, Serial()), sides, out, Serial());
    return out[0].x;
  };
  CHECK(light_at({{1, 0.001f, 1}, {0, 1, 0}}, nothing) == doctest::Approx(1));
  CHECK(light_at({{1, -0.001f, 1}, {0, -1, 0}}, nothing) == doctest::Approx(-1));

  // A wall at x = 1: left of it the floor is lit, right of it dark.
  for (std::size_t i = 0; i < samples.size(); ++i)
    sides[i] = vec3(samples[i].position.x < 0.97f ? 1.0f : 0.0f);
  Mesh wall;
  wall.positions = {{0.97f, -1, -1}, {0.97f, -1, 4}, {0.97f, 3, -1}};
  wall.triangles = {{0, 1, 2}};
  const support::TriangleTracer walls(wall);
  CHECK(light_at({{0.99f, 0, 0.8f}, {0, 1, 0}}, nothing) > 0.1f);
  CHECK(light_at({{0.99f, 0, 0.8f}, {0, 1, 0}}, walls) == 0);
  CHECK(light_at({{0.96f, 0, 0.8f}, {0, 1, 0}}, walls) == doctest::Approx(1));
}

TEST_CASE("a point far from all splats takes the nearest that faces alike, and without samples nothing") {
  const auto samples = ground_samples(50);
  const SplatPoint far{{30, 2, 0}, {0, 1, 0}}, below{{0, -1, 0}, {0, -1, 0}};
  for (const SplatPoint& p : {far, below}) {
    const SplatWeights splats = splat_weights(samples, std::span(&p, 1), nothing, Serial());
    REQUIRE(splats.samples.size() == 1);
    CHECK(splats.weights[0] == 1);
  }
  const SplatWeights none = splat_weights({}, std::span(&far, 1), nothing, Serial());
  CHECK(none.ends == std::vector<std::uint32_t>{0});
  std::vector<float> out(1, 5);
  splat<float>(none, {}, out, Serial());
  CHECK(out[0] == 0);
}

TEST_CASE("splats do not depend on how the work is cut up") {
  const auto samples = ground_samples(300);
  const auto points = points_above(1000, 8);
  const SplatWeights a = splat_weights(samples, points, nothing, Serial());
  const SplatWeights b = splat_weights(samples, points, nothing, support::Backwards());
  CHECK(a.ends == b.ends);
  CHECK(a.samples == b.samples);
  CHECK(a.weights == b.weights);
}
