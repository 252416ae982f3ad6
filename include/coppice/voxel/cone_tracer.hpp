// The visibility of many cones from many points: exact rays near the surface, a march through voxels beyond.
#pragma once

#include <coppice/voxel/ray_list.hpp>
//
#include <coppice/shared/cones.h>

#include <coppice/core/parallel.hpp>
#include <coppice/scene/occluder.hpp>
#include <span>

namespace coppice {

/// How ConeTracer traces.
struct ConeTracerOptions {
  VoxelTrace trace = default_voxel_trace;
  float contact = 3;  ///< voxels that exact rays reach, since contact is what fails; 0: none are traced
};

/// An Occluder where nothing is, for tracing without exact rays.
struct OpenSpace {
  bool occluded(const vec3&, const vec3&, float) const { return false; }
  std::uint32_t occluded(const ShadowPacket&, std::uint32_t) const { return 0; }
};
static_assert(Occluder<OpenSpace>);

}  // namespace coppice

namespace coppice::inline HWY_NAMESPACE {

/// Traces cones, a register of rays at a time.
class ConeTracer {
 public:
  /// The grid must outlive the tracer.
  explicit ConeTracer(const BrickGrid& grid, const ConeTracerOptions& options = {})
      : grid_(grid),
        options_(options),
        march_(grid, options.trace, std::fmax(options.trace.start, options.contact)) {
    COPPICE_ASSERT(options.trace.rays > 0);
    const std::size_t count = rounded_up(options.trace.rays);
    for (std::size_t i = 0; i < count; ++i) {
      const float angle = float(i) * VOXEL_TURN;
      cos_.push_back(std::cos(angle)), sin_.push_back(std::sin(angle));
      u_.push_back(std::fmin((float(i) + 0.5f) / float(options.trace.rays), 0.999f));
    }
    if (options.trace.rays == 1) u_[0] = 0;
  }

  /// visibility[cone], in [0, 1]: the share that is visible of what the Gaussian has above the horizon of the
  /// shading normal, as cone_visibility() finds it, where a ray that meets anything of the occluder within
  /// the contact's reach is closed; 0 where nothing of a cone is above. Positions are those from which shadow
  /// rays may start. The same for any executor. Preconditions: `cones_end` do not fall, the last is at most
  /// cones.size(), and `visibility` has room for as many. Cost: docs/voxel.md.
  template <Occluder O, Executor E>
  void trace(const O& occluder, std::span<const ConeReceiver> receivers, std::span<const SgShape> cones,
             std::span<float> visibility, const E& executor) const {
    COPPICE_ASSERT(visibility.size() >= cones.size());
    executor(receivers.size(), 64, [&](std::size_t begin, std::size_t end) {
      Group group;
      group.first_cone = group.last_cone = begin > 0 ? receivers[begin - 1].cones_end : 0;
      for (std::size_t i = begin; i < end; ++i) {
        add(occluder, receivers[i], cones, group);
        if (group.rays.count >= group_size || i + 1 == end) finish(group, visibility);
      }
    });
  }

 private:
  static constexpr std::size_t width = Lanes::width;
  static constexpr std::size_t group_size = 512;
  static std::size_t rounded_up(std::size_t n) { return (n + width - 1) / width * width; }

  /// The rays of a few receivers that are not yet known to be closed.
  struct Group {
    RayList rays;
    std::uint32_t first_cone = 0, last_cone = 0;
    std::vector<float> all;  ///< by cone: what its rays have above the horizon
  };

  /// Appends the rays of one receiver's cones.
  template <Occluder O>
  void add(const O& occluder, const ConeReceiver& receiver, std::span<const SgShape> cones,
           Group& group) const {
    COPPICE_ASSERT(group.last_cone <= receiver.cones_end && receiver.cones_end <= cones.size());
    RayList& rays = group.rays;
    const std::size_t first = rays.count, added = receiver.cones_end - group.last_cone;
    rays.make_room(first + added * options_.trace.rays + rounded_up(options_.trace.rays) + width);
    for (; group.last_cone < receiver.cones_end; ++group.last_cone) {
      group.all.push_back(0);
      add_rays(cones[group.last_cone], receiver, group.last_cone, rays, group.all.back());
    }
    if (options_.contact > 0) drop_blocked(occluder, receiver, first, rays);
    const vec3 from = grid_.place(receiver.position) + options_.trace.lift * receiver.normal;
    for (std::size_t i = first; i < rays.count; ++i)
      rays.from_x[i] = from.x, rays.from_y[i] = from.y, rays.from_z[i] = from.z;
  }

  void finish(Group& group, std::span<float> visibility) const {
    march_(group.rays);
    const auto seen = visibility.subspan(group.first_cone, group.last_cone - group.first_cone);
    std::ranges::fill(seen, 0.0f);
    for (std::size_t i = 0; i < group.rays.count; ++i)
      seen[group.rays.cone[i] - group.first_cone] += group.rays.share[i] * group.rays.open[i];
    for (std::size_t c = 0; c < seen.size(); ++c)
      seen[c] = group.all[c] > 0 ? std::fmin(seen[c] / group.all[c], 1.0f) : 0.0f;
    group.rays.count = 0, group.all.clear(), group.first_cone = group.last_cone;
  }

