// Fixed directions spread over the hemisphere or the sphere, and those nearest to any other direction.
#pragma once

#include <algorithm>
#include <array>
#include <coppice/core/config.hpp>
#include <coppice/light/directions.hpp>
#include <coppice/sg/octahedron.hpp>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace coppice {

/// Where directions lie: over all of the sphere, or over the half of it around +Y.
enum class Dome : std::uint8_t { hemisphere, sphere };

/// `count` directions on the spherical Fibonacci lattice (those of even_directions; on the hemisphere the
/// upper half of twice as many), and a table that finds the four nearest to any direction: the octahedral
/// square is cut into cells, each with a list of all directions that can be among the four nearest to one of
/// its points, about 7 long for 2,016. A second table holds the four nearest to the middle of each cell, for
/// look-ups in one read. All tables are flat arrays, as a shader would read them.
class DirectionGrid {
 public:
  /// The indices of four directions, the nearest first.
  using Four = std::array<std::uint16_t, 4>;

  /// Precondition: 4 <= count < 65536. O(count · cells): 0.6 s for 4,032 over the sphere.
  explicit DirectionGrid(std::uint32_t count = 2016, Dome dome = Dome::hemisphere) : dome_(dome) {
    COPPICE_ASSERT(count >= 4 && count < 65536);
    directions_ = even_directions(dome == Dome::sphere ? count : 2 * count);
    directions_.resize(count);
    while (side_ * side_ < (dome == Dome::sphere ? 8 : 16) * count) side_ *= 2;
    ends_.reserve(side_ * side_);
    fours_.resize(side_ * side_);
    for (std::uint32_t y = 0; y < side_; ++y)
      for (std::uint32_t x = 0; x < side_; ++x) append_cell(x, y);
  }

  Dome dome() const { return dome_; }
  std::size_t size() const { return directions_.size(); }
  /// Unit, +Y the dome's middle.
  std::span<const vec3> directions() const { return directions_; }

  /// The four directions nearest to the unit direction d; of equally near ones those of lower index. On the
  /// hemisphere d.y >= 0. Exact but for directions whose cosines differ by less than rounding.
  Four nearest(const vec3& d) const {
    Four best{};
    std::array<float, 4> cosines{-2, -2, -2, -2};
    for (const std::uint16_t i : candidates(d)) insert(i, dot(directions_[i], d), best, cosines);
    return best;
  }

  /// The four directions nearest to the middle of the cell that d falls into: those nearest to d but where
  /// others are nearly as near, by less than the cell's width, a third of the directions' spacing.
  const Four& nearly_nearest(const vec3& d) const { return fours_[cell_of(d)]; }

  /// All directions that may be among the four nearest to d, ascending.
  std::span<const std::uint16_t> candidates(const vec3& d) const {
    const std::size_t cell = cell_of(d), begin = cell == 0 ? 0 : ends_[cell - 1];
    return std::span(candidates_).subspan(begin, ends_[cell] - begin);
  }

  /// The table: cells row by row of the square of octahedral_point, `side` to a row; the candidates of a cell
  /// end before its end and begin at that of the cell before.
  std::uint32_t side() const { return side_; }
  std::span<const std::uint32_t> ends() const { return ends_; }
  std::span<const std::uint16_t> all_candidates() const { return candidates_; }
  /// A cell: what nearly_nearest gives; zeros in cells below the hemisphere.
  std::span<const Four> fours() const { return fours_; }

  /// Keeps the four greatest cosines in descending order.
  static void insert(std::uint16_t index, float cosine, Four& best, std::array<float, 4>& cosines) {
    if (!(cosine > cosines[3])) return;
    int place = 3;
    for (; place > 0 && cosine > cosines[std::size_t(place - 1)]; --place) {
      cosines[std::size_t(place)] = cosines[std::size_t(place - 1)];
      best[std::size_t(place)] = best[std::size_t(place - 1)];
    }
    cosines[std::size_t(place)] = cosine;
    best[std::size_t(place)] = index;
  }

 private:
  std::size_t cell_of(const vec3& d) const {
    const vec2 p = octahedral_point(d) * float(side_);
    const auto at = [this](float x) { return std::min(std::uint32_t(std::max(x, 0.0f)), side_ - 1); };
    return std::size_t(at(p.y)) * side_ + at(p.x);
  }

  /// A direction of the cell is at most `reach` from its middle, because a cone that holds the corners of a
  /// flat piece of the octahedron holds all of it. So the fourth nearest is at most reach + fourth away from
  /// it, and 2 · reach + fourth from the middle.
  void append_cell(std::uint32_t x, std::uint32_t y) {
    const auto at = [&](float dx, float dy) {
      return octahedral_direction(vec2(float(x) + dx, float(y) + dy) / float(side_));
    };
    const vec3 middle = at(0.5f, 0.5f);
    float reach = 0;
    bool used = dome_ == Dome::sphere;
    for (const vec3& corner : {at(0, 0), at(1, 0), at(0, 1), at(1, 1)}) {
      reach = std::max(reach, angle(corner, middle));
      used |= corner.y > -1e-3f;
    }
    if (used) append_within(middle, reach);
    ends_.push_back(std::uint32_t(candidates_.size()));
  }

  void append_within(const vec3& middle, float reach) {
    Four& best = fours_[ends_.size()];
    std::array<float, 4> cosines{-2, -2, -2, -2};
    for (std::size_t i = 0; i < size(); ++i)
      insert(std::uint16_t(i), dot(directions_[i], middle), best, cosines);
    const float widest = angle(directions_[best[3]], middle) + 2 * reach + 1e-3f;
    const float least = widest < pi ? std::cos(widest) : -2.0f;
    for (std::size_t i = 0; i < size(); ++i)
      if (dot(directions_[i], middle) >= least) candidates_.push_back(std::uint16_t(i));
  }

  static float angle(const vec3& a, const vec3& b) {
    return 2 * std::asin(std::min(1.0f, 0.5f * length(a - b)));
  }

  Dome dome_;
  std::uint32_t side_ = 8;
  std::vector<vec3> directions_;
  std::vector<std::uint32_t> ends_;
  std::vector<std::uint16_t> candidates_;
  std::vector<Four> fours_;
};

}  // namespace coppice
