// A light with a size: many points of light spread over a ball.
#pragma once

#include <coppice/light/directions.hpp>
#include <coppice/light/local_light.hpp>

namespace coppice {

/// A point light or spot that shines from all of a ball's surface alike. The ball itself casts no shadow.
struct SizedLight {
  LocalLight light;  ///< of the whole ball, at its centre; not a distant one
  float radius = 0;  ///< metres; 0: a point, with hard shadows
};

/// The light as `count` equal points on its ball, or one where it has no radius. The paper takes 25 (PCA
/// section 6). All lights' points lie alike, so that shadows do not flicker.
inline std::vector<LocalLight> points_of(const SizedLight& light, std::uint32_t count = 25) {
  if (!(light.radius > 0) || count < 2) return {light.light};
  std::vector<LocalLight> points(count, light.light);
  const std::vector<vec3> directions = even_directions(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    points[i].position += light.radius * directions[i];
    points[i].intensity /= float(count);
  }
  return points;
}

}  // namespace coppice
