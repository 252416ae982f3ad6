// Connected regions of the sphere that are brighter than a threshold.
#pragma once

#include <algorithm>
#include <coppice/core/config.hpp>
#include <coppice/core/parallel.hpp>
#include <coppice/light/environment.hpp>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace coppice {

/// Texels [begin, end) of a row of an environment map, all of one region.
struct BrightRun {
  int row = 0, begin = 0, end = 0;
  std::uint32_t region = 0;
};

/// Runs from the top row down, left to right; regions are numbered by their first run.
struct BrightRegions {
  std::vector<BrightRun> runs;
  std::uint32_t count = 0;
};

}  // namespace coppice

namespace coppice::detail {

/// Which runs belong together: each points to an earlier one, the first of all to itself.
class RunSets {
 public:
  explicit RunSets(std::size_t count) : parent_(count) {
    for (std::size_t i = 0; i < count; ++i) parent_[i] = std::uint32_t(i);
  }
  std::uint32_t first_of(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = first_of(a), b = first_of(b);
    if (a != b) parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

/// The runs of one row that are brighter than the threshold.
inline std::vector<BrightRun> bright_runs(const Image& map, int row, float threshold) {
  std::vector<BrightRun> runs;
  const vec3* texels = &map.pixels[map.index(0, row)];
  for (int x = 0; x < map.width; ++x) {
    if (!(luminance(texels[x]) > threshold)) continue;
    if (runs.empty() || runs.back().end != x) runs.push_back({row, x, x, 0});
    runs.back().end = x + 1;
  }
  return runs;
}

/// Joins runs of two neighbouring rows (or of one row with itself) that touch, at corners and across the
/// seam too.
inline void join_rows(std::span<const BrightRun> runs, std::pair<std::uint32_t, std::uint32_t> above,
                      std::pair<std::uint32_t, std::uint32_t> below, int width, RunSets& sets) {
  std::uint32_t a = above.first;
  for (std::uint32_t b = below.first; b < below.second; ++b) {
    while (a < above.second && runs[a].end < runs[b].begin) ++a;
    for (std::uint32_t i = a; i < above.second && runs[i].begin <= runs[b].end; ++i) sets.join(i, b);
  }
  if (above.first == above.second || below.first == below.second) return;
  const auto touches = [&](std::uint32_t left, std::uint32_t right) {
    return runs[left].begin == 0 && runs[right].end == width;
  };
  if (touches(above.first, below.second - 1)) sets.join(above.first, below.second - 1);
  if (touches(below.first, above.second - 1)) sets.join(below.first, above.second - 1);
}

/// All texels of the first and of the last row meet at a pole.
inline void join_all(std::pair<std::uint32_t, std::uint32_t> row, RunSets& sets) {
  for (std::uint32_t i = row.first; i + 1 < row.second; ++i) sets.join(i, i + 1);
}

}  // namespace coppice::detail

namespace coppice {

/// The regions of texels whose luminance exceeds the threshold. Texels that share an edge or a corner are
/// neighbours, across the left and right edge of the map too, as are all texels of the top row and all of
/// the bottom row: the paper's connected components (SG section 6), on the sphere. The turn of an environment
/// does not matter.
/// Cost: one pass over the map. Precondition: the map has texels.
template <Executor E = Serial>
BrightRegions bright_regions(const Image& map, float threshold, const E& executor = {}) {
  COPPICE_ASSERT(map.width > 0 && map.height > 0);
  std::vector<std::vector<BrightRun>> rows(static_cast<std::size_t>(map.height));
  executor(rows.size(), 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t y = begin; y < end; ++y) rows[y] = detail::bright_runs(map, int(y), threshold);
  });
  BrightRegions regions;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> ranges;
  for (const auto& row : rows) {
    const std::uint32_t first = std::uint32_t(regions.runs.size());
    regions.runs.insert(regions.runs.end(), row.begin(), row.end());
    ranges.push_back({first, std::uint32_t(regions.runs.size())});
  }
  detail::RunSets sets(regions.runs.size());
  for (std::size_t y = 0; y < ranges.size(); ++y)
    detail::join_rows(regions.runs, ranges[y > 0 ? y - 1 : 0], ranges[y], map.width, sets);
  for (const auto& range : ranges) detail::join_rows(regions.runs, range, range, map.width, sets);
  detail::join_all(ranges.front(), sets);
  detail::join_all(ranges.back(), sets);
  for (std::uint32_t i = 0; i < regions.runs.size(); ++i) {
    const std::uint32_t first = sets.first_of(i);
    regions.runs[i].region = first == i ? regions.count++ : regions.runs[first].region;
  }
  return regions;
}

}  // namespace coppice
