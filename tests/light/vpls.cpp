// Where VPLs lie: on all the area, evenly, as densely as light arrives, and on what moves.
#include <doctest/doctest.h>

#include <coppice/light/vpls.hpp>
#include <coppice/scene/pose.hpp>

#include "support/executors.hpp"
#include "support/occluders.hpp"
#include "support/scenes.hpp"

using namespace coppice;

namespace {

constexpr VplDensity densities[]{VplDensity::area, VplDensity::root_irradiance, VplDensity::irradiance};
constexpr VplSpread spreads[]{VplSpread::elimination, VplSpread::repulsion};
const support::SphereOccluder nothing{};

Scene square(float half_width = 0.5f) {
  Scene scene;
  scene.materials.resize(1);
  support::add_ground(scene.mesh, half_width);
  return scene;
}

/// A room of walls that face inwards and outwards, with a box in it.
Scene furnished_room() {
  Scene scene;
  scene.materials.resize(2);
  scene.materials[0].double_sided = true;
  support::add_box(scene.mesh, {-2, 0, -1.5f}, {2, 2.5f, 1.5f}, 0);
  support::add_box(scene.mesh, {0.3f, 0.5f, -0.5f}, {1.3f, 0.9f, 0.5f}, 1);
  return scene;
}
const std::vector<LocalLight> bulb{point_light({-0.3f, 1.7f, 0.2f}, {2, 4, 1})};
const double room_area = 2 * 2 * (4 * 2.5 + 3 * 2.5 + 4 * 3) + 2 * (0.4 + 1 + 0.4);

template <Occluder O, Executor E = Serial>
std::vector<SurfaceSample> place(const Scene& scene, std::span<const LocalLight> lights, const O& occluder,
                                 const VplOptions& options, const E& executor = {}) {
  return place_vpls(scene, lights, occluder, executor, options);
}

double area_of(std::span<const SurfaceSample> vpls) {
  double sum = 0;
  for (const SurfaceSample& v : vpls) sum += double(v.area);
  return sum;
}

template <class F>
double sum_over(std::span<const SurfaceSample> vpls, F&& f) {
  double sum = 0;
  for (const SurfaceSample& v : vpls) sum += double(v.area) * double(f(v));
  return sum;
}

/// Mean distance to the nearest neighbour over that of as many points in a hexagonal lattice on their area.
double evenness(std::span<const SurfaceSample> vpls) {
  double sum = 0;
  for (const SurfaceSample& a : vpls) {
    float nearest = 1e9f;
    for (const SurfaceSample& b : vpls)
      if (&a != &b) nearest = std::min(nearest, length(a.position - b.position));
    sum += double(nearest);
  }
  const double count = double(vpls.size());
  return sum / count / std::sqrt(2 * area_of(vpls) / (std::sqrt(3.0) * count));
}

bool same(const SurfaceSample& a, const SurfaceSample& b) {
  return a.position == b.position && a.area == b.area && a.normal == b.normal && a.u == b.u && a.v == b.v &&
         a.side.triangle == b.side.triangle && a.side.front == b.side.front;
}
bool same(std::span<const SurfaceSample> a, std::span<const SurfaceSample> b) {
  return std::ranges::equal(a, b, [](const auto& x, const auto& y) { return same(x, y); });
}

}  // namespace

TEST_CASE("VPLs stand for all the area, for any density and spread") {
  const Scene scene = furnished_room();
  const support::TriangleTracer tracer(scene.mesh);
  for (const VplDensity density : densities)
    for (const VplSpread spread : spreads) {
      CAPTURE(int(density));
      CAPTURE(int(spread));
      const auto vpls = place(scene, bulb, tracer, {.count = 600, .density = density, .spread = spread});
      CHECK(vpls.size() <= 600);
      CHECK(vpls.size() >= 590);
      CHECK(area_of(vpls) == doctest::Approx(room_area).epsilon(2e-3));
      for (const SurfaceSample& v : vpls) {
        CHECK((v.area > 0 && v.u >= 0 && v.v >= 0 && v.u + v.v <= 1.0001f));
        CHECK(length(v.position - position_at(scene.mesh, hit_of(v))) < 1e-5f);
        CHECK((v.side.front || scene.materials[scene.mesh.materials[v.side.triangle]].double_sided));
      }
    }
}

