// The triangles on which visibility is stored at the corners and interpolated between them.
#pragma once

#include <algorithm>
#include <array>
#include <coppice/core/config.hpp>
#include <coppice/core/math.hpp>
#include <coppice/scene/mesh.hpp>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

namespace coppice {

/// A point at which visibility is stored.
struct Receiver {
  vec3 position{0};  ///< a little off the surface and away from the faces' borders: where shadow rays begin
  vec3 normal{0, 1, 0};  ///< unit; mean of the faces around it
  vec3 inward{0};        ///< in the tangent plane, from the corner to the mean of its faces' centroids
  float horizon = 0;  ///< lights with dot(normal, direction) <= horizon lie below all those faces: occluded
  float bend = 0;     ///< sine of the angle by which normal maps may bend the shading normals around it
};

/// A scene's triangle, seen from one side.
struct SidedTriangle {
  std::uint32_t triangle = 0;
  bool front = true;  ///< the side on which the vertex normals are
};

inline constexpr std::uint32_t no_face = ~std::uint32_t{0};

/// Corners at which receivers stand, welded where position and shading normal agree, and the faces between
/// them. Each face is a part of one side of a scene's triangle; a refined face has children that tile it
/// (refine.hpp), and only faces without children count. Faces that share an edge share its receivers, so
/// interpolation is continuous across it.
class ReceiverMesh {
 public:
  struct Corner {
    vec3 position;  ///< on the surface
    vec3 normal;    ///< shading normal on the face's side
  };
  struct Face {
    uvec3 corners;
    std::array<vec2, 3>
        uv;       ///< of the corners, as (u, v) of the scene's triangle: p = (1-u-v)·p0 + u·p1 + v·p2
    vec3 normal;  ///< unit; of the scene's triangle, on the face's side
    std::uint32_t triangle = 0;  ///< the scene's triangle
    std::uint32_t first_child = no_face;
    std::uint32_t child_count = 0;
  };
  /// A face without children, and barycentric weights of its three corners.
  struct Location {
    std::uint32_t face = no_face;
    vec3 weights{0};
  };

  ReceiverMesh() = default;
  /// One face for each of `sides`.
  ReceiverMesh(const Mesh& mesh, std::span<const SidedTriangle> sides) {
    std::unordered_map<Key, std::uint32_t, KeyHash> corner_of;
    for (const SidedTriangle& side : sides) add_root(mesh, side, corner_of);
  }

  /// From the arrays that corners(), faces() and sides() give. Precondition: are_faces(...).
  static ReceiverMesh from_arrays(std::vector<Corner> corners, std::vector<Face> faces,
                                  std::span<const SidedTriangle> sides) {
    COPPICE_ASSERT(are_faces(corners.size(), faces, sides.size()));
    ReceiverMesh mesh;
    mesh.corners_ = std::move(corners), mesh.faces_ = std::move(faces);
    for (const SidedTriangle& side : sides) mesh.note_root(side);
    return mesh;
  }

  /// True where faces have corners below corner_count, and all but the first `roots` are children of one face
  /// each, which stands before them.
  static bool are_faces(std::size_t corner_count, std::span<const Face> faces, std::size_t roots) {
    if (roots > faces.size()) return false;
    std::vector<bool> has_parent(faces.size(), false);
    for (std::size_t f = 0; f < faces.size(); ++f) {
      const Face& face = faces[f];
      for (int k = 0; k < 3; ++k)
        if (face.corners[k] >= corner_count) return false;
      if (face.child_count == 0) continue;
      const std::size_t first = face.first_child, end = first + face.child_count;
      if (first <= f || first < roots || end > faces.size()) return false;
      for (std::size_t child = first; child < end; ++child) {
        if (has_parent[child]) return false;
        has_parent[child] = true;
      }
    }
    return std::find(has_parent.begin() + std::ptrdiff_t(roots), has_parent.end(), false) == has_parent.end();
  }

  const std::vector<Corner>& corners() const { return corners_; }
  const std::vector<Face>& faces() const { return faces_; }
  /// Those given to the constructor; of the first faces, in order.
  const std::vector<SidedTriangle>& sides() const { return sides_; }
  bool is_leaf(std::uint32_t face) const { return faces_[face].child_count == 0; }

  std::uint32_t add_corner(const Corner& corner) {
    corners_.push_back(corner);
    return std::uint32_t(corners_.size() - 1);
  }

