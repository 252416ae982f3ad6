// Lights of the scene: points, spots, small surfaces, and suns.
#pragma once

#include <algorithm>
#include <coppice/core/math.hpp>

namespace coppice {

/// A light that stands in the scene, or far away from it. It is at position / w; where w = 0 it is infinitely
/// far away in the direction of `position`, whose length is the distance at which its intensity counts. A
/// point x that sees it receives, across the direction to it, the irradiance intensity · emission /
/// (|position - w x|² + area / π).
struct LocalLight {
  vec3 position{0};
  float w = 1;
  vec3 intensity{0};  ///< W/sr along the axis, linear RGB
  vec3 axis{0};       ///< of the emission's profile; zero: alike to all sides
  float offset = 1;
  float square = 0;
  float area = 0;  ///< m²; of a surface, whose nearness it softens
};

/// Share of its intensity that a light sends along the unit direction d: s·(1 - square + square·s) with
/// s = clamp(dot(axis, d) + offset, 0, 1).
inline float emission_towards(const LocalLight& light, const vec3& d) {
  const float s = std::clamp(dot(light.axis, d) + light.offset, 0.0f, 1.0f);
  return s * (1 - light.square + light.square * s);
}

/// Shines alike to all sides, with W/sr.
inline LocalLight point_light(const vec3& position, const vec3& intensity) {
  return {.position = position, .intensity = intensity};
}

/// Shines along a unit axis: fully within `inner` radians of it, not at all beyond `outer`, with the squared
/// ramp of KHR_lights_punctual between them. As there, a spot whose two cosines differ by less than 0.001 (no
/// wider than 2.6°) does not reach its full intensity. Precondition: 0 <= inner < outer <= π/2.
inline LocalLight spot_light(const vec3& position, const vec3& intensity, const vec3& axis, float inner,
                             float outer) {
  const float scale = 1 / std::max(0.001f, std::cos(inner) - std::cos(outer));
  return {.position = position,
          .intensity = intensity,
          .axis = scale * axis,
          .offset = -std::cos(outer) * scale,
          .square = 1};
}

/// Gives the irradiance across the unit direction towards it everywhere. `reach` is a length of the scene's
/// size: to trees and bounds the light is that far away.
inline LocalLight distant_light(const vec3& towards, const vec3& irradiance, float reach) {
  return {.position = reach * towards, .w = 0, .intensity = reach * reach * irradiance};
}

/// A small Lambertian surface that shines to the side of its unit normal.
inline LocalLight surface_light(const vec3& position, const vec3& normal, const vec3& radiance, float area) {
  return {.position = position, .intensity = area * radiance, .axis = normal, .offset = 0, .area = area};
}

}  // namespace coppice
