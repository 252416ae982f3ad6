// Lattice visibility: against its uncompressed twin and shadow rays, at the extremes, on any threads.
#include <doctest/doctest.h>

#include <coppice/reference/lattice_visibility.hpp>
#include <coppice/transfer/decisions.hpp>
#include <coppice/transfer/lattice_fit.hpp>

#include "support/executors.hpp"
#include "support/generators.hpp"
#include "support/occluders.hpp"
#include "support/scenes.hpp"

using namespace coppice;

namespace {

/// A room of 4 × 2 × 2 metres with a thin wall at x = 0 through all of it, or through half.
struct Room {
  Scene scene;
  ClusteredSamples samples;
  std::vector<vec3> free;

  explicit Room(bool divided, std::size_t count = 300) {
    Material both;
    both.double_sided = true;
    scene.materials = {both};
    support::add_box(scene.mesh, {-2, 0, -1}, {2, 2, 1});
    support::add_quad(scene.mesh, {0.05f, 0, -1}, {0, 2, 0}, {0, 0, divided ? 2.0f : 1.0f});
    const auto sides = triangle_sides(scene, [](const Material&) { return true; });
    for (const auto& s : scatter_samples(scene.mesh, sides, count, Shares::by_area, 3))
      if (inside(s.position + 0.01f * s.normal)) samples.samples.push_back(s);
    const auto size = std::uint32_t(samples.size());
    samples.ends = {size / 3, size / 2, size};
    free = lights(3000, 5);
  }
  static bool inside(const vec3& p) { return std::abs(p.x) < 2 && p.y > 0 && p.y < 2 && std::abs(p.z) < 1; }
  static std::vector<vec3> lights(std::size_t count, std::uint64_t seed) {
    Random random(seed);
    std::vector<vec3> result;
    for (std::size_t i = 0; i < count; ++i) {
      const float x = random.uniform(), y = random.uniform(), z = random.uniform();
      result.push_back({3.8f * x - 1.9f, 1.8f * y + 0.1f, 1.8f * z - 0.9f});
    }
    return result;
  }
};

SizedLight bulb(const vec3& p, float radius = 0) { return {point_light(p, vec3(1)), radius}; }

template <class Visibility, Occluder O>
WrongDecisions judge(const Room& room, const Visibility& visibility, const O& occluder) {
  std::vector<float> out(room.samples.size());
  std::vector<SizedLight> lights;
  for (const vec3& p : Room::lights(40, 77)) lights.push_back(bulb(p));
  return wrong_decisions(room.samples.samples, lights, occluder, Serial(), [&](const SizedLight& light) {
    CHECK(lattice_visibility(visibility, light, LatticeShadow::hard, occluder, Serial(), out));
    return std::span<const float>(out);
  });
}

}  // namespace

TEST_CASE("at full rank, lights on lattice points cast the twin's shadows") {
  const Room room(false);
  const support::TriangleTracer tracer(room.scene.mesh);
  const LightLattice lattice = light_lattice(std::span<const vec3>(room.free), 1.1f, tracer);
  const auto twin = reference::lattice_visibility(room.samples.samples, lattice, tracer);
  const auto fitted = fit_lattice_visibility<std::int16_t>(
      room.samples, lattice, {}, tracer, Serial(),
      {.rank = lattice.count() + 1, .rounds = 30, .cap = 1, .relaxation = 1});
  std::vector<float> out(room.samples.size());
  std::size_t hidden = 0;
  for (std::uint32_t p = 0; p < lattice.count(); ++p) {
    LatticeCorners corners;
    corners.points[0] = p, corners.weights[0] = 1, corners.count = 1;
    CHECK(lattice_visibility(fitted, std::span(&corners, 1), LatticeShadow::hard, Serial(), out));
    for (std::size_t i = 0; i < out.size(); ++i) {
      const float exact = reference::margin(twin, i, corners);
      if (exact == 0) continue;
      CHECK((out[i] == 1) == (exact > 0));
      hidden += exact < 0;
    }
  }
  CHECK(hidden > 100);
}

