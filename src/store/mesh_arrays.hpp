// A mesh of receivers as the arrays of a store. Faces are split at corners and at middles of edges only,
// into at most one more than the middles that are used, so that a child takes one byte, and a corner that is
// the middle of an edge takes its index.
#pragma once

#include <coppice/relight/receiver_mesh.hpp>

#include "contents.hpp"

namespace coppice::store {

/// `corners`: those up to the last that is not just the middle of an edge; corner_count counts the others
/// too. The faces that are split come in the order of their first children. A child is v0 + 6 v1 + 36 v2:
/// vertex v is the parent's corner v for v < 3, else the middle of its edge from corner v - 3 to the next.
/// `middles` has for each split face the corners at the middles that its children use, in the order of its
/// edges.
struct MeshArrays {
  std::uint32_t corner_count = 0;
  std::vector<vec3> corner_positions, corner_normals;
  std::vector<uvec3> root_corners;
  std::vector<vec3> root_normals;
  std::vector<std::uint32_t> root_triangles;
  std::vector<std::uint8_t> root_fronts;
  std::vector<std::uint32_t> split_faces;
  std::vector<std::uint8_t> split_children, children;
  std::vector<std::uint32_t> middles;
};

/// Throws Refusal where a face is split elsewhere.
MeshArrays arrays_of(const ReceiverMesh& mesh);

/// Throws Refusal where the arrays describe no mesh. Allocates in proportion to the arrays.
ReceiverMesh mesh_of(const MeshArrays& arrays);

}  // namespace coppice::store
