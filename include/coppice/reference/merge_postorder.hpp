// The paper's own merge of cuts, by postorder index and leftmost leaf: the oracle for merge.hpp.
#pragma once

#include <algorithm>
#include <bit>
#include <coppice/cut/cut.hpp>
#include <ranges>
#include <span>
#include <vector>

namespace coppice::reference {

/// A node as the paper stores it (Cuts section 3.2, Figure 2).
struct PostorderNode {
  std::uint32_t index = 0;     ///< postorder traversal index
  std::uint32_t leftleaf = 0;  ///< postorder index of the leftmost leaf below it
  double value = 0;
};

/// Postorder index of leaf rank i in a complete binary tree: leaves before it, and the inner nodes finished
/// by then.
inline std::uint32_t postorder_of_leaf(std::uint32_t i) { return 2 * i - std::uint32_t(std::popcount(i)); }

/// A node of m leaves ends its subtree of 2m - 1 nodes.
inline PostorderNode postorder_node(LeafRange r, double value) {
  const std::uint32_t first = postorder_of_leaf(r.begin);
  return {first + 2 * r.size() - 2, first, value};
}

template <class Value>
std::vector<PostorderNode> to_postorder(CutView<Value> cut) {
  std::vector<PostorderNode> nodes;
  for_each_piece(cut.ends, [&](LeafRange r, std::size_t i) {
    nodes.push_back(postorder_node(r, double(cut.values[i])));
  });
  return nodes;
}

/// Runs the paper's loop and calls visit(common leaves, current node of each cut) whenever all current nodes
/// overlap.
template <class Visit>
void merge_postorder(const std::vector<std::vector<PostorderNode>>& cuts, Visit&& visit) {
  std::vector<std::size_t> at(cuts.size(), 0);
  std::vector<PostorderNode> p(cuts.size());
  while (std::ranges::all_of(std::views::iota(std::size_t{0}, cuts.size()),
                             [&](auto j) { return at[j] < cuts[j].size(); })) {
    for (std::size_t j = 0; j < cuts.size(); ++j) p[j] = cuts[j][at[j]];
    const std::uint32_t min_index = std::ranges::min(p, {}, &PostorderNode::index).index;
    const std::uint32_t max_leftleaf = std::ranges::max(p, {}, &PostorderNode::leftleaf).leftleaf;
    if (max_leftleaf <= min_index)
      visit((min_index - max_leftleaf + 2) / 2, std::span<const PostorderNode>(p));
    for (std::size_t j = 0; j < cuts.size(); ++j) at[j] += p[j].index == min_index;
  }
}

/// Σ over leaves of the product of all cuts by the paper's loop.
inline double product_integral_postorder(const std::vector<std::vector<PostorderNode>>& cuts) {
  double sum = 0;
  merge_postorder(cuts, [&](std::uint32_t leaves, std::span<const PostorderNode> nodes) {
    double product = 1;
    for (const auto& n : nodes) product *= n.value;
    sum += leaves * product;
  });
  return sum;
}

}  // namespace coppice::reference
