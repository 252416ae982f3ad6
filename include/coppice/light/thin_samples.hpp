// Thins random surface samples to fewer that lie evenly.
#pragma once

#include <array>
#include <coppice/core/config.hpp>
#include <coppice/core/parallel.hpp>
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

  /// The same of those points that are `wanted(index)`. Looks at 1,024 points at most: where wanted ones
  /// are rare it may find fewer, or others than the nearest.
  template <class Wanted>
  std::span<const std::uint32_t> nearest(const vec3& p, std::span<std::uint32_t> found,
                                         std::span<float> distance2, Wanted&& wanted) const {
    Choosy<Wanted> results{nanoflann::KNNResultSet<float, std::uint32_t>(found.size()), wanted};
    results.all.init(found.data(), distance2.data());
    tree_.findNeighbors(results, &p.x, nanoflann::SearchParams());
    return found.first(results.size());
  }

 private:
  /// What the tree's search asks of results, wanted ones only.
  template <class Wanted>
  struct Choosy {
    nanoflann::KNNResultSet<float, std::uint32_t> all;
    Wanted& wanted;
    int left = 1024;
    bool addPoint(float distance2, std::uint32_t i) {
      if (wanted(i)) all.addPoint(distance2, i);
      return --left > 0;
    }
    float worstDist() const { return all.worstDist(); }
    bool full() const { return all.full(); }
    std::size_t size() const { return all.size(); }
  };
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

/// Half the distance of `samples` that lie as evenly as can be on `area` (Yuksel 2015, section 3.1: r_max).
inline double even_radius(double area, double samples) {
  return std::sqrt(area / (2 * std::sqrt(3.0) * samples));
}

/// The crowding of candidates and its elimination (Yuksel, "Sample Elimination for Generating Poisson Disk
/// Sample Sets", Eurographics 2015).
class Elimination {
 public:
  /// Towards samples that lie alike everywhere. Candidates know the nearest forty of all.
  Elimination(std::span<const SurfaceSample> candidates, std::size_t count) : Elimination(candidates) {
    double area = 0;
    for (const SurfaceSample& s : candidates) area += double(s.area);
    reach_.assign(candidates.size(), float(2 * even_radius(area, double(count))));
    find_neighbours(count, [](const SampleFinder& finder, const vec3& p, auto& found, auto& distance2,
                              std::uint32_t) { return finder.nearest(p, found, distance2); });
  }

  /// Towards samples of which each has the room (m²) that is given at the candidates. They should lie so too.
  /// Candidates know the nearest forty of those that face alike: sheets may be sparse on one side only.
  Elimination(std::span<const SurfaceSample> candidates, std::span<const float> room, std::size_t count)
      : Elimination(candidates) {
    for (const float each : room) reach_.push_back(float(2 * even_radius(double(each), 1)));
    find_neighbours(count, [this](const SampleFinder& finder, const vec3& p, auto& found, auto& distance2,
                                  std::uint32_t i) {
      return finder.nearest(p, found, distance2, [&](std::uint32_t other) {
        return faces_alike(candidates_[i], candidates_[other]);
      });
    });
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

  explicit Elimination(std::span<const SurfaceSample> candidates)
      : candidates_(candidates), alive_(candidates.size(), true) {}

  template <class Search>
  void find_neighbours(std::size_t count, Search&& search) {
    const SampleFinder finder(positions_of(candidates_));
    const double ratio = double(count) / double(candidates_.size());
    const auto nearest = float(0.65 * (1 - std::pow(ratio, 1.5)));  // Eq. 5: r_min / r_max
    std::array<std::uint32_t, most_neighbours> found;
    std::array<float, most_neighbours> distance2;
    first_.push_back(0);
    for (std::uint32_t i = 0; i < candidates_.size(); ++i) {
      const auto near = search(finder, candidates_[i].position, found, distance2, i);
      for (std::size_t k = 0; k < near.size(); ++k) {
        const float reach = 0.5f * (reach_[i] + reach_[near[k]]);
        if (near[k] == i || !(distance2[k] < reach * reach)) continue;
        if (faces_alike(candidates_[i], candidates_[near[k]]))
          neighbours_.push_back({near[k], weight(std::sqrt(distance2[k]), reach * nearest, reach)});
      }
      first_.push_back(std::uint32_t(neighbours_.size()));
    }
  }

  /// Eq. 2 with α = 8.
  static float weight(float distance, float nearest, float farthest) {
    const float w = 1 - std::max(distance, nearest) / farthest, w2 = w * w, w4 = w2 * w2;
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
  std::vector<float> reach_;  ///< 2 r_max, by candidate
  std::vector<Neighbour> neighbours_;
  std::vector<std::uint32_t> first_;  ///< in neighbours_, a candidate and one more
};

/// How ill a kept sample stands for a candidate: by distance, the more the more they are tilted against each
/// other; any that faces alike before any that does not, and of those the one that is tilted least.
inline float misfit(const SurfaceSample& candidate, const SurfaceSample& kept, float distance2) {
  const float tilt = 1 - dot(candidate.normal, kept.normal);
  return faces_alike(candidate, kept) ? distance2 * (1 + 16 * tilt) : 1e30f * tilt;
}

/// For each candidate the kept one that fits best of those, 1 to 16, that search(finder, its index, found,
/// distances²) finds.
template <class Search, Executor E>
std::vector<std::uint32_t> find_owners(std::span<const SurfaceSample> candidates,
                                       std::span<const std::uint32_t> kept, const E& executor,
                                       Search&& search) {
  std::vector<vec3> positions;
  for (const std::uint32_t k : kept) positions.push_back(candidates[k].position);
  const SampleFinder finder(std::move(positions));
  std::vector<std::uint32_t> owners(candidates.size());
  executor(candidates.size(), 1024, [&](std::size_t begin, std::size_t end) {
    std::array<std::uint32_t, 16> found;
    std::array<float, 16> distance2;
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t near = search(finder, i, found, distance2).size();
      std::size_t best = 0;
      const auto cost = [&](std::size_t k) {
        return misfit(candidates[i], candidates[kept[found[k]]], distance2[k]);
      };
      for (std::size_t k = 1; k < near; ++k)
        if (cost(k) < cost(best)) best = k;
      owners[i] = found[best];
    }
  });
  return owners;
}

/// Of the 16 nearest, whatever they face.
inline std::vector<std::uint32_t> find_owners(std::span<const SurfaceSample> candidates,
                                              std::span<const std::uint32_t> kept) {
  return find_owners(candidates, kept, Serial(),
                     [&](const SampleFinder& finder, std::size_t i, auto& found, auto& distance2) {
                       return finder.nearest(candidates[i].position, found, distance2);
                     });
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
