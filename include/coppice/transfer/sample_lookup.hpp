// The sample that stands for a point of a surface.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <coppice/core/config.hpp>
#include <coppice/light/surface_samples.hpp>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace coppice {

/// Which samples may stand for a point.
struct SampleReach {
  float distance = 0;         ///< metres; farther ones may not
  float least_cosine = 0.5f;  ///< between the normals; those that are tilted more may not: in (0, 1]
};

/// The mean distance of samples, metres: √(area / count); 0 where there are none.
inline float sample_spacing(std::span<const SurfaceSample> samples) {
  double area = 0;
  for (const SurfaceSample& sample : samples) area += double(sample.area);
  return samples.empty() ? 0 : float(std::sqrt(area / double(samples.size())));
}

/// How ill a sample stands for a point, m²: distance² · (1 + 16·tilt), tilt = 1 - cos between the normals, so
/// that at a rounded edge the side that faces alike wins; infinity where it may not.
inline float sample_misfit(const vec3& position, const vec3& normal, const vec3& point,
                           const vec3& point_normal, const SampleReach& reach) {
  const vec3 across = point - position;
  const float distance2 = dot(across, across), cosine = dot(normal, point_normal);
  if (!(cosine >= reach.least_cosine) || !(distance2 <= reach.distance * reach.distance))
    return std::numeric_limits<float>::infinity();
  return distance2 * (1 + 16 * std::max(0.0f, 1 - cosine));
}

namespace detail {

/// Points hashed into cells: each cell lists all points within a margin of it, in their order.
class HashedCells {
 public:
  HashedCells(std::span<const vec3> points, float side, float margin);

  /// Those within the margin of p, and others near it. Ascending.
  std::span<const std::uint32_t> near(const vec3& p) const {
    const vec3 at = (p - low_) * inverse_side_;
    if (!(std::min({at.x, at.y, at.z}) >= 0 && std::max({at.x, at.y, at.z}) < most_cells)) return {};
    const std::uint64_t key = key_of(std::uint32_t(at.x), std::uint32_t(at.y), std::uint32_t(at.z));
    for (std::size_t slot = slot_of(key); slots_[slot].count > 0; slot = (slot + 1) & (slots_.size() - 1))
      if (slots_[slot].key == key) return std::span(points_).subspan(slots_[slot].first, slots_[slot].count);
    return {};
  }

 private:
  struct Slot {
    std::uint64_t key = 0;
    std::uint32_t first = 0, count = 0;
  };
  using Entry = std::pair<std::uint64_t, std::uint32_t>;  // a cell's key, a point

  static constexpr float most_cells = 0x1p20f;  // an axis

  static std::uint64_t key_of(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    return (std::uint64_t(x) << 40) | (std::uint64_t(y) << 20) | z;
  }
  std::size_t slot_of(std::uint64_t key) const {
    return std::size_t((key * 0x9e3779b97f4a7c15u) >> 32) & (slots_.size() - 1);
  }
  void add_cells(std::vector<Entry>& entries, std::uint32_t index, const vec3& point, float margin) const;
  void fill_slots(const std::vector<Entry>& entries);

