// Which part of a scene is worth voxels.
#pragma once

#include <algorithm>
#include <coppice/voxel/brick_grid.hpp>
#include <span>

namespace coppice {

/// A box that grows around points.
class GrowingBox {
 public:
  void add(const vec3& p) {
    box_.low = empty_ ? p : glm::min(box_.low, p);
    box_.high = empty_ ? p : glm::max(box_.high, p);
    empty_ = false;
  }
  bool empty() const { return empty_; }
  const VoxelBox& box() const { return box_; }

 private:
  VoxelBox box_;
  bool empty_ = true;
};

/// Per axis, the box that has all but one in a thousand of the points beyond each of its sides; the box of
/// all points where they are few.
inline VoxelBox dense_box(std::span<const vec3> points) {
  VoxelBox box;
  std::vector<float> values(points.size());
  const std::size_t left_out = points.size() / 1000;
  for (int axis = 0; axis < 3 && !points.empty(); ++axis) {
    for (std::size_t i = 0; i < points.size(); ++i) values[i] = points[i][axis];
    std::ranges::nth_element(values, values.begin() + std::ptrdiff_t(left_out));
    box.low[axis] = values[left_out];
    std::ranges::nth_element(values, values.end() - 1 - std::ptrdiff_t(left_out));
    box.high[axis] = values[values.size() - 1 - left_out];
  }
  return box;
}

/// The box of all vertices, unless a few that lie far out (a ground that goes on to the horizon) would take
/// the voxels from the others: where the box of all is more than four times as long as the dense box, that
/// box, as far again to all sides as half its longest side. What lies outside of it hides nothing.
inline VoxelBox box_worth_voxels(std::span<const vec3> vertices) {
  GrowingBox all;
  for (const vec3& p : vertices) all.add(p);
  const auto longest = [](const VoxelBox& b) {
    const vec3 size = b.high - b.low;
    return std::max({size.x, size.y, size.z});
  };
  VoxelBox dense = dense_box(vertices);
  const float size = longest(dense);
  if (!(longest(all.box()) > 4 * size) || !(size > 0)) return all.box();
  dense.low = glm::max(dense.low - 0.5f * size, all.box().low);
  dense.high = glm::min(dense.high + 0.5f * size, all.box().high);
  return dense;
}

}  // namespace coppice
