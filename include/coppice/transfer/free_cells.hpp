// Which cells of a grid are free, closed, or cut by a surface; and where rays come free again behind one.
#pragma once

#include <coppice/transfer/particles.hpp>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace coppice {

/// Cells of a box, each closed, cut by a surface, or open: known from free flights, which begin and end at
/// surfaces. The inside of solids, gaps behind walls and what is outside a closed room stay closed, whichever
/// way their triangles face. A byte a cell.
class FreeCells {
 public:
  /// All cells are closed at first. Preconditions: low < high in every coordinate and spacing > 0, in metres;
  /// so many cells that they fit in memory.
  FreeCells(const vec3& low, const vec3& high, float spacing) : low_(low), spacing_(spacing) {
    COPPICE_ASSERT(spacing > 0 && high.x > low.x && high.y > low.y && high.z > low.z);
    for (int k = 0; k < 3; ++k) size_[k] = std::uint32_t(std::ceil((high[k] - low[k]) / spacing)) + 1;
    cells_.assign(std::size_t(size_.x) * size_.y * size_.z, closed);
  }

  /// Everything between two points is free, where `from` lies in the box; but for a thousandth of a cell at
  /// both ends, which rounding may have put behind a surface.
  void add(const vec3& from, const vec3& to) {
    const float whole = length(to - from), reach = whole - 2e-3f * spacing_;
    if (!(reach > 0)) return;
    const vec3 direction = (to - from) / whole;
    walk(from + 1e-3f * spacing_ * direction, direction, reach, [this](std::size_t cell, float) {
      if (cells_[cell] == closed) cells_[cell] = open;
      return true;
    });
  }

  /// A surface passes through this point.
  void add_surface(const vec3& position) {
    if (holds(position)) cells_[cell_of(uvec3((position - low_) / spacing_))] = surface;
  }

  /// Whether a flight or a surface passes through the point's cell.
  bool is_free(const vec3& position) const {
    return holds(position) && cells_[cell_of(uvec3((position - low_) / spacing_))] != closed;
  }

  /// For a ray that meets a surface `hit` metres from its origin: how far away free space begins again behind
  /// it; +infinity where it does not within the box, or not before `limit`. That is `hit` itself where only
  /// cells that surfaces cut lie between: sheets thinner than a cell or two. Behind solids it is where the
  /// cells that their far side cuts begin. Too far only where no flight crossed a cell that is free.
  float next_free(const vec3& origin, const vec3& direction, float hit, float limit) const {
    float begin = hit, result = std::numeric_limits<float>::infinity();
    bool cut = true, first = true;  // cut: in a run of cells that are not closed
    walk(origin + hit * direction, direction, limit - hit, [&](std::size_t cell, float t) {
      const std::uint8_t kind = std::exchange(first, false) ? std::uint8_t(surface) : cells_[cell];
      if (kind != closed && !cut) begin = hit + t;
      cut = kind != closed;
      if (kind == open) result = begin;
      return kind != open;
    });
    return result;
  }

  /// Metres; the edge of a cell.
  float spacing() const { return spacing_; }
  /// How many cells.
  std::size_t size() const { return cells_.size(); }

 private:
  enum Kind : std::uint8_t { closed, surface, open };

  bool holds(const vec3& position) const {
    const vec3 p = (position - low_) / spacing_;
    return p.x >= 0 && p.y >= 0 && p.z >= 0 && p.x < float(size_.x) && p.y < float(size_.y) &&
           p.z < float(size_.z);
  }
  std::size_t cell_of(const uvec3& c) const { return (std::size_t(c.z) * size_.y + c.y) * size_.x + c.x; }

  /// Calls visit(cell, t where the ray enters it) for the cells along a ray that begins in the box, until it
  /// returns false, the ray leaves the box, or t reaches `reach`.
  template <class Visit>
  void walk(const vec3& origin, const vec3& direction, float reach, Visit&& visit) const {
    if (!holds(origin)) return;
    const vec3 p = (origin - low_) / spacing_;
    uvec3 cell(p);
    glm::ivec3 step(0);
    vec3 next(std::numeric_limits<float>::infinity()), across = next;
    for (int k = 0; k < 3; ++k) {
      if (direction[k] == 0) continue;
      step[k] = direction[k] > 0 ? 1 : -1;
      across[k] = spacing_ / std::abs(direction[k]);
      next[k] = (float(cell[k]) + (step[k] > 0 ? 1.0f : 0.0f) - p[k]) * spacing_ / direction[k];
    }
    for (float t = 0; t < reach;) {
      if (!visit(cell_of(cell), t)) return;
      const int k = next.x < next.y ? (next.x < next.z ? 0 : 2) : (next.y < next.z ? 1 : 2);
      cell[k] += std::uint32_t(step[k]);  // below 0 it wraps round and so leaves the box
      if (step[k] == 0 || cell[k] >= size_[k]) return;
      t = next[k];
      next[k] += across[k];
    }
  }

  vec3 low_;
  float spacing_;
  uvec3 size_{0};
  std::vector<std::uint8_t> cells_;
};

/// The cells that particles' flights cross, in a box round all of them; `spacing` (m) about that of samples.
/// Precondition: at least one flight.
inline FreeCells free_cells(std::span<const Flight> flights, float spacing) {
  COPPICE_ASSERT(!flights.empty());
  vec3 low(std::numeric_limits<float>::infinity()), high = -low;
  for (const Flight& f : flights)
    low = glm::min(low, glm::min(f.from, f.to)), high = glm::max(high, glm::max(f.from, f.to));
  FreeCells cells(low - 1.5f * spacing, high + spacing, spacing);  // straight walls pass through middles
  for (const Flight& f : flights) cells.add(f.from, f.to);
  for (const Flight& f : flights) {
    if (!f.from_sky) cells.add_surface(f.from);
    cells.add_surface(f.to);
  }
  return cells;
}

}  // namespace coppice
