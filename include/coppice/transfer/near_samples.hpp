// Samples within a distance, by a grid: faster than a tree where the distance is known beforehand.
#pragma once

#include <algorithm>
#include <coppice/core/config.hpp>
#include <coppice/light/surface_samples.hpp>

namespace coppice::detail {

/// Samples sorted by the cell of a cubic grid. It refers to them; they must outlive it.
class NearSamples {
 public:
  /// reach: m, the farthest that will be asked for; above 0.
  NearSamples(std::span<const SurfaceSample> samples, float reach) : samples_(samples) {
    COPPICE_ASSERT(reach > 0);
    if (samples.empty()) return;
    vec3 high = low_ = samples[0].position;
    for (const SurfaceSample& s : samples)
      low_ = glm::min(low_, s.position), high = glm::max(high, s.position);
    const vec3 size = high - low_;
    cell_ = std::max(1.001f * reach, std::max({size.x, size.y, size.z}) / 1e6f);
    entries_.reserve(samples.size());
    for (std::uint32_t i = 0; i < samples.size(); ++i)
      entries_.push_back({key(cell_of(samples[i].position)), i});
    std::ranges::sort(entries_, {}, [](const Entry& e) { return std::pair(e.key, e.sample); });
  }

  /// Calls visit(index, distance²) for each sample not farther than `reach` from p, in an order that depends
  /// on the samples alone. Precondition: p lies in the samples' box, reach is at most the constructor's.
  template <class Visit>
  void for_each_within(const vec3& p, float reach, Visit&& visit) const {
    COPPICE_ASSERT(reach <= cell_);
    if (entries_.empty()) return;
    const glm::ivec3 at = cell_of(p);
    for (int x = std::max(0, at.x - 1); x <= at.x + 1; ++x)
      for (int y = std::max(0, at.y - 1); y <= at.y + 1; ++y)
        visit_row(key({x, y, std::max(0, at.z - 1)}), key({x, y, at.z + 1}), p, reach * reach, visit);
  }

  /// m; the farthest that may be asked for.
  float reach() const { return cell_; }

 private:
  struct Entry {
    std::uint64_t key;
    std::uint32_t sample;
  };

  glm::ivec3 cell_of(const vec3& p) const { return {(p - low_) / cell_}; }
  static std::uint64_t key(const glm::ivec3& c) {
    return std::uint64_t(c.x) << 42 | std::uint64_t(c.y) << 21 | std::uint64_t(c.z);
  }

  template <class Visit>
  void visit_row(std::uint64_t first, std::uint64_t last, const vec3& p, float reach2, Visit&& visit) const {
    for (auto e = std::ranges::lower_bound(entries_, first, {}, &Entry::key);
         e != entries_.end() && e->key <= last; ++e) {
      const vec3 way = samples_[e->sample].position - p;
      if (const float distance2 = dot(way, way); distance2 <= reach2) visit(e->sample, distance2);
    }
  }

  std::span<const SurfaceSample> samples_;
  vec3 low_{0};
  float cell_ = 0;
  std::vector<Entry> entries_;  ///< by key
};

}  // namespace coppice::detail
