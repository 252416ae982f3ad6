// A distant environment as few distant lights, which lie where its light comes from.
#pragma once

#include <coppice/core/config.hpp>
#include <coppice/light/environment.hpp>
#include <coppice/light/local_light.hpp>
#include <queue>
#include <vector>

namespace coppice {

namespace detail {

/// Sums over a part of the sphere.
struct SkySums {
  glm::dvec3 power{0};    ///< Σ radiance · solid angle
  glm::dvec3 towards{0};  ///< Σ weight · direction, the weight a luminance of the power
  double weight = 0;

  SkySums& operator+=(const SkySums& o) {
    power += o.power, towards += o.towards, weight += o.weight;
    return *this;
  }
  SkySums operator-(const SkySums& o) const {
    return {power - o.power, towards - o.towards, weight - o.weight};
  }
  /// Σ weight · |direction - mean direction|² / 2, the error of first order in that square.
  double spread() const {
    return weight > 0 ? std::max(0.0, weight - length(towards) * length(towards) / weight) : 0;
  }
};

/// Columns [left, right) and rows [top, bottom) of a grid.
struct SkyCell {
  int left, right, top, bottom;
};

/// A map's grid of sums, of at most `most_rows` rows and at least half of them: small maps are subdivided,
/// texels of large ones added up, each with its own direction.
class SkyGrid {
 public:
  explicit SkyGrid(const Environment& environment)
      : parts_(std::max(1, (least_rows + environment.map.height - 1) / environment.map.height)),
        merged_(std::max(1, environment.map.height / least_rows)),
        width_((environment.map.width * parts_ + merged_ - 1) / merged_),
        height_((environment.map.height * parts_ + merged_ - 1) / merged_),
        sums_(std::size_t(width_ + 1) * std::size_t(height_ + 1)) {
    add_texels(environment);
    for (int y = 1; y <= height_; ++y)
      for (int x = 1; x <= width_; ++x) at(x, y) += at(x - 1, y);
    for (int y = 1; y <= height_; ++y)
      for (int x = 1; x <= width_; ++x) at(x, y) += at(x, y - 1);
  }

  SkyCell whole() const { return {0, width_, 0, height_}; }
  SkySums over(const SkyCell& c) const {
    SkySums sums = at(c.right, c.bottom) - at(c.left, c.bottom);
    return (sums += at(c.left, c.top)) - at(c.right, c.top);
  }

 private:
  static constexpr int least_rows = 512;

  const SkySums& at(int x, int y) const {
    return sums_[std::size_t(y) * std::size_t(width_ + 1) + std::size_t(x)];
  }
  SkySums& at(int x, int y) { return sums_[std::size_t(y) * std::size_t(width_ + 1) + std::size_t(x)]; }

  void add_texels(const Environment& environment) {
    const int width = environment.map.width * parts_, height = environment.map.height * parts_;
    for (int y = 0; y < height; ++y) {
      const double area = texel_solid_angle(y, width, height);
      for (int x = 0; x < width; ++x) {
        const vec3& radiance = environment.map.at(x / parts_, y / parts_);
        const double weight = area * double(luminance(radiance));
        at(x / merged_ + 1, y / merged_ + 1) +=
            {area * glm::dvec3(radiance), weight * glm::dvec3(texel_direction(x, y, width, height)), weight};
      }
    }
  }

  int parts_, merged_, width_, height_;
  std::vector<SkySums> sums_;  ///< of all entries above and to the left
};

/// The two parts of a cell, cut where their spreads add up to least. Precondition: more than one entry.
inline std::pair<SkyCell, SkyCell> split(const SkyGrid& grid, const SkyCell& cell) {
  std::pair<SkyCell, SkyCell> best;
  double least = std::numeric_limits<double>::infinity();
  const auto consider = [&](const SkyCell& a, const SkyCell& b) {
    const double spread = grid.over(a).spread() + grid.over(b).spread();
    if (spread < least) least = spread, best = {a, b};
  };
  for (int x = cell.left + 1; x < cell.right; ++x)
    consider({cell.left, x, cell.top, cell.bottom}, {x, cell.right, cell.top, cell.bottom});
  for (int y = cell.top + 1; y < cell.bottom; ++y)
    consider({cell.left, cell.right, cell.top, y}, {cell.left, cell.right, y, cell.bottom});
  return best;
}

/// At most `count` cells: the one of most spread is split, again and again.
inline std::vector<SkyCell> sky_cells(const SkyGrid& grid, std::size_t count) {
  struct Entry {
    double spread;
    std::size_t cell;
    bool operator<(const Entry& o) const { return spread < o.spread; }
  };
  std::vector<SkyCell> cells{grid.whole()};
  std::priority_queue<Entry> queue;
  const auto push = [&](std::size_t i) {
    const SkyCell& c = cells[i];
    if ((c.right - c.left) * (c.bottom - c.top) > 1) queue.push({grid.over(c).spread(), i});
  };
  push(0);
  while (cells.size() < count && !queue.empty() && queue.top().spread > 0) {
    const std::size_t i = queue.top().cell;
    queue.pop();
    const auto [a, b] = split(grid, cells[i]);
    cells[i] = a, cells.push_back(b);
    push(i), push(cells.size() - 1);
  }
  return cells;
}

/// d turned about +Y as Environment::rotation turns the map.
inline vec3 turned_with(const Environment& environment, const glm::dvec3& d) {
  const double c = std::cos(double(environment.rotation)), s = std::sin(double(environment.rotation));
  return vec3(glm::dvec3(c * d.x + s * d.z, d.y, c * d.z - s * d.x));
}

}  // namespace detail

/// The environment as at most `count` distant lights, for points that need not tell it finer. Rectangles of
/// the map, each a light of its power at its mean direction, luminance as weight; of all, the one whose light
/// is spread most (Σ weight · squared distance from the mean direction) is split, where that leaves the
/// least. So many small ones lie where the light comes from, a sun keeps its place, and to smooth functions
/// of the direction the lights are right to first order. Power is kept to 1e-6; dark cells give no light.
/// `reach` as for distant_light. Precondition: the map has texels. Errors: docs/light.md. Cost: one pass over
/// the map, then a search of each cell's rows and columns.
inline std::vector<LocalLight> environment_lights(const Environment& environment, std::size_t count,
                                                  float reach) {
  COPPICE_ASSERT(environment.map.width > 0 && environment.map.height > 0);
  if (count == 0) return {};
  const detail::SkyGrid grid(environment);
  const double dark = 1e-12 * grid.over(grid.whole()).weight;
  std::vector<LocalLight> lights;
  for (const detail::SkyCell& cell : detail::sky_cells(grid, count)) {
    const detail::SkySums sums = grid.over(cell);
    const double size = length(sums.towards);
    if (!(sums.weight > dark)) continue;
    const glm::dvec3 direction = size > 0 ? sums.towards / size : glm::dvec3(0, 1, 0);
    lights.push_back(distant_light(detail::turned_with(environment, direction),
                                   vec3(glm::max(sums.power, glm::dvec3(0))), reach));
  }
  return lights;
}

}  // namespace coppice
