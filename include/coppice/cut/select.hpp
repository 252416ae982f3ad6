// Chooses the nodes of a cut: by an error threshold, by importance within a budget, or by a price a piece.
#pragma once

#include <algorithm>
#include <coppice/cut/cut.hpp>
#include <coppice/tree/walk.hpp>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace coppice {

inline constexpr std::size_t unlimited = std::numeric_limits<std::size_t>::max();

namespace detail {

struct Candidate {
  double priority;
  std::uint32_t node;
  /// Heap order: highest priority on top, ties to the smaller id, so that the choice is the same everywhere.
  friend bool operator<(const Candidate& a, const Candidate& b) {
    return a.priority < b.priority || (a.priority == b.priority && a.node > b.node);
  }
};

}  // namespace detail

/// Starts from the root and splits the node of highest priority(h) until every node has at most `threshold`
/// or the cut has max_size pieces (Cuts section 3.2). Leaves are never split. Returns the ends of the pieces.
/// O(size · log size). Precondition: priorities are not NaN; max_size >= 1.
template <class Priority>
std::vector<std::uint32_t> refine_cut(std::uint32_t leaf_count, Priority&& priority, double threshold,
                                      std::size_t max_size) {
  COPPICE_ASSERT(max_size >= 1);
  if (leaf_count == 0) return {};
  std::vector<detail::Candidate> open;
  std::vector<std::uint32_t> ends;
  const auto add = [&](std::uint32_t h) {
    const double p = double(priority(h));
    COPPICE_ASSERT(p == p);
    if (h < leaf_count && p > threshold) {
      open.push_back({p, h});
      std::push_heap(open.begin(), open.end());
    } else {
      ends.push_back(leaves_below(leaf_count, h).end);
    }
  };
  add(1);
  while (!open.empty() && open.size() + ends.size() < max_size) {
    std::pop_heap(open.begin(), open.end());
    const std::uint32_t h = open.back().node;
    open.pop_back();
    add(2 * h);
    add(2 * h + 1);
  }
  for (const auto& c : open) ends.push_back(leaves_below(leaf_count, c.node).end);
  std::sort(ends.begin(), ends.end());
  return ends;
}

/// The coarsest cut in which every inner node has error(h) <= threshold, as long as it needs no more than
/// max_size pieces; beyond that the worst nodes are split first until max_size is reached. With error(h) =
/// |C|·var and threshold σ² this is Cuts Eq. 6. The usual case is one stackless walk over the nodes above the
/// cut.
template <class Error>
std::vector<std::uint32_t> select_by_threshold(std::uint32_t leaf_count, Error&& error, double threshold,
                                               std::size_t max_size = unlimited) {
  std::vector<std::uint32_t> ends;
  walk_tree(leaf_count, [&](std::uint32_t h) {
    if (h<leaf_count&& double(error(h))> threshold) return true;
    ends.push_back(leaves_below(leaf_count, h).end);
    return false;
  });
  if (ends.size() <= max_size) return ends;
  return refine_cut(leaf_count, error, threshold, max_size);
}

/// The cut of at most max_size pieces that splits the most intense node first (Cuts section 3.2,
/// illumination): intensity(h) is the SUM over the cluster; by the mean the error is several times larger
/// (docs/cut.md). Nodes without intensity are never split, so a dark environment has a cut of one piece.
template <class Intensity>
std::vector<std::uint32_t> select_by_budget(std::uint32_t leaf_count, Intensity&& intensity,
                                            std::size_t max_size) {
  return refine_cut(leaf_count, intensity, 0.0, max_size);
}

/// The cut that minimises Σ error(h) + price · pieces over all cuts of the tree; of cuts that cost the same,
/// the one of fewer pieces. That is the least Σ error for its number of pieces, which a threshold on each
/// node does not give (optimal tree pruning: Breiman, Friedman, Olshen and Stone 1984; Chou, Lookabaugh and
/// Gray 1989). Keeps its scratch between calls; slow twin: reference::optimal_cut.
class OptimalCutSelector {
 public:
  /// Returns the ends of the pieces. Where they would be more than max_size the price is doubled until they
  /// fit, and so they may be far fewer. Cost: 2 · leaf_count calls of error for each price tried.
  /// Preconditions: errors are finite and not negative; price >= 0; max_size >= 1.
  template <class Error>
  std::vector<std::uint32_t> select(std::uint32_t leaf_count, Error&& error, double price,
                                    std::size_t max_size = unlimited) {
    COPPICE_ASSERT(price >= 0 && max_size >= 1);
    auto ends = ends_at_price(leaf_count, error, price);
    while (ends.size() > max_size) {
      price = std::max({2 * price, double(error(1u)) / leaf_count, std::numeric_limits<double>::min()});
      ends = ends_at_price(leaf_count, error, price);
    }
    return ends;
  }

 private:
  /// From the leaves to the root a node is split where its children's best cuts cost less than the node as a
  /// piece.
  template <class Error>
  std::vector<std::uint32_t> ends_at_price(std::uint32_t leaf_count, Error&& error, double price) {
    cost_.resize(2 * std::size_t(leaf_count));
    is_split_.assign(cost_.size(), 0);
    for (std::uint32_t h = leaf_count; h < 2 * leaf_count; ++h) cost_[h] = double(error(h)) + price;
    for (std::uint32_t h = leaf_count; h-- > 1;) {
      const double whole = double(error(h)) + price, split = cost_[2 * h] + cost_[2 * h + 1];
      is_split_[h] = split < whole;
      cost_[h] = std::min(split, whole);
    }
    std::vector<std::uint32_t> ends;
    walk_tree(leaf_count, [&](std::uint32_t h) {
      if (is_split_[h]) return true;
      ends.push_back(leaves_below(leaf_count, h).end);
      return false;
    });
    return ends;
  }

  std::vector<double> cost_;  // a heap id; of the best cut below it
  std::vector<std::uint8_t> is_split_;
};

/// One cut by an OptimalCutSelector of its own.
template <class Error>
std::vector<std::uint32_t> select_optimal(std::uint32_t leaf_count, Error&& error, double price,
                                          std::size_t max_size = unlimited) {
  return OptimalCutSelector().select(leaf_count, std::forward<Error>(error), price, max_size);
}

}  // namespace coppice
