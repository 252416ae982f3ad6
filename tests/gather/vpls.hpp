// Random VPLs and points that gather their light, ordinary and extreme.
#pragma once

#include <coppice/gather/vpl_tree.hpp>
//
#include <coppice/core/random.hpp>
#include <coppice/gather/point_groups.hpp>
#include <coppice/reference/vpl.hpp>
#include <support/occluders.hpp>
#include <utility>

namespace support {

using coppice::GlossyPoint;
using coppice::Random;
using coppice::vec3;
using coppice::VplNode;

inline const SphereOccluder nothing{};

/// Blocks what passes where normal · x > offset.
struct HalfSpace {
  vec3 normal;
  float offset;

  bool contains(const vec3& x) const { return dot(normal, x) > offset; }
  bool occluded(const vec3& origin, const vec3& direction, float t_max) const {
    return contains(origin) || contains(origin + t_max * direction);
  }
  std::uint32_t occluded(const coppice::ShadowPacket& rays, std::uint32_t lanes) const {
    return lane_by_lane(*this, rays, lanes);
  }
};
static_assert(coppice::Occluder<HalfSpace>);

/// From low to high, evenly by logarithm.
inline float spread(Random& random, float low, float high) {
  return low * std::pow(high / low, random.uniform());
}
inline vec3 any_colour(Random& random) {
  const float r = random.uniform(), g = random.uniform(), b = random.uniform();
  return random.below(8) == 0 ? vec3(r < 0.4f ? 1 : 0, g < 0.4f ? 1 : 0, 0.2f) : vec3(r, g, b);
}
inline vec3 in_cube(Random& random, float half) {
  const float x = random.uniform(), y = random.uniform(), z = random.uniform();
  return half * (2.0f * vec3(x, y, z) - 1.0f);
}

/// A place on the walls of [-2, 2]³, and the normal there, inwards.
inline std::pair<vec3, vec3> on_wall(Random& random) {
  vec3 position = in_cube(random, 2), normal(0);
  const int axis = int(random.below(3));
  const float side = random.below(2) == 0 ? -1.0f : 1.0f;
  position[axis] = 2 * side, normal[axis] = -side;
  return {position, normal};
}

/// A VPL of a patch: with lobe and diffuse light, or one of them, or dark.
inline VplNode any_vpl(Random& random, const vec3& position, const vec3& normal, float most_exponent = 1e6f) {
  VplNode n{};
  n.position = position, n.normal = normal;
  n.area = spread(random, 1e-4f, 0.1f);
  n.softening = n.area / coppice::pi;
  const std::uint32_t kind = random.below(8);
  if (kind != 0 && kind != 1) n.diffuse = n.area * any_colour(random);
  if (kind != 0 && kind != 2) n.specular = n.area * any_colour(random);
  n.exponent = random.below(6) == 0 ? 0.0f : spread(random, 1, most_exponent);
  n.lobe = normalize(normal + 0.99f * random.direction());
  n.energy = coppice::vpl_energy(n.diffuse, n.specular);
  return n;
}

/// A room of patches.
inline std::vector<VplNode> room_vpls(Random& random, std::size_t count, float most_exponent = 1e6f) {
  std::vector<VplNode> vpls;
  while (vpls.size() < count) {
    const auto [position, normal] = on_wall(random);
    vpls.push_back(any_vpl(random, position, normal, most_exponent));
  }
  return vpls;
}

/// Anything goes: clumps, coincident VPLs, opposite lobes, areas next to zero, bright among faint.
inline std::vector<VplNode> wild_vpls(Random& random, std::size_t count) {
  std::vector<VplNode> vpls;
  while (vpls.size() < count) {
    const bool is_near = !vpls.empty() && random.below(3) != 0;
    const vec3 place = is_near ? vpls.back().position + in_cube(random, spread(random, 1e-5f, 1))
                               : in_cube(random, spread(random, 0.01f, 10));
    VplNode n = any_vpl(random, place, random.direction());
    if (!vpls.empty() && random.below(5) == 0) n.position = vpls.back().position;
    if (!vpls.empty() && random.below(5) == 0) n.lobe = -vpls.back().lobe;
    if (random.below(5) == 0) n.exponent = -random.uniform();
    if (random.below(8) == 0) n.area = n.softening = 1e-12f;
    if (random.below(8) == 0) n.area = n.softening = n.energy = 0, n.diffuse = n.specular = vec3(0);
    const float scale = random.below(4) == 0 ? spread(random, 1e-4f, 1e4f) : 1.0f;
    n.diffuse *= scale, n.specular *= scale, n.energy *= scale;
    vpls.push_back(n);
  }
  return vpls;
}

inline void look_from(GlossyPoint& p, const vec3& to_viewer) {
  p.mirror = normalize(2 * dot(p.normal, to_viewer) * p.normal - to_viewer);
}

/// A point of a surface with a random viewer above it.
inline GlossyPoint any_point(Random& random, const vec3& position, const vec3& normal,
                             float most_exponent = 1e5f) {
  GlossyPoint p{};
  p.position = position, p.normal = normal;
  p.exponent = spread(random, 1, most_exponent);
  look_from(p, normalize(random.direction() + 1.05f * normal));
  const std::uint32_t kind = random.below(5);
  if (kind != 0) p.diffuse = any_colour(random);
  if (kind != 1) p.specular = any_colour(random);
  return p;
}

/// Points in the room, about half of them on its walls; pixels count them.
inline std::vector<GlossyPoint> room_points(Random& random, std::size_t count, float most_exponent = 1e5f) {
  std::vector<GlossyPoint> points;
  while (points.size() < count) {
    auto [position, normal] = on_wall(random);
    if (random.below(2) == 0) position = in_cube(random, 1.9f), normal = random.direction();
    points.push_back(any_point(random, position, normal, most_exponent));
    points.back().pixel = std::uint32_t(points.size() - 1);
  }
  return points;
}

/// Points that lie close together and look alike.
inline std::vector<GlossyPoint> coherent_points(Random& random, std::size_t count,
                                                float most_exponent = 1e5f) {
  const GlossyPoint first = room_points(random, 1, most_exponent)[0];
  std::vector<GlossyPoint> points;
  for (std::size_t i = 0; i < count; ++i) {
    GlossyPoint p = first;
    p.position += in_cube(random, 0.05f);
    p.normal = normalize(p.normal + in_cube(random, 0.05f));
    p.mirror = normalize(p.mirror + in_cube(random, 0.05f));
    p.exponent = spread(random, std::max(1.0f, 0.3f * first.exponent), first.exponent);
    p.diffuse = any_colour(random), p.pixel = std::uint32_t(i);
    points.push_back(p);
  }
  return points;
}

/// Groups of the given sizes in turn.
inline coppice::PointGroups in_groups(std::span<const GlossyPoint> points,
                                      std::span<const std::uint32_t> sizes) {
  coppice::PointGroups groups{{points.begin(), points.end()}, {}};
  std::uint32_t end = 0;
  for (std::size_t g = 0; end < points.size(); ++g) {
    end = std::min(end + sizes[g % sizes.size()], std::uint32_t(points.size()));
    groups.ends.push_back(end);
  }
  return groups;
}

/// The VPLs below a node.
inline std::vector<VplNode> vpls_below(const coppice::VplTree& tree, std::uint32_t h) {
  const auto range = coppice::leaves_below(tree.leaf_count(), h);
  const auto leaves = tree.nodes().subspan(tree.leaf_count());
  return {leaves.begin() + range.begin, leaves.begin() + range.end};
}

/// GroupBound of one node: what it brings, and the most that its size covers.
inline std::pair<double, double> bounded(const coppice::PointBound& points, const coppice::VplBound& b,
                                         float size) {
  coppice::VplBoundLanes n;
  for (int k = 0; k < 3; ++k) {
    n.low[k] = b.low[k], n.high[k] = b.high[k];
    n.normal_low[k] = b.normal_low[k], n.normal_high[k] = b.normal_high[k];
    n.lobe_low[k] = b.lobe_low[k], n.lobe_high[k] = b.lobe_high[k];
  }
  n.slowest = b.slowest, n.peak = b.peak, n.diffuse = b.diffuse, n.softening = b.softening, n.size = size;
  const auto result = coppice::GroupBound(points)(n);
  float radiance[coppice::Lanes::width], angle[coppice::Lanes::width];
  result.radiance.store(radiance), result.angle.store(angle);
  return {double(radiance[0]), double(angle[0])};
}

inline double most(const glm::dvec3& rgb) { return std::max(rgb.x, std::max(rgb.y, rgb.z)); }
inline double luminance(const glm::dvec3& rgb) { return 0.2126 * rgb.x + 0.7152 * rgb.y + 0.0722 * rgb.z; }

}  // namespace support
