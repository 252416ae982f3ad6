// From a hit to its surface, mapped normal, material and emission.
#include <doctest/doctest.h>

#include <coppice/scene/surface.hpp>
#include <vector>

#include "support/generators.hpp"

using namespace coppice;
using namespace test_support;

namespace {

/// One triangle in the plane z = 0, its front towards +Z, uv = position, tangent +X, one material.
Scene one_triangle() {
  Scene scene;
  Mesh& mesh = scene.mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.normals.assign(3, vec3(0, 0, 1));
  mesh.tangents.assign(3, vec4(1, 0, 0, 1));
  mesh.uvs = {{0, 0}, {1, 0}, {0, 1}};
  mesh.triangles = {{0, 1, 2}};
  mesh.materials = {0};
  scene.materials.resize(1);
  return scene;
}

/// A texture of one colour; its index.
int add_texture(Scene& scene, std::vector<std::uint8_t> rgba) {
  scene.textures.push_back({1, 1, false, Wrap::repeat, Wrap::repeat, std::move(rgba)});
  return int(scene.textures.size()) - 1;
}

ShadingPoint seen_from(const Scene& scene, const vec3& to_viewer, const Hit& hit = {}) {
  return shading_point(scene, hit, to_viewer, Shading::metallic_roughness);
}

void check_frame(const ShadingPoint& p) {
  CHECK(std::abs(length(p.normal) - 1) < 1e-6f);
  CHECK(std::abs(length(p.tangent) - 1) < 1e-6f);
  CHECK(std::abs(dot(p.normal, p.tangent)) < 1e-4f);
}

const vec3 front(0, 0, 1), behind(0, 0, -1);

}  // namespace

TEST_CASE("attributes are mixed by the hit's barycentric coordinates") {
  Scene scene = one_triangle();
  scene.mesh.normals = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const Surface s = surface_at(scene.mesh, {0, 0.25f, 0.5f});
  CHECK(length(s.normal - normalize(vec3(1, 1, 2))) < 1e-6f);
  CHECK(s.uv == vec2(0.25f, 0.5f));
  CHECK(s.tangent == vec3(1, 0, 0));
  CHECK(s.bitangent_sign == 1);
}

TEST_CASE("normals that cancel give way to the triangle's own, a degenerate triangle to +Y") {
  Scene scene = one_triangle();
  scene.mesh.normals = {vec3(0), vec3(0), vec3(0)};
  CHECK(surface_at(scene.mesh, {0, 0.3f, 0.3f}).normal == vec3(0, 0, 1));
  scene.mesh.positions = {vec3(1), vec3(1), vec3(1)};
  CHECK(surface_at(scene.mesh, {0, 0.3f, 0.3f}).normal == vec3(0, 1, 0));
}

TEST_CASE("the shading normal is on the viewer's side") {
  const Scene scene = one_triangle();
  CHECK(seen_from(scene, front).normal == front);
  CHECK(seen_from(scene, behind).normal == behind);
  CHECK(seen_from(scene, behind).to_viewer == behind);
}

TEST_CASE("a flat normal map keeps the normal, a bent one bends it along tangent and bitangent") {
  Scene scene = one_triangle();
  scene.materials[0].normal_texture = add_texture(scene, {128, 128, 255, 255});
  CHECK(length(seen_from(scene, front).normal - front) < 0.006f);  // 128 is not quite 0
  scene.textures[0].rgba = {255, 128, 128, 255};
  CHECK(seen_from(scene, front).normal.x > 0.99f);
  scene.textures[0].rgba = {128, 255, 128, 255};
  CHECK(seen_from(scene, front).normal.y > 0.99f);
  for (auto& t : scene.mesh.tangents) t.w = -1;
  CHECK(seen_from(scene, front).normal.y < -0.99f);
}

TEST_CASE("the normal scale bends less or more, 0 not at all") {
  Scene scene = one_triangle();
  scene.materials[0].normal_texture = add_texture(scene, {191, 128, 218, 255});
  const float plain = seen_from(scene, front).normal.x;
  scene.materials[0].normal_scale = 0.5f;
  CHECK(seen_from(scene, front).normal.x < 0.7f * plain);
  scene.materials[0].normal_scale = 0;
  CHECK(seen_from(scene, front).normal == front);
}

TEST_CASE("without a tangent a normal map is left out, and the frame is still orthonormal") {
  Scene scene = one_triangle();
  scene.materials[0].normal_texture = add_texture(scene, {255, 128, 128, 255});
  scene.mesh.tangents.assign(3, vec4(0));
  CHECK(seen_from(scene, front).normal == front);
  check_frame(seen_from(scene, front));
}