  vec3 low_{0};
  float side_, inverse_side_ = 0;
  std::vector<Slot> slots_ = std::vector<Slot>(1);  ///< a power of two, half of them empty at least
  std::vector<std::uint32_t> points_;
};

inline HashedCells::HashedCells(std::span<const vec3> points, float side, float margin) : side_(side) {
  if (points.empty()) return;
  vec3 high = low_ = points[0];
  for (const vec3& p : points) low_ = glm::min(low_, p), high = glm::max(high, p);
  const vec3 size = high - low_;
  const float extent = std::max({size.x, size.y, size.z}),
              largest = std::max(glm::length(low_), glm::length(high));
  margin = 1.0001f * margin + 1e-6f * largest;  // whatever rounding says of the cell that a point lies in
  low_ -= 1.01f * margin;
  side_ = std::max(side, 1.1f * (extent + 3 * margin) / most_cells);
  inverse_side_ = 1 / side_;
  std::vector<Entry> entries;
  for (std::uint32_t i = 0; i < points.size(); ++i) add_cells(entries, i, points[i], margin);
  std::ranges::sort(entries);
  fill_slots(entries);
}

inline void HashedCells::add_cells(std::vector<Entry>& entries, std::uint32_t index, const vec3& point,
                                   float margin) const {
  const auto first = uvec3(glm::max((point - margin - low_) * inverse_side_, 0.0f));
  const auto last = uvec3(glm::max((point + margin - low_) * inverse_side_, 0.0f));
  for (std::uint32_t x = first.x; x <= last.x; ++x)
    for (std::uint32_t y = first.y; y <= last.y; ++y)
      for (std::uint32_t z = first.z; z <= last.z; ++z) {
        const vec3 corner = low_ + side_ * vec3(x, y, z);
        const vec3 apart = point - glm::clamp(point, corner, corner + side_);
        if (dot(apart, apart) <= margin * margin) entries.emplace_back(key_of(x, y, z), index);
      }
}

inline void HashedCells::fill_slots(const std::vector<Entry>& entries) {
  std::size_t cells = 0;
  for (std::size_t i = 0; i < entries.size(); ++i)
    cells += i == 0 || entries[i].first != entries[i - 1].first;
  slots_.assign(std::bit_ceil(2 * cells + 1), {});
  for (std::size_t begin = 0, end = 0; begin < entries.size(); begin = end) {
    while (end < entries.size() && entries[end].first == entries[begin].first) ++end;
    std::size_t slot = slot_of(entries[begin].first);
    while (slots_[slot].count > 0) slot = (slot + 1) & (slots_.size() - 1);
    slots_[slot] = {entries[begin].first, std::uint32_t(begin), std::uint32_t(end - begin)};
  }
  points_.reserve(entries.size());
  for (const Entry& entry : entries) points_.push_back(entry.second);
}

}  // namespace detail

/// Finds the sample that stands for a point of a surface: the one of least sample_misfit, the first of
/// equals; so light does not bleed through thin walls or round corners. Two grids: small cells answer most
/// queries, cells of the reach the rest. Copies what it needs of the samples.
class SampleLookup {
 public:
  SampleLookup(std::span<const SurfaceSample> samples, const SampleReach& reach)
      : SampleLookup(samples, reach, std::min(reach.distance, sample_spacing(samples))) {}

  /// `normal` is the unit geometric one on the side that is meant. None where no sample may stand for it.
  std::optional<std::uint32_t> nearest(const vec3& point, const vec3& normal) const {
    Best best = best_of(fine_.near(point), point, normal);
    if (!(best.misfit <= certain_)) best = best_of(coarse_.near(point), point, normal);
    if (best.misfit == std::numeric_limits<float>::infinity()) return std::nullopt;
    return best.sample;
  }

 private:
  struct Place {
    vec3 position, normal;
  };
  struct Best {
    std::uint32_t sample = 0;
    float misfit = std::numeric_limits<float>::infinity();
  };

  SampleLookup(std::span<const SurfaceSample> samples, const SampleReach& reach, float spacing);

  Best best_of(std::span<const std::uint32_t> among, const vec3& point, const vec3& normal) const {
    Best best;
    for (const std::uint32_t i : among) {
      const float misfit = sample_misfit(places_[i].position, places_[i].normal, point, normal, reach_);
      if (misfit < best.misfit) best = {i, misfit};
    }
    return best;
  }
  static std::vector<vec3> positions(std::span<const SurfaceSample> samples) {
    std::vector<vec3> result;
    for (const SurfaceSample& sample : samples) result.push_back(sample.position);
    return result;
  }

  SampleReach reach_;
  float certain_;  ///< no sample that the small cells leave out can fit better than this, m²
  std::vector<Place> places_;
  detail::HashedCells fine_, coarse_;
};

inline SampleLookup::SampleLookup(std::span<const SurfaceSample> samples, const SampleReach& reach,
                                  float spacing)
    : reach_(reach),
      certain_(spacing * spacing),
      fine_(positions(samples), spacing, spacing),
      coarse_(positions(samples), reach.distance, reach.distance) {
  COPPICE_ASSERT(reach.distance > 0 && reach.least_cosine > 0);
  for (const SurfaceSample& sample : samples) places_.push_back({sample.position, sample.normal});
}

}  // namespace coppice
