// A scene for benchmarks of many lights, made up: rooms in a grid, with doors, pillars and lamps.
#pragma once

#include <coppice/core/random.hpp>
#include <coppice/scene/scene.hpp>

namespace coppice::bench {

inline void add_quad(Mesh& mesh, const vec3& corner, const vec3& a, const vec3& b) {
  const auto first = std::uint32_t(mesh.positions.size());
  const vec3 normal = normalize(cross(a, b));
  for (const vec3& p : {corner, corner + a, corner + a + b, corner + b}) {
    mesh.positions.push_back(p);
    mesh.normals.push_back(normal);
    mesh.tangents.emplace_back(normalize(a), 1);
    mesh.uvs.emplace_back(0);
  }
  mesh.triangles.emplace_back(first, first + 1, first + 2);
  mesh.triangles.emplace_back(first, first + 2, first + 3);
  mesh.materials.insert(mesh.materials.end(), 2, 0u);
}

/// A box that stands on the ground: its four sides and its top.
inline void add_box(Mesh& mesh, const vec3& low, const vec3& high) {
  const vec3 x(high.x - low.x, 0, 0), y(0, high.y - low.y, 0), z(0, 0, high.z - low.z);
  add_quad(mesh, low, y, x);
  add_quad(mesh, low + z, x, y);
  add_quad(mesh, low, z, y);
  add_quad(mesh, low + x, y, z);
  add_quad(mesh, low + y, z, x);
}

/// `count` × `count` rooms of 4 m, walls 2.5 m high with a door each and no roof, a pillar and `lamps` point
/// lights of many colours and powers in every room; the camera looks in from above.
inline Scene lit_rooms(int count = 5, int lamps = 24) {
  constexpr float size = 4, height = 2.5f, half_wall = 0.1f, half_door = 0.5f;
  Scene scene;
  scene.materials.push_back({.name = "plaster", .base_color = vec3(0.6f), .metallic = 0, .roughness = 0.5f});
  const float width = size * float(count);
  add_quad(scene.mesh, vec3(0), vec3(0, 0, width), vec3(width, 0, 0));
  Random random(1);
  for (int i = 0; i < count * count; ++i) {
    const float x = size * float(i % count), z = size * float(i / count), middle = size / 2;
    for (const float from : {0.0f, middle + half_door}) {
      const float to = from + middle - half_door;
      add_box(scene.mesh, {x - half_wall, 0, z + from}, {x + half_wall, height, z + to});
      add_box(scene.mesh, {x + from, 0, z - half_wall}, {x + to, height, z + half_wall});
    }
    const vec3 foot(x + 1 + 2 * random.uniform(), 0, z + 1 + 2 * random.uniform());
    add_box(scene.mesh, foot - vec3(0.2f, 0, 0.2f), foot + vec3(0.2f, 1.5f, 0.2f));
    for (int l = 0; l < lamps; ++l) {
      const float u = random.uniform(), v = random.uniform(), h = random.uniform();
      const vec3 colour(random.uniform(), random.uniform(), random.uniform());
      scene.lights.push_back({.position = {x + 0.2f + 3.6f * u, 0.3f + 2 * h, z + 0.2f + 3.6f * v},
                              .intensity = (0.05f + random.uniform()) * colour});
    }
  }
  Camera camera;
  camera.position = {width / 2, 1.2f * width, 1.1f * width};
  camera.forward = normalize(vec3(width / 2, 0, width / 2) - camera.position);
  camera.right = {1, 0, 0};
  camera.up = cross(camera.right, camera.forward);
  camera.vertical_fov = 0.75f;
  scene.camera = camera;
  return scene;
}

}  // namespace coppice::bench
