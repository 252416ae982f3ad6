// A scene's lights as local lights: KHR's definitions, and the power and irradiance of shining surfaces.
#include <doctest/doctest.h>

#include <coppice/light/direct_irradiance.hpp>
#include <coppice/light/scene_lights.hpp>

#include "support/occluders.hpp"
#include "support/scenes.hpp"

using namespace coppice;

namespace {

Material shining(const vec3& radiance) {
  Material material;
  material.emission = radiance;
  return material;
}

/// A square of the plane y = 0 that shines upwards.
Scene lamp(float half_width, const vec3& radiance) {
  Scene scene;
  scene.materials = {shining(radiance)};
  support::add_ground(scene.mesh, half_width);
  return scene;
}

glm::dvec3 intensity_of(std::span<const LocalLight> lights) {
  glm::dvec3 sum(0);
  for (const LocalLight& light : lights) sum += glm::dvec3(light.intensity);
  return sum;
}

/// Without shadows.
double irradiance_of(std::span<const LocalLight> lights, const vec3& point, const vec3& normal) {
  double sum = 0;
  for (const LocalLight& light : lights)
    if (const auto path = path_to(light, point, normal)) sum += double(path->irradiance.x);
  return sum;
}

/// Irradiance at distance h on the axis of a square of radiance 1, by an element that faces it: four times
/// the form factor of the element at a corner (Howell, configuration B-4), times π.
double square_irradiance(double half_width, double h) {
  const double a = half_width / h, b = std::sqrt(1 + a * a);
  return 4 * (a / b * std::atan(a / b));
}

}  // namespace

TEST_CASE("a point light: inverse square and cosine, its range ignored") {
  Scene scene;
  scene.lights = {{.position = {1, 2, 3}, .intensity = {4, 5, 6}, .range = 0.5f}};
  const auto lights = scene_lights(scene, 100);
  REQUIRE(lights.size() == 1);
  const vec3 up(0, 1, 0);
  const auto path = path_to(lights[0], {1, 0, 3}, up);
  REQUIRE(path);
  CHECK(length(path->irradiance - vec3(1, 1.25f, 1.5f)) < 1e-6f);
  CHECK(path->direction == up);
  CHECK(path->t_max == doctest::Approx(2).epsilon(2e-4));
  CHECK(irradiance_of(lights, {3, 0, 3}, up) == doctest::Approx(4 / 8.0 * std::sqrt(0.5)));
  CHECK(!path_to(lights[0], {1, 0, 3}, -up));
}

TEST_CASE("a spot light: the squared ramp of KHR_lights_punctual") {
  Scene scene;
  const float inner = 0.3f, outer = 0.7f;
  scene.lights = {{.type = PunctualLightType::spot,
                   .direction = {0, 0, -1},
                   .intensity = vec3(2),
                   .inner_cone = inner,
                   .outer_cone = outer}};
  const auto lights = scene_lights(scene, 0);
  for (const float angle : {0.0f, 0.2f, 0.29f, 0.35f, 0.5f, 0.65f, 0.71f, 1.5f, 3.0f}) {
    const vec3 towards(std::sin(angle), 0, -std::cos(angle));
    const float scale = 1 / std::max(0.001f, std::cos(inner) - std::cos(outer));
    const float offset = -std::cos(outer) * scale;
    const float ramp = std::clamp(std::cos(angle) * scale + offset, 0.0f, 1.0f);
    CHECK(irradiance_of(lights, 2.0f * towards, -towards) == doctest::Approx(2 * ramp * ramp / 4));
  }
}

TEST_CASE("a sun shines alike everywhere, from as far as the scene is large") {
  Scene scene = support::still_life();
  scene.lights = {{.type = PunctualLightType::directional, .direction = {0, -1, 0}, .intensity = vec3(3)}};
  const auto lights = scene_lights(scene, 10);
  REQUIRE(lights.size() == 1);
  CHECK(length(lights[0].position) == doctest::Approx(scene_size(scene.mesh)));
  for (const vec3& p : {vec3(0), vec3(2, 5, 1), vec3(-900, 3, 40)}) {
    CHECK(irradiance_of(lights, p, {0, 1, 0}) == doctest::Approx(3));
    CHECK(irradiance_of(lights, p, {0.8f, 0.6f, 0}) == doctest::Approx(1.8));
    CHECK(std::isinf(path_to(lights[0], p, {0, 1, 0})->t_max));
  }
  scene.mesh = {};
  CHECK(irradiance_of(scene_lights(scene, 10), vec3(7), {0, 1, 0}) == doctest::Approx(3));
}

TEST_CASE("a shining square: its power to rounding, its irradiance as the form factor says") {
  const Scene scene = lamp(0.5f, {2, 4, 8});
  for (const std::size_t count : {1u, 4u, 100u, 1000u}) {
    const auto lights = scene_lights(scene, count, 3);
    CHECK(lights.size() == count);
    CHECK(glm::length(intensity_of(lights) / glm::dvec3(2, 4, 8) - 1.0) < 1e-5);
    for (const LocalLight& light : lights) CHECK((light.position.y == 0 && light.axis == vec3(0, 1, 0)));
  }
  const auto lights = scene_lights(scene, 1000, 3);
  for (const float height : {0.1f, 0.3f, 1.0f, 4.0f})
    CHECK(irradiance_of(lights, {0, height, 0}, {0, -1, 0}) ==
          doctest::Approx(2 * square_irradiance(0.5, double(height)))
              .epsilon(height < 0.2f ? 0.03 : 0.005));  // three spacings away, the area softens
  CHECK(irradiance_of(lights, {0, -1, 0}, {0, 1, 0}) == 0);
}

