// Fills a grid of bricks from triangles, and refreshes it where they move.
#pragma once

#include <coppice/voxel/brick_triangles.hpp>
#include <coppice/voxel/corner_distances.hpp>

namespace coppice {

/// Keeps what refreshing a grid needs: the lists of triangles, and the nearest surface points of the corners.
class BrickBuilder {
 public:
  /// See empty_brick_grid. The box of moving objects must hold all their poses.
  BrickBuilder(const VoxelBox& box, std::uint32_t resolution) : grid_(empty_brick_grid(box, resolution)) {}

  const BrickGrid& grid() const { return grid_; }
  /// Which triangles meet which bricks.
  const BrickTriangles& triangles() const { return lists_; }
  /// What is kept beside the grid.
  std::size_t bytes() const { return lists_.bytes() + nearest_.size() * sizeof(nearest_[0]); }
  /// Bricks whose distances the last build() or update() has computed.
  std::size_t refreshed() const { return refreshed_; }

  /// From all triangles. The same for any executor.
  template <Executor E>
  void build(const Mesh& mesh, const E& executor) {
    lists_.build(grid_, mesh, executor);
    std::vector<std::uint8_t> dirty(grid_.slots.size(), 1);
    refresh(mesh, dirty, executor);
  }

  /// After triangles have moved: what build() would make of the mesh, bit for bit. moved[triangle] is not 0
  /// for those whose corners differ from the last time. Preconditions: build() came before, with as many
  /// triangles.
  template <Executor E>
  void update(const Mesh& mesh, std::span<const std::uint8_t> moved, const E& executor) {
    std::vector<std::uint8_t> touched(grid_.slots.size(), 0);
    mark_touched(moved, touched);
    lists_.update(grid_, mesh, moved, executor);
    mark_touched(moved, touched);
    refresh(mesh, widened(touched), executor);
  }

 private:
  struct Corners {
    vec3 points[8];
  };
  struct Contents {
    std::vector<std::uint32_t> filled, slots;
    std::vector<std::uint8_t> distances;
    std::vector<Corners> nearest;

    std::span<std::uint8_t> bytes_of(std::size_t slot, std::size_t first_brick) {
      return {distances.data() + first_brick + slot * VOXEL_BRICK_SIZE, std::size_t(VOXEL_BRICK_SIZE)};
    }
  };
  struct Scratch {
    BrickDistanceFinder finder;
    std::vector<std::uint32_t> shared;
    std::vector<VoxelTriangle> triangles;
  };

  void mark_touched(std::span<const std::uint8_t> moved, std::vector<std::uint8_t>& touched) const {
    for (std::size_t i = 0; i < moved.size(); ++i)
      if (moved[i])
        for (const std::uint32_t b : lists_.bricks_of(i)) touched[b] = 1;
  }

  uvec3 brick_at(std::size_t i) const {
    const uvec3 n = grid_.grid.bricks;
    return {i % n.x, i / n.x % n.y, i / n.x / n.y};
  }
  /// visit(index) for a brick and its 26 neighbours inside the grid.
  template <class Visit>
  void for_each_around(std::size_t brick, Visit&& visit) const {
    const uvec3 b = brick_at(brick), low = glm::max(b, uvec3(1)) - 1u,
                high = glm::min(b + 1u, grid_.grid.bricks - 1u);
    for (std::uint32_t z = low.z; z <= high.z; ++z)
      for (std::uint32_t y = low.y; y <= high.y; ++y)
        for (std::uint32_t x = low.x; x <= high.x; ++x) visit(grid_.brick_index({x, y, z}));
  }
  std::vector<std::uint8_t> widened(std::span<const std::uint8_t> touched) const {
    std::vector<std::uint8_t> dirty(touched.size(), 0);
    for (std::size_t i = 0; i < touched.size(); ++i)
      if (touched[i]) for_each_around(i, [&](std::size_t b) { dirty[b] = 1; });
    return dirty;
  }

