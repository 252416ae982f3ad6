// A regular lattice of light positions in the free space of a scene.
#pragma once

#include <algorithm>
#include <array>
#include <coppice/core/config.hpp>
#include <coppice/core/math.hpp>
#include <coppice/scene/occluder.hpp>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace coppice {

/// Points of a lattice that stand for a light, with weights that are positive and sum to 1. None where
/// `count` is 0: the lattice then says nothing about a light there, and only shadow rays do.
struct LatticeCorners {
  std::array<std::uint32_t, 8> points{};
  std::array<float, 8> weights{};
  std::uint32_t count = 0;
};

/// Points at origin + spacing · (x, y, z) for 0 <= x < size.x and so on; only those in free space count, and
/// have a number.
struct LightLattice {
  static constexpr std::uint32_t none = ~0u;

  vec3 origin{0};     ///< world space, metres
  float spacing = 0;  ///< metres
  glm::ivec3 size{0};
  std::vector<std::uint32_t> numbers;  ///< at (z · size.y + y) · size.x + x: the point's number, or none
  std::vector<vec3> positions;         ///< by number

  std::size_t count() const { return positions.size(); }
  vec3 place(const glm::ivec3& cell) const { return origin + spacing * vec3(cell); }
  /// The cell whose low corner is (x, y, z); its corners may lie outside the lattice.
  glm::ivec3 cell_of(const vec3& p) const { return glm::ivec3(glm::floor((p - origin) / spacing)); }
  bool contains(const glm::ivec3& cell) const {
    return cell.x >= 0 && cell.y >= 0 && cell.z >= 0 && cell.x < size.x && cell.y < size.y && cell.z < size.z;
  }
  /// Precondition: contains(cell).
  std::size_t index(const glm::ivec3& cell) const {
    return (std::size_t(cell.z) * std::size_t(size.y) + std::size_t(cell.y)) * std::size_t(size.x) +
           std::size_t(cell.x);
  }
  std::uint32_t number(const glm::ivec3& cell) const { return contains(cell) ? numbers[index(cell)] : none; }
};

namespace detail {

/// Corner k of the cell at `low`: bit 0 is +x, bit 1 +y, bit 2 +z.
inline glm::ivec3 corner_of(const glm::ivec3& low, int k) {
  return low + glm::ivec3(k & 1, (k >> 1) & 1, k >> 2);
}

/// Which of up to sixteen points are seen from p; a point at p itself is seen.
template <Occluder O>
std::uint32_t seen_points(const vec3& p, std::span<const vec3> points, const O& occluder) {
  ShadowPacket rays{};
  std::fill_n(rays.origin_x, 16, p.x), std::fill_n(rays.origin_y, 16, p.y),
      std::fill_n(rays.origin_z, 16, p.z);
  std::uint32_t seen = 0, lanes = 0;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const vec3 across = points[i] - p;
    const float distance = length(across);
    if (!(distance > 0)) {
      seen |= 1u << i;
      continue;
    }
    rays.direction_x[i] = across.x / distance, rays.direction_y[i] = across.y / distance;
    rays.direction_z[i] = across.z / distance, rays.t_max[i] = distance;
    lanes |= 1u << i;
  }
  return seen | (lanes != 0 ? lanes & ~occluder.occluded(rays, lanes) : 0u);
}

/// An empty lattice round the positions, all numbers none.
inline LightLattice lattice_round(std::span<const vec3> positions, float spacing) {
  vec3 low = positions[0], high = positions[0];
  for (const vec3& p : positions) low = glm::min(low, p), high = glm::max(high, p);
  LightLattice lattice;
  lattice.spacing = spacing;
  const glm::ivec3 cells = glm::max(glm::ivec3(glm::ceil((high - low) / spacing)), glm::ivec3(1));
  lattice.size = cells + 1;
  lattice.origin = 0.5f * (low + high) - 0.5f * spacing * vec3(cells);
  lattice.numbers.assign(
      std::size_t(lattice.size.x) * std::size_t(lattice.size.y) * std::size_t(lattice.size.z),
      LightLattice::none);
  return lattice;
}

