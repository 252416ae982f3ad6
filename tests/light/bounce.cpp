// One bounce: energy, lit places only, frames, and no dependence on the executor.
#include <doctest/doctest.h>

#include <coppice/light/bounce.hpp>

#include "support/executors.hpp"
#include "support/occluders.hpp"
#include "support/scenes.hpp"

using namespace coppice;

namespace {

/// A room of double-sided walls with a box in it.
Scene furnished_room() {
  Scene scene;
  scene.materials = {support::dielectric({0.5f, 0.25f, 1}, 1), support::dielectric({0.5f, 0.25f, 1}, 1)};
  for (Material& material : scene.materials) material.double_sided = true;
  support::add_box(scene.mesh, {-2, 0, -1.5f}, {2, 2.5f, 1.5f}, 0);
  support::add_box(scene.mesh, {0.3f, 0.5f, -0.5f}, {1.3f, 0.9f, 0.5f}, 1);
  return scene;
}

const LocalLight bulb = point_light({-0.3f, 1.7f, 0.2f}, {2, 4, 1});

template <Executor E = Serial>
std::vector<LocalLight> lit(std::span<const SurfaceSample> samples, std::span<const LocalLight> lights,
                            const support::TriangleTracer& tracer, const E& executor = {}) {
  std::vector<LocalLight> result(samples.size());
  light_samples(samples, lights, tracer, executor, result);
  return result;
}

/// π · intensity: of a Lambertian light.
glm::dvec3 flux_of(std::span<const LocalLight> lights) {
  glm::dvec3 sum(0);
  for (const LocalLight& light : lights) sum += std::numbers::pi * glm::dvec3(light.intensity);
  return sum;
}

bool same(const LocalLight& a, const LocalLight& b) {
  return a.position == b.position && a.intensity == b.intensity && a.axis == b.axis && a.area == b.area &&
         a.w == b.w && a.offset == b.offset && a.square == b.square;
}

}  // namespace

TEST_CASE("a closed room gives back the albedo's share of all light, shadows or not") {
  const Scene scene = furnished_room();
  const support::TriangleTracer tracer(scene.mesh);
  const std::vector<LocalLight> lights{bulb};
  const auto samples = bounce_samples(scene, lights, tracer, Serial(),
                                      {.count = 4096, .seed = 2, .shading = Shading::lambert});
  CHECK(samples.size() == 4096);
  const glm::dvec3 expected = 4 * std::numbers::pi * glm::dvec3(bulb.intensity) * glm::dvec3(0.5, 0.25, 1);
  CHECK(glm::length(flux_of(lit(samples, lights, tracer)) / expected - 1.0) < 0.01);
}

TEST_CASE("only lit places take samples: inside the room, above the box") {
  const Scene scene = furnished_room();
  const support::TriangleTracer tracer(scene.mesh);
  const std::vector<LocalLight> lights{bulb};
  double area = 0;
  for (const SurfaceSample& s : bounce_samples(scene, lights, tracer, Serial(), {.count = 500})) {
    CHECK(dot(bulb.position - s.position, s.normal) > 0);
    const vec3 across = bulb.position - ray_origin(s);
    CHECK(!tracer.occluded(ray_origin(s), normalize(across), length(across)));
    area += double(s.area);
  }
  CHECK(area < 2 * (4 * 2.5 + 3 * 2.5 + 4 * 3));  // the walls, less the box's shadow
  CHECK(area > 0.8 * 2 * (4 * 2.5 + 3 * 2.5 + 4 * 3));
}

TEST_CASE("lights of later frames: places stay, what is dark is black") {
  const Scene scene = furnished_room();
  const support::TriangleTracer tracer(scene.mesh);
  const std::vector<LocalLight> first{bulb}, none,
      moved{point_light({1.8f, 0.2f, 1.2f}, vec3(1))};  // below the box's top
  const auto samples = bounce_samples(scene, first, tracer, Serial(), {.count = 300});
  const auto a = lit(samples, first, tracer), b = lit(samples, moved, tracer), c = lit(samples, none, tracer);
  std::size_t dark = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    CHECK(a[i].position == samples[i].position);
    CHECK((b[i].position == a[i].position && b[i].axis == a[i].axis && b[i].area == a[i].area));
    CHECK(luminance(a[i].intensity) > 0);
    CHECK(c[i].intensity == vec3(0));
    dark += b[i].intensity == vec3(0);
  }
  CHECK(dark > 5);
  CHECK(dark < samples.size() / 2);
}

