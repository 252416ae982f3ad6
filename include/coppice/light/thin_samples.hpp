// Thins random surface samples to fewer that lie evenly.
#pragma once

#include <array>
#include <coppice/core/config.hpp>
#include <coppice/light/surface_samples.hpp>
#include <nanoflann.hpp>
#include <queue>

namespace coppice {

namespace detail {

/// Faces that are tilted by less than 30° against each other are one surface, to samples.
inline bool faces_alike(const SurfaceSample& a, const SurfaceSample& b) {
  return dot(a.normal, b.normal) > 0.866f;
}

/// Nearest samples by distance.
class SampleFinder {
 public:
  explicit SampleFinder(std::vector<vec3> points)
      : points_{std::move(points)}, tree_(3, points_, nanoflann::KDTreeSingleIndexAdaptorParams(8)) {}

  /// Indices of the nearest points, nearest first: as many as `found` holds, or all there are.
  std::span<const std::uint32_t> nearest(const vec3& p, std::span<std::uint32_t> found,
                                         std::span<float> distance2) const {
    return found.first(tree_.knnSearch(&p.x, found.size(), found.data(), distance2.data()));
  }

 private:
  struct Points {
    std::vector<vec3> values;
    std::size_t kdtree_get_point_count() const { return values.size(); }
    float kdtree_get_pt(std::size_t i, std::size_t axis) const { return values[i][int(axis)]; }
    template <class Box>
    bool kdtree_get_bbox(Box&) const {
      return false;
    }
  };
  using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Points>, Points, 3,
                                                   std::uint32_t>;
  Points points_;
  Tree tree_;
};

inline std::vector<vec3> positions_of(std::span<const SurfaceSample> samples) {
  std::vector<vec3> positions;
  positions.reserve(samples.size());
  for (const SurfaceSample& s : samples) positions.push_back(s.position);
  return positions;
}

/// The crowding of candidates and its elimination (Yuksel, "Sample Elimination for Generating Poisson Disk
/// Sample Sets", Eurographics 2015).
class Elimination {
 public:
  Elimination(std::span<const SurfaceSample> candidates, std::size_t count)
      : candidates_(candidates), alive_(candidates.size(), true) {
    double area = 0;
    for (const SurfaceSample& s : candidates) area += double(s.area);
    const double ratio = double(count) / double(candidates.size());
    farthest_ = float(2 * std::sqrt(area / (2 * std::sqrt(3.0) * double(count))));  // section 3.1: 2 r_max
    nearest_ = farthest_ * float(0.65 * (1 - std::pow(ratio, 1.5)));                // Eq. 5: 2 r_min
    find_neighbours();
  }

  /// Takes out the most crowded candidate, again and again, until `count` are left.
  std::vector<std::uint32_t> run(std::size_t count) {
    using Entry = std::pair<float, std::uint32_t>;  // crowding only falls, so an old one is an upper bound
    std::vector<Entry> entries;
    for (std::uint32_t i = 0; i < candidates_.size(); ++i) entries.emplace_back(crowding(i), i);
    std::priority_queue<Entry> queue(std::less<Entry>(), std::move(entries));
    for (std::size_t left = candidates_.size(); left > count;) {
      const auto [bound, i] = queue.top();
      queue.pop();
      if (const float now = crowding(i); now < bound)
        queue.emplace(now, i);
      else
        alive_[i] = false, --left;
    }
    std::vector<std::uint32_t> kept;
    for (std::uint32_t i = 0; i < candidates_.size(); ++i)
      if (alive_[i]) kept.push_back(i);
    return kept;
  }

 private:
  static constexpr std::size_t most_neighbours = 40;  // 18 on a plane with five candidates a sample

  void find_neighbours() {
    const SampleFinder finder(positions_of(candidates_));
    std::array<std::uint32_t, most_neighbours> found;
    std::array<float, most_neighbours> distance2;
    first_.push_back(0);
    for (std::uint32_t i = 0; i < candidates_.size(); ++i) {
      const auto near = finder.nearest(candidates_[i].position, found, distance2);
      for (std::size_t k = 0; k < near.size() && distance2[k] < farthest_ * farthest_; ++k)
        if (near[k] != i && faces_alike(candidates_[i], candidates_[near[k]]))
          neighbours_.push_back({near[k], weight(std::sqrt(distance2[k]))});
      first_.push_back(std::uint32_t(neighbours_.size()));
    }
  }

  /// Eq. 2 with α = 8.
  float weight(float distance) const {
    const float w = 1 - std::max(distance, nearest_) / farthest_, w2 = w * w, w4 = w2 * w2;
    return w4 * w4;
  }

