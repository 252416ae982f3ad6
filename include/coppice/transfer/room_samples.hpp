// Samples of the surfaces of a room: the candidates of particles, thinned.
#pragma once

#include <coppice/transfer/crowding.hpp>
#include <coppice/transfer/particles.hpp>

namespace coppice {

struct RoomSampleOptions {
  std::size_t count = 45000;  ///< samples wanted
  float radius = 0;           ///< m; above 0 it sets the count: samples lie about this far apart, or farther
  float curvature = 1.5f;     ///< 1 to 2: radii are divided by this where surfaces curve, docs/transfer.md
};

/// How many samples a dart throwing with this radius leaves on an area: it covers 0.547 of the area with
/// discs of half the radius (Feder 1980; the jamming limit of random sequential adsorption).
inline double samples_for_radius(double area, double radius) {
  return 0.547 * area / (double(pi) * 0.25 * radius * radius);
}

/// And the other way round.
inline double radius_for_samples(double area, double count) {
  return std::sqrt(0.547 * area / (double(pi) * 0.25 * count));
}

namespace detail {

/// Radians that normals turn on the way of a metre, mean over the neighbours that face within 60°; 0 where
/// the candidate has none. Edges between flat walls do not count.
inline float turn_at(const NearSamples& near, std::span<const SurfaceSample> candidates, std::size_t i,
                     float reach) {
  const SurfaceSample& s = candidates[i];
  float turn = 0, way = 0;
  near.for_each_within(s.position, reach, [&](std::uint32_t k, float distance2) {
    if (!(dot(s.normal, candidates[k].normal) > 0.5f)) return;
    turn += length(s.normal - candidates[k].normal);
    way += std::sqrt(distance2);
  });
  return way > 0 ? turn / way : 0;
}

/// Room (m²) for a sample at each candidate so that `count` fit on all. A spacing over which normals turn by
/// half a radian or more gets the smallest radius.
template <Executor E>
std::vector<float> rooms_by_curvature(std::span<const SurfaceSample> candidates, std::size_t count,
                                      float curvature, const E& executor) {
  std::vector<float> room(candidates.size(), 1);
  double area = 0, fit = 0;
  for (const SurfaceSample& s : candidates) area += double(s.area);
  const auto spacing = float(std::sqrt(area / double(count)));
  if (curvature > 1) {
    const NearSamples near(candidates, spacing);
    executor(candidates.size(), 1024, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const float bend = std::min(1.0f, 2 * spacing * turn_at(near, candidates, i, spacing));
        const float divisor = 1 + (curvature - 1) * bend;
        room[i] = 1 / (divisor * divisor);
      }
    });
  }
  for (std::size_t i = 0; i < room.size(); ++i) fit += double(candidates[i].area) / double(room[i]);
  for (float& r : room) r = float(double(r) * fit / double(count));
  return room;
}

/// Owners of which each faces its candidate alike, if there is one near.
template <Executor E>
std::vector<std::uint32_t> owners_facing_alike(std::span<const SurfaceSample> candidates,
                                               std::span<const std::uint32_t> kept, const E& executor) {
  return find_owners(candidates, kept, executor,
                     [&](const SampleFinder& finder, std::size_t i, auto& found, auto& distance2) {
                       const auto alike = [&](std::uint32_t k) {
                         return faces_alike(candidates[i], candidates[kept[k]]);
                       };
                       const vec3& p = candidates[i].position;
                       const auto near = finder.nearest(p, found, distance2);
                       if (std::ranges::any_of(near, alike)) return near;
                       const auto far = finder.nearest(p, found, distance2, alike);
                       return far.empty() ? finder.nearest(p, found, distance2) : far;
                     });
}

}  // namespace detail

/// Thins the candidates to samples that lie evenly on what particles reached (PCA section 4.1), closer where
/// it curves. They are candidates themselves, so on the surface; each has the area (m²) of the candidates
/// that are nearest to it and face alike, and the mean of their albedos: Σ area stays. The two sides of a
/// sheet neither crowd nor own each other. All candidates where there are fewer than wanted. Order: theirs.
/// Best with six candidates a sample or more. Same bits for any executor. Preconditions: candidates have
/// areas; 1 <= curvature <= 2. O(n log n).
template <Executor E>
std::vector<SurfaceSample> room_samples(std::span<const SurfaceSample> candidates, const E& executor,
                                        const RoomSampleOptions& options = {}) {
  COPPICE_ASSERT(options.curvature >= 1 && options.curvature <= 2);
  double area = 0;
  for (const SurfaceSample& s : candidates) area += double(s.area);
  std::size_t count = options.count;
  if (options.radius > 0)
    count = std::max<std::size_t>(1, std::size_t(samples_for_radius(area, double(options.radius)) + 0.5));
  if (count == 0 || candidates.empty()) return {};
  if (candidates.size() <= count) return {candidates.begin(), candidates.end()};
  const auto room = detail::rooms_by_curvature(candidates, count, options.curvature, executor);
  const auto kept = detail::Crowding(candidates, room, count, executor).run(count);
  const auto owners = detail::owners_facing_alike(candidates, kept, executor);
  return detail::gather_cells(candidates, owners, kept.size());
}

}  // namespace coppice
