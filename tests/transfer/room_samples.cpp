// Samples of rooms: even, on the surface, with all its area; sheets keep their sides apart.
#include <doctest/doctest.h>

#include <coppice/reference/dart_throwing.hpp>
#include <coppice/transfer/room_samples.hpp>

#include "rooms.hpp"
#include "support/executors.hpp"
#include "support/generators.hpp"

using namespace coppice;

namespace {

double area_of(std::span<const SurfaceSample> samples) {
  double area = 0;
  for (const SurfaceSample& s : samples) area += double(s.area);
  return area;
}

/// Distance to the nearest other that faces alike.
float nearest_distance(std::span<const SurfaceSample> samples, const SurfaceSample& s) {
  float nearest = 1e9f;
  for (const SurfaceSample& other : samples)
    if (&other != &s && detail::faces_alike(s, other))
      nearest = std::min(nearest, length(other.position - s.position));
  return nearest;
}

const ParticleField& box_field() {
  static const ParticleField field = support::particles_in(support::box_room(), {vec3(1)}, {.count = 6000});
  return field;
}

bool same_bits(std::span<const SurfaceSample> a, std::span<const SurfaceSample> b) {
  return std::ranges::equal(a, b, [](const SurfaceSample& s, const SurfaceSample& t) {
    return s.position == t.position && s.area == t.area && s.colour == t.colour;
  });
}

}  // namespace

TEST_CASE("room samples lie evenly on the walls and have all their area") {
  const ParticleField& field = box_field();
  const auto samples = room_samples(field.candidates, Serial(), {.count = 1000});
  CHECK(samples.size() > 990);
  CHECK(samples.size() <= 1000);
  CHECK(area_of(samples) == doctest::Approx(field.area).epsilon(1e-4));
  const double spacing = std::sqrt(field.area / 1000);
  double mean = 0, square = 0;
  for (const SurfaceSample& s : samples) {
    const double distance = double(nearest_distance(samples, s)) / spacing;
    mean += distance / double(samples.size()), square += double(s.area) * double(s.area);
    CHECK(std::ranges::any_of(field.candidates, [&](auto& c) { return c.position == s.position; }));
  }
  CHECK(mean > 0.75);  // random points: 0.5
  const double each = area_of(samples) / double(samples.size());
  CHECK(square / double(samples.size()) / (each * each) - 1 <
        0.5 * 0.5);  // six candidates a cell alone: 0.41
}

TEST_CASE("a radius keeps about as many samples as a throw of darts") {
  const ParticleField& field = box_field();
  const float radius = 0.35f;
  const auto darts = reference::throw_darts(field.candidates, radius, 1);
  const double expected = samples_for_radius(field.area, double(radius));
  CHECK(double(darts.size()) == doctest::Approx(expected).epsilon(0.15));  // edges hold a few more
  CHECK(radius_for_samples(field.area, expected) == doctest::Approx(double(radius)));
  const auto samples = room_samples(field.candidates, Serial(), {.count = 7, .radius = radius});
  CHECK(double(samples.size()) == doctest::Approx(expected).epsilon(0.02));
  for (const SurfaceSample& c : field.candidates) {  // none is left out by more than about the radius
    float nearest = 1e9f;
    for (const SurfaceSample& s : samples)
      if (detail::faces_alike(s, c)) nearest = std::min(nearest, length(s.position - c.position));
    CHECK(nearest < 1.25f * radius);
  }
}

TEST_CASE("the two sides of a sheet have samples of their own") {
  Scene scene = support::box_room();
  scene.materials.push_back(support::wall({0, 1, 0}));
  support::add_quad(scene.mesh, {0.2f, 1, 0.2f}, {1.6f, 0, 0}, {0, 0, 3.6f}, 1);  // 5.76 m² a side
  const auto field =
      support::particles_in(scene, {vec3(1, 2, 2)}, {.count = 12000, .shading = Shading::lambert});
  const auto samples = room_samples(field.candidates, Serial(), {.count = 2000});
  double above = 0, below = 0;
  for (const SurfaceSample& s : samples) {
    if (s.side.triangle < 12) continue;
    CHECK(s.colour == vec3(0, 1, 0));
    (s.normal.y > 0 ? above : below) += double(s.area);
  }
  CHECK(above == doctest::Approx(5.76).epsilon(0.08));
  CHECK(below == doctest::Approx(5.76).epsilon(0.08));
}

TEST_CASE("curved surfaces have more samples where that is wanted") {
  Scene scene = support::box_room();
  support::add_ball(scene.mesh, {1, 1, 1}, 0.4f, 12);
  const auto field = support::particles_in(scene, {vec3(1, 2.5f, 3)}, {.count = 8000});
  const auto on_ball = [&](float curvature) {
    const auto samples = room_samples(field.candidates, Serial(), {.count = 1200, .curvature = curvature});
    CHECK(area_of(samples) == doctest::Approx(field.area).epsilon(1e-4));
    return double(std::ranges::count_if(
        samples, [](const SurfaceSample& s) { return length(s.position - vec3(1)) < 0.45f; }));
  };
  const double plain = on_ball(1), most = on_ball(2);
  CHECK(plain == doctest::Approx(1200 * 2.0 / 54).epsilon(0.25));
  CHECK(most > 2.0 * plain);
  CHECK(most < 4.5 * plain);
  const double some = on_ball(1.5f);
  CHECK(some > plain);
  CHECK(some < most);
}

TEST_CASE("room samples for none, one and all candidates") {
  const ParticleField& field = box_field();
  CHECK(room_samples(field.candidates, Serial(), {.count = 0}).empty());
  CHECK(room_samples(std::span<const SurfaceSample>(), Serial()).empty());
  const auto one = room_samples(field.candidates, Serial(), {.count = 1});
  REQUIRE(one.size() == 1);
  CHECK(double(one[0].area) == doctest::Approx(field.area).epsilon(1e-4));
  CHECK(same_bits(room_samples(field.candidates, Serial(), {.count = 6000}), field.candidates));
}

TEST_CASE("room samples are the same for any executor") {
  const auto& candidates = box_field().candidates;
  const auto serial = room_samples(candidates, Serial(), {.count = 700});
  CHECK(same_bits(serial, room_samples(candidates, support::Backwards(), {.count = 700})));
  CHECK(same_bits(serial, room_samples(candidates, support::TwoThreads(), {.count = 700})));
}

TEST_CASE("the grid finds what lies within a distance, and nothing else") {
  rc::check([] {
    Random random = test_support::any_random();
    std::vector<SurfaceSample> samples(1 + random.below(60));
    for (auto& s : samples)
      s.position = vec3(random.uniform(), random.uniform(), 0.2f * random.uniform()) - 0.5f;
    const float reach = 0.02f + 0.5f * random.uniform();
    const detail::NearSamples near(samples, reach);
    const vec3 p = samples[random.below(std::uint32_t(samples.size()))].position;
    std::vector<std::uint32_t> found, expected;
    near.for_each_within(p, reach, [&](std::uint32_t i, float) { found.push_back(i); });
    for (std::uint32_t i = 0; i < samples.size(); ++i) {
      const vec3 way = samples[i].position - p;
      if (dot(way, way) <= reach * reach) expected.push_back(i);
    }
    std::ranges::sort(found);
    RC_ASSERT(found == expected);
  });
}
