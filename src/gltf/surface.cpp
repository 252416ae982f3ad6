#include "surface.hpp"

#include <algorithm>

namespace coppice::gltf {
namespace {

// In double: differences and products of floats lose next to nothing there.
glm::dvec3 edge_cross(const Mesh& mesh, const uvec3& triangle) {
  const glm::dvec3 origin(mesh.positions[triangle.x]);
  return cross(glm::dvec3(mesh.positions[triangle.y]) - origin,
               glm::dvec3(mesh.positions[triangle.z]) - origin);
}

// v / |v| by way of double, or zero where v has no direction.
vec3 direction(const glm::dvec3& v) {
  const double size = length(v);
  return size > 1e-30 && std::isfinite(size) ? vec3(v / size) : vec3(0);
}

vec3 perpendicular(const vec3& v, const vec3& normal) {
  const glm::dvec3 n(normal), part = glm::dvec3(v) - n * dot(n, glm::dvec3(v));
  return length(part) > 1e-6 * length(glm::dvec3(v)) ? direction(part) : vec3(0);
}

template <class T>
void unshare(std::vector<T>& values, const std::vector<uvec3>& triangles) {
  std::vector<T> own;
  own.reserve(3 * triangles.size());
  for (const uvec3& triangle : triangles)
    for (int corner = 0; corner < 3; ++corner) own.push_back(values[triangle[corner]]);
  values = std::move(own);
}

double corner_angle(const Mesh& mesh, const uvec3& triangle, int corner) {
  const glm::dvec3 here(mesh.positions[triangle[corner]]);
  const glm::dvec3 a = glm::dvec3(mesh.positions[triangle[(corner + 1) % 3]]) - here;
  const glm::dvec3 b = glm::dvec3(mesh.positions[triangle[(corner + 2) % 3]]) - here;
  return std::atan2(length(cross(a, b)), dot(a, b));
}

struct Derivatives {
  vec3 along_u{0}, along_v{0};  // of the position, unit; zero where uv is degenerate
};

Derivatives uv_derivatives(const Mesh& mesh, const uvec3& triangle) {
  const glm::dvec3 origin(mesh.positions[triangle.x]);
  const glm::dvec2 uv(mesh.uvs[triangle.x]);
  const glm::dvec3 e1 = glm::dvec3(mesh.positions[triangle.y]) - origin;
  const glm::dvec3 e2 = glm::dvec3(mesh.positions[triangle.z]) - origin;
  const glm::dvec2 d1 = glm::dvec2(mesh.uvs[triangle.y]) - uv, d2 = glm::dvec2(mesh.uvs[triangle.z]) - uv;
  const double area = d1.x * d2.y - d2.x * d1.y;
  if (area == 0) return {};
  const double sign = area > 0 ? 1 : -1;
  return {direction((e1 * d2.y - e2 * d1.y) * sign), direction((e2 * d1.x - e1 * d2.x) * sign)};
}

}  // namespace

std::size_t drop_flat_triangles(Mesh& mesh) {
  std::size_t kept = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (length(edge_cross(mesh, mesh.triangles[t])) < least_cross) continue;
    mesh.triangles[kept] = mesh.triangles[t];
    mesh.materials[kept++] = mesh.materials[t];
  }
  const std::size_t dropped = mesh.triangles.size() - kept;
  mesh.triangles.resize(kept);
  mesh.materials.resize(kept);
  return dropped;
}

void make_flat_normals(Mesh& mesh) {
  mesh.normals.clear();
  for (const uvec3& triangle : mesh.triangles)
    mesh.normals.insert(mesh.normals.end(), 3, direction(edge_cross(mesh, triangle)));
  unshare(mesh.positions, mesh.triangles);
  unshare(mesh.tangents, mesh.triangles);
  unshare(mesh.uvs, mesh.triangles);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    mesh.triangles[t] = uvec3(3 * t, 3 * t + 1, 3 * t + 2);
}

std::size_t normalize_normals(Mesh& mesh) {
  std::size_t replaced = 0;
  for (vec3& normal : mesh.normals) {
    normal = direction(glm::dvec3(normal));
    replaced += normal == vec3(0);
  }
  if (replaced == 0) return 0;
  std::vector<glm::dvec3> around(mesh.normals.size(), glm::dvec3(0));
  std::vector<vec3> any(mesh.normals.size(), vec3(0));
  for (const uvec3& triangle : mesh.triangles) {
    const glm::dvec3 geometric = edge_cross(mesh, triangle);
    for (int corner = 0; corner < 3; ++corner) {
      around[triangle[corner]] += geometric;
      any[triangle[corner]] = direction(geometric);
    }
  }
  for (std::size_t v = 0; v < mesh.normals.size(); ++v)
    if (mesh.normals[v] == vec3(0)) {
      const vec3 mean = direction(around[v]);
      mesh.normals[v] = mean == vec3(0) ? any[v] : mean;  // opposite triangles may cancel
    }
  return replaced;
}

void orthonormalize_tangents(Mesh& mesh) {
  for (std::size_t v = 0; v < mesh.tangents.size(); ++v)
    mesh.tangents[v] =
        vec4(perpendicular(vec3(mesh.tangents[v]), mesh.normals[v]), mesh.tangents[v].w < 0 ? -1 : 1);
}

void make_tangents(Mesh& mesh) {
  std::vector<glm::dvec3> along_u(mesh.positions.size(), glm::dvec3(0)), along_v = along_u;
  for (const uvec3& triangle : mesh.triangles) {
    const Derivatives d = uv_derivatives(mesh, triangle);
    for (int corner = 0; corner < 3; ++corner) {
      const std::uint32_t v = triangle[corner];
      const double weight = corner_angle(mesh, triangle, corner);
      along_u[v] += weight * glm::dvec3(perpendicular(d.along_u, mesh.normals[v]));
      along_v[v] += weight * glm::dvec3(perpendicular(d.along_v, mesh.normals[v]));
    }
  }
  for (std::size_t v = 0; v < mesh.tangents.size(); ++v) {
    const glm::dvec3 bitangent = cross(glm::dvec3(mesh.normals[v]), along_u[v]);
    const float w = dot(bitangent, along_v[v]) > 0 ? -1.0f : 1.0f;
    mesh.tangents[v] = vec4(perpendicular(direction(along_u[v]), mesh.normals[v]), w);
  }
}

void drop_unused_vertices(Mesh& mesh) {
  std::vector<std::uint32_t> place(mesh.positions.size(), 0);
  for (const uvec3& triangle : mesh.triangles)
    for (int corner = 0; corner < 3; ++corner) place[triangle[corner]] = 1;
  std::uint32_t kept = 0;
  for (std::size_t v = 0; v < place.size(); ++v) {
    if (!place[v]) continue;
    mesh.positions[kept] = mesh.positions[v];
    if (!mesh.normals.empty()) mesh.normals[kept] = mesh.normals[v];
    mesh.tangents[kept] = mesh.tangents[v];
    mesh.uvs[kept] = mesh.uvs[v];
    place[v] = kept++;
  }
  mesh.positions.resize(kept);
  mesh.normals.resize(std::min<std::size_t>(kept, mesh.normals.size()));
  mesh.tangents.resize(kept);
  mesh.uvs.resize(kept);
  for (uvec3& triangle : mesh.triangles) triangle = {place[triangle.x], place[triangle.y], place[triangle.z]};
}

}  // namespace coppice::gltf
