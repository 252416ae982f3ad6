// Rooms for particles: boxes seen from inside, made of quads.
#pragma once

#include <coppice/transfer/particles.hpp>

#include "support/occluders.hpp"
#include "support/scenes.hpp"

namespace support {

/// A material of this colour, solid on both sides.
inline coppice::Material wall(const vec3& colour = vec3(0.5f), bool double_sided = true) {
  coppice::Material material = dielectric(colour, 1);
  material.double_sided = double_sided;
  return material;
}

/// A box whose fronts are inside.
inline void add_room(coppice::Mesh& mesh, const vec3& low, const vec3& high, std::uint32_t material = 0) {
  const std::size_t first = mesh.triangles.size();
  add_box(mesh, low, high, material);
  for (std::size_t t = first; t < mesh.triangles.size(); ++t)
    std::swap(mesh.triangles[t].y, mesh.triangles[t].z);
}

/// 2 × 3 × 4 m: 52 m².
inline coppice::Scene box_room(bool double_sided = true) {
  coppice::Scene scene;
  scene.materials = {wall(vec3(0.5f), double_sided)};
  add_room(scene.mesh, {0, 0, 0}, {2, 3, 4});
  return scene;
}

/// The scene's particles by the brute-force tracer.
template <class E = coppice::Serial>
coppice::ParticleField particles_in(const coppice::Scene& scene, std::vector<vec3> starts,
                                    const coppice::ParticleOptions& options, const E& executor = {}) {
  return coppice::trace_particles(scene, TriangleTracer(scene.mesh), starts, executor, options);
}

}  // namespace support
