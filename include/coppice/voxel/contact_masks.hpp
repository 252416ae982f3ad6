// Which rays of cones end near the surface that they start from: what exact rays tell a march that runs
// elsewhere.
#pragma once

#include <coppice/voxel/cone_tracer.hpp>
//
#include <algorithm>
#include <bit>
#include <cstdint>

namespace coppice {

namespace contact_masks_detail {

/// Rays that wait until sixteen can be traced at once.
template <Occluder O>
class Rays {
 public:
  Rays(const O& occluder, float reach, std::span<std::uint8_t> masks)
      : occluder_(occluder), reach_(reach), masks_(masks) {}

  void add(const vec3& origin, const vec3& direction, std::size_t cone, std::uint32_t ray) {
    packet_.origin_x[count_] = origin.x, packet_.origin_y[count_] = origin.y,
    packet_.origin_z[count_] = origin.z;
    packet_.direction_x[count_] = direction.x, packet_.direction_y[count_] = direction.y,
    packet_.direction_z[count_] = direction.z;
    packet_.t_max[count_] = reach_;
    cones_[count_] = cone, bits_[count_] = std::uint8_t(1u << ray);
    if (++count_ == size) trace();
  }

  /// Traces those that wait.
  void trace() {
    if (count_ == 0) return;
    for (std::size_t k = count_; k < size; ++k) repeat_last(k);
    const std::uint32_t blocked = occluder_.occluded(packet_, (1u << count_) - 1);
    for (std::size_t k = 0; k < count_; ++k)
      if ((blocked >> k) & 1) masks_[cones_[k]] = std::uint8_t(masks_[cones_[k]] | bits_[k]);
    count_ = 0;
  }

 private:
  static constexpr std::size_t size = 16;

  void repeat_last(std::size_t k) {
    const std::size_t last = count_ - 1;
    for (float* field : {packet_.origin_x, packet_.origin_y, packet_.origin_z, packet_.direction_x,
                         packet_.direction_y, packet_.direction_z, packet_.t_max})
      field[k] = field[last];
  }

  const O& occluder_;
  float reach_;
  std::span<std::uint8_t> masks_;
  ShadowPacket packet_{};
  std::size_t cones_[size] = {};
  std::uint8_t bits_[size] = {};
  std::size_t count_ = 0;
};

/// Cosine to the normal from which on a ray meets nothing within the reach (voxels): a ball that touches the
/// surface from above is empty, and holds it so far. Beyond 1 where it is not, or the grid does not know
/// well.
inline float clear_slope(const BrickGrid& grid, const ConeReceiver& receiver, float reach) {
  constexpr float radius = 5, tolerance = 0.15f;
  const vec3 centre = grid.place(receiver.position) + radius * receiver.normal;
  if (!in_filled_brick(grid, centre) || nearest_surface(grid, centre) < radius - tolerance) return 2;
  return 0.5f * reach / radius;
}

}  // namespace contact_masks_detail

}  // namespace coppice

namespace coppice::inline HWY_NAMESPACE {

/// Finds which rays of cones end near the surface, as ConeTracer asks it.
class ContactMasks {
 public:
  /// The grid must outlive it. Precondition: 1 to 8 rays a cone.
  ContactMasks(const BrickGrid& grid, const ConeTracerOptions& options)
      : grid_(grid), options_(options), reach_(options.contact + options.trace.lift) {
    COPPICE_ASSERT(options.trace.rays > 0 && options.trace.rays <= 8);
    for (std::uint32_t i = 0; i < options.trace.rays; ++i) {
      const float angle = float(i) * VOXEL_TURN;
      u_[i] = options.trace.rays == 1 ? 0 : (float(i) + 0.5f) / float(options.trace.rays);
      cosine_[i] = std::cos(angle), sine_[i] = std::sin(angle);
    }
  }

