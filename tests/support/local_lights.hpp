// Random lights in a scene.
#pragma once

#include <coppice/core/random.hpp>
#include <coppice/light/local_light.hpp>
#include <cstdint>
#include <span>
#include <vector>

namespace support {

enum class LightKind { point, spot, surface, distant };
inline constexpr LightKind all_light_kinds[] = {LightKind::point, LightKind::spot, LightKind::surface,
                                                LightKind::distant};

inline coppice::vec3 in_box(coppice::Random& random) {
  const float x = random.uniform(), y = random.uniform(), z = random.uniform();
  return 2.0f * coppice::vec3(x, y, z) - 1.0f;
}

/// In a box of 2 × 2 × 2 round the origin; distant ones 10 away.
inline coppice::LocalLight random_local_light(coppice::Random& random, LightKind kind) {
  const coppice::vec3 place = in_box(random), direction = random.direction();
  const coppice::vec3 colour = 0.05f + 0.5f * (in_box(random) + 1.0f);
  switch (kind) {
    case LightKind::spot: {
      const float outer = 0.2f + 1.3f * random.uniform();
      return coppice::spot_light(place, colour, direction, outer * 0.9f * random.uniform(), outer);
    }
    case LightKind::surface:
      return coppice::surface_light(place, direction, 10.0f * colour, 0.01f + 0.1f * random.uniform());
    case LightKind::distant:
      return coppice::distant_light(direction, 0.2f * colour, 10);
    default:
      return coppice::point_light(place, colour);
  }
}

/// Of the kinds in turn.
inline std::vector<coppice::LocalLight> random_local_lights(
    coppice::Random& random, std::size_t count, std::span<const LightKind> kinds = all_light_kinds) {
  std::vector<coppice::LocalLight> lights;
  for (std::size_t i = 0; i < count; ++i)
    lights.push_back(random_local_light(random, kinds[i % kinds.size()]));
  return lights;
}

}  // namespace support
