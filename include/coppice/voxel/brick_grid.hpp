// Distances to the nearest surface in sparse bricks: what cones march through.
#pragma once

#include <coppice/shared/voxel.h>

#include <cmath>
#include <coppice/core/config.hpp>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

namespace coppice {

/// A box in world space. Surfaces outside of it are left out.
struct VoxelBox {
  vec3 low{0}, high{0};
};

/// The buffers of a grid, as a kernel reads them too (VoxelGrid tells their order). Plain data; BrickBuilder
/// fills them.
struct BrickGrid {
  VoxelGrid grid{vec3(0), 1, uvec3(1), 1, 16};
  std::vector<std::uint32_t> slots = {0};
  std::vector<std::uint8_t> distances = std::vector<std::uint8_t>(20, 255);

  /// Of both buffers.
  std::size_t bytes() const { return 4 * slots.size() + distances.size(); }
  /// Of one byte a voxel.
  std::size_t dense_bytes() const { return slots.size() * VOXEL_BRICK_SIZE; }
  std::size_t filled_bricks() const { return (distances.size() - 4 - grid.first_brick) / VOXEL_BRICK_SIZE; }
  std::size_t corner_count() const {
    const uvec3 n = grid.bricks + 1u;
    return std::size_t(n.x) * n.y * n.z;
  }
  std::size_t brick_index(const uvec3& b) const {
    return (std::size_t(b.z) * grid.bricks.y + b.y) * grid.bricks.x + b.x;
  }

  /// From world space to voxels from the grid's low corner.
  vec3 place(const vec3& world) const { return (world - grid.low) * grid.voxels_per_unit; }
  /// The grid's size in voxels.
  vec3 size() const { return vec3(grid.bricks * VOXEL_BRICK); }
};

/// An empty grid over a box: all is visible. The longest side has `resolution` voxels, of which one lies on
/// either side of the box. Precondition: resolution is a multiple of 8 and positive; the box is finite.
inline BrickGrid empty_brick_grid(const VoxelBox& box, std::uint32_t resolution) {
  COPPICE_ASSERT(resolution > 0 && resolution % VOXEL_BRICK == 0);
  COPPICE_ASSERT(is_finite(box.low) && is_finite(box.high));
  const vec3 extent = glm::max(box.high - box.low, vec3(0));
  const float longest = std::fmax(extent.x, std::fmax(extent.y, extent.z));
  BrickGrid result;
  VoxelGrid& g = result.grid;
  g.voxel = longest > 1e-30f ? longest / float(resolution - 2) : 1;
  g.voxels_per_unit = 1 / g.voxel;
  const vec3 bricks = glm::ceil((extent * g.voxels_per_unit + 2.0f) / 8.0f - 1e-3f);
  g.bricks = glm::clamp(uvec3(bricks), uvec3(1), uvec3(resolution / VOXEL_BRICK));
  g.low = 0.5f * (box.low + box.high) - 0.5f * g.voxel * vec3(g.bricks * VOXEL_BRICK);
  g.first_brick = std::uint32_t((2 * result.corner_count() + 3) / 4 * 4);
  result.slots.assign(std::size_t(g.bricks.x) * g.bricks.y * g.bricks.z, 0);
  result.distances.assign(g.first_brick + 4, 255);
  return result;
}

namespace brick_grid {

/// Trilinear from eight values, whose rows and slices are so many bytes apart.
template <class T>
float interpolate(const std::uint8_t* from, std::size_t row, std::size_t slice, const vec3& f) {
  const auto along_x = [&](const std::uint8_t* p) {
    T a, b;
    std::memcpy(&a, p, sizeof(T)), std::memcpy(&b, p + sizeof(T), sizeof(T));
    return float(a) + f.x * (float(b) - float(a));
  };
  const auto along_y = [&](const std::uint8_t* p) {
    const float a = along_x(p);
    return a + f.y * (along_x(p + row) - a);
  };
  const float a = along_y(from);
  return a + f.z * (along_y(from + slice) - a);
}

/// Inside the grid's box.
inline float distance_inside(const BrickGrid& g, const vec3& place) {
  const uvec3 n = g.grid.bricks;
  const uvec3 b(voxel_brick(place.x, n.x), voxel_brick(place.y, n.y), voxel_brick(place.z, n.z));
  const vec3 within = place - vec3(b * VOXEL_BRICK);
  if (const std::uint32_t slot = g.slots[g.brick_index(b)]; slot > 0) {
    const vec3 p = within * VOXEL_PLACES;
    const uvec3 i = glm::min(uvec3(p), uvec3(6));
    const std::size_t at = std::size_t(slot - 1) * VOXEL_BRICK_SIZE + (i.z * 8 + i.y) * 8 + i.x;
    return VOXEL_NEAR_UNIT *
           interpolate<std::uint8_t>(&g.distances[g.grid.first_brick + at], 8, 64, p - vec3(i));
  }
  const std::size_t row = 2 * std::size_t(n.x + 1), slice = row * (n.y + 1);
  const std::uint8_t* from = &g.distances[b.z * slice + b.y * row + 2 * b.x];
  return VOXEL_FAR_UNIT * interpolate<std::uint16_t>(from, row, slice, within * 0.125f);
}

}  // namespace brick_grid

/// Distance in voxels from a place to the nearest surface, to the grid's precision. Outside of the grid's box
/// it is at least so far: the box is convex, so that the way to its nearest point and the way on from there
/// are at no sharp angle, and their squares add. At most 1,024 inside. Finite for finite places.
inline float nearest_surface(const BrickGrid& g, const vec3& place) {
  const vec3 inside = glm::clamp(place, vec3(0), g.size());
  const float distance = brick_grid::distance_inside(g, inside);
  return std::sqrt(distance * distance + dot(place - inside, place - inside));
}

/// True where the brick that a place lies in is filled, so that distances are exact to a voxel's fraction;
/// false outside of the grid's box.
inline bool in_filled_brick(const BrickGrid& g, const vec3& place) {
  const vec3 size = g.size();
  if (!glm::all(glm::greaterThanEqual(place, vec3(0))) || !glm::all(glm::lessThan(place, size))) return false;
  return g.slots[g.brick_index(uvec3(place * 0.125f))] != 0;
}

}  // namespace coppice
