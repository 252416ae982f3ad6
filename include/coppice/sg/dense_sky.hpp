// An environment as lights that are all summed, each with a shadow ray: what Gaussians are compared with.
#pragma once

#include <coppice/shared/cones.h>

#include <bit>
#include <coppice/relight/dense_lights.hpp>
#include <coppice/relight/visibility.hpp>
#include <coppice/scene/occluder.hpp>
#include <coppice/sg/sky_lights.hpp>
#include <limits>

namespace coppice {

/// The cells of an even lattice of `cells` directions, each shining from where its light comes from; texels
/// brighter than eight times the mean are lights of their own, unless they are wider than a cell. The leaves
/// of a frame without a cut, padded with dark lights; directions are those of the map.
inline FrameLighting dense_sky(const Image& map, std::uint32_t cells) {
  Environment rest{map, 0};
  const float limit = float(8 * mean_luminance(map));
  std::vector<LightNode> leaves;
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) {
      vec3& radiance = rest.map.pixels[map.index(x, y)];
      const auto area = float(texel_solid_angle(y, map.width, map.height));
      if (!(luminance(radiance) > limit) || area * float(cells) > 4 * pi) continue;
      leaves.push_back({radiance * area, 0, texel_direction(x, y, map.width, map.height), area});
      radiance = vec3(0);
    }
  const std::vector<vec3> lattice = even_directions(cells);
  const EnvironmentCells table(lattice, map.width, map.height);
  const auto lights = table.gather(rest);
  const auto directions = table.centroids(rest, lattice);
  for (std::size_t i = 0; i < lights.size(); ++i)
    leaves.push_back({lights[i].power, 0, directions[i], lights[i].solid_angle});
  const std::size_t count = std::bit_ceil(leaves.size());
  FrameLighting frame;
  frame.nodes.assign(2 * count, LightNode{vec3(0), 0, vec3(0, 1, 0), 0});
  std::copy(leaves.begin(), leaves.end(), frame.nodes.begin() + std::ptrdiff_t(count));
  return frame;
}

/// Sets the bit of each light that a receiver sees: above both horizons, and with nothing in the way.
template <Occluder O>
void see_lights(const DenseLights& lights, const MapFrame& turn, const ConeReceiver& receiver,
                const O& occluder, std::span<std::uint64_t> bits) {
  std::fill(bits.begin(), bits.end(), 0);
  for (std::size_t first = 0; first < lights.x.size(); first += 16) {
    ShadowPacket p;
    std::uint32_t open = 0;
    for (std::uint32_t k = 0; k < 16; ++k) {
      const std::size_t i = first + k;
      const vec3 d = turn.to_world({lights.x[i], lights.y[i], lights.z[i]});
      p.origin_x[k] = receiver.position.x, p.origin_y[k] = receiver.position.y,
      p.origin_z[k] = receiver.position.z;
      p.direction_x[k] = d.x, p.direction_y[k] = d.y, p.direction_z[k] = d.z;
      p.t_max[k] = std::numeric_limits<float>::infinity();
      const bool is_lit = lights.red[i] + lights.green[i] + lights.blue[i] > 0;
      if (is_lit && dot(d, receiver.shading_normal) > 0 && dot(d, receiver.normal) > 0) open |= 1u << k;
    }
    if (open != 0) open &= ~occluder.occluded(p, open);
    bits[first / 64] |= std::uint64_t{open} << (first % 64);
  }
}

}  // namespace coppice
