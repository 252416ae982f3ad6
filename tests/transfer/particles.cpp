// Particles: what they reach, how evenly, and what they must leave out.
#include <doctest/doctest.h>

#include <coppice/transfer/free_space.hpp>

#include "rooms.hpp"
#include "support/executors.hpp"
#include "support/generators.hpp"

using namespace coppice;

namespace {

constexpr auto lambert = Shading::lambert;

/// How many candidates are `in`.
template <class In>
double share_of(const ParticleField& field, In&& in) {
  return double(std::ranges::count_if(field.candidates, in)) / double(field.candidates.size());
}

bool same_bits(const ParticleField& a, const ParticleField& b) {
  const auto same = [](const SurfaceSample& s, const SurfaceSample& t) {
    return s.position == t.position && s.area == t.area && s.colour == t.colour && s.normal == t.normal;
  };
  return a.particle == b.particle && a.area == b.area && a.stray == b.stray && a.escaped == b.escaped &&
         std::ranges::equal(a.candidates, b.candidates, same);
}

/// Goes through walls now and then, as rays do through cracks.
struct LeakyTracer {
  support::TriangleTracer tracer;
  std::uint64_t one_in;

  std::optional<Hit> closest(const vec3& origin, const vec3& direction) const {
    const auto hit = tracer.closest(origin, direction);
    if (!hit || Random(std::bit_cast<std::uint32_t>(direction.x)).bits() % one_in != 0) return hit;
    const float skipped = hit->t + 1e-4f;
    auto next = tracer.closest(origin + skipped * direction, direction);
    if (next) next->t += skipped;
    return next;
  }
};
static_assert(RayTracer<LeakyTracer>);

bool inside(const vec3& p, const vec3& low, const vec3& high) {
  return glm::all(glm::greaterThanEqual(p, low)) && glm::all(glm::lessThanEqual(p, high));
}

}  // namespace

TEST_CASE("in a closed box candidates are even by area wherever particles start") {
  const Scene scene = support::box_room();
  for (const vec3& start : {vec3(1, 1.5f, 2), vec3(0.01f, 0.02f, 3.99f)}) {
    const auto field = support::particles_in(scene, {start}, {.count = 20000, .shading = lambert});
    REQUIRE(field.candidates.size() == 20000);
    CHECK(field.escaped == 0);
    CHECK(field.stray == 0);
    CHECK_FALSE(field.sky);
    CHECK(field.area == doctest::Approx(52).epsilon(0.01));
    for (std::uint32_t face = 0; face < 6; ++face) {
      const double expected =
          (triangle_area(scene.mesh, 2 * face) + triangle_area(scene.mesh, 2 * face + 1)) / 52;
      const double share =
          share_of(field, [&](const SurfaceSample& s) { return s.side.triangle / 2 == face; });
      CHECK(std::abs(share - expected) < 4 * std::sqrt(expected * (1 - expected) / 20000));
    }
  }
}

TEST_CASE("candidates lie on the side that was hit, with its albedo, at the end of a free flight") {
  Scene scene = support::box_room();
  scene.materials[0].base_color = {0.1f, 0.6f, 0.3f};
  const support::TriangleTracer tracer(scene.mesh);
  const auto field = support::particles_in(scene, {vec3(1)}, {.count = 500, .shading = lambert});
  REQUIRE(field.flights.size() == field.candidates.size());
  double area = 0;
  for (std::size_t i = 0; i < field.candidates.size(); ++i) {
    const SurfaceSample& s = field.candidates[i];
    const Flight& f = field.flights[i];
    area += double(s.area);
    CHECK(length(position_at(scene.mesh, hit_of(s)) - s.position) < 1e-5f);
    CHECK(s.colour == scene.materials[0].base_color);
    CHECK(s.side.front);
    CHECK(dot(s.normal, f.from - f.to) > 0);
    CHECK(f.to == ray_origin(s));
    CHECK_FALSE(tracer.occluded(f.from, normalize(f.to - f.from), 0.9999f * length(f.to - f.from)));
  }
  CHECK(area == doctest::Approx(field.area).epsilon(1e-5));
}

