// Small procedural scenes and environments.
#pragma once

#include <coppice/core/random.hpp>
#include <coppice/light/environment.hpp>
#include <coppice/scene/scene.hpp>
#include <cstdint>
#include <utility>

namespace support {

using coppice::uvec3;
using coppice::vec2;
using coppice::vec3;
using coppice::vec4;

inline std::uint32_t add_vertex(coppice::Mesh& mesh, const vec3& position, const vec3& normal) {
  mesh.positions.push_back(position);
  mesh.normals.push_back(normal);
  mesh.tangents.push_back(vec4(0, 0, 0, 1));
  mesh.uvs.push_back(vec2(0));
  return std::uint32_t(mesh.positions.size() - 1);
}

inline void add_triangle(coppice::Mesh& mesh, const uvec3& corners, std::uint32_t material = 0) {
  mesh.triangles.push_back(corners);
  mesh.materials.push_back(material);
}

/// The parallelogram p, p + a, p + a + b, p + b as two triangles that face a × b.
inline void add_quad(coppice::Mesh& mesh, const vec3& p, const vec3& a, const vec3& b,
                     std::uint32_t material = 0) {
  const vec3 n = normalize(cross(a, b));
  const std::uint32_t first = add_vertex(mesh, p, n);
  add_vertex(mesh, p + a, n), add_vertex(mesh, p + a + b, n), add_vertex(mesh, p + b, n);
  add_triangle(mesh, {first, first + 1, first + 2}, material);
  add_triangle(mesh, {first, first + 2, first + 3}, material);
}

/// A square of the plane at `height`, facing +Y.
inline void add_ground(coppice::Mesh& mesh, float half_width, float height = 0, std::uint32_t material = 0) {
  add_quad(mesh, {-half_width, height, half_width}, {2 * half_width, 0, 0}, {0, 0, -2 * half_width},
           material);
}

inline void add_box(coppice::Mesh& mesh, const vec3& low, const vec3& high, std::uint32_t material = 0) {
  const vec3 s = high - low, x(s.x, 0, 0), y(0, s.y, 0), z(0, 0, s.z);
  add_quad(mesh, low, z, y, material), add_quad(mesh, low + x, y, z, material);
  add_quad(mesh, low, x, z, material), add_quad(mesh, low + y, z, x, material);
  add_quad(mesh, low, y, x, material), add_quad(mesh, low + z, x, y, material);
}

/// A ball of 2 · rings slices with smooth normals.
inline void add_ball(coppice::Mesh& mesh, const vec3& centre, float radius, std::uint32_t rings,
                     std::uint32_t material = 0) {
  const std::uint32_t first = std::uint32_t(mesh.positions.size()), slices = 2 * rings;
  for (std::uint32_t i = 0; i <= rings; ++i)
    for (std::uint32_t j = 0; j < slices; ++j) {
      const float polar = coppice::pi * float(i) / float(rings),
                  azimuth = 2 * coppice::pi * float(j) / float(slices);
      const float r = i == 0 || i == rings ? 0.0f : std::sin(polar);
      const vec3 n(r * std::cos(azimuth), std::cos(polar), -r * std::sin(azimuth));
      add_vertex(mesh, centre + radius * n, normalize(n));
    }
  for (std::uint32_t i = 0; i < rings; ++i)
    for (std::uint32_t j = 0; j < slices; ++j) {
      const std::uint32_t a = first + i * slices + j, b = first + i * slices + (j + 1) % slices;
      if (i > 0) add_triangle(mesh, {a, a + slices, b}, material);
      if (i + 1 < rings) add_triangle(mesh, {b, a + slices, b + slices}, material);
    }
}

/// A bumpy square of cells × cells × 2 triangles over [0, 1]², smooth vertex normals, heights up to
/// `amplitude`.
inline coppice::Mesh bumpy_mesh(std::uint32_t cells, float amplitude, std::uint64_t seed) {
  coppice::Mesh mesh;
  coppice::Random random(seed);
  const auto place = [&](std::uint32_t i) { return float(i) / float(cells); };
  for (std::uint32_t z = 0; z <= cells; ++z)
    for (std::uint32_t x = 0; x <= cells; ++x)
      add_vertex(mesh, {place(x), amplitude * random.uniform(), -place(z)}, vec3(0));
  for (std::uint32_t z = 0; z < cells; ++z)
    for (std::uint32_t x = 0; x < cells; ++x) {
      const std::uint32_t a = z * (cells + 1) + x, b = a + cells + 1;
      add_triangle(mesh, {a, a + 1, b + 1}), add_triangle(mesh, {a, b + 1, b});
    }
  for (const uvec3& t : mesh.triangles) {
    const vec3 p = mesh.positions[t.x], n = cross(mesh.positions[t.y] - p, mesh.positions[t.z] - p);
    for (int k = 0; k < 3; ++k) mesh.normals[t[k]] += n;
  }
  for (vec3& n : mesh.normals) n = normalize(n);
  return mesh;
}

/// Looks from `eye` at `target`, +Y up.
inline coppice::Camera look_at(const vec3& eye, const vec3& target, float vertical_fov) {
  coppice::Camera camera;
  camera.position = eye;
  camera.forward = normalize(target - eye);
  camera.right = normalize(cross(camera.forward, vec3(0, 1, 0)));
  camera.up = cross(camera.right, camera.forward);
  camera.vertical_fov = vertical_fov;
  return camera;
}

inline coppice::Material dielectric(const vec3& base, float roughness) {
  coppice::Material material;
  material.base_color = base, material.metallic = 0, material.roughness = roughness;
  return material;
}

/// A box and a ball on a square of ground: about 300 triangles.
inline coppice::Scene still_life() {
  coppice::Scene scene;
  scene.materials = {dielectric({0.6f, 0.6f, 0.55f}, 0.9f), dielectric({0.7f, 0.3f, 0.2f}, 0.6f),
                     dielectric({0.2f, 0.4f, 0.8f}, 0.5f)};
  add_ground(scene.mesh, 2, 0, 0);
  add_box(scene.mesh, {-1, 0, -0.5f}, {-0.2f, 0.9f, 0.3f}, 1);
  add_ball(scene.mesh, {0.6f, 0.5f, 0}, 0.5f, 9, 2);
  scene.camera = look_at({0.5f, 2, 3.5f}, {0, 0.35f, 0}, 0.7f);
  return scene;
}

inline coppice::Environment constant_environment(const vec3& radiance, int width = 32, int height = 16) {
  return {coppice::Image(width, height, radiance), 0};
}

/// A blue gradient with a soft sun at `towards`.
inline coppice::Environment sky(const vec3& towards = normalize(vec3(1, 1.2f, 0.6f)), int width = 128,
                                int height = 64) {
  coppice::Environment environment{coppice::Image(width, height), 0};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const vec3 d = coppice::texel_direction(x, y, width, height);
      const float sun = 30 * std::exp(60 * (dot(d, towards) - 1));
      environment.map.at(x, y) = vec3(0.3f, 0.4f, 0.6f) * (1.1f + d.y) + sun * vec3(1, 0.9f, 0.7f);
    }
  return environment;
}

}  // namespace support
