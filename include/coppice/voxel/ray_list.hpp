// Rays through a grid of bricks, marched a register at a time.
#pragma once

#include <coppice/voxel/brick_lanes.hpp>
//
#include <algorithm>
#include <array>
#include <bit>
#include <coppice/voxel/cone_visibility.hpp>

namespace coppice {

/// Rays of any number of cones, in voxels.
struct RayList {
  std::vector<float> from_x, from_y, from_z;  ///< where they start: on the surface, lifted along its normal
  std::vector<float> x, y, z;                 ///< direction, unit
  std::vector<float> slope;                   ///< cosine to the receiver's normal, at least 0
  std::vector<float> share;                   ///< above the horizon (ConeRay)
  std::vector<float> width;                   ///< voxel_ray_width
  std::vector<float> end;                     ///< nothing of the grid is ahead beyond this distance
  std::vector<float> open;                    ///< how open they are
  std::vector<std::uint32_t> cone;
  std::size_t count = 0;

  auto fields() {
    return std::array{&from_x, &from_y, &from_z, &x, &y, &z, &slope, &share, &width, &end, &open};
  }
  /// Room for so many rays; those there are stay.
  void make_room(std::size_t size) {
    if (cone.size() >= size) return;
    for (auto* field : fields()) field->resize(2 * size, 0.0f);
    cone.resize(2 * size);
  }
  /// Copies what is known of a ray before it is marched, but for where it starts.
  void move(std::size_t from, std::size_t to) {
    x[to] = x[from], y[to] = y[from], z[to] = z[from], slope[to] = slope[from], share[to] = share[from];
    width[to] = width[from], cone[to] = cone[from];
  }
};

}  // namespace coppice

namespace coppice::inline HWY_NAMESPACE {

/// Marches lists of rays. A lane whose ray has ended takes the next of the list: half of the work otherwise
/// goes to lanes that wait. What comes out for a ray does not depend on the others.
class RayMarch {
 public:
  /// The grid must outlive it. Marches start `start` voxels from where the rays do.
  RayMarch(const BrickGrid& grid, const VoxelTrace& trace, float start)
      : lookup_(grid), trace_(trace), size_(grid.size()), start_(start) {}

  /// Fills rays.end and rays.open. Precondition: room for rays.count + Lanes::width.
  void operator()(RayList& rays) const {
    for (std::size_t i = 0; i < rays.count; i += Lanes::width) find_end(rays, i);
    State state;
    std::size_t next = 0, live = 0;
    for (std::size_t lane = 0; lane < Lanes::width; ++lane) {
      state.ray[lane] = none;
      if (next < rays.count) state.take(lane, rays, next++, start_, trace_.softness), ++live;
    }
    while (live > 0)
      for (std::uint64_t done = advance(state); done != 0; done &= done - 1) {
        const auto lane = std::size_t(std::countr_zero(done));
        if (state.ray[lane] == none) continue;
        rays.open[state.ray[lane]] = state.open[lane];
        state.ray[lane] = none, --live;
        if (next < rays.count) state.take(lane, rays, next++, start_, trace_.softness), ++live;
      }
  }

 private:
  static constexpr std::uint32_t none = 0xffffffffu;
  static constexpr int steps_at_once = 3;

  /// A ray a lane. Lanes without one stand still at an end that they have reached.
  struct State {
    static constexpr std::size_t width = Lanes::width;
    alignas(64) float from_x[width] = {}, from_y[width] = {}, from_z[width] = {};
    alignas(64) float x[width] = {}, y[width] = {}, z[width] = {};
    alignas(64) float slope[width] = {}, reach[width] = {}, end[width] = {};
    alignas(64) float t[width] = {}, open[width] = {}, steps[width] = {};
    std::uint32_t ray[width];

    void take(std::size_t lane, const RayList& rays, std::size_t i, float start, float softness) {
      from_x[lane] = rays.from_x[i], from_y[lane] = rays.from_y[i], from_z[lane] = rays.from_z[i];
      x[lane] = rays.x[i], y[lane] = rays.y[i], z[lane] = rays.z[i];
      slope[lane] = rays.slope[i], reach[lane] = softness * rays.width[i], end[lane] = rays.end[i];
      t[lane] = start, open[lane] = 1, steps[lane] = 0;
      ray[lane] = std::uint32_t(i);
    }
  };

  /// A few steps of all lanes; the bits of those that have no more to do.
  std::uint64_t advance(State& s) const {
    const Lanes from_x = Lanes::load(s.from_x), from_y = Lanes::load(s.from_y),
                from_z = Lanes::load(s.from_z);
    const Lanes x = Lanes::load(s.x), y = Lanes::load(s.y), z = Lanes::load(s.z);
    const Lanes slope = Lanes::load(s.slope), reach = Lanes::load(s.reach), end = Lanes::load(s.end);
    Lanes t = Lanes::load(s.t), open = Lanes::load(s.open), steps = Lanes::load(s.steps);
    const auto alive = [&] { return (t < end) & (open > 0.0f) & (steps < float(trace_.steps)); };
    for (int k = 0; k < steps_at_once; ++k) {
      const LaneMask going = alive();
      const Lanes d = lookup_(mul_add(t, x, from_x), mul_add(t, y, from_y), mul_add(t, z, from_z));
      const Lanes rise = mul_add(t, slope, trace_.lift);
      const Lanes here = voxel_opening(d, t, rise, reach, Lanes(trace_.skin), Lanes(trace_.slack));
      open = select(going, min(open, here), open);
      t = select(going, t + voxel_stride(d, t, reach, Lanes(trace_.growth)), t);
      steps += 1.0f;
    }
    t.store(s.t), open.store(s.open), steps.store(s.steps);
    return bits_of(!alive()) & ((std::uint64_t(1) << Lanes::width) - 1);
  }

  void find_end(RayList& rays, std::size_t i) const {
    const Lanes x = Lanes::load(&rays.x[i]), y = Lanes::load(&rays.y[i]), z = Lanes::load(&rays.z[i]);
    const Lanes px = Lanes::load(&rays.from_x[i]), py = Lanes::load(&rays.from_y[i]),
                pz = Lanes::load(&rays.from_z[i]);
    const vec3 half = 0.5f * size_;
    const Lanes all = mul_add(x, half.x - px, mul_add(y, half.y - py, z * (half.z - pz))) +
                      mul_add(abs(x), half.x, mul_add(abs(y), half.y, abs(z) * half.z));
    Lanes exit = all, entry = 0.0f;
    const auto slab = [&](Lanes from, float size, Lanes direction) {
      const Lanes inverse = 1.0f / select(abs(direction) > 1e-12f, direction, 1e-12f);
      const Lanes a = -from * inverse, b = (size - from) * inverse;
      exit = min(exit, max(a, b)), entry = max(entry, min(a, b));
    };
    slab(px, size_.x, x), slab(py, size_.y, y), slab(pz, size_.z, z);
    select(entry < exit, exit, all).store(&rays.end[i]);
  }

  BrickLanes lookup_;
  VoxelTrace trace_;
  vec3 size_;
  float start_;
};

}  // namespace coppice::inline HWY_NAMESPACE