TEST_CASE("the radiance of a sample is albedo/π times what it receives") {
  Scene scene;
  scene.materials = {support::dielectric(vec3(0.6f), 1)};
  support::add_ground(scene.mesh, 1);
  const support::TriangleTracer tracer(scene.mesh);
  const std::vector<LocalLight> sun{distant_light({0, 1, 0}, vec3(5), 3)};
  for (const std::size_t count : {1u, 40u}) {
    const auto lights =
        lit(bounce_samples(scene, sun, tracer, Serial(), {.count = count, .shading = Shading::lambert}), sun,
            tracer);
    CHECK(lights.size() == count);
    CHECK(flux_of(lights).x == doctest::Approx(4 * 5 * 0.6).epsilon(1e-5));
    for (const LocalLight& light : lights) {
      CHECK(light.intensity.x / light.area == doctest::Approx(0.6 * 5 / std::numbers::pi));
      CHECK((light.axis == vec3(0, 1, 0) && light.offset == 0 && light.square == 0));
    }
  }
}

TEST_CASE("albedo: the base colour for Lambert, diffuse and f0 otherwise") {
  Scene scene;
  scene.materials = {support::dielectric({0.5f, 0.25f, 1}, 0.5f)};
  support::add_ground(scene.mesh, 1);
  const SurfaceSample sample;
  const auto albedo = [&](Shading shading) { return diffuse_albedo(scene, sample, shading); };
  CHECK(albedo(Shading::lambert) == vec3(0.5f, 0.25f, 1));
  CHECK(length(albedo(Shading::metallic_roughness) - vec3(0.52f, 0.28f, 1)) < 1e-6f);
  CHECK(albedo(Shading::ward) == albedo(Shading::metallic_roughness));
  scene.materials[0].metallic = 1;
  CHECK(length(albedo(Shading::metallic_roughness) - vec3(0.5f, 0.25f, 1)) < 1e-6f);
  scene.materials[0].base_color_texture = 0;
  scene.textures.push_back({.width = 1, .height = 1, .rgba = {51, 255, 0, 255}});
  CHECK(length(albedo(Shading::lambert) - vec3(0.1f, 0.25f, 0)) < 1e-6f);
}

TEST_CASE("a texture finer than the samples counts with its mean") {
  Scene scene;
  scene.materials = {support::dielectric(vec3(1), 1)};
  support::add_ground(scene.mesh, 1);
  for (std::size_t i = 0; i < 4; ++i)
    scene.mesh.uvs[i] = 30.0f * vec2(scene.mesh.positions[i].x, scene.mesh.positions[i].z);
  scene.materials[0].base_color_texture = 0;
  scene.textures.push_back({.width = 2, .height = 1, .rgba = {0, 0, 0, 255, 255, 255, 255, 255}});
  const support::TriangleTracer tracer(scene.mesh);
  const std::vector<LocalLight> sun{distant_light({0, 1, 0}, vec3(1), 3)};
  const auto samples =
      bounce_samples(scene, sun, tracer, Serial(), {.count = 16, .shading = Shading::lambert});
  for (const SurfaceSample& s : samples) CHECK(std::abs(s.colour.x - 0.5f) < 0.1f);
}

TEST_CASE("any executor gives the same bits") {
  const Scene scene = furnished_room();
  const support::TriangleTracer tracer(scene.mesh);
  std::vector<LocalLight> lights;
  Random random(9);
  for (int i = 0; i < 100; ++i)
    lights.push_back(point_light(vec3(0, 1.3f, 0) + 0.9f * random.direction(), vec3(random.uniform())));
  const BounceOptions options{.count = 200, .seed = 4};
  const auto serial = bounce_samples(scene, lights, tracer, Serial(), options);
  const auto backwards = bounce_samples(scene, lights, tracer, support::Backwards(), options);
  const auto threads = bounce_samples(scene, lights, tracer, support::TwoThreads(), options);
  REQUIRE((serial.size() == backwards.size() && serial.size() == threads.size()));
  const auto light = [&](const auto& samples, const auto& executor) {
    std::vector<LocalLight> result(samples.size());
    light_samples(std::span(samples), std::span<const LocalLight>(lights), tracer, executor,
                  std::span(result), 32);
    return result;
  };
  const auto a = light(serial, Serial()), b = light(backwards, support::Backwards()),
             c = light(threads, support::TwoThreads());
  for (std::size_t i = 0; i < a.size(); ++i) CHECK((same(a[i], b[i]) && same(a[i], c[i])));
}

TEST_CASE("no bounce: no lights, no count, no triangles, nothing lit, no area") {
  const Scene scene = furnished_room();
  const support::TriangleTracer tracer(scene.mesh);
  const std::vector<LocalLight> none, lights{bulb}, away{point_light(bulb.position, vec3(0))};
  const auto count_of = [&](const Scene& s, std::span<const LocalLight> l, std::size_t count) {
    return bounce_samples(s, l, tracer, Serial(), {.count = count}).size();
  };
  CHECK(count_of(scene, none, 100) == 0);
  CHECK(count_of(scene, lights, 0) == 0);
  CHECK(count_of({}, lights, 100) == 0);
  CHECK(count_of(scene, away, 10) == 0);
  CHECK(count_of(scene, lights, 1) == 1);
  Scene flat;
  flat.materials.resize(1);
  support::add_ground(flat.mesh, 0);
  CHECK(count_of(flat, lights, 100) == 0);
}