  /// cone_ray() for all rays of a cone; those wholly below either horizon are left out.
  void add_rays(const SgShape& cone, const ConeReceiver& receiver, std::uint32_t index, RayList& rays,
                float& all) const {
    const float w = voxel_ray_width(cone.sharpness, options_.trace.rays), least = voxel_ray_least_rise(w);
    const Lanes sharpness = std::fmax(cone.sharpness, 1e-4f);
    const vec3 n = receiver.normal, shading = receiver.shading_normal;
    vec3 a, b;
    make_frame(cone.axis, a, b);
    for (std::size_t i = 0; i < options_.trace.rays; i += width) {
      const Lanes drop =
          options_.trace.rays == 1 ? Lanes(0.0f) : voxel_ray_drop(Lanes::load(&u_[i]), sharpness);
      const Lanes radius = sqrt(max(drop * (2.0f - drop), 0.0f)), along = 1.0f - drop;
      const Lanes u = radius * Lanes::load(&cos_[i]), v = radius * Lanes::load(&sin_[i]);
      const Lanes x = mul_add(along, cone.axis.x, mul_add(u, a.x, v * b.x)),
                  y = mul_add(along, cone.axis.y, mul_add(u, a.y, v * b.y)),
                  z = mul_add(along, cone.axis.z, mul_add(u, a.z, v * b.z));
      const Lanes rise = mul_add(x, n.x, mul_add(y, n.y, z * n.z)), up = max(Lanes(least) - rise, 0.0f);
      store_directions(mul_add(up, n.x, x), mul_add(up, n.y, y), mul_add(up, n.z, z), n, rays);
      const Lanes rise_of_shading = mul_add(x, shading.x, mul_add(y, shading.y, z * shading.z));
      const Lanes lit = voxel_ray_share(rise_of_shading, Lanes(w));
      min(lit, voxel_ray_share(rise, Lanes(w))).store(&rays.share[rays.count]);
      lit.store(&rays.open[rays.count]);
      keep_above(std::min(width, options_.trace.rays - i), w, index, rays, all);
    }
  }
  static void store_directions(Lanes x, Lanes y, Lanes z, const vec3& n, RayList& rays) {
    const Lanes inverse = 1.0f / sqrt(max(mul_add(x, x, mul_add(y, y, z * z)), 1e-12f));
    const Lanes dx = x * inverse, dy = y * inverse, dz = z * inverse;
    const std::size_t to = rays.count;
    dx.store(&rays.x[to]), dy.store(&rays.y[to]), dz.store(&rays.z[to]);
    max(mul_add(dx, n.x, mul_add(dy, n.y, dz * n.z)), 0.0f).store(&rays.slope[to]);
  }
  /// Of the rays behind the last, whose `open` tells what is above the shading horizon, those that are above
  /// both.
  static void keep_above(std::size_t count, float w, std::uint32_t cone, RayList& rays, float& all) {
    const std::size_t first = rays.count;
    for (std::size_t k = first; k < first + count; ++k) {
      all += rays.open[k];
      if (!(rays.share[k] > 0)) continue;
      rays.width[k] = w, rays.cone[k] = cone;
      rays.move(k, rays.count++);
    }
  }

  /// Leaves out the rays from `first` on that end within the contact's reach.
  template <Occluder O>
  void drop_blocked(const O& occluder, const ConeReceiver& r, std::size_t first, RayList& rays) const {
    const float reach = options_.contact + options_.trace.lift, clear = clear_slope(r, reach);
    std::array<std::size_t, 16> pending;
    std::size_t count = 0;
    for (std::size_t i = first; i < rays.count; ++i) {
      rays.open[i] = 1;
      if (rays.slope[i] < clear) pending[count++] = i;
      if (count == pending.size() || (i + 1 == rays.count && count > 0)) {
        trace_packet(occluder, r.position, reach * grid_.grid.voxel, {pending.data(), count}, rays);
        count = 0;
      }
    }
    const std::size_t end = rays.count;
    rays.count = first;
    for (std::size_t i = first; i < end; ++i)
      if (rays.open[i] > 0) rays.move(i, rays.count++);
  }

  /// Rays at least as steep as this meet nothing within the reach: a ball that touches the surface from above
  /// is empty, and holds them so far. Beyond 1 where it is not, or where the grid does not know well.
  float clear_slope(const ConeReceiver& r, float reach) const {
    constexpr float radius = 5, tolerance = 0.15f;
    const vec3 centre = grid_.place(r.position) + radius * r.normal;
    if (!in_filled_brick(grid_, centre) || nearest_surface(grid_, centre) < radius - tolerance) return 2;
    return 0.5f * reach / radius;
  }

  template <Occluder O>
  static void trace_packet(const O& occluder, const vec3& origin, float reach,
                           std::span<const std::size_t> chosen, RayList& rays) {
    ShadowPacket packet;
    for (std::size_t k = 0; k < 16; ++k) {
      const std::size_t i = chosen[std::min(k, chosen.size() - 1)];
      packet.origin_x[k] = origin.x, packet.origin_y[k] = origin.y, packet.origin_z[k] = origin.z;
      packet.direction_x[k] = rays.x[i], packet.direction_y[k] = rays.y[i], packet.direction_z[k] = rays.z[i];
      packet.t_max[k] = reach;
    }
    const std::uint32_t blocked = occluder.occluded(packet, (1u << chosen.size()) - 1);
    for (std::size_t k = 0; k < chosen.size(); ++k)
      if ((blocked >> k) & 1) rays.open[chosen[k]] = 0;
  }

  const BrickGrid& grid_;
  ConeTracerOptions options_;
  RayMarch march_;
  std::vector<float> cos_, sin_, u_;
};

}  // namespace coppice::inline HWY_NAMESPACE
