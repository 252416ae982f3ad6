// The sphere on a square: an octahedron's faces unfolded.
#pragma once

#include <coppice/core/math.hpp>

namespace coppice {

/// The point of the unit square [0, 1]² that a direction (of any length > 0) falls on: +Y is the middle, -Y
/// the four corners, and points of an edge that mirror each other about its middle are one direction.
inline vec2 octahedral_point(const vec3& d) {
  const float scale = 1 / (std::abs(d.x) + std::abs(d.y) + std::abs(d.z));
  const vec2 flat(d.x * scale, d.z * scale);
  const vec2 folded((1 - std::abs(flat.y)) * std::copysign(1.0f, flat.x),
                    (1 - std::abs(flat.x)) * std::copysign(1.0f, flat.y));
  return 0.5f * (d.y >= 0 ? flat : folded) + vec2(0.5f);
}

/// Unit direction of a point of the square.
inline vec3 octahedral_direction(const vec2& point) {
  const vec2 p = 2.0f * point - vec2(1);
  const float y = 1 - std::abs(p.x) - std::abs(p.y);
  if (y >= 0) return normalize(vec3(p.x, y, p.y));
  return normalize(vec3((1 - std::abs(p.y)) * std::copysign(1.0f, p.x), y,
                        (1 - std::abs(p.x)) * std::copysign(1.0f, p.y)));
}

}  // namespace coppice