  /// masks[cone]: bit k is set where ray k of the cone (cone_ray) meets something within the contact's reach.
  /// Neither rays wholly below the horizon nor those that leave the surface too steeply to meet anything are
  /// traced. The same for any executor. Preconditions: `cones_end` do not fall, the last is at most
  /// cones.size(), and there are as many masks. Cost: docs/vulkan.md.
  template <Occluder O, Executor E>
  void find(const O& occluder, std::span<const ConeReceiver> receivers, std::span<const SgShape> cones,
            std::span<std::uint8_t> masks, const E& executor) const {
    COPPICE_ASSERT(masks.size() >= cones.size());
    std::ranges::fill(masks, std::uint8_t{0});
    if (!(options_.contact > 0)) return;
    executor(receivers.size(), 64, [&](std::size_t begin, std::size_t end) {
      contact_masks_detail::Rays waiting(occluder, reach_ * grid_.grid.voxel, masks);
      std::uint32_t cone = begin > 0 ? receivers[begin - 1].cones_end : 0;
      for (std::size_t i = begin; i < end; ++i) {
        const float clear = contact_masks_detail::clear_slope(grid_, receivers[i], reach_);
        for (; cone < receivers[i].cones_end; ++cone) add(receivers[i], cones[cone], cone, clear, waiting);
      }
      waiting.trace();
    });
  }

 private:
  static constexpr std::size_t width = Lanes::width, room = std::max<std::size_t>(8, width);

  /// The rays of a cone that are above the horizon and whose cosine to the normal is below `clear`.
  template <Occluder O>
  void add(const ConeReceiver& r, const SgShape& cone, std::size_t index, float clear,
           contact_masks_detail::Rays<O>& waiting) const {
    const std::uint32_t count = options_.trace.rays;
    const Lanes w = voxel_ray_width(cone.sharpness, count), sharpness = std::fmax(cone.sharpness, 1e-4f);
    const vec3& n = r.normal;
    vec3 a, b;
    make_frame(cone.axis, a, b);
    alignas(64) float x[room], y[room], z[room];
    for (std::size_t i = 0; i < count; i += width) {
      const Lanes drop = voxel_ray_drop(Lanes::load(&u_[i]), sharpness), along = 1.0f - drop;
      const Lanes radius = sqrt(max(drop * (2.0f - drop), 0.0f));
      const Lanes u = radius * Lanes::load(&cosine_[i]), v = radius * Lanes::load(&sine_[i]);
      Lanes dx = mul_add(along, cone.axis.x, mul_add(u, a.x, v * b.x));
      Lanes dy = mul_add(along, cone.axis.y, mul_add(u, a.y, v * b.y));
      Lanes dz = mul_add(along, cone.axis.z, mul_add(u, a.z, v * b.z));
      const Lanes rise = mul_add(dx, n.x, mul_add(dy, n.y, dz * n.z));
      const Lanes up = max(voxel_ray_least_rise(w) - rise, 0.0f);
      dx = mul_add(up, n.x, dx), dy = mul_add(up, n.y, dy), dz = mul_add(up, n.z, dz);
      const Lanes inverse = 1.0f / sqrt(max(mul_add(dx, dx, mul_add(dy, dy, dz * dz)), 1e-12f));
      (dx * inverse).store(&x[i]), (dy * inverse).store(&y[i]), (dz * inverse).store(&z[i]);
      const Lanes slope = inverse * (rise + up);
      std::uint64_t kept =
          bits_of((voxel_ray_share(rise, w) > 0.0f) & (slope < clear) & first_lanes(count - i));
      for (; kept != 0; kept &= kept - 1) {
        const std::size_t k = i + std::size_t(std::countr_zero(kept));
        waiting.add(r.position, {x[k], y[k], z[k]}, index, std::uint32_t(k));
      }
    }
  }

  const BrickGrid& grid_;
  ConeTracerOptions options_;
  float reach_;  ///< voxels
  float u_[room] = {}, cosine_[room] = {}, sine_[room] = {};
};

}  // namespace coppice::inline HWY_NAMESPACE
