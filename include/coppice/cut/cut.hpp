// A cut: a piecewise constant function of the leaf rank whose pieces are nodes of the light tree.
#pragma once

#include <coppice/core/config.hpp>
#include <coppice/tree/light_tree.hpp>
#include <cstdint>
#include <span>
#include <vector>

namespace coppice {

/// Piece i covers the leaves [ends[i-1], ends[i]) (from 0 for i = 0) and has values[i]. Ends are strictly
/// increasing, the last is the leaf count, and each piece is a node. Without leaves there are no pieces.
template <class Value>
struct Cut {
  std::vector<std::uint32_t> ends;
  std::vector<Value> values;

  std::size_t size() const { return ends.size(); }
};

/// The same over memory that another owns.
template <class Value>
struct CutView {
  std::span<const std::uint32_t> ends;
  std::span<const Value> values;

  CutView() = default;
  CutView(std::span<const std::uint32_t> e, std::span<const Value> v) : ends(e), values(v) {}
  CutView(const Cut<Value>& cut) : ends(cut.ends), values(cut.values) {}

  std::size_t size() const { return ends.size(); }
};

/// Calls visit(LeafRange, index) for each piece from left to right.
template <class Visit>
void for_each_piece(std::span<const std::uint32_t> ends, Visit&& visit) {
  std::uint32_t begin = 0;
  for (std::size_t i = 0; i < ends.size(); begin = ends[i], ++i) visit(LeafRange{begin, ends[i]}, i);
}

/// True where `ends` is a cut through the tree over leaf_count leaves: every leaf covered once, by nodes.
inline bool is_cut(std::uint32_t leaf_count, std::span<const std::uint32_t> ends) {
  std::uint32_t begin = 0;
  for (const std::uint32_t end : ends) {
    const std::uint32_t size = end - begin;
    if (end <= begin || end > leaf_count || !std::has_single_bit(size) || begin % size != 0) return false;
    begin = end;
  }
  return begin == leaf_count;
}

/// The cut whose value on each piece is value_of(heap id).
template <class ValueOf>
auto cut_with_values(std::uint32_t leaf_count, std::vector<std::uint32_t> ends, ValueOf&& value_of) {
  Cut<std::decay_t<decltype(value_of(1u))>> cut;
  cut.values.reserve(ends.size());
  for_each_piece(ends, [&](LeafRange r, std::size_t) {
    cut.values.push_back(value_of(node_of_range(leaf_count, r.begin, r.end)));
  });
  cut.ends = std::move(ends);
  return cut;
}

}  // namespace coppice
