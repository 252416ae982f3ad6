// Points scattered over the surfaces of a scene, each for its share of their area.
#pragma once

#include <algorithm>
#include <coppice/core/random.hpp>
#include <coppice/scene/surface.hpp>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace coppice {

/// One side of a triangle of a mesh; the front is where its corners run counter-clockwise.
struct TriangleSide {
  std::uint32_t triangle = 0;
  bool front = true;
};

/// A point of a surface, the area that it stands for, and a colour of that area: its albedo or radiance.
struct SurfaceSample {
  vec3 position{0};
  float area = 0;  ///< m²
  vec3 normal{0};  ///< unit; geometric, on the side that is meant
  vec3 colour{0};
  TriangleSide side;
  float u = 0, v = 0;  ///< position = (1 - u - v)·p0 + u·p1 + v·p2
};

/// The sample as a ray would meet it from its side; t is 0.
inline Hit hit_of(const SurfaceSample& sample) {
  return {sample.side.triangle, sample.u, sample.v, 0, sample.side.front};
}

namespace detail {

/// Twice the area long, on the front.
inline glm::dvec3 area_normal(const Mesh& mesh, std::uint32_t triangle) {
  const uvec3 t = mesh.triangles[triangle];
  const glm::dvec3 p(mesh.positions[t.x]);
  return cross(glm::dvec3(mesh.positions[t.y]) - p, glm::dvec3(mesh.positions[t.z]) - p);
}

/// Point k of a triangle's sequence: the plastic number's additive recurrence (Roberts, "The Unreasonable
/// Effectiveness of Quasirandom Sequences", 2018), which leaves no gaps, shifted, and folded to the triangle.
inline SurfaceSample place_sample(const Mesh& mesh, TriangleSide side, const glm::dvec2& shift, double k) {
  constexpr double plastic = 1.32471795724474602596;
  glm::dvec2 uv = glm::fract(shift + k * glm::dvec2(1 / plastic, 1 / (plastic * plastic)));
  if (uv.x + uv.y > 1) uv = 1.0 - uv;
  const uvec3 t = mesh.triangles[side.triangle];
  SurfaceSample sample{.side = side, .u = float(uv.x), .v = float(uv.y)};
  sample.position = vec3((1 - uv.x - uv.y) * glm::dvec3(mesh.positions[t.x]) +
                         uv.x * glm::dvec3(mesh.positions[t.y]) + uv.y * glm::dvec3(mesh.positions[t.z]));
  sample.normal = vec3(normalize(area_normal(mesh, side.triangle))) * (side.front ? 1.0f : -1.0f);
  return sample;
}

}  // namespace detail

/// m²; of one side.
inline double triangle_area(const Mesh& mesh, std::uint32_t triangle) {
  return 0.5 * length(detail::area_normal(mesh, triangle));
}

/// The front of each triangle whose material `counts(material)`, and the back too where that is double-sided;
/// in the mesh's order, triangles without area left out.
template <class Counts>
std::vector<TriangleSide> triangle_sides(const Scene& scene, Counts&& counts) {
  std::vector<TriangleSide> sides;
  for (std::uint32_t i = 0; i < scene.mesh.triangles.size(); ++i) {
    const Material& material = scene.materials[scene.mesh.materials[i]];
    if (!counts(material) || !(triangle_area(scene.mesh, i) > 0)) continue;
    sides.push_back({i, true});
    if (material.double_sided) sides.push_back({i, false});
  }
  return sides;
}

/// How many samples a side gets: its share of the count by area, rounded up or down; or that, but one at
/// least.
enum class Shares { by_area, at_least_one };

/// Scatters `count` samples over the sides. Shares are drawn systematically: a stretch of sides whose area
/// earns k samples gets more than k - 1 and less than k + 1. Each stands for the same area, the mean; with
/// at_least_one there may be sides.size() samples more, and those of a side share exactly its area. None
/// where there is no area. Order: that of the sides.
inline std::vector<SurfaceSample> scatter_samples(const Mesh& mesh, std::span<const TriangleSide> sides,
                                                  std::size_t count, Shares shares, std::uint64_t seed) {
  double total = 0, before = 0;
  for (const TriangleSide& side : sides) total += triangle_area(mesh, side.triangle);
  std::vector<SurfaceSample> samples;
  if (count == 0 || !(total > 0)) return samples;
  samples.reserve(count + (shares == Shares::at_least_one ? sides.size() : 0));
  Random random(seed);
  const double offset = double(random.uniform()) + 0x1p-26;  // never so near to 0 or 1 that rounding decides
  for (const TriangleSide& side : sides) {
    const double area = triangle_area(mesh, side.triangle), after = before + area;
    const auto rank = [&](double a) { return std::floor(a / total * double(count) + offset); };
    double earned = rank(after) - rank(before);
    if (shares == Shares::at_least_one) earned = std::max(earned, 1.0);
    const double each = shares == Shares::at_least_one ? area / earned : total / double(count);
    const glm::dvec2 shift(random.uniform(), random.uniform());
    for (double k = 0; k < earned; ++k) {
      samples.push_back(detail::place_sample(mesh, side, shift, k));
      samples.back().area = float(each);
    }
    before = after;
  }
  return samples;
}

/// False in the holes that the material's alpha mask cuts out.
inline bool is_solid(const Scene& scene, const SurfaceSample& sample) {
  const Material& material = scene.materials[scene.mesh.materials[sample.side.triangle]];
  if (!material.alpha_mask) return true;
  float alpha = material.alpha;
  if (material.base_color_texture >= 0)
    alpha *= coppice::sample(scene.textures[std::size_t(material.base_color_texture)],
                             surface_at(scene.mesh, hit_of(sample)).uv)
                 .a;
  return alpha >= material.alpha_cutoff;
}

}  // namespace coppice
