// Gathers an environment map into lights: each receives the texels nearest to its direction.
#pragma once

#include <coppice/core/config.hpp>
#include <coppice/light/environment.hpp>
#include <cstdint>
#include <nanoflann.hpp>
#include <span>
#include <vector>

namespace coppice {

/// What a light stands for: its cell of the sphere.
struct CellLight {
  vec3 power{0};  ///< Σ radiance · solid angle over the cell; power / solid_angle is the mean radiance
  float solid_angle = 0;  ///< steradians
};

/// The cells of a set of directions: a table that tells for each direction of a grid the nearest light. Every
/// texel goes to one cell whole, so the map's energy is kept to rounding and no bright texel is lost between
/// lights. Turning the environment is a shift of columns, rounded to the table's: at most 0.18° for maps of
/// 1,024 columns or more, a sixth of a cell's width for 32,768 lights.
class EnvironmentCells {
 public:
  /// For maps of width × height texels; small maps are subdivided to a table of at least 512 rows.
  /// Cost: one nearest-neighbour query a table entry. Precondition: at least one direction and one texel.
  EnvironmentCells(std::span<const vec3> directions, int width, int height)
      : light_count_(directions.size()),
        subdivision_(std::max(1, (512 + height - 1) / height)),
        width_(width * subdivision_),
        height_(height * subdivision_) {
    COPPICE_ASSERT(!directions.empty() && width > 0 && height > 0);
    const Cloud cloud{directions};
    const KdTree tree(3, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(8));
    light_.resize(std::size_t(width_) * std::size_t(height_));
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x)
        light_[index(x, y)] = nearest(tree, texel_direction(x, y, width_, height_));
  }

  /// The light nearest to a unit direction, to a table entry.
  std::uint32_t nearest_light(const vec3& d) const {
    const float turns = std::atan2(d.z, d.x) / (2 * pi) + 0.5f;
    const float height = std::acos(std::clamp(d.y, -1.0f, 1.0f)) / pi;
    const int x = int(turns * float(width_)), y = int(height * float(height_));
    return light_[index(std::clamp(x, 0, width_ - 1), std::clamp(y, 0, height_ - 1))];
  }

  /// Where the light of each cell comes from under this environment: the mean direction of its texels,
  /// weighted by their luminance. A sun that lies between lattice points keeps its place, and its shadows
  /// theirs. Cells without light, or whose light comes from all sides, keep the direction given for them.
  std::vector<vec3> centroids(const Environment& environment, std::span<const vec3> directions) const {
    COPPICE_ASSERT(directions.size() == light_count_);
    std::vector<glm::dvec4> sums(light_count_, glm::dvec4(0));  // Σ weight · (direction, 1)
    for_each_texel(environment, [&](std::uint32_t light, int x, int y, double area, const vec3& radiance) {
      const double weight = area * double(luminance(radiance));
      sums[light] += weight * glm::dvec4(glm::dvec3(texel_direction(x, y, width_, height_)), 1);
    });
    std::vector<vec3> result(directions.begin(), directions.end());
    for (std::size_t i = 0; i < light_count_; ++i)
      if (const double size = glm::length(glm::dvec3(sums[i])); size > 1e-9 * sums[i].w)
        result[i] = vec3(glm::dvec3(sums[i]) / size);
    return result;
  }

  /// The lights under this environment, in the order of the directions. Sums in double: energy to 1e-7.
  /// Precondition: the map has the size that was given to the constructor.
  std::vector<CellLight> gather(const Environment& environment) const {
    std::vector<glm::dvec4> sums(light_count_, glm::dvec4(0));
    for_each_texel(environment, [&](std::uint32_t light, int, int, double area, const vec3& radiance) {
      sums[light] += area * glm::dvec4(glm::dvec3(radiance), 1);
    });
    std::vector<CellLight> lights(light_count_);
    for (std::size_t i = 0; i < light_count_; ++i) lights[i] = {vec3(sums[i]), float(sums[i].w)};
    return lights;
  }

 private:
  struct Cloud {
    std::span<const vec3> points;
    std::size_t kdtree_get_point_count() const { return points.size(); }
    float kdtree_get_pt(std::size_t i, std::size_t axis) const { return points[i][int(axis)]; }
    template <class Box>
    bool kdtree_get_bbox(Box&) const {
      return false;
    }
  };
  using KdTree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Cloud>, Cloud, 3,
                                                     std::uint32_t>;

  static std::uint32_t nearest(const KdTree& tree, const vec3& d) {
    std::uint32_t found = 0;
    float squared_distance = 0;
    tree.knnSearch(&d.x, 1, &found, &squared_distance);
    return found;
  }

  std::size_t index(int x, int y) const { return std::size_t(y) * std::size_t(width_) + std::size_t(x); }

  /// Calls visit(light, column, row, solid angle, radiance) for each entry of the table, the map turned as it
  /// is.
  template <class Visit>
  void for_each_texel(const Environment& environment, Visit&& visit) const {
    COPPICE_ASSERT(environment.map.width * subdivision_ == width_ &&
                   environment.map.height * subdivision_ == height_);
    const int shift = column_shift(environment.rotation);
    for (int y = 0; y < height_; ++y) {
      const double area = texel_solid_angle(y, width_, height_);
      const vec3* row = &environment.map.pixels[environment.map.index(0, y / subdivision_)];
      for (int x = 0; x < width_; ++x) {
        const int column = x >= shift ? x - shift : x - shift + width_;
        visit(light_[index(column, y)], column, y, area, row[x / subdivision_]);
      }
    }
  }

  /// Columns by which a turn moves texels towards smaller azimuth, in [0, width).
  int column_shift(float rotation) const {
    const double turns = double(rotation) / (2 * std::numbers::pi);
    return int(std::llround((turns - std::floor(turns)) * width_)) % width_;
  }

  std::size_t light_count_;
  int subdivision_, width_, height_;
  std::vector<std::uint32_t> light_;
};

}  // namespace coppice
