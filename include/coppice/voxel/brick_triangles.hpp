// Which triangles meet which bricks, in both orders.
#pragma once

#include <coppice/core/parallel.hpp>
#include <coppice/scene/mesh.hpp>
#include <coppice/voxel/brick_distances.hpp>
#include <coppice/voxel/brick_grid.hpp>

namespace coppice {

/// The lists of bricks of each triangle, and of triangles of each brick, kept while triangles move.
class BrickTriangles {
 public:
  /// All triangles anew.
  template <Executor E>
  void build(const BrickGrid& grid, const Mesh& mesh, const E& executor) {
    first_.clear(), bricks_.clear();
    update(grid, mesh, std::vector<std::uint8_t>(mesh.triangles.size(), 1), executor);
  }

  /// Looks again where moved[triangle] is not 0. Precondition: as many triangles as before, if it is not the
  /// first time. Cost: that of the triangles that moved, and a copy of the lists.
  template <Executor E>
  void update(const BrickGrid& grid, const Mesh& mesh, std::span<const std::uint8_t> moved,
              const E& executor) {
    COPPICE_ASSERT(moved.size() == mesh.triangles.size());
    COPPICE_ASSERT(first_.empty() || first_.size() == moved.size() + 1);
    std::vector<std::uint32_t> first(moved.size() + 1, 0);
    executor(moved.size(), 4096, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        first[i + 1] = moved[i] ? count(grid, mesh, i) : std::uint32_t(bricks_of(i).size());
    });
    for (std::size_t i = 0; i < moved.size(); ++i) first[i + 1] += first[i];
    std::vector<std::uint32_t> bricks(first.back());
    executor(moved.size(), 4096, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) fill(grid, mesh, i, moved[i] != 0, bricks.data() + first[i]);
    });
    first_ = std::move(first), bricks_ = std::move(bricks);
    sort_by_brick(grid.slots.size());
  }

  std::span<const std::uint32_t> bricks_of(std::size_t triangle) const {
    if (first_.empty()) return {};
    return {bricks_.data() + first_[triangle], bricks_.data() + first_[triangle + 1]};
  }
  std::span<const std::uint32_t> triangles_of(std::size_t brick) const {
    return {triangles_.data() + brick_first_[brick], triangles_.data() + brick_first_[brick + 1]};
  }
  std::size_t bytes() const {
    return 4 * (first_.size() + bricks_.size() + brick_first_.size() + triangles_.size());
  }

 private:
  template <class Visit>
  static void for_each_brick(const BrickGrid& g, const Mesh& mesh, std::size_t i, Visit&& visit) {
    const uvec3 t = mesh.triangles[i], n = g.grid.bricks;
    const TriangleCorners corners{g.place(mesh.positions[t.x]), g.place(mesh.positions[t.y]),
                                  g.place(mesh.positions[t.z])};
    for_each_cell(corners, float(VOXEL_BRICK), glm::ivec3(0), glm::ivec3(n), [&](int x, int y, int z) {
      visit((std::uint32_t(z) * n.y + std::uint32_t(y)) * n.x + std::uint32_t(x));
    });
  }
  static std::uint32_t count(const BrickGrid& g, const Mesh& mesh, std::size_t i) {
    std::uint32_t result = 0;
    for_each_brick(g, mesh, i, [&](std::uint32_t) { ++result; });
    return result;
  }
  void fill(const BrickGrid& g, const Mesh& mesh, std::size_t i, bool moved, std::uint32_t* to) const {
    if (moved)
      for_each_brick(g, mesh, i, [&](std::uint32_t brick) { *to++ = brick; });
    else
      std::ranges::copy(bricks_of(i), to);
  }

  /// By counting; within a brick triangles stand in their order.
  void sort_by_brick(std::size_t brick_count) {
    brick_first_.assign(brick_count + 1, 0);
    for (const std::uint32_t b : bricks_) ++brick_first_[b + 1];
    for (std::size_t b = 0; b < brick_count; ++b) brick_first_[b + 1] += brick_first_[b];
    std::vector<std::uint32_t> next(brick_first_.begin(), brick_first_.end() - 1);
    triangles_.resize(bricks_.size());
    for (std::size_t i = 0; i + 1 < first_.size(); ++i)
      for (const std::uint32_t b : bricks_of(i)) triangles_[next[b]++] = std::uint32_t(i);
  }

  std::vector<std::uint32_t> first_, bricks_;           ///< by triangle
  std::vector<std::uint32_t> brick_first_, triangles_;  ///< by brick
};

}  // namespace coppice
