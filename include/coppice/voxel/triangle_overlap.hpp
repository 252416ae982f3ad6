// Which boxes of a lattice a triangle meets.
#pragma once

#include <algorithm>
#include <coppice/core/math.hpp>

namespace coppice {

/// Corners of a triangle, in any frame.
struct TriangleCorners {
  vec3 a, b, c;
};

namespace triangle_overlap {

/// True where the projections of triangle and box on an axis do not meet. The corners are relative to the
/// box's centre.
inline bool apart_along(const vec3& axis, const TriangleCorners& t, const vec3& half) {
  const float a = dot(axis, t.a), b = dot(axis, t.b), c = dot(axis, t.c);
  const float reach = dot(glm::abs(axis), half) * (1 + 1e-5f);
  return std::min({a, b, c}) > reach || std::max({a, b, c}) < -reach;
}

inline bool apart_across_edge(const vec3& edge, const TriangleCorners& t, const vec3& half) {
  return apart_along({0, -edge.z, edge.y}, t, half) || apart_along({edge.z, 0, -edge.x}, t, half) ||
         apart_along({-edge.y, edge.x, 0}, t, half);
}

}  // namespace triangle_overlap

/// True where a triangle and a box meet or touch: none of 13 axes separates them (Akenine-Möller, "Fast 3D
/// Triangle-Box Overlap Testing", JGT 2001). Conservative: boxes count as larger by 1e-5 of their size.
/// Degenerate triangles count as the segment or point that they are.
inline bool triangle_meets_box(const TriangleCorners& triangle, const vec3& centre, const vec3& half) {
  using namespace triangle_overlap;
  const TriangleCorners t{triangle.a - centre, triangle.b - centre, triangle.c - centre};
  const vec3 low = glm::min(glm::min(t.a, t.b), t.c), high = glm::max(glm::max(t.a, t.b), t.c);
  const vec3 reach = half * (1 + 1e-5f);
  if (glm::any(glm::greaterThan(low, reach)) || glm::any(glm::lessThan(high, -reach))) return false;
  const vec3 ab = t.b - t.a, bc = t.c - t.b, ca = t.a - t.c;
  return !apart_along(cross(ab, bc), t, half) && !apart_across_edge(ab, t, half) &&
         !apart_across_edge(bc, t, half) && !apart_across_edge(ca, t, half);
}

/// Calls visit(x, y, z) for the cells that a triangle meets of a lattice of cubes of this edge: cell (x, y,
/// z) begins at edge · (x, y, z). Only cells in [first, end) are visited, in the order of memory. Cost: one
/// test for each cell of the triangle's bounding box.
template <class Visit>
void for_each_cell(const TriangleCorners& t, float edge, const glm::ivec3& first, const glm::ivec3& end,
                   Visit&& visit) {
  const vec3 low = glm::min(glm::min(t.a, t.b), t.c) / edge, high = glm::max(glm::max(t.a, t.b), t.c) / edge;
  const vec3 begin_cell(first), last_cell(end - 1);
  if (glm::any(glm::lessThan(high, begin_cell)) || glm::any(glm::greaterThan(low, last_cell + 1.0f))) return;
  const glm::ivec3 l(glm::clamp(glm::floor(low - 1e-4f), begin_cell, last_cell)),
      h(glm::clamp(glm::floor(high + 1e-4f), begin_cell, last_cell));
  if (l == h && glm::all(glm::greaterThanEqual(low, vec3(l))) &&
      glm::all(glm::lessThanEqual(high, vec3(l + 1))))
    return visit(l.x, l.y, l.z);
  for (int z = l.z; z <= h.z; ++z)
    for (int y = l.y; y <= h.y; ++y)
      for (int x = l.x; x <= h.x; ++x)
        if (triangle_meets_box(t, edge * (vec3(x, y, z) + 0.5f), vec3(0.5f * edge))) visit(x, y, z);
}

}  // namespace coppice
