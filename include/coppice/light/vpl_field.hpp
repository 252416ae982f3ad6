// How densely VPLs are to lie on the surfaces of a scene: by area, or as light arrives.
#pragma once

#include <coppice/light/direct_irradiance.hpp>
//
#include <coppice/core/parallel.hpp>
#include <coppice/light/bounce.hpp>
#include <coppice/light/thin_samples.hpp>
#include <map>

namespace coppice {

/// What the number of VPLs on each m² follows.
enum class VplDensity {
  area,             ///< alike everywhere
  root_irradiance,  ///< the root of the luminance of the direct light that arrives
  irradiance        ///< that luminance
};

/// How VPLs are made to lie evenly.
enum class VplSpread {
  elimination,  ///< the most crowded candidates leave: `thin_samples`
  repulsion     ///< points push each other apart along the surface (Filtering section 2.4): `repel`
};

struct VplOptions {
  std::size_t count = 16384;  ///< VPLs at most (Filtering section 2.4)
  VplDensity density = VplDensity::root_irradiance;
  VplSpread spread = VplSpread::elimination;
  std::uint64_t seed = 0;
};

namespace detail {

/// Puts a sample where its triangle and barycentric coordinates say; a triangle without area leaves the
/// normal.
inline void put_on(const Mesh& mesh, SurfaceSample& sample) {
  const uvec3 t = mesh.triangles[sample.side.triangle];
  const double u = double(sample.u), v = double(sample.v);
  sample.position = vec3((1 - u - v) * glm::dvec3(mesh.positions[t.x]) + u * glm::dvec3(mesh.positions[t.y]) +
                         v * glm::dvec3(mesh.positions[t.z]));
  const glm::dvec3 normal = area_normal(mesh, sample.side.triangle);
  if (const double size = length(normal); size > 0)
    sample.normal = vec3(normal / size) * (sample.side.front ? 1.0f : -1.0f);
}

}  // namespace detail

}  // namespace coppice

namespace coppice::detail::inline HWY_NAMESPACE {

/// The least density of VPLs over the mean: what is dark now may be lit later, or by the first bounce.
inline constexpr float least_vpl_density = 0.1f;

/// Points for each VPL: those that tell the mean density and its peaks; those that make up its cell, where
/// the density is as high as anywhere on its side of a triangle; and at most on average.
inline constexpr std::size_t vpl_pilots = 8, vpl_cell_points = 8, most_vpl_points = 64;

/// What the density of VPLs follows, at each point: a power of the luminance of its direct light, judged by
/// sixteen rays. Their noise costs evenness only. 1 everywhere where the area counts.
template <Occluder O, Executor E>
std::vector<float> judge_light(std::span<const SurfaceSample> points, std::span<const LocalLight> lights,
                               const O& occluder, const E& executor, const VplOptions& options) {
  std::vector<float> judged(points.size(), 1);
  if (options.density == VplDensity::area) return judged;
  const DirectIrradiance direct(lights, 16);
  executor(points.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Random random(Random(options.seed + i).bits());
      const vec3 irradiance = direct.at(occluder, ray_origin(points[i]), points[i].normal, random);
      const float arriving = std::min(luminance(irradiance), 1e30f);
      judged[i] = options.density == VplDensity::irradiance ? arriving : std::sqrt(arriving);
    }
  });
  return judged;
}

inline double mean_of(std::span<const float> values) {
  double sum = 0;
  for (const float value : values) sum += double(value);
  return values.empty() ? 0 : sum / double(values.size());
}

/// In units of the mean, at least least_vpl_density; 1 where nothing is lit.
inline void scale_densities(std::span<float> judged, double mean) {
  for (float& d : judged) d = mean > 0 ? std::max(least_vpl_density, float(double(d) / mean)) : 1.0f;
}

/// The least power of two that is not below `density`.
inline float rounded_up(float density) { return std::exp2(std::ceil(std::log2(density))); }

/// For each side the highest density of the pilots on it and of the eight nearest to its centroid, whatever
/// they face; rounded up to few values. `pilots` in the order of the sides.
template <Executor E>
std::vector<float> peak_densities(const Mesh& mesh, std::span<const TriangleSide> sides,
                                  std::span<const SurfaceSample> pilots, std::span<const float> densities,
                                  const E& executor) {
  std::vector<float> peaks(sides.size());
  const SampleFinder finder(positions_of(pilots));
  executor(sides.size(), 1024, [&](std::size_t begin, std::size_t end) {
    std::array<std::uint32_t, 8> found;
    std::array<float, 8> distance2;
    for (std::size_t i = begin; i < end; ++i) {
      SurfaceSample centre{.side = sides[i], .u = 1.0f / 3, .v = 1.0f / 3};
      put_on(mesh, centre);
      for (const std::uint32_t p : finder.nearest(centre.position, found, distance2))
        peaks[i] = std::max(peaks[i], densities[p]);
    }
  });
  std::size_t side = 0;
  for (std::size_t i = 0; i < pilots.size(); ++i) {
    const TriangleSide on = pilots[i].side;
    while (sides[side].triangle != on.triangle || sides[side].front != on.front) ++side;
    peaks[side] = std::max(peaks[side], densities[i]);
  }
  for (float& peak : peaks) peak = rounded_up(peak);
  return peaks;
}