/// The corners of p's cell that have no number yet and are seen from p get one: 0, in place of none.
template <Occluder O>
void mark_corners(LightLattice& lattice, const vec3& p, const O& occluder) {
  const glm::ivec3 low = lattice.cell_of(p);
  std::array<vec3, 8> points;
  std::array<std::size_t, 8> places;
  std::uint32_t count = 0;
  for (int k = 0; k < 8; ++k) {
    const glm::ivec3 corner = corner_of(low, k);
    if (!lattice.contains(corner) || lattice.numbers[lattice.index(corner)] == 0) continue;
    points[count] = lattice.place(corner), places[count++] = lattice.index(corner);
  }
  if (count == 0) return;
  const std::uint32_t seen = seen_points(p, std::span<const vec3>(points.data(), count), occluder);
  for (std::uint32_t k = 0; k < count; ++k)
    if ((seen >> k) & 1) lattice.numbers[places[k]] = 0;
}

/// Keeps of p's corners those that are seen from p; weights not yet normalised. Their sum.
template <Occluder O>
float add_seen(LatticeCorners& corners, const vec3& p, std::span<const std::uint32_t> numbers,
               std::span<const vec3> points, std::span<const float> weights, const O& occluder) {
  if (points.empty()) return 0;
  const std::uint32_t seen = seen_points(p, points, occluder);
  float sum = 0;
  for (std::uint32_t k = 0; k < points.size() && corners.count < 8; ++k) {
    if (!((seen >> k) & 1) || !(weights[k] > 0)) continue;
    corners.points[corners.count] = numbers[k], corners.weights[corners.count++] = weights[k];
    sum += weights[k];
  }
  return sum;
}

/// The points of the 4 × 4 × 4 corners round p's cell that p sees, nearest first, up to eight, weighted by
/// 1 / distance².
template <Occluder O>
LatticeCorners near_corners(const LightLattice& lattice, const vec3& p, const O& occluder) {
  struct Near {
    float distance2;
    std::uint32_t number;
  };
  std::array<Near, 64> near;
  std::size_t count = 0;
  const glm::ivec3 low = lattice.cell_of(p) - 1;
  for (int k = 0; k < 64; ++k) {
    const std::uint32_t number = lattice.number(low + glm::ivec3(k & 3, (k >> 2) & 3, k >> 4));
    if (number == LightLattice::none) continue;
    const vec3 across = lattice.positions[number] - p;
    near[count++] = {dot(across, across), number};
  }
  std::sort(near.begin(), near.begin() + std::ptrdiff_t(count), [](const Near& a, const Near& b) {
    return a.distance2 != b.distance2 ? a.distance2 < b.distance2 : a.number < b.number;
  });
  LatticeCorners corners;
  float sum = 0;
  for (std::size_t first = 0; first < count && corners.count < 8; first += 8) {
    std::array<std::uint32_t, 8> numbers;
    std::array<vec3, 8> points;
    std::array<float, 8> weights;
    const std::size_t few = std::min<std::size_t>(8, count - first);
    for (std::size_t k = 0; k < few; ++k) {
      numbers[k] = near[first + k].number, points[k] = lattice.positions[numbers[k]];
      weights[k] = 1 / std::max(near[first + k].distance2, 1e-12f);
    }
    sum += add_seen(corners, p, std::span<const std::uint32_t>(numbers.data(), few),
                    std::span<const vec3>(points.data(), few), std::span<const float>(weights.data(), few),
                    occluder);
  }
  for (std::uint32_t k = 0; k < corners.count; ++k) corners.weights[k] /= sum;
  return corners;
}

}  // namespace detail

