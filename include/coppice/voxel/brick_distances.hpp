// The distances of one brick: exact to the triangles around it, found by narrowing down who can be nearest.
#pragma once

#include <coppice/shared/voxel.h>

#include <coppice/voxel/triangle_distance.hpp>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace coppice {

/// A triangle and a ball that holds it, in voxels.
struct VoxelTriangle {
  TriangleCorners corners;
  vec3 centre;
  float radius;
};

inline VoxelTriangle voxel_triangle(const vec3& a, const vec3& b, const vec3& c) {
  using triangle_distance::squared;
  const vec3 low = glm::min(glm::min(a, b), c), high = glm::max(glm::max(a, b), c);
  const vec3 centre = 0.5f * (low + high);
  const float radius2 = std::max({squared(a - centre), squared(b - centre), squared(c - centre)});
  return {{a, b, c}, centre, std::sqrt(radius2) * (1 + 1e-6f)};
}

/// Computes bricks, one after the other; keeps its scratch memory.
class BrickDistanceFinder {
 public:
  /// Distances at the 8³ places of the brick whose low corner is here, and the surface point nearest to each
  /// of its corners: that with the bits of i as offsets along x, y, z is number i. Exact to rounding and the
  /// unit of 8 bits, up to 8 voxels from the triangles given. Triangles may repeat; the nearer they are to
  /// those beside them in the list, the faster. Precondition: at least one triangle.
  void find(std::span<const VoxelTriangle> triangles, const vec3& low, std::span<std::uint8_t> distances,
            std::span<vec3, 8> nearest) {
    constexpr float half_brick = 4 * 1.7320508f;
    triangles_ = triangles;
    make_runs();
    narrow(runs_, low + 4.0f, half_brick, in_brick_);
    for (int i = 0; i < 8; ++i) {
      narrow(in_brick_, low + vec3(2) + 4.0f * vec3(bits(i)), half_brick / 2, in_block_);
      for (int j = 0; j < 8; ++j) find_small_block(low, 2 * bits(i) + bits(j), distances);
    }
    for (int i = 0; i < 8; ++i) {
      const vec3 corner = low + 8.0f * vec3(bits(i));
      narrow(in_brick_, corner, 0, in_block_);
      nearest[std::size_t(i)] = nearest_of(in_block_, corner).point;
    }
  }

 private:
  /// Small triangles that follow each other, up to eight, or one large one; and a ball that holds them.
  struct Run {
    vec3 centre;
    float radius;
    std::uint32_t first, end;
  };
  struct Nearest {
    float distance2;
    vec3 point;
  };

  static glm::ivec3 bits(int i) { return {i & 1, (i >> 1) & 1, i >> 2}; }

  void make_runs() {
    runs_.clear();
    constexpr float small = 0.75f;
    for (std::uint32_t i = 0, end; i < triangles_.size(); i = end) {
      vec3 low = triangles_[i].centre, high = low;
      for (end = i + 1; end < triangles_.size() && end < i + 8; ++end) {
        if (triangles_[i].radius > small || triangles_[end].radius > small) break;
        low = glm::min(low, triangles_[end].centre), high = glm::max(high, triangles_[end].centre);
      }
      const vec3 centre = 0.5f * (low + high);
      float radius = 0;
      for (std::uint32_t k = i; k < end; ++k)
        radius = std::max(radius, length(triangles_[k].centre - centre) + triangles_[k].radius);
      runs_.push_back({centre, radius * (1 + 1e-6f), i, end});
    }
  }

  float distance_to_one(const Run& run, const vec3& p) const {
    return length(nearest_on_triangle(triangles_[run.first].corners, p) - p);
  }

  /// The runs that can hold the triangle nearest to any place within `reach` of the centre: judged by their
  /// balls, and by the triangle itself where it is large. The most promising comes first.
  void narrow(std::span<const Run> from, const vec3& centre, float reach, std::vector<Run>& to) const {
    float most = std::numeric_limits<float>::infinity();
    for (const Run& run : from) {
      const float apart = length(run.centre - centre);
      most = std::min(most, apart + run.radius);
      if (run.end == run.first + 1 && run.radius > reach && apart - run.radius < most)
        most = std::min(most, distance_to_one(run, centre));
    }
    const float limit = (most + 2 * reach) * (1 + 1e-5f);
    to.clear();
    float least = std::numeric_limits<float>::infinity();
    for (const Run& run : from) {
      const float by_ball = limit + run.radius, apart2 = triangle_distance::squared(run.centre - centre);
      if (apart2 > by_ball * by_ball) continue;
      if (run.end == run.first + 1 && run.radius > reach && distance_to_one(run, centre) > limit) continue;
      to.push_back(run);
      if (apart2 < least) least = apart2, std::swap(to.front(), to.back());
    }
  }

  Nearest nearest_of(std::span<const Run> runs, const vec3& p) const {
    Nearest best{std::numeric_limits<float>::infinity(), p};
    float distance = best.distance2;
    const auto is_far = [&](const vec3& centre, float radius) {
      const float limit = distance + radius;
      return triangle_distance::squared(centre - p) > limit * limit;
    };
    for (const Run& run : runs) {
      if (is_far(run.centre, run.radius)) continue;
      for (const VoxelTriangle& t : triangles_.subspan(run.first, run.end - run.first)) {
        if (is_far(t.centre, t.radius)) continue;
        const vec3 q = nearest_on_triangle(t.corners, p);
        if (const float d2 = triangle_distance::squared(q - p); d2 < best.distance2)
          best = {d2, q}, distance = std::sqrt(d2);
      }
    }
    return best;
  }

  /// The places of a block of 2³.
  void find_small_block(const vec3& low, const glm::ivec3& block, std::span<std::uint8_t> distances) {
    constexpr float step = 8.0f / 7.0f;
    const vec3 centre = low + step * (2.0f * vec3(block) + 0.5f);
    narrow(in_block_, centre, 0.5f * step * 1.7320508f, in_small_block_);
    for (int i = 0; i < 8; ++i) {
      const glm::ivec3 at = 2 * block + bits(i);
      const float distance = std::sqrt(nearest_of(in_small_block_, low + step * vec3(at)).distance2);
      distances[std::size_t((at.z * 8 + at.y) * 8 + at.x)] =
          std::uint8_t(std::min(distance / VOXEL_NEAR_UNIT + 0.5f, 255.0f));
    }
  }

  std::span<const VoxelTriangle> triangles_;
  std::vector<Run> runs_, in_brick_, in_block_, in_small_block_;
};

}  // namespace coppice