TEST_CASE("VPLs of equal density lie evenly, in place and in area") {
  const Scene scene = square();
  for (const VplSpread spread : spreads) {
    CAPTURE(int(spread));
    const auto vpls =
        place(scene, {}, nothing, {.count = 1000, .density = VplDensity::area, .spread = spread});
    REQUIRE(vpls.size() == 1000);
    CHECK(evenness(vpls) > 0.74);  // random points: 0.47
    double variance = 0;
    for (const SurfaceSample& v : vpls) variance += std::pow(double(v.area) * 1000 - 1, 2) / 1000;
    CHECK(std::sqrt(variance) < (spread == VplSpread::elimination ? 0.26 : 0.35));  // random points: 0.53
  }
}

TEST_CASE("with a density that follows the light, VPLs are as many as it asks for, and still even") {
  const Scene scene = square(2);
  const std::vector<LocalLight> lamp{point_light({0, 0.7f, 0}, vec3(1))};
  const auto wanted = [&](const vec3& p, VplDensity density) {
    const double e = std::pow(dot(p, p) + 0.49, -1.5);
    return density == VplDensity::irradiance ? e : std::sqrt(e);
  };
  for (const VplDensity density : {VplDensity::root_irradiance, VplDensity::irradiance})
    for (const VplSpread spread : spreads) {
      CAPTURE(int(density));
      CAPTURE(int(spread));
      const auto vpls = place(scene, lamp, nothing, {.count = 2000, .density = density, .spread = spread});
      double inner = 0, inner_wanted = 0, total = 0;
      for (int x = 0; x < 200; ++x)
        for (int z = 0; z < 200; ++z) {
          const vec3 p(-2 + 0.02f * (float(x) + 0.5f), 0, -2 + 0.02f * (float(z) + 0.5f));
          const double w = wanted(p, density);
          total += w, inner_wanted += length(p) < 0.8f ? w : 0;
        }
      for (const SurfaceSample& v : vpls) inner += length(v.position) < 0.8f ? 1 : 0;
      CHECK(inner / double(vpls.size()) == doctest::Approx(inner_wanted / total).epsilon(0.12));
      CHECK(area_of(vpls) == doctest::Approx(16).epsilon(2e-3));
    }
}

TEST_CASE("sums over area do not depend on the density") {
  const Scene scene = furnished_room();
  const support::TriangleTracer tracer(scene.mesh);
  const auto smooth = [](const SurfaceSample& v) {
    return 2 + std::sin(v.position.x + 2 * v.position.y) + 0.5f * v.normal.y + v.position.z * v.position.z;
  };
  const auto lit = [&](const SurfaceSample& v) {
    const auto path = path_to(bulb[0], ray_origin(v), v.normal);
    return path && !tracer.occluded(ray_origin(v), path->direction, path->t_max) ? path->irradiance.y : 0.0f;
  };
  const auto up = [](const SurfaceSample& v) { return v.normal.y > 0.9f ? 1.0f : 0.0f; };
  const auto many = scatter_samples(scene.mesh, triangle_sides(scene, [](const Material&) { return true; }),
                                    200000, Shares::by_area, 1);
  for (const VplDensity density : densities)
    for (const VplSpread spread : spreads)
      for (const std::uint64_t seed : {1u, 2u}) {
        CAPTURE(int(density));
        CAPTURE(int(spread));
        const auto vpls =
            place(scene, bulb, tracer, {.count = 1000, .density = density, .spread = spread, .seed = seed});
        CHECK(sum_over(vpls, smooth) == doctest::Approx(sum_over(many, smooth)).epsilon(0.02));
        CHECK(sum_over(vpls, lit) == doctest::Approx(sum_over(many, lit)).epsilon(0.03));
        CHECK(sum_over(vpls, up) == doctest::Approx(sum_over(many, up)).epsilon(0.005));
      }
}

