// Points scattered over triangles: on them, in proportion to area, on the sides that count.
#include <doctest/doctest.h>

#include <coppice/light/surface_samples.hpp>
#include <map>

#include "support/scenes.hpp"

using namespace coppice;

namespace {

constexpr auto every_material = [](const Material&) { return true; };

/// A large single-sided square, a small double-sided one, and a triangle without area.
Scene squares() {
  Scene scene;
  scene.materials.resize(2);
  scene.materials[1].double_sided = true;
  support::add_ground(scene.mesh, 2);
  support::add_quad(scene.mesh, {5, 0, 0}, {1, 0, 0}, {0, 1, 0}, 1);
  support::add_triangle(scene.mesh, {0, 1, 1});
  return scene;
}

double area_of(std::span<const SurfaceSample> samples) {
  double sum = 0;
  for (const SurfaceSample& s : samples) sum += double(s.area);
  return sum;
}

}  // namespace

TEST_CASE("sides are the fronts, the backs of double-sided triangles, and none without area") {
  const Scene scene = squares();
  const auto sides = triangle_sides(scene, every_material);
  REQUIRE(sides.size() == 6);
  CHECK(std::ranges::count_if(sides, [](const TriangleSide& s) { return !s.front; }) == 2);
  CHECK(std::ranges::all_of(sides, [](const TriangleSide& s) { return s.triangle < 4; }));
  CHECK(triangle_sides(scene, [](const Material& m) { return m.double_sided; }).size() == 4);
}

TEST_CASE("samples lie on their triangles, and their normals point to the side") {
  const Scene scene = squares();
  for (const SurfaceSample& s :
       scatter_samples(scene.mesh, triangle_sides(scene, every_material), 500, Shares::by_area, 1)) {
    const uvec3 t = scene.mesh.triangles[s.side.triangle];
    const vec3 p = (1 - s.u - s.v) * scene.mesh.positions[t.x] + s.u * scene.mesh.positions[t.y] +
                   s.v * scene.mesh.positions[t.z];
    CHECK(length(p - s.position) < 1e-5f);
    CHECK((s.u >= 0 && s.v >= 0 && s.u + s.v <= 1.000001f));
    const vec3 front = s.side.triangle < 2 ? vec3(0, 1, 0) : vec3(0, 0, 1);
    CHECK(length(s.normal - (s.side.front ? front : -front)) < 1e-6f);
  }
}

TEST_CASE("each side has its share of the samples, and the areas add up") {
  const Scene scene = squares();
  const auto sides = triangle_sides(scene, every_material);  // 8, 8, 1/2, 1/2, 1/2, 1/2
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const auto samples = scatter_samples(scene.mesh, sides, 1000, Shares::by_area, seed);
    CHECK(samples.size() == 1000);
    CHECK(area_of(samples) == doctest::Approx(18).epsilon(1e-5));
    std::map<std::uint32_t, double> count;
    for (const SurfaceSample& s : samples) ++count[s.side.triangle];
    CHECK(std::abs(count[0] - 1000 * 8.0 / 18) < 1.001);
    CHECK(std::abs(count[2] - 1000 * 1.0 / 18) < 2.001);
  }
}

TEST_CASE("samples of a triangle are spread over it: its moments are right") {
  Scene scene;
  scene.materials.resize(1);
  for (const vec3& p : {vec3(0), vec3(1, 0, 0), vec3(0, 1, 0)})
    support::add_vertex(scene.mesh, p, vec3(0, 0, 1));
  support::add_triangle(scene.mesh, {0, 1, 2});
  glm::dvec3 mean(0);
  double square = 0;
  const auto samples =
      scatter_samples(scene.mesh, triangle_sides(scene, every_material), 2000, Shares::by_area, 4);
  for (const SurfaceSample& s : samples) {
    mean += glm::dvec3(s.position) / 2000.0;
    square += double(s.position.x * s.position.x) / 2000;
  }
  CHECK(std::abs(mean.x - 1.0 / 3) < 2e-3);
  CHECK(std::abs(mean.y - 1.0 / 3) < 2e-3);
  CHECK(std::abs(square - 1.0 / 6) < 2e-3);  // ∫ x² over the triangle, divided by its area
}

TEST_CASE("at least one sample a side keeps the area of every side") {
  const Scene scene = squares();
  const auto sides = triangle_sides(scene, every_material);
  for (const std::size_t count : {1u, 5u, 40u}) {
    const auto samples = scatter_samples(scene.mesh, sides, count, Shares::at_least_one, 1);
    CHECK(samples.size() <= count + sides.size());
    std::map<std::pair<std::uint32_t, bool>, double> area;
    for (const SurfaceSample& s : samples) area[{s.side.triangle, s.side.front}] += double(s.area);
    for (const TriangleSide& side : sides)
      CHECK(area[std::pair(side.triangle, side.front)] ==
            doctest::Approx(triangle_area(scene.mesh, side.triangle)).epsilon(1e-6));
  }
}

TEST_CASE("no sides, no area or no count: no samples") {
  const Scene scene = squares();
  const auto sides = triangle_sides(scene, every_material);
  const std::vector<TriangleSide> flat{{4, true}};
  CHECK(scatter_samples(scene.mesh, {}, 10, Shares::at_least_one, 1).empty());
  CHECK(scatter_samples(scene.mesh, flat, 10, Shares::at_least_one, 1).empty());
  CHECK(scatter_samples(scene.mesh, sides, 0, Shares::at_least_one, 1).empty());
  CHECK(scatter_samples(scene.mesh, sides, 1, Shares::by_area, 1).size() == 1);
}

TEST_CASE("an alpha mask's holes are not solid") {
  Scene scene = squares();
  SurfaceSample sample;
  CHECK(is_solid(scene, sample));
  scene.materials[0].alpha = 0.4f;
  CHECK(is_solid(scene, sample));
  scene.materials[0].alpha_mask = true;
  CHECK(!is_solid(scene, sample));
  scene.materials[0].alpha = 1;
  scene.materials[0].base_color_texture = 0;
  scene.textures.push_back({.width = 1, .height = 1, .rgba = {255, 255, 255, 100}});
  CHECK(!is_solid(scene, sample));
  scene.textures[0].rgba[3] = 200;
  CHECK(is_solid(scene, sample));
}