  /// Replaces a face by children that tile it.
  void subdivide(std::uint32_t face, std::span<const Face> children) {
    faces_[face].first_child = std::uint32_t(faces_.size());
    faces_[face].child_count = std::uint32_t(children.size());
    faces_.insert(faces_.end(), children.begin(), children.end());
  }

  bool has(SidedTriangle side) const { return root_of_.contains(root_key(side)); }

  /// The face in which the point (u, v) of that side lies. Cost: the depth of the refinement. Precondition:
  /// the side was given to the constructor.
  Location locate(SidedTriangle side, vec2 uv) const {
    const auto root = root_of_.find(root_key(side));
    COPPICE_ASSERT(root != root_of_.end());
    Location found{root->second, weights_in(faces_[root->second], uv)};
    while (!is_leaf(found.face)) found = best_child(found.face, uv);
    found.weights = glm::max(found.weights, vec3(0));
    found.weights /= found.weights.x + found.weights.y + found.weights.z;
    return found;
  }

 private:
  using Key = std::array<float, 6>;
  struct KeyHash {
    std::size_t operator()(const Key& key) const {
      std::uint64_t h = 0xcbf29ce484222325u;
      for (const float f : key) {
        std::uint32_t bits = 0;
        std::memcpy(&bits, &f, 4);
        h = (h ^ bits) * 0x100000001b3u;
      }
      return std::size_t(h ^ (h >> 29));
    }
  };

  static std::uint64_t root_key(SidedTriangle s) { return 2 * std::uint64_t(s.triangle) + (s.front ? 1 : 0); }

  /// Geometric normal on the side where the vertex normals are (front) or are not.
  static vec3 side_normal(const Mesh& mesh, SidedTriangle side) {
    const uvec3 t = mesh.triangles[side.triangle];
    const vec3 p = mesh.positions[t.x];
    const vec3 shading = mesh.normals[t.x] + mesh.normals[t.y] + mesh.normals[t.z];
    const vec3 n = normalize_or(cross(mesh.positions[t.y] - p, mesh.positions[t.z] - p),
                                normalize_or(shading, vec3(0, 1, 0)));
    return (dot(n, shading) < 0) == side.front ? -n : n;
  }

  void add_root(const Mesh& mesh, SidedTriangle side,
                std::unordered_map<Key, std::uint32_t, KeyHash>& corner_of) {
    Face face{{}, {vec2(0, 0), vec2(1, 0), vec2(0, 1)}, side_normal(mesh, side), side.triangle};
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t v = mesh.triangles[side.triangle][k];
      const vec3 p = mesh.positions[v] + 0.0f, n = (side.front ? mesh.normals[v] : -mesh.normals[v]) + 0.0f;
      const auto [it, is_new] = corner_of.try_emplace(Key{p.x, p.y, p.z, n.x, n.y, n.z}, 0u);
      if (is_new) it->second = add_corner({p, n});
      face.corners[k] = it->second;
    }
    note_root(side);
    faces_.push_back(face);
  }

  void note_root(SidedTriangle side) {
    root_of_[root_key(side)] = std::uint32_t(sides_.size());
    sides_.push_back(side);
  }

  /// Barycentric weights of (u, v) in a face. Faces that rounding has flattened give their first corner.
  static vec3 weights_in(const Face& face, vec2 uv) {
    const vec2 a = face.uv[1] - face.uv[0], b = face.uv[2] - face.uv[0], p = uv - face.uv[0];
    const float area = a.x * b.y - a.y * b.x;
    if (area == 0) return {1, 0, 0};
    const float w1 = (p.x * b.y - p.y * b.x) / area, w2 = (a.x * p.y - a.y * p.x) / area;
    return {1 - w1 - w2, w1, w2};
  }

  Location best_child(std::uint32_t face, vec2 uv) const {
    Location best;
    float best_inside = -std::numeric_limits<float>::infinity();
    for (std::uint32_t c = 0; c < faces_[face].child_count; ++c) {
      const vec3 w = weights_in(faces_[faces_[face].first_child + c], uv);
      const float inside = std::min(w.x, std::min(w.y, w.z));
      if (inside > best_inside) best_inside = inside, best = {faces_[face].first_child + c, w};
    }
    return best;
  }

  std::vector<Corner> corners_;
  std::vector<Face> faces_;
  std::vector<SidedTriangle> sides_;
  std::unordered_map<std::uint64_t, std::uint32_t> root_of_;
};

}  // namespace coppice