TEST_CASE("over an open plane particles come back from the sky, and without it none arrives") {
  Scene scene;
  scene.materials = {support::wall()};
  support::add_ground(scene.mesh, 2);
  const auto field = support::particles_in(scene, {{0, 1, 0}}, {.count = 8000});
  CHECK(field.sky);
  REQUIRE(field.candidates.size() == 8000);
  CHECK(field.area == doctest::Approx(32).epsilon(0.02));  // both sides of 16 m²
  CHECK(std::abs(share_of(field, [](const SurfaceSample& s) { return s.side.front; }) - 0.5) < 0.025);
  const auto lost = support::particles_in(scene, {{0, 1, 0}}, {.count = 300, .escape = Escape::start_again});
  CHECK(lost.candidates.empty());
  CHECK(lost.area == 0);
  CHECK(lost.traced >= 300);
  CHECK(free_positions(lost.flights, 10, 1).empty());
}

TEST_CASE("particles find the second room through a door") {
  Scene scene;  // 4 × 2 × 2 m, a wall without thickness at x = 2, a door 0.6 m wide in it
  scene.materials = {support::wall()};
  support::add_room(scene.mesh, {0, 0, 0}, {4, 2, 2});
  support::add_quad(scene.mesh, {2, 0, 0}, {0, 0, 0.7f}, {0, 2, 0});
  support::add_quad(scene.mesh, {2, 0, 1.3f}, {0, 0, 0.7f}, {0, 2, 0});
  const auto field = support::particles_in(scene, {{0.5f, 1, 1}}, {.count = 30000});
  CHECK(field.area == doctest::Approx(40 + 2 * 2.8).epsilon(0.02));
  const double far = share_of(field, [](const SurfaceSample& s) { return ray_origin(s).x > 2; });
  CHECK(far > 0.45);
  CHECK(far < 0.54);
  const auto both = support::particles_in(scene, {{0.5f, 1, 1}, {3.5f, 1, 1}}, {.count = 30000});
  CHECK(both.area == doctest::Approx(45.6).epsilon(0.02));  // counted once
}

TEST_CASE("rooms that no door joins take a start each, and candidates by their areas") {
  Scene scene;
  scene.materials = {support::wall()};
  support::add_room(scene.mesh, {0, 0, 0}, {3, 3, 3});  // 54 m²
  support::add_room(scene.mesh, {5, 0, 0}, {6, 1, 1});  // 6 m²
  const auto in_small = [](const SurfaceSample& s) { return s.position.x > 4; };
  const auto one = support::particles_in(scene, {vec3(1)}, {.count = 20000});
  CHECK(share_of(one, in_small) == 0);
  CHECK(one.area == doctest::Approx(54).epsilon(0.02));
  const auto two = support::particles_in(scene, {vec3(1), vec3(5.5f, 0.5f, 0.5f)}, {.count = 20000});
  CHECK(two.area == doctest::Approx(60).epsilon(0.02));
  CHECK(share_of(two, in_small) == doctest::Approx(0.1).epsilon(0.05));
  CHECK(two.candidates.size() > 10000);
}

TEST_CASE("a closed solid is covered outside and empty inside, also where particles slip in") {
  const vec3 low(0.5f, 0.5f, 1), high(1.5f, 1.5f, 2), inner_low = low + 1e-4f, inner_high = high - 1e-4f;
  for (const bool double_sided : {true, false}) {
    Scene scene = support::box_room(double_sided);
    support::add_box(scene.mesh, low, high);
    const auto in_solid = [&](const SurfaceSample& s) {
      return inside(s.position, low, high) && inside(s.position + 0.01f * s.normal, inner_low, inner_high);
    };
    const auto tight = support::particles_in(scene, {vec3(0.2f)}, {.count = 20000});
    CHECK(share_of(tight, in_solid) == 0);
    CHECK(tight.stray == 0);
    CHECK(tight.area == doctest::Approx(58).epsilon(0.02));
    const LeakyTracer leaky{support::TriangleTracer(scene.mesh), double_sided ? 1500u : 12000u};
    const std::vector<vec3> starts{vec3(0.2f)};
    const auto field = trace_particles(scene, leaky, starts, Serial(), {.count = 60000});
    REQUIRE(field.stray > 20);
    if (!double_sided) CHECK(share_of(field, in_solid) == 0);
    CHECK(share_of(field, in_solid) * double(field.candidates.size()) < 0.3 * double(field.stray));
    CHECK(field.area == doctest::Approx(58).epsilon(0.03));
  }
}