  /// New slots in the order of the bricks; distances are kept where the brick is not dirty.
  template <Executor E>
  void refresh(const Mesh& mesh, std::span<const std::uint8_t> dirty, const E& executor) {
    Contents next = empty_contents();
    std::vector<std::uint32_t> anew;  // slots
    for (std::uint32_t i = 0; i < next.filled.size(); ++i)
      if (dirty[next.filled[i]])
        anew.push_back(i);
      else
        keep(grid_.slots[next.filled[i]] - 1, next.bytes_of(i, grid_.grid.first_brick), next.nearest[i]);
    executor(anew.size(), 1, [&](std::size_t begin, std::size_t end) {
      Scratch scratch;
      for (std::size_t k = begin; k < end; ++k) {
        const std::uint32_t i = anew[k];
        compute(mesh, next.filled[i], scratch, next.bytes_of(i, grid_.grid.first_brick), next.nearest[i]);
      }
    });
    refreshed_ = anew.size();
    grid_.slots = std::move(next.slots), grid_.distances = std::move(next.distances);
    nearest_ = std::move(next.nearest);
    fill_corners(next.filled);
  }

  /// Room for what the lists of triangles ask for.
  Contents empty_contents() const {
    Contents next;
    next.slots.assign(grid_.slots.size(), 0);
    for (std::uint32_t b = 0; b < next.slots.size(); ++b)
      if (!lists_.triangles_of(b).empty())
        next.filled.push_back(b), next.slots[b] = std::uint32_t(next.filled.size());
    next.distances.assign(grid_.grid.first_brick + next.filled.size() * VOXEL_BRICK_SIZE + 4, 255);
    next.nearest.resize(next.filled.size());
    return next;
  }

  void keep(std::size_t slot, std::span<std::uint8_t> distances, Corners& nearest) const {
    std::copy_n(grid_.distances.data() + grid_.grid.first_brick + slot * VOXEL_BRICK_SIZE, distances.size(),
                distances.data());
    nearest = nearest_[slot];
  }
  void compute(const Mesh& mesh, std::uint32_t brick, Scratch& scratch, std::span<std::uint8_t> distances,
               Corners& nearest) const {
    gather_triangles(mesh, brick, scratch.shared, scratch.triangles);
    scratch.finder.find(scratch.triangles, vec3(brick_at(brick) * VOXEL_BRICK), distances, nearest.points);
  }

  /// The triangles of a brick and its neighbours, each once; within a brick in the order of the mesh, which
  /// keeps near ones together, and last those that meet several bricks.
  void gather_triangles(const Mesh& mesh, std::uint32_t brick, std::vector<std::uint32_t>& shared,
                        std::vector<VoxelTriangle>& triangles) const {
    shared.clear(), triangles.clear();
    const auto add = [&](std::uint32_t i) {
      const uvec3 t = mesh.triangles[i];
      triangles.push_back(voxel_triangle(grid_.place(mesh.positions[t.x]), grid_.place(mesh.positions[t.y]),
                                         grid_.place(mesh.positions[t.z])));
    };
    for_each_around(brick, [&](std::size_t b) {
      for (const std::uint32_t i : lists_.triangles_of(b))
        lists_.bricks_of(i).size() == 1 ? add(i) : shared.push_back(i);
    });
    std::ranges::sort(shared);
    shared.erase(std::unique(shared.begin(), shared.end()), shared.end());
    for (const std::uint32_t i : shared) add(i);
  }

  void fill_corners(std::span<const std::uint32_t> filled) {
    CornerDistances corners(grid_.grid.bricks + 1u, float(VOXEL_BRICK));
    for (std::size_t i = 0; i < filled.size(); ++i)
      for (std::uint32_t c = 0; c < 8; ++c)
        corners.offer(brick_at(filled[i]) + uvec3(c & 1, (c >> 1) & 1, c >> 2), nearest_[i].points[c]);
    corners.spread();
    for (std::size_t i = 0; i < grid_.corner_count(); ++i) {
      const auto rounded = std::uint16_t(std::min(corners.distance(i) / VOXEL_FAR_UNIT + 0.5f, 65535.0f));
      std::memcpy(&grid_.distances[2 * i], &rounded, 2);
    }
  }

  BrickGrid grid_;
  BrickTriangles lists_;
  std::vector<Corners> nearest_;  ///< by slot: surface points nearest to the corners
  std::size_t refreshed_ = 0;
};

}  // namespace coppice
