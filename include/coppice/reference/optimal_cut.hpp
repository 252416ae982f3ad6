// The optimal cut of a small tree, found by looking at every cut there is.
#pragma once

#include <bit>
#include <coppice/cut/cut.hpp>
#include <cstdint>
#include <span>
#include <vector>

namespace coppice::reference {

/// Every cut below node h: bit i is set where a piece ends after leaf i. A tree of 1, 2, 4, 8, 16 leaves has
/// 1, 2, 5, 26, 677 of them. Precondition: leaf_count is 1, 2, 4, 8 or 16.
inline std::vector<std::uint32_t> all_cuts(std::uint32_t leaf_count, std::uint32_t h = 1) {
  COPPICE_ASSERT(std::has_single_bit(leaf_count) && leaf_count <= 16);
  std::vector<std::uint32_t> cuts{1u << (leaves_below(leaf_count, h).end - 1)};
  if (h >= leaf_count) return cuts;
  const auto right_cuts = all_cuts(leaf_count, 2 * h + 1);
  for (const std::uint32_t left : all_cuts(leaf_count, 2 * h))
    for (const std::uint32_t right : right_cuts) cuts.push_back(left | right);
  return cuts;
}

/// The ends that a mask of all_cuts stands for.
inline std::vector<std::uint32_t> ends_of_mask(std::uint32_t mask) {
  std::vector<std::uint32_t> ends;
  for (; mask != 0; mask &= mask - 1) ends.push_back(std::uint32_t(std::countr_zero(mask)) + 1);
  return ends;
}

/// Σ error(h) over the pieces + price · pieces.
template <class Error>
double cut_cost(std::uint32_t leaf_count, std::span<const std::uint32_t> ends, Error&& error, double price) {
  double cost = price * double(ends.size());
  for_each_piece(ends, [&](LeafRange r, std::size_t) {
    cost += double(error(node_of_range(leaf_count, r.begin, r.end)));
  });
  return cost;
}

/// The cut of least cost, and of those the one of fewest pieces. Precondition: as all_cuts.
template <class Error>
std::vector<std::uint32_t> optimal_cut(std::uint32_t leaf_count, Error&& error, double price) {
  std::vector<std::uint32_t> best{leaf_count};
  double best_cost = cut_cost(leaf_count, best, error, price);
  for (const std::uint32_t mask : all_cuts(leaf_count)) {
    const auto ends = ends_of_mask(mask);
    const double cost = cut_cost(leaf_count, ends, error, price);
    if (cost > best_cost || (cost == best_cost && ends.size() >= best.size())) continue;
    best = ends, best_cost = cost;
  }
  return best;
}

}  // namespace coppice::reference