TEST_CASE("particles need a scene, a start and a wish") {
  const Scene room = support::box_room();
  CHECK(support::particles_in(Scene(), {vec3(0)}, {}).candidates.empty());
  CHECK(support::particles_in(room, {}, {}).candidates.empty());
  CHECK(support::particles_in(room, {vec3(1)}, {.count = 0}).candidates.empty());
  const auto one = support::particles_in(room, {vec3(1)}, {.count = 1});
  REQUIRE(one.candidates.size() == 1);
  CHECK(one.candidates[0].area > 0);
  Scene triangle;
  triangle.materials = {support::wall()};
  for (const vec3& p : {vec3(0), vec3(1, 0, 0), vec3(0, 1, 0)})
    support::add_vertex(triangle.mesh, p, {0, 0, 1});
  support::add_triangle(triangle.mesh, {0, 1, 2});
  const auto field = support::particles_in(triangle, {vec3(0.2f, 0.2f, 1)}, {.count = 3000});
  CHECK(field.candidates.size() == 3000);
  CHECK(field.area == doctest::Approx(1).epsilon(0.02));
}

TEST_CASE("particles are the same for any executor and others for another seed") {
  const Scene scene = support::still_life();
  for (const ParticleOptions& options :
       {ParticleOptions{.count = 3000, .seed = 7}, {.count = 100, .seed = 3}}) {
    const auto serial = support::particles_in(scene, {vec3(0, 1, 1)}, options);
    CHECK(serial.sky);
    CHECK(same_bits(serial, support::particles_in(scene, {vec3(0, 1, 1)}, options, support::Backwards())));
    CHECK(same_bits(serial, support::particles_in(scene, {vec3(0, 1, 1)}, options, support::TwoThreads())));
    ParticleOptions other = options;
    ++other.seed;
    CHECK_FALSE(same_bits(serial, support::particles_in(scene, {vec3(0, 1, 1)}, other)));
  }
}

TEST_CASE("free positions fill the room evenly and keep clear of where flights end") {
  const Scene scene = support::box_room();
  const auto field = support::particles_in(scene, {vec3(1)}, {.count = 20000});
  const auto positions = free_positions(field.flights, 8000, 5, 0.1f);
  REQUIRE(positions.size() == 8000);
  glm::dvec3 mean(0), square(0);
  for (const vec3& p : positions) {
    CHECK(inside(p, vec3(0), {2, 3, 4}));
    mean += glm::dvec3(p) / 8000.0, square += glm::dvec3(p) * glm::dvec3(p) / 8000.0;
  }
  const glm::dvec3 size(2, 3, 4), variance = square - mean * mean;
  for (int k = 0; k < 3; ++k) {
    CHECK(mean[k] == doctest::Approx(size[k] / 2).epsilon(0.03));
    CHECK(variance[k] < 1.05 * size[k] * size[k] / 12);  // uniform: size² / 12, less what is kept clear
    CHECK(variance[k] > 0.8 * size[k] * size[k] / 12);
  }
  const auto fewer = free_positions(field.flights, 10, 5, 0.1f);
  CHECK(std::equal(fewer.begin(), fewer.end(), positions.begin()));
  CHECK(free_positions(field.flights, 10, 5, 100.0f).empty());
}

TEST_CASE("the area that is reached is found from a few hits") {
  rc::check([] {
    Random random = test_support::any_random();
    std::vector<float> cells(2000);
    double area = 0;
    for (float& c : cells) area += double(c = 0.1f + random.uniform());
    std::vector<std::uint8_t> hit(cells.size(), 0);
    for (std::size_t k = 0; k < 3000;) {  // by rejection
      const std::uint32_t i = random.below(2000);
      if (random.uniform() * 1.1f < cells[i]) hit[i] = 1, ++k;
    }
    std::vector<float> found;
    for (std::size_t i = 0; i < cells.size(); ++i)
      if (hit[i]) found.push_back(cells[i]);
    RC_ASSERT(test_support::close(detail::reached_area(found, 3000), area, 0.08));
  });
}
