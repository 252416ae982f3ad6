// Groups of points that lie close together and look alike, so that one bound serves all of them.
#pragma once

#include <coppice/shared/vpl.h>

#include <algorithm>
#include <cmath>
#include <coppice/core/config.hpp>
#include <cstdint>
#include <span>
#include <vector>

namespace coppice {

/// Points in order of their groups.
struct PointGroups {
  std::vector<GlossyPoint> points;
  std::vector<std::uint32_t> ends;  ///< a group; its points end before this index

  std::size_t size() const { return ends.size(); }
  std::size_t first(std::size_t g) const { return g == 0 ? 0 : ends[g - 1]; }
  std::span<const GlossyPoint> group(std::size_t g) const {
    return std::span(points).subspan(first(g), ends[g] - first(g));
  }
};

/// How alike the points of a group are.
struct GroupOptions {
  int tile = 8;                 ///< side of the tiles of pixels that groups never leave
  float normal_cosine = 0.95f;  ///< of each normal to the first point's
  float mirror_cosine = 0.95f;  ///< of the mirror directions, likewise
  float plane = 0.02f;  ///< distance from the first point's tangent plane, as a share of the point's depth
  float reach = 0.1f;   ///< distance from the first point, likewise
};

/// For points that are scattered over an image of so many pixels: tiles so large that they hold about as many
/// points as one of 8 × 8 pixels would if all were points, and at most 64 wide.
inline GroupOptions scattered_groups(std::size_t points, std::size_t pixels) {
  GroupOptions o;
  const double each = double(pixels) / double(std::max<std::size_t>(points, 1));
  o.tile = std::clamp(int(o.tile * std::sqrt(each) + 0.5), 1, 64);
  return o;
}

namespace detail {

inline bool alike(const GlossyPoint& a, const GlossyPoint& b, float depth, const GroupOptions& o) {
  const vec3 apart = b.position - a.position;
  return dot(a.normal, b.normal) >= o.normal_cosine && dot(a.mirror, b.mirror) >= o.mirror_cosine &&
         std::fabs(dot(apart, a.normal)) <= o.plane * depth &&
         dot(apart, apart) <= o.reach * o.reach * depth * depth;
}

}  // namespace detail

/// Splits the points of each tile: the first that has no group begins one, and all that are like it join.
/// Order: tiles by row, groups by their first point. Deterministic. Precondition: pixels lie in the image.
inline PointGroups group_points(std::span<const GlossyPoint> points, int width, const vec3& eye,
                                const GroupOptions& options = {}) {
  std::vector<std::vector<std::uint32_t>> tiles;
  const auto columns = std::uint32_t((width + options.tile - 1) / options.tile);
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const std::uint32_t x = points[i].pixel % std::uint32_t(width),
                        y = points[i].pixel / std::uint32_t(width);
    const std::size_t tile =
        std::size_t(y / std::uint32_t(options.tile)) * columns + x / std::uint32_t(options.tile);
    if (tile >= tiles.size()) tiles.resize(tile + 1);
    tiles[tile].push_back(i);
  }
  PointGroups groups;
  groups.points.reserve(points.size());
  for (auto& rest : tiles)
    while (!rest.empty()) {
      const GlossyPoint first = points[rest[0]];
      const float depth = length(first.position - eye);
      std::erase_if(rest, [&](std::uint32_t i) {
        if (!detail::alike(first, points[i], depth, options)) return false;
        groups.points.push_back(points[i]);
        groups.points.back().group = std::uint32_t(groups.ends.size());
        return true;
      });
      groups.ends.push_back(std::uint32_t(groups.points.size()));
    }
  return groups;
}

}  // namespace coppice
