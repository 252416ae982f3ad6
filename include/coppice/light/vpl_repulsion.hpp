// Points of a surface that push each other apart until they lie evenly: the paper's way to spread VPLs.
#pragma once

#include <coppice/light/thin_samples.hpp>

namespace coppice::detail {

/// Points that repel their neighbours along the surface (Filtering section 2.4), each on one of the `places`,
/// a dense set over the surface. `rooms` is the area (m²) that a point should have at each place.
class Repulsion {
 public:
  Repulsion(std::span<const SurfaceSample> places, std::span<const float> rooms,
            std::vector<std::uint32_t> points)
      : places_(places),
        rooms_(rooms),
        points_(std::move(points)),
        taken_(places.size(), false),
        finder_(positions_of(places)) {
    for (const std::uint32_t p : points_) taken_[p] = true;
  }

  /// Each point in turn is pushed by those around it, as they stand before the round, and goes to the nearest
  /// free place that faces alike.
  void push_all(float strength) {
    std::vector<vec3> positions;
    for (const std::uint32_t p : points_) positions.push_back(places_[p].position);
    const SampleFinder others(std::move(positions));
    std::vector<vec3> targets;
    for (std::uint32_t i = 0; i < points_.size(); ++i)
      targets.push_back(places_[points_[i]].position + strength * push(others, i));
    for (std::uint32_t i = 0; i < points_.size(); ++i) move(points_[i], targets[i]);
  }

  const std::vector<std::uint32_t>& points() const { return points_; }

 private:
  static constexpr std::size_t neighbours = 16;

  float reach(std::uint32_t place) const { return float(2 * even_radius(double(rooms_[place]), 1)); }

  /// In the tangent plane, metres: from each neighbour within 1.5 spacings, stronger the nearer it is.
  vec3 push(const SampleFinder& others, std::uint32_t i) const {
    const SurfaceSample& here = places_[points_[i]];
    std::array<std::uint32_t, neighbours> found;
    std::array<float, neighbours> distance2;
    const auto near = others.nearest(here.position, found, distance2, [&](std::uint32_t other) {
      return other != i && faces_alike(here, places_[points_[other]]);
    });
    vec3 sum(0);
    for (std::size_t k = 0; k < near.size(); ++k) {
      const std::uint32_t other = points_[near[k]];
      const float spacing = 0.5f * (reach(points_[i]) + reach(other)), distance = std::sqrt(distance2[k]);
      if (!(distance < 1.5f * spacing) || !(distance > 0)) continue;
      const float nearness = 1 - distance / (1.5f * spacing);
      sum += spacing * nearness * nearness * (here.position - places_[other].position) / distance;
    }
    return sum - dot(sum, here.normal) * here.normal;
  }

  void move(std::uint32_t& point, const vec3& target) {
    taken_[point] = false;
    std::uint32_t found;
    float distance2;
    const auto near = finder_.nearest(target, {&found, 1}, {&distance2, 1}, [&](std::uint32_t place) {
      return !taken_[place] && faces_alike(places_[point], places_[place]);
    });
    if (!near.empty()) point = found;
    taken_[point] = true;
  }

  std::span<const SurfaceSample> places_;
  std::span<const float> rooms_;
  std::vector<std::uint32_t> points_;
  std::vector<bool> taken_;
  SampleFinder finder_;
};

/// `count` of the places, or all where there are fewer: drawn at random, then pushed apart so that each has
/// the room (m²) that is given for it. In the order of the places. Cost: 2 · rounds searches a point.
/// Evenness by strength: best at 0.8; at 1.2 points swing to and fro, at 0.3 they stick to their places
/// (docs/light.md).
inline std::vector<std::uint32_t> repel(std::span<const SurfaceSample> places, std::span<const float> rooms,
                                        std::size_t count, std::uint64_t seed, int rounds = 16,
                                        float strength = 0.8f) {
  double total = 0, before = 0;
  for (std::size_t i = 0; i < places.size(); ++i) total += double(places[i].area) / double(rooms[i]);
  Random random(seed);
  std::vector<std::uint32_t> drawn;
  double next = double(random.uniform());
  for (std::uint32_t i = 0; i < places.size() && drawn.size() < count; ++i) {
    const double after = before + double(places[i].area) / double(rooms[i]) / total * double(count);
    if (next < after) {
      drawn.push_back(i);
      next = std::max(after, double(drawn.size()) + double(random.uniform()));
    }
    before = after;
  }
  Repulsion repulsion(places, rooms, std::move(drawn));
  for (int round = 0; round < rounds; ++round) repulsion.push_all(strength);
  std::vector<std::uint32_t> points = repulsion.points();
  std::ranges::sort(points);
  return points;
}

}  // namespace coppice::detail
