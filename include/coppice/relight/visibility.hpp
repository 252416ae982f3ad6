// Binary visibility of all lights from a point: one bit a leaf of the light tree.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <coppice/core/config.hpp>
#include <coppice/relight/receivers.hpp>
#include <coppice/scene/occluder.hpp>
#include <coppice/tree/light_tree.hpp>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace coppice {

/// Bits in words of 64, bit i of the row is leaf i.
inline std::uint32_t words_for_bits(std::uint32_t bits) { return (bits + 63) / 64; }
inline bool bit_at(const std::uint64_t* words, std::uint32_t i) { return (words[i / 64] >> (i % 64)) & 1; }

/// Distant lights ready to be traced: directions in packets of 16 in the order given.
class DirectionPackets {
 public:
  /// Towards the lights, unit. A padding leaf is given as the zero vector and is never visible.
  explicit DirectionPackets(std::span<const vec3> directions) : count_(std::uint32_t(directions.size())) {
    for (auto& axis : axes_) axis.assign((directions.size() + 15) / 16 * 16, 0.0f);
    for (std::size_t i = 0; i < directions.size(); ++i)
      for (int k = 0; k < 3; ++k) axes_[std::size_t(k)][i] = directions[i][k];
  }

  std::uint32_t count() const { return count_; }
  std::uint32_t packet_count() const { return (count_ + 15) / 16; }
  vec3 direction(std::uint32_t i) const { return {axes_[0][i], axes_[1][i], axes_[2][i]}; }

  /// Directions of the rays of a packet; t_max stays infinite.
  void aim(std::uint32_t packet, const vec3&, ShadowPacket& rays) const {
    std::copy_n(axes_[0].data() + 16 * packet, 16, rays.direction_x);
    std::copy_n(axes_[1].data() + 16 * packet, 16, rays.direction_y);
    std::copy_n(axes_[2].data() + 16 * packet, 16, rays.direction_z);
  }

  /// Lanes of a packet that lie above a receiver's horizon: the rays that must be traced.
  std::uint32_t worth_tracing(std::uint32_t packet, const Receiver& receiver) const {
    const float *x = axes_[0].data() + 16 * packet, *y = axes_[1].data() + 16 * packet,
                *z = axes_[2].data() + 16 * packet;
    std::uint32_t lanes = 0;
    for (std::uint32_t i = 0; i < 16; ++i) {
      const float cosine = receiver.normal.x * x[i] + receiver.normal.y * y[i] + receiver.normal.z * z[i];
      const bool is_light = x[i] != 0 || y[i] != 0 || z[i] != 0;
      lanes |= std::uint32_t(is_light && cosine > receiver.horizon) << i;
    }
    return lanes;
  }

 private:
  std::uint32_t count_;
  std::array<std::vector<float>, 3> axes_;
};

/// Lights in packets of 16 that shadow rays can be aimed at. `aim` sets directions and, where lights are
/// near, t_max of rays whose origins and infinite t_max are set; `worth_tracing` gives the lanes of which a
/// receiver can receive any light.
template <class L>
concept LightPackets = requires(const L& lights, std::uint32_t packet, vec3 origin, ShadowPacket& rays,
                                const Receiver& receiver) {
  { lights.count() } -> std::same_as<std::uint32_t>;
  { lights.packet_count() } -> std::same_as<std::uint32_t>;
  lights.aim(packet, origin, rays);
  { lights.worth_tracing(packet, receiver) } -> std::same_as<std::uint32_t>;
};
static_assert(LightPackets<DirectionPackets>);

/// Directions of distant lights at the leaves, zero for padding.
inline std::vector<vec3> leaf_directions(const LightTree& tree, std::span<const vec3> directions) {
  std::vector<vec3> leaves;
  leaves.reserve(tree.leaf_count());
  for (const std::uint32_t light : tree.light_of_leaf)
    leaves.push_back(light == no_light ? vec3(0) : directions[light]);
  return leaves;
}

inline ShadowPacket packet_from(const vec3& origin) {
  ShadowPacket rays{};
  std::fill_n(rays.origin_x, 16, origin.x);
  std::fill_n(rays.origin_y, 16, origin.y);
  std::fill_n(rays.origin_z, 16, origin.z);
  std::fill_n(rays.t_max, 16, std::numeric_limits<float>::infinity());
  return rays;
}

/// Writes the visibility of every direction from a receiver into `bits` (words_for_bits(count) words). Shadow
/// rays go out in packets of 16 neighbours; those below the receiver's horizon are not traced. Returns the
/// rays traced.
template <Occluder O, LightPackets L>
std::size_t trace_visibility(const O& occluder, const L& lights, const Receiver& receiver,
                             std::span<std::uint64_t> bits) {
  COPPICE_ASSERT(bits.size() >= words_for_bits(lights.count()));
  std::ranges::fill(bits, std::uint64_t{0});
  ShadowPacket rays = packet_from(receiver.position);
  std::size_t traced = 0;
  for (std::uint32_t p = 0; p < lights.packet_count(); ++p) {
    const std::uint32_t lanes = lights.worth_tracing(p, receiver);
    if (lanes == 0) continue;
    lights.aim(p, receiver.position, rays);
    const std::uint64_t visible = lanes & ~occluder.occluded(rays, lanes);
    bits[p / 4] |= visible << (16 * (p % 4));
    traced += std::size_t(std::popcount(lanes));
  }
  return traced;
}

}  // namespace coppice