TEST_CASE("lit sides take most VPLs, and dark ones keep some") {
  const Scene scene = furnished_room();  // the outsides of its walls are dark: half of all area
  const support::TriangleTracer tracer(scene.mesh);
  const auto vpls = place(scene, bulb, tracer, {.count = 1000, .density = VplDensity::irradiance});
  const auto dark = std::ranges::count_if(vpls, [&](const SurfaceSample& v) {
    const vec3 to_light = bulb[0].position - v.position;
    return !path_to(bulb[0], v.position, v.normal) ||
           tracer.occluded(ray_origin(v), normalize(to_light), 0.999f * length(to_light));
  });
  CHECK(dark > 20);
  CHECK(dark < 250);
}

TEST_CASE("holes of an alpha mask take no VPLs") {
  Scene scene = square(1);
  for (std::size_t i = 0; i < 4; ++i)
    scene.mesh.uvs[i] = {scene.mesh.positions[i].x > 0 ? 0.99f : 0.01f, 0.5f};
  scene.materials[0].alpha_mask = true;
  scene.materials[0].base_color_texture = 0;
  scene.textures.push_back({.width = 2, .height = 1, .rgba = {9, 9, 9, 255, 9, 9, 9, 0}});
  const auto vpls = place(scene, {}, nothing, {.count = 200});
  CHECK(area_of(vpls) == doctest::Approx(2).epsilon(0.03));
  for (const SurfaceSample& v : vpls) CHECK(is_solid(scene, v));
  scene.textures[0].rgba = {9, 9, 9, 0, 9, 9, 9, 0};
  CHECK(place(scene, {}, nothing, {.count = 200}).empty());
}

TEST_CASE("a dense front does not take the area of a sparse back, however near") {
  Scene scene = square(1);
  scene.materials[0].double_sided = true;
  const support::TriangleTracer tracer(scene.mesh);
  const std::vector<LocalLight> lamp{point_light({0, 1, 0}, vec3(1))};
  const auto vpls = place(scene, lamp, tracer, {.count = 1000, .density = VplDensity::irradiance});
  const double front = sum_over(vpls, [](const SurfaceSample& v) { return v.side.front ? 1.0f : 0.0f; });
  CHECK(front == doctest::Approx(4).epsilon(2e-3));
  CHECK(std::ranges::count_if(vpls, [](const auto& v) { return !v.side.front; }) < 120);
}

TEST_CASE("without light the density is the area's: no lights, dark ones, one within something solid") {
  const Scene scene = furnished_room();
  const support::TriangleTracer tracer(scene.mesh);
  const std::vector<LocalLight> none, black{point_light({0, 1, 0}, vec3(0))},
      inside{point_light({0.8f, 0.7f, 0}, vec3(1))};
  Scene one_sided = scene;
  one_sided.materials[0].double_sided = false;  // the box's inside has no side
  const VplOptions options{.count = 300, .density = VplDensity::irradiance};
  const auto by_area = place(one_sided, none, tracer, {.count = 300, .density = VplDensity::area});
  for (const auto& lights : {none, black, inside})
    CHECK(same(place(one_sided, lights, tracer, options), by_area));
}

TEST_CASE("any executor places VPLs with the same bits, and the seed matters") {
  const Scene scene = furnished_room();
  const support::TriangleTracer tracer(scene.mesh);
  for (const VplSpread spread : spreads) {
    const VplOptions options{.count = 150, .spread = spread, .seed = 3};
    const auto a = place(scene, bulb, tracer, options);
    CHECK(same(a, place(scene, bulb, tracer, options, support::Backwards())));
    CHECK(same(a, place(scene, bulb, tracer, options, support::TwoThreads())));
    CHECK(!same(a, place(scene, bulb, tracer, {.count = 150, .spread = spread, .seed = 4})));
  }
}

