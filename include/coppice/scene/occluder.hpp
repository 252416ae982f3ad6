// What the precomputation of visibility asks of a host's ray tracer.
#pragma once

#include <concepts>
#include <coppice/core/math.hpp>
#include <cstdint>

namespace coppice {

/// Sixteen shadow rays side by side; a lane counts where the mask given beside it has its bit set.
struct alignas(64) ShadowPacket {
  float origin_x[16], origin_y[16], origin_z[16];
  float direction_x[16], direction_y[16], direction_z[16];  ///< unit
  float t_max[16];                                          ///< +infinity for distant lights
};

/// Tells whether anything lies between a point and a light. Safe to call from several threads.
/// `occluded(origin, direction, t_max)` answers for one ray; `occluded(packet, lanes)` returns the bits of
/// those lanes that are blocked, a subset of `lanes`.
template <class O>
concept Occluder = requires(const O& occluder, vec3 v, float t_max, const ShadowPacket& packet,
                            std::uint32_t lanes) {
  { occluder.occluded(v, v, t_max) } -> std::same_as<bool>;
  { occluder.occluded(packet, lanes) } -> std::same_as<std::uint32_t>;
};

}  // namespace coppice
