// Where shadow rays begin: a little off the surface, and inside the faces that meet at a corner.
#pragma once

#include <algorithm>
#include <cmath>
#include <coppice/relight/receiver_mesh.hpp>
#include <cstdint>
#include <span>
#include <vector>

namespace coppice {

namespace detail {

/// Sums over the faces around a point.
struct FacesAround {
  vec3 normal{0};  ///< Σ unit geometric normals
  vec3 inward{0};  ///< Σ (centroid - point)
  float size = std::numeric_limits<float>::infinity();  ///< shortest |centroid - point|
  int count = 0;

  void add(const vec3& point, const vec3& face_normal, const vec3& centroid) {
    normal += face_normal;
    inward += centroid - point;
    size = std::min(size, length(centroid - point));
    ++count;
  }
};

/// Unit normal of a face on the side of its corners' shading normals.
inline vec3 face_normal(const ReceiverMesh& mesh, const ReceiverMesh::Face& face) {
  const auto& c = mesh.corners();
  const vec3 p = c[face.corners.x].position;
  const vec3 shading = c[face.corners.x].normal + c[face.corners.y].normal + c[face.corners.z].normal;
  const vec3 n = normalize_or(cross(c[face.corners.y].position - p, c[face.corners.z].position - p),
                              normalize_or(shading, vec3(0, 1, 0)));
  return dot(n, shading) < 0 ? -n : n;
}

inline vec3 face_centroid(const ReceiverMesh& mesh, const ReceiverMesh::Face& face) {
  const auto& c = mesh.corners();
  return (c[face.corners.x].position + c[face.corners.y].position + c[face.corners.z].position) / 3.0f;
}

/// Where rays leave a point with those faces around: lifted by 1e-3 of the faces' size and at least by what float
/// positions resolve, and drawn inward, in the tangent plane so that it does not sink below a bulge. Thus a wall that
/// ends at the same corner is in front of the ray, not behind it.
inline Receiver place_receiver(const vec3& point, const vec3& fallback_normal, const FacesAround& around) {
  Receiver r;
  r.normal = normalize_or(around.normal, fallback_normal);
  const float magnitude = std::max({std::fabs(point.x), std::fabs(point.y), std::fabs(point.z)});
  const float size = around.count > 0 && std::isfinite(around.size) ? around.size : 0.0f;
  const float lift = std::max(1e-3f * size, 4e-6f * std::max(magnitude, 1e-3f));
  const vec3 inward = around.count > 0 ? around.inward / float(around.count) : vec3(0);
  r.position = point + lift * r.normal + 0.02f * (inward - dot(inward, r.normal) * r.normal);
  return r;
}

}  // namespace detail

/// Receivers at every corner of the mesh, in order.
inline std::vector<Receiver> corner_receivers(const ReceiverMesh& mesh) {
  std::vector<detail::FacesAround> around(mesh.corners().size());
  std::vector<float> lowest(mesh.corners().size(), 1.0f);
  const auto for_each_corner = [&](auto&& visit) {
    for (std::uint32_t f = 0; f < mesh.faces().size(); ++f) {
      if (!mesh.is_leaf(f)) continue;
      const auto& face = mesh.faces()[f];
      const vec3 n = detail::face_normal(mesh, face), centroid = detail::face_centroid(mesh, face);
      for (int k = 0; k < 3; ++k) visit(face.corners[k], n, centroid);
    }
  };
  for_each_corner([&](std::uint32_t c, const vec3& n, const vec3& centroid) {
    around[c].add(mesh.corners()[c].position, n, centroid);
  });
  std::vector<Receiver> receivers;
  receivers.reserve(around.size());
  for (std::size_t c = 0; c < around.size(); ++c)
    receivers.push_back(detail::place_receiver(mesh.corners()[c].position, mesh.corners()[c].normal, around[c]));
  for_each_corner([&](std::uint32_t c, const vec3& n, const vec3&) {
    lowest[c] = std::min(lowest[c], dot(n, receivers[c].normal));
  });
  for (std::size_t c = 0; c < receivers.size(); ++c)  // a face tilted by φ sees directions down to -sin φ
    receivers[c].horizon = lowest[c] <= 0 ? -1.0f : -std::sqrt(std::max(0.0f, 1 - lowest[c] * lowest[c]));
  return receivers;
}

}  // namespace coppice
