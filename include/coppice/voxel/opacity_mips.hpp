// Opacity in a pyramid of voxels, and the cone tracing through it that SG section 5 tells of: the yardstick
// of the march through distances (docs/voxel.md), which leaks less.
#pragma once

#include <coppice/voxel/brick_triangles.hpp>

namespace coppice {

/// Level 0 is opaque where a triangle meets the voxel; each level further is the mean of 2³ voxels of the one
/// below (Crassin et al., "Interactive Indirect Illumination Using Voxel Cone Tracing", 2011). Dense.
class OpacityMips {
 public:
  /// The voxels of a grid and of the lists of triangles that belong to it.
  template <Executor E>
  OpacityMips(const BrickGrid& grid, const BrickTriangles& lists, const Mesh& mesh, const E& executor)
      : low_(grid.grid.low), voxels_per_unit_(grid.grid.voxels_per_unit) {
    levels_.push_back(Level(grid.grid.bricks * VOXEL_BRICK));
    executor(grid.slots.size(), 16, [&](std::size_t begin, std::size_t end) {
      for (std::size_t b = begin; b < end; ++b) fill_brick(grid, lists, mesh, b);
    });
    while (glm::any(glm::greaterThan(levels_.back().size, uvec3(1)))) levels_.push_back(half(levels_.back()));
  }

  std::size_t bytes() const {
    std::size_t sum = 0;
    for (const Level& level : levels_) sum += level.opacity.size();
    return sum;
  }
  /// Whether any triangle meets a voxel.
  bool is_surface(const uvec3& voxel) const { return levels_[0].opacity[levels_[0].index(voxel)] != 0; }

  /// What is left of a Gaussian by the cone at whose edge it is a half (SG Eq. 6), in [0, 1]; `steps` is set
  /// to the number of lookups. Strides of half the cone's width, from 1.5 voxels on, lifted by a voxel.
  float cone_visibility(const vec3& origin, const vec3& normal, const SgShape& cone, int& steps) const {
    const vec3 start = (origin - low_) * voxels_per_unit_ + normal;
    const float drop = std::fmin(0.6931472f / std::fmax(cone.sharpness, 0.35f), 1.9f);
    const float spread = 2 * std::sqrt(drop * (2 - drop)) / std::fmax(1 - drop, 0.1f);
    const float end = length(vec3(levels_[0].size));
    float through = 1;
    steps = 0;
    for (float t = 1.5f; t < end && through > 0.003f; ++steps) {
      const float width = std::fmax(spread * t, 1.0f), stride = 0.5f * width;
      const float opacity = at(start + t * cone.axis, std::log2(width));
      through *= std::pow(std::fmax(1 - opacity, 0.0f), stride / width);
      t += stride;
    }
    return through;
  }

 private:
  struct Level {
    uvec3 size{1};
    std::vector<std::uint8_t> opacity;

    explicit Level(const uvec3& s) : size(s), opacity(std::size_t(s.x) * s.y * s.z, 0) {}
    std::size_t index(const uvec3& v) const { return (std::size_t(v.z) * size.y + v.y) * size.x + v.x; }
    /// 0 outside.
    float get(const glm::ivec3& v) const {
      if (glm::any(glm::lessThan(v, glm::ivec3(0))) || glm::any(glm::greaterThanEqual(v, glm::ivec3(size))))
        return 0;
      return float(opacity[index(uvec3(v))]) / 255;
    }
    /// Trilinear between the voxels' centres; in voxels of this level.
    float sample(const vec3& place) const {
      const vec3 p = place - 0.5f, cell = glm::floor(p), f = p - cell;
      float sum = 0;
      for (int i = 0; i < 8; ++i) {
        const glm::ivec3 o(i & 1, (i >> 1) & 1, i >> 2);
        const vec3 w = glm::mix(1.0f - f, f, vec3(o));
        sum += w.x * w.y * w.z * get(glm::ivec3(cell) + o);
      }
      return sum;
    }
  };

  void fill_brick(const BrickGrid& grid, const BrickTriangles& lists, const Mesh& mesh, std::size_t b) {
    const uvec3 n = grid.grid.bricks;
    const glm::ivec3 first(8 * int(b % n.x), 8 * int(b / n.x % n.y), 8 * int(b / n.x / n.y));
    for (const std::uint32_t i : lists.triangles_of(b)) {
      const uvec3 t = mesh.triangles[i];
      const TriangleCorners corners{grid.place(mesh.positions[t.x]), grid.place(mesh.positions[t.y]),
                                    grid.place(mesh.positions[t.z])};
      for_each_cell(corners, 1, first, first + 8,
                    [&](int x, int y, int z) { levels_[0].opacity[levels_[0].index(uvec3(x, y, z))] = 255; });
    }
  }

  static Level half(const Level& fine) {
    Level coarse((fine.size + 1u) / 2u);
    for (std::uint32_t z = 0; z < coarse.size.z; ++z)
      for (std::uint32_t y = 0; y < coarse.size.y; ++y)
        for (std::uint32_t x = 0; x < coarse.size.x; ++x) {
          float sum = 0;
          for (int i = 0; i < 8; ++i)
            sum += fine.get(glm::ivec3(2u * uvec3(x, y, z)) + glm::ivec3(i & 1, (i >> 1) & 1, i >> 2));
          coarse.opacity[coarse.index({x, y, z})] = std::uint8_t(255 * sum / 8 + 0.5f);
        }
    return coarse;
  }

  float at(const vec3& place, float level) const {
    const float clamped = std::clamp(level, 0.0f, float(levels_.size() - 1));
    const auto lower = std::size_t(clamped), upper = std::min(lower + 1, levels_.size() - 1);
    const float a = levels_[lower].sample(place / float(1u << lower)),
                b = levels_[upper].sample(place / float(1u << upper));
    return a + (clamped - float(lower)) * (b - a);
  }

  vec3 low_;
  float voxels_per_unit_;
  std::vector<Level> levels_;
};

}  // namespace coppice
