// A scene whose objects move, as it stands at one time.
#pragma once

#include <coppice/scene/scene.hpp>

namespace coppice {

/// Appends the vertices and triangles of another mesh, behind what is there.
inline void append(Mesh& mesh, const Mesh& more) {
  const auto base = std::uint32_t(mesh.positions.size());
  const auto join = [](auto& all, const auto& part) { all.insert(all.end(), part.begin(), part.end()); };
  join(mesh.positions, more.positions);
  join(mesh.normals, more.normals);
  join(mesh.tangents, more.tangents);
  join(mesh.uvs, more.uvs);
  join(mesh.materials, more.materials);
  mesh.triangles.reserve(mesh.triangles.size() + more.triangles.size());
  for (const uvec3& triangle : more.triangles) mesh.triangles.push_back(triangle + base);
}

/// The mesh carried along; everything but positions, normals and tangents stays.
inline Mesh moved(Mesh mesh, const RigidTransform& transform) {
  for (vec3& p : mesh.positions) p = transform.point(p);
  for (vec3& n : mesh.normals) n = transform.direction(n);
  for (vec4& t : mesh.tangents) t = vec4(transform.direction(vec3(t)), t.w);
  return mesh;
}

/// All triangles in world space at a time in seconds: Scene::mesh, then the objects in their order.
/// Precondition: time is not NaN. Cost: a copy of all the meshes.
inline Mesh mesh_at(const Scene& scene, float time) {
  Mesh all = scene.mesh;
  for (const MovingObject& object : scene.objects) append(all, moved(object.mesh, object.motion.at(time)));
  return all;
}

}  // namespace coppice