TEST_CASE("a surface does not shadow its own lights") {
  Scene scene = lamp(0.5f, vec3(1));
  for (vec3& p : scene.mesh.positions) p = vec3(0.8f * p.x - 0.6f * p.y, 0.6f * p.x + 0.8f * p.y, p.z) + 3.3f;
  const support::TriangleTracer tracer(scene.mesh);
  const auto lights = scene_lights(scene, 300);
  Random random(1);
  for (int i = 0; i < 20; ++i) {
    const vec3 point = 3.3f + vec3(-1.2f, 1.6f, 0) + 0.7f * random.direction();
    const vec3 n = normalize(vec3(3.3f) - point);
    CHECK(DirectIrradiance(lights).at(tracer, point, n, random).x ==
          doctest::Approx(irradiance_of(lights, point, n)).epsilon(1e-5));
  }
}

TEST_CASE("a double-sided square shines to both sides") {
  Scene scene = lamp(0.5f, vec3(1));
  scene.materials[0].double_sided = true;
  const auto lights = scene_lights(scene, 400);
  CHECK(intensity_of(lights).x == doctest::Approx(2).epsilon(1e-5));
  const double expected = square_irradiance(0.5, 1);
  CHECK(irradiance_of(lights, {0, 1, 0}, {0, -1, 0}) == doctest::Approx(expected).epsilon(0.02));
  CHECK(irradiance_of(lights, {0, -1, 0}, {0, 1, 0}) == doctest::Approx(expected).epsilon(0.02));
}

TEST_CASE("an emission texture: only where it is bright, and its mean") {
  Scene scene = lamp(1, vec3(3));
  for (std::size_t i = 0; i < 4; ++i)
    scene.mesh.uvs[i] = 0.5f * (vec2(scene.mesh.positions[i].x, scene.mesh.positions[i].z) + 1.0f);
  scene.materials[0].emission_texture = 0;
  Texture texture{.width = 64, .height = 1, .wrap_u = Wrap::clamp, .wrap_v = Wrap::clamp, .rgba = {}};
  for (int x = 0; x < 64; ++x) {
    const auto red = std::uint8_t(x < 32 ? 0 : 255), green = std::uint8_t(x < 32 ? 0 : 4 * (x - 32));
    for (const std::uint8_t value : {red, green, std::uint8_t(0), std::uint8_t(255)})
      texture.rgba.push_back(value);
  }
  scene.textures = {texture};
  const auto lights = scene_lights(scene, 500);
  CHECK(std::ranges::all_of(lights, [](const LocalLight& l) { return l.position.x > -0.04f; }));
  CHECK(intensity_of(lights).x == doctest::Approx(3 * 2).epsilon(0.02));
  CHECK(intensity_of(lights).y == doctest::Approx(3 * 2 * 62.0 / 255).epsilon(0.03));
  CHECK(intensity_of(lights).z == 0);
}

TEST_CASE("fewer lights than triangles: no power is lost, and it keeps its facing") {
  Scene scene;
  scene.materials = {shining({1, 2, 3})};
  for (int i = 0; i < 20; ++i) {
    const vec3 low(3.0f * float(i), 0, float(i % 3));
    support::add_box(scene.mesh, low, low + vec3(0.1f + 0.01f * float(i)));
  }
  double face = 0;
  for (int i = 0; i < 20; ++i) face += std::pow(0.1 + 0.01 * i, 2);
  for (const std::size_t count : {1u, 7u, 60u, 200u}) {
    CAPTURE(count);
    const auto lights = scene_lights(scene, count);
    CHECK(lights.size() == count);
    CHECK(glm::length(intensity_of(lights) / (6 * face * glm::dvec3(1, 2, 3)) - 1.0) < 1e-5);
    for (int axis = 0; axis < 6 && count >= 60; ++axis) {
      double sum = 0;
      for (const LocalLight& l : lights)
        if (l.axis[axis / 2] * (axis % 2 == 0 ? 1.0f : -1.0f) > 0.5f) sum += double(l.intensity.x);
      CHECK(sum == doctest::Approx(face).epsilon(1e-4));
    }
  }
}

TEST_CASE("no lights: no triangles, none that shine, none with area, none asked for, only holes") {
  CHECK(scene_lights({}, 100).empty());
  CHECK(scene_lights(support::still_life(), 100).empty());
  Scene scene = lamp(0.5f, vec3(1));
  CHECK(scene_lights(scene, 0).empty());
  scene.materials[0].alpha_mask = true;
  scene.materials[0].alpha = 0;
  CHECK(scene_lights(scene, 100).empty());
  scene = lamp(0, vec3(1));
  CHECK(scene_lights(scene, 100).empty());
  CHECK(scene_size({}) == 1);
}

TEST_CASE("the same seed gives the same lights, another seed others") {
  const Scene scene = lamp(0.5f, vec3(1));
  const auto a = scene_lights(scene, 50, 1), b = scene_lights(scene, 50, 1), c = scene_lights(scene, 50, 2);
  for (std::size_t i = 0; i < 50; ++i) CHECK(a[i].position == b[i].position);
  CHECK(a[0].position != c[0].position);
}
