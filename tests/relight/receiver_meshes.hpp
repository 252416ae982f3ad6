// Receiver meshes over whole scenes, and what is around their corners.
#pragma once

#include <coppice/relight/receiver_mesh.hpp>
#include <vector>

namespace relight_test {

inline std::vector<coppice::SidedTriangle> all_fronts(const coppice::Mesh& mesh) {
  std::vector<coppice::SidedTriangle> sides;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) sides.push_back({t, true});
  return sides;
}

/// Normals of the undivided faces that meet at each corner.
inline std::vector<std::vector<coppice::vec3>> normals_around(const coppice::ReceiverMesh& mesh) {
  std::vector<std::vector<coppice::vec3>> normals(mesh.corners().size());
  for (std::uint32_t f = 0; f < mesh.faces().size(); ++f)
    for (int k = 0; mesh.is_leaf(f) && k < 3; ++k)
      normals[mesh.faces()[f].corners[k]].push_back(mesh.faces()[f].normal);
  return normals;
}

}  // namespace relight_test