TEST_CASE("unseen lights: few wrong decisions, fewer with free margins and a fit through the interpolation") {
  const Room room(false, 1500);
  const support::TriangleTracer tracer(room.scene.mesh);
  const LightLattice lattice = light_lattice(std::span<const vec3>(room.free), 0.4f, tracer);
  const auto lights = Room::lights(1500, 11);
  const auto plain =
      fit_lattice_visibility(room.samples, lattice, {}, tracer, Serial(), {.rank = 6, .cap = 1});
  const auto margins = fit_lattice_visibility(room.samples, lattice, {}, tracer, Serial(), {.rank = 6});
  const auto trained = fit_lattice_visibility(room.samples, lattice, lights, tracer, Serial(), {.rank = 6});
  const double a = judge(room, plain, tracer).plain, b = judge(room, margins, tracer).plain,
               c = judge(room, trained, tracer).plain;
  CAPTURE(a);
  CAPTURE(b);
  CAPTURE(c);
  CHECK(b < a);
  CHECK(c < b);
  CHECK(c < 0.04);
}

TEST_CASE("nothing leaks through a thin wall between two rooms") {
  const Room room(true, 600);
  const support::TriangleTracer tracer(room.scene.mesh);
  const LightLattice lattice = light_lattice(std::span<const vec3>(room.free), 0.5f, tracer);
  const auto twin = reference::lattice_visibility(room.samples.samples, lattice, tracer);
  const auto fitted =
      fit_lattice_visibility(room.samples, lattice, Room::lights(800, 11), tracer, Serial(), {.rank = 8});
  std::vector<float> out(room.samples.size());
  std::size_t pairs = 0, leaks = 0;
  for (const vec3& p : Room::lights(60, 77)) {
    CHECK(lattice_visibility(fitted, bulb(p), LatticeShadow::hard, tracer, Serial(), out));
    const LatticeCorners corners = lattice_corners(lattice, p, tracer);
    for (std::size_t i = 0; i < out.size(); ++i) {
      const SurfaceSample& s = room.samples.samples[i];
      const bool apart = ((s.position + 0.01f * s.normal).x < 0.05f) != (p.x < 0.05f);
      if (!apart || !path_to(point_light(p, vec3(1)), ray_origin(s), s.normal)) continue;
      CHECK(reference::margin(twin, i, corners) <= 0);
      ++pairs, leaks += out[i] != 0;
    }
  }
  CHECK(pairs > 1000);
  CHECK(leaks < pairs / 500);
}

TEST_CASE("a light that the lattice does not serve is told, and nothing is written") {
  const Room room(false, 100);
  const support::TriangleTracer tracer(room.scene.mesh);
  const auto fitted = fit_lattice_visibility(
      room.samples, light_lattice(std::span<const vec3>(room.free), 0.7f, tracer), {}, tracer, Serial(), {});
  std::vector<float> out(room.samples.size(), 7);
  CHECK(!lattice_visibility(fitted, bulb(vec3(50, 0, 0)), LatticeShadow::hard, tracer, Serial(), out));
  CHECK(!lattice_visibility(fitted, std::span<const LatticeCorners>(), LatticeShadow::smooth, Serial(), out));
  CHECK(std::all_of(out.begin(), out.end(), [](float x) { return x == 7; }));
}

TEST_CASE("no lattice, no samples, no light to learn from, rank 0 and a rank above what there is") {
  const Room room(false, 100);
  const support::TriangleTracer tracer(room.scene.mesh);
  const LightLattice lattice = light_lattice(std::span<const vec3>(room.free), 0.9f, tracer);
  std::vector<float> out(room.samples.size());
  const auto at = [&](const auto& fitted, std::span<float> to) {
    return lattice_visibility(fitted, bulb(vec3(1, 1, 0.2f)), LatticeShadow::hard, tracer, Serial(), to);
  };
  CHECK(!at(fit_lattice_visibility(room.samples, LightLattice(), {}, tracer, Serial(), {}), out));
  CHECK(at(fit_lattice_visibility(ClusteredSamples(), lattice, {}, tracer, Serial(), {}), {}) == true);
  const auto nothing = fit_lattice_visibility(room.samples, lattice, {}, tracer, Serial(), {.rank = 0});
  CHECK(at(nothing, out));
  CHECK(std::all_of(out.begin(), out.end(), [](float x) { return x == 0; }));
  const std::vector<vec3> far{vec3(90)}, one{vec3(1, 1, 0)};
  for (const auto* lights : {&far, &one}) {
    const auto fitted = fit_lattice_visibility(room.samples, lattice, *lights, tracer, Serial(), {});
    CHECK(at(fitted, out));
    for (const auto& cluster : fitted.clusters)
      for (const float scale : cluster.scales) CHECK(std::isfinite(scale));
  }
  const auto rich = fit_lattice_visibility(room.samples, lattice, {}, tracer, Serial(), {.rank = 300});
  CHECK(at(rich, out));
  for (const auto& cluster : rich.clusters)
    for (const float scale : cluster.scales) CHECK(std::isfinite(scale));
}