/// Points over all sides, of which each stands for its area, and the density of VPLs that is wanted there.
struct VplField {
  std::vector<SurfaceSample> points;
  std::vector<float> densities;
};

/// Scatters `count` points, systematically, each side's share by its area times its rate; the sides of one
/// rate after those of another, so that the area of each rate is kept to one point's.
inline VplField scatter_at_rates(const Mesh& mesh, std::span<const TriangleSide> sides,
                                 std::span<const float> rates, std::size_t count, std::uint64_t seed) {
  std::map<float, std::vector<std::uint32_t>> by_rate;
  double total = 0, before = 0;
  for (std::uint32_t i = 0; i < sides.size(); ++i) {
    by_rate[rates[i]].push_back(i);
    total += double(rates[i]) * triangle_area(mesh, sides[i].triangle);
  }
  VplField field;
  Random random(seed);
  const double offset = double(random.uniform()) + 0x1p-26;
  const auto rank = [&](double earned) { return std::floor(earned / total * double(count) + offset); };
  for (const auto& [rate, members] : by_rate)
    for (const std::uint32_t i : members) {
      const double after = before + double(rate) * triangle_area(mesh, sides[i].triangle);
      const glm::dvec2 shift(random.uniform(), random.uniform());
      for (double k = 0; k < rank(after) - rank(before); ++k) {
        field.points.push_back(place_sample(mesh, sides[i], shift, k));
        field.points.back().area = float(total / double(count) / double(rate));
        field.densities.push_back(rate);
      }
      before = after;
    }
  return field;
}

/// How many points give each VPL `vpl_cell_points` on the sides where its density is the peak, if the mean
/// over all is `mean`. Peaks come down until that is not too many.
inline std::size_t field_size(const Mesh& mesh, std::span<const TriangleSide> sides, std::span<float> peaks,
                              double mean, std::size_t count) {
  double total = 0, wanted = 0;
  for (const TriangleSide& side : sides) total += triangle_area(mesh, side.triangle);
  for (float cap = *std::ranges::max_element(peaks);; cap *= 0.5f) {
    wanted = 0;
    for (std::size_t i = 0; i < sides.size(); ++i) {
      peaks[i] = std::min(peaks[i], cap);
      wanted += double(peaks[i]) * triangle_area(mesh, sides[i].triangle) / (mean * total);
    }
    if (wanted * double(vpl_cell_points) <= double(most_vpl_points)) break;
  }
  return std::size_t(std::ceil(wanted * double(vpl_cell_points * count)));
}

/// Without the points of density 0, which lie in holes.
inline VplField solid_part(const VplField& field) {
  VplField solid;
  for (std::size_t i = 0; i < field.points.size(); ++i) {
    if (field.densities[i] == 0) continue;
    solid.points.push_back(field.points[i]);
    solid.densities.push_back(field.densities[i]);
  }
  return solid;
}

/// The points of which VPLs and their cells are made, holes left out. Empty where there is no area.
template <Occluder O, Executor E>
VplField vpl_field(const Scene& scene, std::span<const LocalLight> lights, const O& occluder,
                   const E& executor, const VplOptions& options) {
  const auto sides = triangle_sides(scene, [](const Material&) { return true; });
  if (sides.empty()) return {};
  const auto pilots =
      scatter_samples(scene.mesh, sides, vpl_pilots * options.count, Shares::by_area, options.seed);
  auto densities = judge_light(std::span<const SurfaceSample>(pilots), lights, occluder, executor, options);
  const double mean = mean_of(densities);
  scale_densities(densities, mean);
  auto peaks = peak_densities(scene.mesh, sides, pilots, densities, executor);
  const std::size_t size = field_size(scene.mesh, sides, peaks, mean_of(densities), options.count);
  VplField field = scatter_at_rates(scene.mesh, sides, peaks, size, options.seed);
  auto wanted =
      judge_light(std::span<const SurfaceSample>(field.points), lights, occluder, executor, options);
  scale_densities(wanted, mean);
  for (std::size_t i = 0; i < field.points.size(); ++i)
    field.densities[i] = is_solid(scene, field.points[i]) ? std::min(field.densities[i], wanted[i]) : 0;
  return solid_part(field);
}

}  // namespace coppice::detail::inline HWY_NAMESPACE
