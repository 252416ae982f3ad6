// How well samples cover what particles reach.
#pragma once

#include <coppice/transfer/clustered_samples.hpp>
#include <coppice/transfer/particles.hpp>

namespace coppice {

/// Numbers for a report. Distances are to the nearest sample that faces within 30°, over the spacing
/// √(area/samples); a hexagonal lattice has 1.075 throughout.
struct CoverageReport {
  std::size_t samples = 0;
  double area = 0;     ///< m², Σ over the samples
  double spacing = 0;  ///< m
  double nearest_mean = 0, nearest_deviation = 0, nearest_min = 0, nearest_max = 0;
  double beyond_radius = 0;  ///< share of fresh hits farther than the radius from every sample
  std::size_t candidates = 0, traced = 0, escaped = 0, stray = 0;
  std::size_t clusters = 0, smallest_cluster = 0, median_cluster = 0, largest_cluster = 0;
};

namespace detail {

/// Distance (m) from s to the nearest sample that faces alike, but not `own`; infinite where there is none.
inline float nearest_alike(const SampleFinder& finder, std::span<const SurfaceSample> samples,
                           const SurfaceSample& s, std::size_t own) {
  std::array<std::uint32_t, 1> found;
  std::array<float, 1> distance2;
  const auto near = finder.nearest(s.position, found, distance2,
                                   [&](std::uint32_t k) { return k != own && faces_alike(s, samples[k]); });
  return near.empty() ? std::numeric_limits<float>::infinity() : std::sqrt(distance2[0]);
}

template <Executor E>
std::vector<float> nearest_samples(std::span<const SurfaceSample> samples,
                                   std::span<const SurfaceSample> points, bool same, const E& executor) {
  const SampleFinder finder(positions_of(samples));
  std::vector<float> distances(points.size());
  executor(points.size(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      distances[i] = nearest_alike(finder, samples, points[i], same ? i : samples.size());
  });
  return distances;
}

/// Of those that have a neighbour.
inline void set_spread(CoverageReport& report, std::span<const float> distances) {
  double sum = 0, sum2 = 0, count = 0;
  report.nearest_min = std::numeric_limits<double>::infinity();
  for (const float d : distances) {
    if (std::isinf(d)) continue;
    const double x = double(d) / report.spacing;
    sum += x, sum2 += x * x, ++count;
    report.nearest_min = std::min(report.nearest_min, x);
    report.nearest_max = std::max(report.nearest_max, x);
  }
  if (count == 0) report.nearest_min = 0;
  if (count > 0) report.nearest_mean = sum / count;
  if (count > 0)
    report.nearest_deviation =
        std::sqrt(std::max(0.0, sum2 / count - report.nearest_mean * report.nearest_mean));
}

}  // namespace detail

/// Looks at samples beside the particles that they come from and `fresh` ones, traced with another seed.
/// radius: m. Cost: a search a sample and a fresh hit. All zero without samples, but beyond_radius 1.
template <Executor E>
CoverageReport coverage(const ClusteredSamples& clustered, const ParticleField& field,
                        std::span<const SurfaceSample> fresh, float radius, const E& executor) {
  CoverageReport report{.samples = clustered.size(),
                        .candidates = field.candidates.size(),
                        .traced = field.traced,
                        .escaped = field.escaped,
                        .stray = field.stray,
                        .clusters = clustered.cluster_count()};
  if (report.samples == 0) return report.beyond_radius = 1, report;
  for (const SurfaceSample& s : clustered.samples) report.area += double(s.area);
  report.spacing = std::sqrt(report.area / double(report.samples));
  detail::set_spread(report, detail::nearest_samples(clustered.samples, clustered.samples, true, executor));
  const auto far = detail::nearest_samples(clustered.samples, fresh, false, executor);
  if (!far.empty())
    report.beyond_radius =
        double(std::ranges::count_if(far, [&](float d) { return d > radius; })) / double(far.size());
  std::vector<std::size_t> sizes;
  for (std::size_t c = 0; c < report.clusters; ++c) sizes.push_back(clustered.size(c));
  std::ranges::sort(sizes);
  report.smallest_cluster = sizes.front(), report.largest_cluster = sizes.back();
  report.median_cluster = sizes[sizes.size() / 2];
  return report;
}

}  // namespace coppice
