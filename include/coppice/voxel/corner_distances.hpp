// Spreads the nearest surface points that some corners of a lattice know to all of them.
#pragma once

#include <coppice/voxel/triangle_distance.hpp>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace coppice {

/// The nearest surface point of each corner of a lattice of cubes, as far as known. A corner takes over what
/// its 26 neighbours know where that is nearer: vector propagation (Danielsson, "Euclidean Distance Mapping",
/// CGIP 1980).
class CornerDistances {
 public:
  /// Corners are `edge` apart; none knows a point. Corner (x, y, z) has the index (z · size.y + y) · size.x +
  /// x.
  CornerDistances(const uvec3& size, float edge)
      : size_(size),
        edge_(edge),
        nearest_(count(size), vec3(0)),
        distance2_(count(size), std::numeric_limits<float>::infinity()) {}

  /// Tells a corner of a point.
  void offer(const uvec3& corner, const vec3& point) { take(index(corner), edge_ * vec3(corner), point); }

  /// Two sweeps, from either end. Distances are those to a point of the surface, so never too small.
  void spread() {
    for (std::uint32_t z = 0; z < size_.z; ++z)
      for (std::uint32_t y = 0; y < size_.y; ++y) sweep_row(y, z, 1);
    for (std::uint32_t z = size_.z; z-- > 0;)
      for (std::uint32_t y = size_.y; y-- > 0;) sweep_row(y, z, -1);
  }

  /// Infinity where nothing is known.
  float distance(std::size_t i) const { return std::sqrt(distance2_[i]); }

 private:
  static std::size_t count(const uvec3& n) { return std::size_t(n.x) * n.y * n.z; }
  std::size_t index(const uvec3& c) const { return (std::size_t(c.z) * size_.y + c.y) * size_.x + c.x; }

  void take(std::size_t i, const vec3& corner, const vec3& point) {
    if (const float d2 = triangle_distance::squared(corner - point); d2 < distance2_[i])
      distance2_[i] = d2, nearest_[i] = point;
  }
  void take_from(std::size_t i, const vec3& corner, std::size_t other) {
    if (distance2_[other] < std::numeric_limits<float>::infinity()) take(i, corner, nearest_[other]);
  }

  /// One row in its turn: first from the rows that came before, then along itself to and fro.
  void sweep_row(std::uint32_t y, std::uint32_t z, int step) {
    const std::size_t row = index({0, y, z});
    const auto other_row = [&](int dy, int dz) {
      const std::int64_t oy = std::int64_t(y) + dy, oz = std::int64_t(z) + dz;
      if (oy < 0 || oz < 0 || oy >= std::int64_t(size_.y) || oz >= std::int64_t(size_.z)) return;
      take_row(row, index({0, std::uint32_t(oy), std::uint32_t(oz)}), y, z);
    };
    other_row(-step, -step), other_row(0, -step), other_row(step, -step), other_row(-step, 0);
    for (std::uint32_t x = 1; x < size_.x; ++x) take_from(row + x, edge_ * vec3(x, y, z), row + x - 1);
    for (std::uint32_t x = size_.x - 1; x-- > 0;) take_from(row + x, edge_ * vec3(x, y, z), row + x + 1);
  }

  void take_row(std::size_t row, std::size_t other, std::uint32_t y, std::uint32_t z) {
    for (std::uint32_t x = 0; x < size_.x; ++x) {
      const vec3 corner = edge_ * vec3(x, y, z);
      if (x > 0) take_from(row + x, corner, other + x - 1);
      take_from(row + x, corner, other + x);
      if (x + 1 < size_.x) take_from(row + x, corner, other + x + 1);
    }
  }

  uvec3 size_;
  float edge_;
  std::vector<vec3> nearest_;
  std::vector<float> distance2_;
};

}  // namespace coppice
