// Obvious ray tracers for the tests: spheres in closed form, and triangles one after the other.
#pragma once

#include <algorithm>
#include <cmath>
#include <coppice/scene/hit.hpp>
#include <coppice/scene/mesh.hpp>
#include <coppice/scene/occluder.hpp>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

namespace support {

using coppice::vec3;

/// The lanes of a packet that a single-ray occluder blocks.
template <class Single>
std::uint32_t lane_by_lane(const Single& single, const coppice::ShadowPacket& rays, std::uint32_t lanes) {
  std::uint32_t blocked = 0;
  for (std::uint32_t i = 0; i < 16; ++i) {
    if (!((lanes >> i) & 1)) continue;
    const vec3 origin(rays.origin_x[i], rays.origin_y[i], rays.origin_z[i]);
    const vec3 direction(rays.direction_x[i], rays.direction_y[i], rays.direction_z[i]);
    blocked |= std::uint32_t(single.occluded(origin, direction, rays.t_max[i])) << i;
  }
  return blocked;
}

struct Sphere {
  vec3 centre;
  float radius;
};

/// Solid balls: a point inside one sees nothing.
struct SphereOccluder {
  std::vector<Sphere> spheres;

  bool occluded(const vec3& origin, const vec3& direction, float t_max) const {
    return std::ranges::any_of(spheres, [&](const Sphere& s) {
      const vec3 to_centre = s.centre - origin;
      const float along = dot(to_centre, direction), inside = s.radius * s.radius - dot(to_centre, to_centre);
      const float root = inside + along * along;
      return root > 0 && (inside > 0 || (along > 0 && along - std::sqrt(root) < t_max));
    });
  }
  std::uint32_t occluded(const coppice::ShadowPacket& rays, std::uint32_t lanes) const {
    return lane_by_lane(*this, rays, lanes);
  }
};
static_assert(coppice::Occluder<SphereOccluder>);

/// All triangles of a mesh, both sides solid, in double; runs of 16 share a ball that a ray must meet first.
class TriangleTracer {
 public:
  explicit TriangleTracer(const coppice::Mesh& mesh) {
    for (const auto& t : mesh.triangles) {
      const glm::dvec3 p(mesh.positions[t.x]);
      triangles_.push_back({p, glm::dvec3(mesh.positions[t.y]) - p, glm::dvec3(mesh.positions[t.z]) - p});
    }
    for (std::size_t first = 0; first < triangles_.size(); first += run) balls_.push_back(ball_around(first));
  }

  std::optional<coppice::Hit> closest(const vec3& origin, const vec3& direction) const {
    std::optional<coppice::Hit> nearest;
    double t_max = std::numeric_limits<double>::infinity();
    for_each_meeting(origin, direction, [&](std::size_t i, double t, double u, double v, bool front) {
      if (t >= t_max) return false;
      nearest = {std::uint32_t(i), float(u), float(v), float(t), front};
      t_max = t;
      return false;
    });
    return nearest;
  }
  bool occluded(const vec3& origin, const vec3& direction, float t_max) const {
    return for_each_meeting(origin, direction,
                            [&](std::size_t, double t, double, double, bool) { return t < double(t_max); });
  }
  std::uint32_t occluded(const coppice::ShadowPacket& rays, std::uint32_t lanes) const {
    return lane_by_lane(*this, rays, lanes);
  }

 private:
  static constexpr std::size_t run = 16;
  struct Triangle {
    glm::dvec3 p, a, b;
  };
  struct Ball {
    glm::dvec3 centre;
    double radius2;
  };

  std::size_t end_of_run(std::size_t first) const { return std::min(first + run, triangles_.size()); }

  Ball ball_around(std::size_t first) const {
    glm::dvec3 low(std::numeric_limits<double>::infinity()), high = -low;
    for (std::size_t i = first; i < end_of_run(first); ++i)
      for (const auto& corner :
           {triangles_[i].p, triangles_[i].p + triangles_[i].a, triangles_[i].p + triangles_[i].b})
        low = glm::min(low, corner), high = glm::max(high, corner);
    return {0.5 * (low + high), 0.251 * glm::dot(high - low, high - low)};
  }

  /// Calls visit(triangle, t, u, v, front) until it returns true; tells whether it did. Edges belong to both
  /// sides.
  template <class Visit>
  bool for_each_meeting(const vec3& origin, const vec3& direction, Visit&& visit) const {
    const glm::dvec3 o(origin), d(direction);
    for (std::size_t r = 0; r < balls_.size(); ++r) {
      const glm::dvec3 c = balls_[r].centre - o;
      const double along = std::max(0.0, glm::dot(c, d));
      if (glm::dot(c - along * d, c - along * d) > balls_[r].radius2) continue;
      for (std::size_t i = r * run; i < end_of_run(r * run); ++i) {
        const auto& [p, a, b] = triangles_[i];
        const glm::dvec3 q = glm::cross(d, b), s = o - p, w = glm::cross(s, a);
        const double determinant = glm::dot(a, q);
        if (determinant == 0) continue;
        const double u = glm::dot(s, q) / determinant, v = glm::dot(d, w) / determinant;
        const double t = glm::dot(b, w) / determinant;
        if (u < -1e-9 || v < -1e-9 || u + v > 1 + 1e-9 || t <= 0) continue;
        if (visit(i, t, u, v, determinant > 0)) return true;
      }
    }
    return false;
  }

  std::vector<Triangle> triangles_;
  std::vector<Ball> balls_;
};
static_assert(coppice::Occluder<TriangleTracer> && coppice::RayTracer<TriangleTracer>);

}  // namespace support