TEST_CASE("few VPLs, a single triangle, and nothing to place") {
  Scene scene;
  scene.materials.resize(1);
  for (const vec3& p : {vec3(0), vec3(1, 0, 0), vec3(0, 1, 0)}) support::add_vertex(scene.mesh, p, {0, 0, 1});
  support::add_triangle(scene.mesh, {0, 1, 2});
  for (const VplDensity density : densities)
    for (const VplSpread spread : spreads)
      for (const std::size_t count : {1u, 2u, 5u, 33u}) {
        const auto vpls = place(scene, bulb, nothing, {.count = count, .density = density, .spread = spread});
        CHECK(vpls.size() <= count);
        CHECK(vpls.size() >= (count + 1) / 2);
        CHECK(area_of(vpls) == doctest::Approx(0.5).epsilon(1e-3));
        for (const SurfaceSample& v : vpls) CHECK(v.normal == vec3(0, 0, 1));
      }
  CHECK(place(scene, bulb, nothing, {.count = 0}).empty());
  CHECK(place({}, bulb, nothing, {.count = 10}).empty());
  scene.mesh.positions[2] = {0.5f, 0, 0};
  CHECK(place(scene, bulb, nothing, {.count = 10}).empty());
  support::add_ground(scene.mesh, 1);
  for (const SurfaceSample& v : place(scene, bulb, nothing, {.count = 10}))
    CHECK((v.side.triangle > 0 && is_finite(v.position) && is_finite(v.normal) && v.area > 0));
}

TEST_CASE("VPLs follow a rigid motion") {
  const Scene scene = furnished_room();
  const support::TriangleTracer tracer(scene.mesh);
  const auto rest = place(scene, bulb, tracer, {.count = 200});
  const RigidTransform transform{glm::angleAxis(0.8f, normalize(vec3(1, 2, 3))), {4, -1, 2}};
  const Mesh posed = moved(scene.mesh, transform);
  auto vpls = rest;
  follow(vpls, scene.mesh, posed);
  for (std::size_t i = 0; i < vpls.size(); ++i) {
    CHECK(length(vpls[i].position - transform.point(rest[i].position)) < 3e-6f);
    CHECK(length(vpls[i].normal - transform.direction(rest[i].normal)) < 1e-6f);
    CHECK(vpls[i].area == doctest::Approx(rest[i].area).epsilon(1e-5));
    CHECK((vpls[i].side.triangle == rest[i].side.triangle && vpls[i].u == rest[i].u));
  }
  auto still = rest;
  follow(still, scene.mesh, scene.mesh);
  CHECK(same(still, rest));
}

TEST_CASE("VPLs follow a deformation: on the surface, with its area") {
  Scene scene;
  scene.materials.resize(1);
  scene.mesh = support::bumpy_mesh(8, 0.1f, 3);
  const auto rest = place(scene, {}, nothing, {.count = 400, .density = VplDensity::area});
  Mesh posed = scene.mesh;
  for (vec3& p : posed.positions) p = {2 * p.x, p.y + 0.3f * p.x * p.x, p.z * (1 + p.x)};
  auto vpls = rest;
  follow(vpls, scene.mesh, posed);
  double area = 0;
  for (std::uint32_t t = 0; t < posed.triangles.size(); ++t) area += triangle_area(posed, t);
  CHECK(area_of(vpls) == doctest::Approx(area).epsilon(0.02));
  for (const SurfaceSample& v : vpls) {
    CHECK(length(v.position - position_at(posed, hit_of(v))) < 1e-6f);
    const uvec3 t = posed.triangles[v.side.triangle];
    CHECK(std::abs(dot(v.normal, posed.positions[t.y] - posed.positions[t.x])) < 1e-6f);
    CHECK(length(v.normal) == doctest::Approx(1));
  }
}

TEST_CASE("a triangle that collapses keeps its VPLs' normals and leaves them no area") {
  const Scene scene = square();
  const auto rest = place(scene, {}, nothing, {.count = 20, .density = VplDensity::area});
  for (const float size : {0.0f, 1e-30f}) {
    Mesh posed = scene.mesh;
    for (vec3& p : posed.positions) p = vec3(size * p.x, 0, 0);
    auto vpls = rest;
    follow(vpls, scene.mesh, posed);
    for (const SurfaceSample& v : vpls)
      CHECK((v.area == 0 && v.normal == vec3(0, 1, 0) && is_finite(v.position)));
    auto back = vpls;
    follow(back, posed, scene.mesh);
    for (const SurfaceSample& v : back) CHECK((v.area == 0 && v.normal == vec3(0, 1, 0)));
  }
}
