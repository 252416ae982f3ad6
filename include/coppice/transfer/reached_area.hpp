// How much surface particles have reached, and candidates of one density over all rooms.
#pragma once

#include <algorithm>
#include <coppice/light/surface_samples.hpp>
#include <numeric>

namespace coppice::detail {

/// A piece of a triangle's side and the candidates on it.
struct ReachedCell {
  std::uint64_t key = 0;  ///< side, then the piece
  std::uint32_t group = 0;
  float area = 0;  ///< m²
};

/// The piece of a side where the sample lies: triangles are cut into n² alike, each of about `area`.
inline ReachedCell cell_of(const Mesh& mesh, const SurfaceSample& s, double area) {
  const double whole = triangle_area(mesh, s.side.triangle);
  const double n = std::clamp(std::floor(std::sqrt(whole / area)), 1.0, 32767.0);
  const double u = n * double(s.u), v = n * double(s.v), i = std::floor(u), j = std::floor(v);
  const auto upper = std::uint64_t(u - i + v - j > 1);
  const std::uint64_t piece = std::uint64_t(i) << 16 | std::uint64_t(j) << 1 | upper;
  const std::uint64_t side = 2 * std::uint64_t(s.side.triangle) + std::uint64_t(s.side.front);
  return {side << 31 | piece, 0, float(whole / (n * n))};
}

/// The area of cells that `count` even candidates have hit, those included that chance left out: A = Σ aᵢ /
/// (1 - exp(-aᵢ·count/A)) over the cells hit (Horvitz and Thompson's estimator, 1952), by iteration.
inline double reached_area(std::span<const float> hit, std::size_t count) {
  double sum = 0;
  for (const float a : hit) sum += double(a);
  double area = sum;
  for (int step = 0; step < 32 && area > 0; ++step) {
    double next = 0;
    for (const float a : hit) next += double(a) / -std::expm1(-double(a) * double(count) / area);
    area = next;
  }
  return area;
}

/// For each start the first of those whose particles meet its own: they share a tenth of the fewer cells.
inline std::vector<std::uint32_t> joined_starts(std::span<const ReachedCell> cells, std::size_t starts) {
  std::vector<std::uint32_t> root(starts), own(starts, 0);
  std::vector<std::uint32_t> shared(starts * starts, 0);
  for (std::size_t begin = 0, end = 0; begin < cells.size(); begin = end) {
    while (end < cells.size() && cells[end].key == cells[begin].key) ++end;
    for (std::size_t i = begin; i < end; ++i) {
      ++own[cells[i].group];
      for (std::size_t k = begin; k < i; ++k) ++shared[cells[k].group * starts + cells[i].group];
    }
  }
  std::iota(root.begin(), root.end(), 0u);
  for (std::size_t a = 0; a < starts; ++a)
    for (std::size_t b = a + 1; b < starts; ++b)
      if (10 * shared[a * starts + b] > std::min(own[a], own[b]) && root[a] != root[b])
        std::ranges::replace(root, std::max(root[a], root[b]), std::min(root[a], root[b]));
  return root;
}

/// A candidate's cells, sorted, one for each group that hits it.
template <class Group>
std::vector<ReachedCell> cells_hit(const Mesh& mesh, std::span<const SurfaceSample> candidates, double area,
                                   Group&& group) {
  std::vector<ReachedCell> cells;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    cells.push_back(cell_of(mesh, candidates[i], area));
    cells.back().group = group(i);
  }
  const auto order = [](const ReachedCell& c) { return std::pair(c.key, c.group); };
  std::ranges::sort(cells, {}, order);
  const auto repeated = std::ranges::unique(cells, {}, order);
  cells.erase(repeated.begin(), repeated.end());
  return cells;
}

/// A size for the cells: about four candidates each, were the sides hit reached wholly.
inline double cell_area(const Mesh& mesh, std::span<const SurfaceSample> candidates) {
  const auto whole =
      cells_hit(mesh, candidates, std::numeric_limits<double>::infinity(), [](std::size_t) { return 0u; });
  double area = 0;
  for (const ReachedCell& c : whole) area += double(c.area);
  return 4 * area / double(candidates.size());
}

/// The candidates that are left out for the sake of one density, marked, and the area of all (m²).
struct EvenCandidates {
  std::vector<std::uint8_t> dropped;
  double area = 0;
};

/// Estimates the area that is reached. Starts whose particles do not meet are rooms of their own: of rooms
/// with more candidates an area than the sparsest some are left out, evenly. `start(i)` is candidate i's.
template <class Start>
EvenCandidates even_out(const Mesh& mesh, std::span<const SurfaceSample> candidates, std::size_t starts,
                        Start&& start) {
  EvenCandidates even{std::vector<std::uint8_t>(candidates.size(), 0)};
  if (candidates.empty()) return even;
  const double size = cell_area(mesh, candidates);
  const auto root = joined_starts(cells_hit(mesh, candidates, size, start), starts);
  const auto group = [&](std::size_t i) { return root[start(i)]; };
  std::vector<std::vector<float>> hit(starts);
  std::vector<std::size_t> count(starts, 0);
  for (const ReachedCell& c : cells_hit(mesh, candidates, size, group)) hit[c.group].push_back(c.area);
  for (std::size_t i = 0; i < candidates.size(); ++i) ++count[group(i)];
  std::vector<double> each(starts, 0), earned(starts, 0.5);  // m² a candidate; candidates kept so far
  for (std::size_t g = 0; g < starts; ++g) {
    const double area = reached_area(hit[g], count[g]);
    even.area += area;
    if (count[g] > 0) each[g] = area / double(count[g]);
  }
  const double sparsest = *std::ranges::max_element(each);
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const double before = std::floor(earned[group(i)]);
    earned[group(i)] += each[group(i)] / sparsest;
    even.dropped[i] = std::floor(earned[group(i)]) == before;
  }
  return even;
}

}  // namespace coppice::detail