  float crowding(std::uint32_t i) const {
    float sum = 0;
    for (std::uint32_t k = first_[i]; k < first_[i + 1]; ++k)
      if (alive_[neighbours_[k].sample]) sum += neighbours_[k].weight;
    return sum;
  }

  struct Neighbour {
    std::uint32_t sample;
    float weight;
  };
  std::span<const SurfaceSample> candidates_;
  std::vector<bool> alive_;
  float farthest_ = 0, nearest_ = 0;
  std::vector<Neighbour> neighbours_;
  std::vector<std::uint32_t> first_;  ///< in neighbours_, a candidate and one more
};

/// How ill a kept sample stands for a candidate: by distance, the more the more they are tilted against each
/// other; any that faces alike before any that does not, and of those the one that is tilted least.
inline float misfit(const SurfaceSample& candidate, const SurfaceSample& kept, float distance2) {
  const float tilt = 1 - dot(candidate.normal, kept.normal);
  return faces_alike(candidate, kept) ? distance2 * (1 + 16 * tilt) : 1e30f * tilt;
}

/// For each candidate the kept one that fits best of the 16 nearest.
inline std::vector<std::uint32_t> find_owners(std::span<const SurfaceSample> candidates,
                                              std::span<const std::uint32_t> kept) {
  std::vector<vec3> positions;
  for (const std::uint32_t k : kept) positions.push_back(candidates[k].position);
  const SampleFinder finder(std::move(positions));
  std::array<std::uint32_t, 16> found;
  std::array<float, 16> distance2;
  std::vector<std::uint32_t> owners;
  owners.reserve(candidates.size());
  for (const SurfaceSample& candidate : candidates) {
    const std::size_t near = finder.nearest(candidate.position, found, distance2).size();
    std::size_t best = 0;
    const auto cost = [&](std::size_t k) {
      return misfit(candidate, candidates[kept[found[k]]], distance2[k]);
    };
    for (std::size_t k = 1; k < near; ++k)
      if (cost(k) < cost(best)) best = k;
    owners.push_back(found[best]);
  }
  return owners;
}

/// For each cell the candidate nearest to the centroid of those that belong to it, with the area of all and
/// the mean of their colours: to a sum over the area, a midpoint rule.
inline std::vector<SurfaceSample> gather_cells(std::span<const SurfaceSample> candidates,
                                               std::span<const std::uint32_t> owners, std::size_t cells) {
  std::vector<glm::dvec4> places(cells, glm::dvec4(0)), colours(cells, glm::dvec4(0));
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const double area = double(candidates[i].area);
    places[owners[i]] += area * glm::dvec4(glm::dvec3(candidates[i].position), 1);
    colours[owners[i]] += area * glm::dvec4(glm::dvec3(candidates[i].colour), 1);
  }
  std::vector<std::uint32_t> middle(cells, std::numeric_limits<std::uint32_t>::max());
  const auto distance = [&](std::uint32_t candidate, const glm::dvec4& place) {
    return glm::distance(glm::dvec3(candidates[candidate].position), glm::dvec3(place) / place.w);
  };
  for (std::uint32_t i = 0; i < candidates.size(); ++i) {
    std::uint32_t& best = middle[owners[i]];
    if (best >= candidates.size() || distance(i, places[owners[i]]) < distance(best, places[owners[i]]))
      best = i;
  }
  std::vector<SurfaceSample> samples;
  for (std::size_t i = 0; i < cells; ++i) {
    if (!(colours[i].w > 0)) continue;  // coincides with another
    SurfaceSample& sample = samples.emplace_back(candidates[middle[i]]);
    sample.area = float(colours[i].w);
    sample.colour = vec3(glm::dvec3(colours[i]) / colours[i].w);
  }
  return samples;
}

}  // namespace detail

/// Keeps `count` of the candidates, or all where there are fewer, so that they lie evenly, by weighted sample
/// elimination; sides that face apart by more than 30° do not crowd each other. Every candidate then gives
/// its area to a kept one that is near and faces alike, and its colour to their mean: Σ area and Σ area ·
/// colour stay, to rounding. Order: that of the candidates. Best with 5 to 10 candidates a sample; how even:
/// docs/light.md. O(n log n) for n candidates.
inline std::vector<SurfaceSample> thin_samples(std::span<const SurfaceSample> candidates, std::size_t count) {
  if (count == 0) return {};
  if (candidates.size() <= count) return {candidates.begin(), candidates.end()};
  const auto kept = detail::Elimination(candidates, count).run(count);
  return detail::gather_cells(candidates, detail::find_owners(candidates, kept), kept.size());
}

}  // namespace coppice
