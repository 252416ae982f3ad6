// Thinned samples: even, and with the area and the colour of all candidates.
#include <doctest/doctest.h>

#include <coppice/light/thin_samples.hpp>

#include "support/scenes.hpp"

using namespace coppice;

namespace {

constexpr auto every_material = [](const Material&) { return true; };

std::vector<SurfaceSample> candidates_on(const Scene& scene, std::size_t count, std::uint64_t seed = 1) {
  return scatter_samples(scene.mesh, triangle_sides(scene, every_material), count, Shares::by_area, seed);
}

Scene unit_square() {
  Scene scene;
  scene.materials.resize(1);
  support::add_ground(scene.mesh, 0.5f);
  return scene;
}

/// Mean distance to the nearest neighbour, over that of as many points in a hexagonal lattice on area 1.
double evenness(std::span<const SurfaceSample> samples) {
  double sum = 0;
  for (const SurfaceSample& a : samples) {
    float nearest = 1e9f;
    for (const SurfaceSample& b : samples)
      if (&a != &b) nearest = std::min(nearest, length(a.position - b.position));
    sum += double(nearest);
  }
  const double count = double(samples.size());
  return sum / count / std::sqrt(2 / (std::sqrt(3.0) * count));
}

struct Totals {
  double area = 0;
  glm::dvec3 colour{0};
};
Totals totals_of(std::span<const SurfaceSample> samples) {
  Totals t;
  for (const SurfaceSample& s : samples) {
    t.area += double(s.area);
    t.colour += double(s.area) * glm::dvec3(s.colour);
  }
  return t;
}

}  // namespace

TEST_CASE("thinned samples lie evenly, in place and in area") {
  const Scene scene = unit_square();
  for (const std::uint64_t seed : {1u, 2u}) {
    const auto candidates = candidates_on(scene, 5000, seed);
    const auto samples = thin_samples(candidates, 1000);
    REQUIRE(samples.size() == 1000);
    CHECK(evenness(samples) > 0.74);  // random points: 0.47
    double spread = 0;
    for (const SurfaceSample& s : samples) spread += std::pow(double(s.area) * 1000 - 1, 2) / 1000;
    CHECK(std::sqrt(spread) < 0.3);  // random points: 0.53
  }
}

TEST_CASE("a thinned square integrates smooth functions as a midpoint rule does") {
  const Scene scene = unit_square();
  const auto samples = thin_samples(candidates_on(scene, 5000), 1000);
  double square = 0, linear = 0;
  for (const SurfaceSample& s : samples) {
    square += double(s.area * s.position.x * s.position.x);
    linear += double(s.area * s.position.z);
  }
  CHECK(std::abs(square - 1.0 / 12) < 5e-4);
  CHECK(std::abs(linear) < 5e-4);
}

TEST_CASE("area and colour are kept, whatever the count") {
  const Scene scene = support::still_life();
  auto candidates = candidates_on(scene, 3000);
  Random random(7);
  for (SurfaceSample& c : candidates) c.colour = {random.uniform(), 1e6f * random.uniform(), 0};
  const Totals before = totals_of(candidates);
  for (const std::size_t count : {1u, 2u, 17u, 700u, 2999u, 3000u, 9000u}) {
    CAPTURE(count);
    const auto samples = thin_samples(candidates, count);
    CHECK(samples.size() <= std::min<std::size_t>(count, 3000));
    CHECK(samples.size() + 2 >= std::min<std::size_t>(count, 3000));
    const Totals after = totals_of(samples);
    CHECK(after.area == doctest::Approx(before.area).epsilon(1e-5));
    for (int k = 0; k < 3; ++k) CHECK(after.colour[k] == doctest::Approx(before.colour[k]).epsilon(1e-5));
  }
}

TEST_CASE("the two sides of a sheet do not mix") {
  Scene scene = unit_square();
  scene.materials[0].double_sided = true;
  auto candidates = candidates_on(scene, 4000);
  for (SurfaceSample& c : candidates) c.colour = c.side.front ? vec3(1, 0, 0) : vec3(0, 0, 1);
  const auto samples = thin_samples(candidates, 800);
  double front = 0;
  for (const SurfaceSample& s : samples) {
    CHECK(s.colour == (s.side.front ? vec3(1, 0, 0) : vec3(0, 0, 1)));
    CHECK(s.normal.y == (s.side.front ? 1.0f : -1.0f));
    front += s.side.front ? double(s.area) : 0.0;
  }
  CHECK(front == doctest::Approx(1).epsilon(1e-3));
  CHECK(std::abs(int(std::ranges::count_if(samples, [](auto& s) { return s.side.front; })) - 400) < 25);
}

TEST_CASE("thinning is a function of its input, and samples are candidates in their order") {
  const auto candidates = candidates_on(support::still_life(), 2000);
  const auto a = thin_samples(candidates, 300), b = thin_samples(candidates, 300);
  REQUIRE(a.size() == b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    CHECK(a[i].position == b[i].position);
    CHECK(a[i].area == b[i].area);
    CHECK(std::ranges::any_of(candidates, [&](const auto& c) { return c.position == a[i].position; }));
  }
}

TEST_CASE("nothing to thin, and candidates that coincide") {
  CHECK(thin_samples({}, 5).empty());
  const auto candidates = candidates_on(unit_square(), 50);
  CHECK(thin_samples(candidates, 0).empty());
  const std::vector<SurfaceSample> same(100, candidates[0]);
  for (const std::size_t count : {1u, 10u, 99u}) {
    const auto samples = thin_samples(same, count);
    CHECK(!samples.empty());
    CHECK(totals_of(samples).area == doctest::Approx(100 * double(candidates[0].area)).epsilon(1e-5));
    for (const SurfaceSample& s : samples) CHECK((is_finite(s.colour) && s.area > 0));
  }
}