TEST_CASE("the same bits for any threads") {
  const Room room(false, 200);
  const support::TriangleTracer tracer(room.scene.mesh);
  const LightLattice lattice = light_lattice(std::span<const vec3>(room.free), 0.7f, tracer);
  const auto lights = Room::lights(200, 11);
  const auto fit = [&](const auto& executor) {
    return fit_lattice_visibility(room.samples, lattice, lights, tracer, executor, {.rank = 5});
  };
  const auto a = fit(Serial()), b = fit(support::TwoThreads()), c = fit(support::Backwards());
  std::vector<float> x(room.samples.size()), y(x);
  for (std::size_t k = 0; k < a.clusters.size(); ++k) {
    CHECK((a.clusters[k].coefficients == b.clusters[k].coefficients &&
           a.clusters[k].rows == b.clusters[k].rows));
    CHECK((a.clusters[k].coefficients == c.clusters[k].coefficients &&
           a.clusters[k].scales == c.clusters[k].scales));
  }
  for (const LatticeShadow shadow : {LatticeShadow::hard, LatticeShadow::smooth}) {
    CHECK(lattice_visibility(a, bulb(vec3(-1, 1, 0), 0.2f), shadow, tracer, Serial(), x));
    CHECK(lattice_visibility(a, bulb(vec3(-1, 1, 0), 0.2f), shadow, tracer, support::TwoThreads(), y));
    CHECK(x == y);
  }
}

TEST_CASE("a light with a size is the mean of its points' decisions, and near the mean of rays") {
  const Room room(false, 800);
  const support::TriangleTracer tracer(room.scene.mesh);
  const auto fitted =
      fit_lattice_visibility(room.samples, light_lattice(std::span<const vec3>(room.free), 0.4f, tracer),
                             Room::lights(1500, 11), tracer, Serial(), {.rank = 10});
  const SizedLight light = bulb(vec3(-0.8f, 1, 0.3f), 0.3f);
  const std::size_t n = room.samples.size();
  std::vector<float> hard(n), smooth(n), one(n), mean(n, 0.0f), exact(n);
  CHECK(lattice_visibility(fitted, light, LatticeShadow::hard, tracer, Serial(), hard));
  CHECK(lattice_visibility(fitted, light, LatticeShadow::smooth, tracer, Serial(), smooth));
  exact_visibility<support::TriangleTracer, Serial>(room.samples.samples, points_of(light), tracer, Serial(),
                                                    exact);
  for (const LocalLight& point : points_of(light)) {
    CHECK(lattice_visibility(fitted, SizedLight{point, 0}, LatticeShadow::hard, tracer, Serial(), one));
    for (std::size_t i = 0; i < n; ++i) mean[i] += one[i] / 25;
  }
  double off_hard = 0, off_smooth = 0, counted = 0;
  for (std::size_t i = 0; i < n; ++i) {
    CHECK(hard[i] == doctest::Approx(mean[i]).epsilon(1e-5));
    CHECK((smooth[i] >= 0 && smooth[i] <= 1));
    const SurfaceSample& s = room.samples.samples[i];
    if (dot(light.light.position - s.position, s.normal) < 0.31f) continue;
    off_hard += double(std::abs(hard[i] - exact[i])), off_smooth += double(std::abs(smooth[i] - exact[i]));
    counted += 1;
  }
  CHECK(off_hard / counted < 0.04);
  CHECK(off_smooth / counted < 0.08);
}
