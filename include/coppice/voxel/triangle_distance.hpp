// The point of a triangle that is nearest to another point.
#pragma once

#include <coppice/voxel/triangle_overlap.hpp>

namespace coppice {

namespace triangle_distance {

inline vec3 nearest_on_segment(const vec3& p, const vec3& a, const vec3& b) {
  const vec3 ab = b - a;
  const float size2 = dot(ab, ab);
  return size2 > 0 ? a + std::clamp(dot(p - a, ab) / size2, 0.0f, 1.0f) * ab : a;
}

inline float squared(const vec3& v) { return dot(v, v); }

inline vec3 nearest_on_edges(const TriangleCorners& t, const vec3& p) {
  vec3 best = nearest_on_segment(p, t.a, t.b);
  for (const vec3& q : {nearest_on_segment(p, t.b, t.c), nearest_on_segment(p, t.c, t.a)})
    if (squared(p - q) < squared(p - best)) best = q;
  return best;
}

}  // namespace triangle_distance

/// The point of a triangle nearest to p: p's foot on the plane where that lies inside, else the nearest point
/// of the edges. Degenerate triangles count as the segment or point that they are.
inline vec3 nearest_on_triangle(const TriangleCorners& t, const vec3& p) {
  const vec3 ab = t.b - t.a, ac = t.c - t.a, ap = p - t.a;
  const float bb = dot(ab, ab), bc = dot(ab, ac), cc = dot(ac, ac), pb = dot(ap, ab), pc = dot(ap, ac);
  const float scale = bb * cc - bc * bc, v = cc * pb - bc * pc, w = bb * pc - bc * pb;
  if (scale > 1e-6f * bb * cc && v >= 0 && w >= 0 && v + w <= scale) return t.a + (v * ab + w * ac) / scale;
  return triangle_distance::nearest_on_edges(t, p);
}

}  // namespace coppice
