// Where shadow rays begin: a little off the surface, and inside the faces that meet at a corner.
#pragma once

#include <algorithm>
#include <cmath>
#include <coppice/relight/receiver_mesh.hpp>
#include <coppice/scene/scene.hpp>
#include <cstdint>
#include <span>
#include <vector>

namespace coppice {

namespace detail {

/// Sums over the faces around a point.
struct FacesAround {
  vec3 normal{0};                                       ///< Σ unit geometric normals
  vec3 inward{0};                                       ///< Σ (centroid - point)
  float size = std::numeric_limits<float>::infinity();  ///< shortest |centroid - point|
  int count = 0;

  void add(const vec3& point, const vec3& face_normal, const vec3& centroid) {
    normal += face_normal;
    inward += centroid - point;
    size = std::min(size, length(centroid - point));
    ++count;
  }
};

inline vec3 face_centroid(const ReceiverMesh& mesh, const ReceiverMesh::Face& face) {
  const auto& c = mesh.corners();
  return (c[face.corners.x].position + c[face.corners.y].position + c[face.corners.z].position) / 3.0f;
}

/// How far rays begin above the faces around a point: 1e-3 of their size, and at least what float positions
/// resolve.
inline float clearance(const vec3& point, const FacesAround& around) {
  const float magnitude = std::max({std::fabs(point.x), std::fabs(point.y), std::fabs(point.z)});
  const float size = std::isfinite(around.size) ? around.size : 0.0f;
  return std::max(1e-3f * size, 4e-6f * std::max(magnitude, 1e-3f));
}

/// A receiver that is drawn inward, in the tangent plane so that it does not sink below a bulge. Thus a wall
/// that ends at the same corner is in front of its rays, not behind them.
inline Receiver place_receiver(const vec3& point, const vec3& fallback_normal, const FacesAround& around) {
  Receiver r;
  r.normal = normalize_or(around.normal, fallback_normal);
  const vec3 inward = around.count > 0 ? around.inward / float(around.count) : vec3(0);
  r.inward = inward - dot(inward, r.normal) * r.normal;
  r.position = point + clearance(point, around) * r.normal + 0.02f * r.inward;
  return r;
}

/// A receiver at the middle of an edge, as seen by its one or two faces.
inline Receiver middle_receiver(const vec3& point, const vec3& fallback_normal, const FacesAround& around) {
  Receiver r = place_receiver(point, fallback_normal, around);
  if (around.count > 1) r.position -= 0.02f * r.inward;  // between two faces it might sink into one of them
  return r;
}

}  // namespace detail

/// Receivers at every corner of the mesh, in order. Each begins above all faces that meet at the corner,
/// unless one of them is tilted by more than 84° (cosine 0.1) from their mean normal.
inline std::vector<Receiver> corner_receivers(const ReceiverMesh& mesh) {
  std::vector<detail::FacesAround> around(mesh.corners().size());
  const auto for_each_corner = [&](auto&& visit) {
    for (std::uint32_t f = 0; f < mesh.faces().size(); ++f)
      for (int k = 0; mesh.is_leaf(f) && k < 3; ++k) visit(mesh.faces()[f].corners[k], mesh.faces()[f]);
  };
  for_each_corner([&](std::uint32_t c, const ReceiverMesh::Face& face) {
    around[c].add(mesh.corners()[c].position, face.normal, detail::face_centroid(mesh, face));
  });
  std::vector<Receiver> receivers;
  receivers.reserve(around.size());
  for (std::size_t c = 0; c < around.size(); ++c)
    receivers.push_back(
        detail::place_receiver(mesh.corners()[c].position, mesh.corners()[c].normal, around[c]));

  std::vector<float> steepest(around.size(),
                              1.0f);             // smallest cosine between the receiver's normal and a face's
  std::vector<float> sunk(around.size(), 0.0f);  // what the receiver lacks of its clearance above a face
  for_each_corner([&](std::uint32_t c, const ReceiverMesh::Face& face) {
    const vec3 p = mesh.corners()[c].position;
    steepest[c] = std::min(steepest[c], dot(face.normal, receivers[c].normal));
    sunk[c] =
        std::max(sunk[c], detail::clearance(p, around[c]) - dot(face.normal, receivers[c].position - p));
  });
  for (std::size_t c = 0; c < receivers.size(); ++c) {
    receivers[c].position += receivers[c].normal * (sunk[c] / std::max(steepest[c], 0.1f));
    const float sine2 = 1 - steepest[c] * steepest[c];  // a face tilted by φ sees directions down to -sin φ
    receivers[c].horizon = steepest[c] <= 0 ? -1.0f : -std::sqrt(std::max(0.0f, sine2));
  }
  return receivers;
}

/// Sine of the angle by which normal maps are taken to bend shading normals: 12 degrees; measured:
/// docs/cut.md.
inline constexpr float bump_sine = 0.2f;

/// Sets the bend of the receivers at corners of faces whose material has a normal map. Precondition: one
/// receiver a corner of the mesh, in order.
inline void mark_bumpy_receivers(const Scene& scene, const ReceiverMesh& mesh,
                                 std::span<Receiver> receivers) {
  COPPICE_ASSERT(receivers.size() == mesh.corners().size());
  for (std::uint32_t f = 0; f < mesh.faces().size(); ++f) {
    const ReceiverMesh::Face& face = mesh.faces()[f];
    const Material& material = scene.materials[scene.mesh.materials[face.triangle]];
    if (!mesh.is_leaf(f) || material.normal_texture < 0) continue;
    for (int k = 0; k < 3; ++k) receivers[face.corners[k]].bend = bump_sine;
  }
}

}  // namespace coppice
