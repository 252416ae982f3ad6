// A register of lookups in a grid of bricks.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <coppice/voxel/brick_grid.hpp>

namespace coppice::inline HWY_NAMESPACE {

/// nearest_surface() for Lanes::width places, to rounding. The grid must outlive it.
class BrickLanes {
 public:
  /// Precondition: the grid's distances are below 2^31 bytes.
  explicit BrickLanes(const BrickGrid& g)
      : grid_(g.grid),
        slots_(reinterpret_cast<const std::int32_t*>(g.slots.data())),
        distances_(reinterpret_cast<const std::int32_t*>(g.distances.data())),
        size_(g.size()) {
    COPPICE_ASSERT(g.distances.size() < std::size_t(1) << 31);
  }

  Lanes operator()(Lanes x, Lanes y, Lanes z) const {
    const Lanes ix = clamp(x, size_.x), iy = clamp(y, size_.y), iz = clamp(z, size_.z);
    const Lanes ax = x - ix, ay = y - iy, az = z - iz;
    const Lanes d = inside(ix, iy, iz);
    return sqrt(mul_add(d, d, mul_add(ax, ax, mul_add(ay, ay, az * az))));
  }

 private:
  using Integer = hn::RebindToSigned<Lanes::Tag>;
  using Integers = hn::Vec<Integer>;

  static Lanes clamp(Lanes x, float size) { return min(max(x, 0.0f), size); }
  static Integers integers(Lanes x) { return hn::ConvertTo(Integer(), x.values); }
  static Integers number(std::int64_t x) { return hn::Set(Integer(), std::int32_t(x)); }
  static Lanes floats(Integers x) { return Lanes(hn::ConvertTo(Lanes::Tag(), x)); }

  /// How the eight values of a lookup lie: apart by rows and slices, each in the bits of `mask`.
  struct Cell {
    Integers first, row, slice, mask, shift;
    Lanes fx, fy, fz;
  };

  Lanes inside(Lanes x, Lanes y, Lanes z) const {
    const Integers bx = brick(x, grid_.bricks.x), by = brick(y, grid_.bricks.y),
                   bz = brick(z, grid_.bricks.z);
    const Integers slot = hn::GatherIndex(Integer(), slots_, at(bx, by, bz, grid_.bricks.x, grid_.bricks.y));
    const auto filled = hn::Gt(slot, hn::Zero(Integer()));
    const LaneMask near{hn::RebindMask(Lanes::Tag(), filled)};
    const Lanes scale = select(near, VOXEL_PLACES, 0.125f);
    const Lanes px = scale * (x - 8.0f * floats(bx)), py = scale * (y - 8.0f * floats(by)),
                pz = scale * (z - 8.0f * floats(bz));
    const Integers cx = cell(px, filled), cy = cell(py, filled), cz = cell(pz, filled);
    Cell c;
    c.first = hn::IfThenElse(filled, in_brick(slot, cx, cy, cz), in_corners(bx, by, bz));
    const std::int64_t row = 2 * (std::int64_t(grid_.bricks.x) + 1);
    c.row = hn::IfThenElse(filled, number(8), number(row));
    c.slice = hn::IfThenElse(filled, number(64), number(row * (std::int64_t(grid_.bricks.y) + 1)));
    c.mask = hn::IfThenElse(filled, number(255), number(65535));
    c.shift = hn::IfThenElse(filled, number(8), number(16));
    c.fx = px - floats(cx), c.fy = py - floats(cy), c.fz = pz - floats(cz);
    return interpolate(c) * select(near, VOXEL_NEAR_UNIT, VOXEL_FAR_UNIT);
  }

  static Integers brick(Lanes x, std::uint32_t bricks) {
    return hn::Min(integers(0.125f * x), number(std::int64_t(bricks) - 1));
  }
  static Integers at(Integers x, Integers y, Integers z, std::uint32_t row, std::uint32_t rows) {
    return hn::Add(hn::Mul(hn::Add(hn::Mul(z, number(rows)), y), number(row)), x);
  }
  /// The lower of the two places around p along an axis of a filled brick; 0 elsewhere.
  template <class Mask>
  static Integers cell(Lanes p, Mask filled) {
    return hn::IfThenElseZero(filled, hn::Min(integers(p), number(6)));
  }
  Integers in_brick(Integers slot, Integers x, Integers y, Integers z) const {
    const Integers brick = hn::ShiftLeft<9>(hn::Sub(slot, number(1)));
    const Integers within = hn::Add(hn::Add(hn::ShiftLeft<6>(z), hn::ShiftLeft<3>(y)), x);
    return hn::Add(hn::Add(brick, within), number(grid_.first_brick));
  }
  Integers in_corners(Integers x, Integers y, Integers z) const {
    return hn::ShiftLeft<1>(at(x, y, z, grid_.bricks.x + 1, grid_.bricks.y + 1));
  }

  /// Two neighbours along x from one load of 4 bytes.
  Lanes along_x(const Cell& c, Integers offset) const {
    const hn::RebindToUnsigned<Integer> words;
    const auto both = hn::BitCast(words, hn::GatherOffset(Integer(), distances_, offset));
    const auto mask = hn::BitCast(words, c.mask);
    const Lanes a = floats(hn::BitCast(Integer(), hn::And(both, mask)));
    const Lanes b = floats(hn::BitCast(Integer(), hn::And(both >> hn::BitCast(words, c.shift), mask)));
    return mul_add(c.fx, b - a, a);
  }
  Lanes interpolate(const Cell& c) const {
    const Integers far = hn::Add(c.first, c.slice);
    const Lanes a = along_x(c, c.first), b = along_x(c, hn::Add(c.first, c.row));
    const Lanes d = along_x(c, far), e = along_x(c, hn::Add(far, c.row));
    const Lanes front = mul_add(c.fy, b - a, a), back = mul_add(c.fy, e - d, d);
    return mul_add(c.fz, back - front, front);
  }

  VoxelGrid grid_;
  const std::int32_t* slots_;
  const std::int32_t* distances_;
  vec3 size_;
};

}  // namespace coppice::inline HWY_NAMESPACE
