// Where the virtual point lights (VPLs) of a scene lie: spread evenly, or as densely as light arrives.
#pragma once

#include <coppice/light/vpl_field.hpp>
//
#include <coppice/light/vpl_repulsion.hpp>

namespace coppice {

/// Carries VPLs from the mesh on which they lie, `rest`, to a pose of it: positions and normals by triangle
/// and barycentric coordinates, areas in proportion to the triangle's. Place them once, and follow with a
/// copy for each pose: then the pose `rest` gives the same bits. Where a triangle of the pose has no area the
/// VPL gets none, and keeps its normal; one without area at rest stays so. Precondition: both meshes have the
/// VPLs' triangles.
inline void follow(std::span<SurfaceSample> vpls, const Mesh& rest, const Mesh& posed) {
  for (SurfaceSample& vpl : vpls) {
    COPPICE_ASSERT(vpl.side.triangle < rest.triangles.size() && vpl.side.triangle < posed.triangles.size());
    const double before = triangle_area(rest, vpl.side.triangle),
                 after = triangle_area(posed, vpl.side.triangle);
    detail::put_on(posed, vpl);
    vpl.area = before > 0 && after > 0 ? float(double(vpl.area) * (after / before)) : 0.0f;
  }
}

namespace detail {

/// Of the field's points, systematically by area times density, `candidates_a_sample` times as many as there
/// will be VPLs.
inline std::vector<std::uint32_t> draw_vpl_candidates(const VplField& field, std::size_t count,
                                                      std::uint64_t seed) {
  double total = 0, sum = 0;
  for (std::size_t i = 0; i < field.points.size(); ++i)
    total += double(field.points[i].area) * double(field.densities[i]);
  const double step = total / double(candidates_a_sample * count);
  double next = step * (double(Random(seed).uniform()) + 0x1p-26);
  std::vector<std::uint32_t> drawn;
  for (std::uint32_t i = 0; i < field.points.size(); ++i) {
    sum += double(field.points[i].area) * double(field.densities[i]);
    if (next >= sum) continue;
    drawn.push_back(i);
    while (next < sum) next += step;
  }
  return drawn;
}

/// m² that a VPL has at each point of the field, if there are `count`.
inline std::vector<float> vpl_rooms(const VplField& field, std::size_t count) {
  double total = 0;
  for (std::size_t i = 0; i < field.points.size(); ++i)
    total += double(field.points[i].area) * double(field.densities[i]);
  std::vector<float> rooms;
  rooms.reserve(field.points.size());
  for (const float density : field.densities)
    rooms.push_back(float(total / (double(count) * double(density))));
  return rooms;
}

/// The points of the field that are left when the most crowded of its candidates have gone.
inline std::vector<std::uint32_t> eliminate_vpls(const VplField& field, std::span<const float> rooms,
                                                 const VplOptions& options) {
  const auto drawn = draw_vpl_candidates(field, options.count, options.seed);
  std::vector<SurfaceSample> candidates;
  std::vector<float> room;
  for (const std::uint32_t i : drawn) candidates.push_back(field.points[i]), room.push_back(rooms[i]);
  if (candidates.size() <= options.count) return drawn;
  auto kept = Elimination(candidates, room, options.count).run(options.count);
  for (std::uint32_t& k : kept) k = drawn[k];
  return kept;
}

/// For each point of the field the VPL to which its area goes: the one that fits best of the 16 nearest that
/// face alike, have a density within a factor of four, and are not far, in their own spacing. Where none is,
/// of the nearest of such density; so dark surfaces that are too small for a VPL do not feed bright ones.
template <Executor E>
std::vector<std::uint32_t> find_vpl_owners(const VplField& field, std::span<const float> rooms,
                                           std::span<const std::uint32_t> kept, const E& executor) {
  const auto search = [&](const SampleFinder& finder, std::size_t i, auto& found, auto& distance2) {
    const SurfaceSample& here = field.points[i];
    const auto similar = [&](std::uint32_t k) {
      const float ratio = field.densities[kept[k]] / field.densities[i];
      return ratio <= 4 && ratio >= 0.25f;
    };
    auto near = finder.nearest(here.position, found, distance2, [&](std::uint32_t k) {
      const vec3 apart = field.points[kept[k]].position - here.position;
      return similar(k) && faces_alike(here, field.points[kept[k]]) &&
             dot(apart, apart) < 16 * rooms[kept[k]];
    });
    if (near.empty()) near = finder.nearest(here.position, found, distance2, similar);
    return near.empty() ? finder.nearest(here.position, found, distance2) : near;
  };
  return find_owners(field.points, kept, executor, search);
}

}  // namespace detail

}  // namespace coppice

namespace coppice::inline HWY_NAMESPACE {

/// Places at most `count` VPLs on both sides of double-sided materials and the fronts of the others, shining
/// ones too; holes of alpha masks take none. Their areas are those of their cells: Σ area is the surface's to
/// 0.1%, less the holes, and Σ area · f is near the integral of f for any density, as each VPL is the point
/// of its cell that is nearest to the centroid. The density follows the direct light of `lights` as the
/// options say, but for a floor of a tenth of its mean; where none arrives anywhere, it is the area's.
/// Colours are unused. The order means nothing, but is the same, bit for bit, for any executor. Errors and
/// times: docs/light.md. Cost: 16 rays for each of 20 to 70 points a VPL, 10 with VplDensity::area, which
/// needs no rays, and as many searches for near VPLs.
template <Occluder O, Executor E>
std::vector<SurfaceSample> place_vpls(const Scene& scene, std::span<const LocalLight> lights,
                                      const O& occluder, const E& executor, const VplOptions& options) {
  if (options.count == 0) return {};
  const detail::VplField field = detail::vpl_field(scene, lights, occluder, executor, options);
  if (field.points.empty()) return {};
  const std::vector<float> rooms = detail::vpl_rooms(field, options.count);
  const auto kept = options.spread == VplSpread::repulsion
                        ? detail::repel(field.points, rooms, options.count, options.seed)
                        : detail::eliminate_vpls(field, rooms, options);
  const auto owners = detail::find_vpl_owners(field, rooms, kept, executor);
  auto vpls = detail::gather_cells(field.points, owners, kept.size());
  for (SurfaceSample& vpl : vpls) detail::put_on(scene.mesh, vpl);
  return vpls;
}

}  // namespace coppice::inline HWY_NAMESPACE