/// The lattice points that lights in free space need: a corner of a cell counts where one of the
/// `free_positions` (drawn along free flights, many more than there will be points) lies in that cell and
/// sees it. So points inside solids and beyond walls do not count. Empty where there are no positions.
/// Preconditions: spacing > 0, positions finite, their box no more than 2^31 cells. Cost: 1 packet a position
/// at most.
template <Occluder O>
LightLattice light_lattice(std::span<const vec3> free_positions, float spacing, const O& occluder) {
  COPPICE_ASSERT(spacing > 0);
  if (free_positions.empty()) return {};
  LightLattice lattice = detail::lattice_round(free_positions, spacing);
  for (const vec3& p : free_positions) detail::mark_corners(lattice, p, occluder);
  for (int z = 0; z < lattice.size.z; ++z)
    for (int y = 0; y < lattice.size.y; ++y)
      for (int x = 0; x < lattice.size.x; ++x) {
        std::uint32_t& number = lattice.numbers[lattice.index({x, y, z})];
        if (number == LightLattice::none) continue;
        number = std::uint32_t(lattice.positions.size());
        lattice.positions.push_back(lattice.place({x, y, z}));
      }
  return lattice;
}

/// The finest lattice, to a few percent, of at most `most_points` points. Precondition: most_points >= 8.
template <Occluder O>
LightLattice light_lattice_within(std::span<const vec3> free_positions, std::size_t most_points,
                                  const O& occluder) {
  COPPICE_ASSERT(most_points >= 8);
  if (free_positions.empty()) return {};
  vec3 low = free_positions[0], high = low;
  for (const vec3& p : free_positions) low = glm::min(low, p), high = glm::max(high, p);
  const vec3 extent = high - low;
  // No finer than the box needs: the free space is at most all of it.
  const float longest = std::max({extent.x, extent.y, extent.z, 1e-3f});
  const double volume = double(std::max(extent.x, 1e-3f * longest)) *
                        double(std::max(extent.y, 1e-3f * longest)) *
                        double(std::max(extent.z, 1e-3f * longest));
  float spacing = float(std::cbrt(volume / double(most_points)));
  LightLattice best;
  for (int round = 0; round < 12; ++round) {
    LightLattice tried = light_lattice(free_positions, spacing, occluder);
    const double ratio = double(tried.count()) / double(most_points);
    const bool fits = ratio <= 1;
    if (fits && (best.count() == 0 || tried.spacing < best.spacing)) best = std::move(tried);
    if (fits && ratio > 0.95) break;
    if (fits && round >= 5) break;
    spacing *= float(std::cbrt(std::max(ratio, 0.05) * 1.03));
  }
  return best;
}

/// How a light at p is interpolated: the eight corners of its cell with trilinear weights, renormalised over
/// those that count and that p sees; where there is none, the nearest seen points up to one cell further,
/// weighted by 1 / distance²; and where there is still none, none. So nothing leaks through walls. Cost: one
/// packet, seldom up to nine.
template <Occluder O>
LatticeCorners lattice_corners(const LightLattice& lattice, const vec3& p, const O& occluder) {
  LatticeCorners corners;
  const vec3 scaled = lattice.count() > 0 ? (p - lattice.origin) / lattice.spacing : vec3(-9);
  // Written so that NaN is outside too, and before the conversion to int.
  if (!glm::all(glm::greaterThanEqual(scaled, vec3(-3))) ||
      !glm::all(glm::lessThanEqual(scaled, vec3(lattice.size) + 3.0f)))
    return corners;
  const glm::ivec3 low = lattice.cell_of(p);
  const vec3 f = scaled - vec3(low);
  std::array<std::uint32_t, 8> numbers;
  std::array<vec3, 8> points;
  std::array<float, 8> weights;
  std::size_t count = 0;
  for (int k = 0; k < 8; ++k) {
    const float weight =
        ((k & 1) != 0 ? f.x : 1 - f.x) * ((k & 2) != 0 ? f.y : 1 - f.y) * ((k & 4) != 0 ? f.z : 1 - f.z);
    const std::uint32_t number = lattice.number(detail::corner_of(low, k));
    if (number == LightLattice::none || !(weight > 0)) continue;
    numbers[count] = number, points[count] = lattice.positions[number], weights[count++] = weight;
  }
  const float sum = detail::add_seen(corners, p, std::span<const std::uint32_t>(numbers.data(), count),
                                     std::span<const vec3>(points.data(), count),
                                     std::span<const float>(weights.data(), count), occluder);
  if (corners.count == 0) return detail::near_corners(lattice, p, occluder);
  for (std::uint32_t k = 0; k < corners.count; ++k) corners.weights[k] /= sum;
  return corners;
}

}  // namespace coppice