TEST_CASE("frames are orthonormal for any normals, tangents, maps and sides") {
  Random random(1);
  for (int i = 0; i < 500; ++i) {
    Scene scene = one_triangle();
    for (auto& n : scene.mesh.normals) n = random.direction();
    for (auto& t : scene.mesh.tangents) t = vec4(random.direction(), random.uniform() < 0.5f ? -1 : 1);
    const auto byte = [&] { return std::uint8_t(random.bits()); };
    if (i % 2 == 0) scene.materials[0].normal_texture = add_texture(scene, {byte(), byte(), byte(), 255});
    const float u = random.uniform(), v = (1 - u) * random.uniform();
    const ShadingPoint p = seen_from(scene, random.direction(), {0, u, v});
    check_frame(p);
  }
}

TEST_CASE("a tangent along the normal is as good as none") {
  Random random(2);
  for (int i = 0; i < 100; ++i) {
    Scene scene = one_triangle();
    const vec3 n = random.direction();
    scene.mesh.normals.assign(3, n);
    scene.mesh.tangents.assign(3, vec4(n, 1));
    check_frame(seen_from(scene, random.direction(), {0, 0.3f, 0.2f}));
  }
}

TEST_CASE("materials are factors times textures: green is roughness, blue is metallic") {
  Scene scene = one_triangle();
  Material& m = scene.materials[0];
  m.base_color = vec3(0.5f, 1, 1);
  m.metallic = 0.5f;
  m.roughness = 0.8f;
  m.base_color_texture = add_texture(scene, {255, 51, 0, 255});
  m.metallic_roughness_texture = add_texture(scene, {7, 153, 51, 255});
  const ShadingPoint p = seen_from(scene, front);
  ShadingPoint expected{};
  set_metallic_roughness(expected, vec3(0.5f, 0.2f, 0), 0.5f * 0.2f, 0.8f * 0.6f);
  CHECK(p.brdf == BRDF_GGX);
  CHECK(p.alpha_x == doctest::Approx(expected.alpha_x));
  CHECK(length(p.diffuse - expected.diffuse) < 1e-6f);
  CHECK(length(p.specular - expected.specular) < 1e-6f);
}

TEST_CASE("read as Lambert, a metal is its base colour") {
  Scene scene = one_triangle();
  scene.materials[0].base_color = vec3(0.9f, 0.6f, 0.1f);
  const ShadingPoint p = shading_point(scene, {}, front, Shading::lambert);
  CHECK(p.brdf == BRDF_LAMBERT);
  CHECK(p.diffuse == vec3(0.9f, 0.6f, 0.1f));
  CHECK(p.specular == vec3(0));
}

TEST_CASE("surfaces emit from their front, from both sides where they have two") {
  Scene scene = one_triangle();
  Material& m = scene.materials[0];
  const Hit on_front{}, on_back{0, 0, 0, 0, false};
  CHECK(emission_at(scene, on_front) == vec3(0));
  m.emission = vec3(10, 20, 30);
  CHECK(emission_at(scene, on_front) == vec3(10, 20, 30));
  CHECK(emission_at(scene, on_back) == vec3(0));
  m.double_sided = true;
  CHECK(emission_at(scene, on_back) == vec3(10, 20, 30));
  m.emission_texture = add_texture(scene, {255, 0, 51, 255});
  CHECK(length(emission_at(scene, on_front) - vec3(10, 0, 6)) < 1e-4f);
}

TEST_CASE("every reading of a material gives its BRDF, valid widths, and no more energy than arrives") {
  const Shading kinds[] = {Shading::metallic_roughness, Shading::lambert, Shading::phong,
                           Shading::blinn_phong, Shading::ward};
  for (std::uint32_t i = 0; i < 5; ++i)
    for (const float metallic : {0.0f, 0.5f, 1.0f})
      for (const float roughness : {0.0f, 0.3f, 1.0f}) {
        ShadingPoint p{};
        set_material(p, kinds[i], vec3(1), metallic, roughness);
        const std::uint32_t expected[] = {BRDF_GGX, BRDF_LAMBERT, BRDF_PHONG, BRDF_BLINN_PHONG, BRDF_WARD};
        CHECK(p.brdf == expected[i]);
        const bool is_exponent = p.brdf == BRDF_PHONG || p.brdf == BRDF_BLINN_PHONG;
        if (p.brdf != BRDF_LAMBERT) {
          CHECK(p.alpha_x >= (is_exponent ? 1.0f : BRDF_MIN_ALPHA));
          CHECK(p.alpha_x <= (is_exponent ? BRDF_MAX_EXPONENT : 1.0f));
        }
        CHECK(p.diffuse.x + p.specular.x <= 1.0f + 1e-6f);
      }
}

TEST_CASE("a rougher surface has a wider lobe, whichever it is") {
  for (const Shading kind : {Shading::phong, Shading::blinn_phong}) {
    ShadingPoint smooth{}, rough{};
    set_material(smooth, kind, vec3(1), 1, 0.3f);
    set_material(rough, kind, vec3(1), 1, 0.6f);
    CHECK(smooth.alpha_x > rough.alpha_x);
  }
  ShadingPoint ward{};
  set_material(ward, Shading::ward, vec3(1), 1, 0.5f);
  CHECK(ward.alpha_x == doctest::Approx(0.25f));
  CHECK(ward.alpha_y == doctest::Approx(0.125f));
}
