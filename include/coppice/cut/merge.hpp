// Merging cuts: the union of their ends, with every cut's value on each piece.
#pragma once

#include <algorithm>
#include <array>
#include <coppice/cut/cut.hpp>
#include <span>
#include <utility>
#include <vector>

namespace coppice {

/// Calls visit(LeafRange, value of each cut...) once for each piece of the merged cut, from left to right.
/// Every step yields one cluster, so the cost is the size of the merged cut; the paper's traversal (Cuts
/// section 3.2, reference/merge_postorder.hpp) spends steps on nodes that do not overlap. Any number of cuts
/// from 1 up, of any value types. Precondition: all are cuts of one tree.
template <class Visit, class... Cuts>
requires(sizeof...(Cuts) >= 1) void merge_cuts(Visit&& visit, const Cuts&... cuts) {
  const std::array<std::size_t, sizeof...(Cuts)> sizes{cuts.ends.size()...};
  COPPICE_ASSERT(std::ranges::all_of(sizes, [&](std::size_t s) { return (s == 0) == (sizes[0] == 0); }));
  if (sizes[0] == 0) return;
  std::array<std::size_t, sizeof...(Cuts)> at{};
  [&]<std::size_t... I>(std::index_sequence<I...>) {
    for (std::uint32_t begin = 0; at[0] < sizes[0];) {
      const std::uint32_t end = std::min({cuts.ends[at[I]]...});
      visit(LeafRange{begin, end}, cuts.values[at[I]]...);
      ((at[I] += cuts.ends[at[I]] == end), ...);
      begin = end;
    }
  }
  (std::index_sequence_for<Cuts...>{});
}

/// The same where the number of cuts is known at run time: visit(LeafRange, span of one value a cut).
template <class Value, class Visit>
void merge_cut_list(std::span<const CutView<Value>> cuts, Visit&& visit) {
  if (cuts.empty() || cuts[0].size() == 0) return;
  std::vector<std::size_t> at(cuts.size(), 0);
  std::vector<Value> values(cuts.size());
  for (std::uint32_t begin = 0; at[0] < cuts[0].size();) {
    std::uint32_t end = cuts[0].ends[at[0]];
    for (std::size_t i = 0; i < cuts.size(); ++i) {
      end = std::min(end, cuts[i].ends[at[i]]);
      values[i] = cuts[i].values[at[i]];
    }
    visit(LeafRange{begin, end}, std::span<const Value>(values));
    for (std::size_t i = 0; i < cuts.size(); ++i) at[i] += cuts[i].ends[at[i]] == end;
    begin = end;
  }
}

/// Σ over leaves of the product of all cuts: Σ_k |C_k| Π_j ⟨p_j⟩ (Cuts section 3.2).
template <class... Cuts>
double product_integral(const Cuts&... cuts) {
  double sum = 0;
  merge_cuts([&](LeafRange r, auto... values) { sum += double(r.size()) * (double(values) * ...); }, cuts...);
  return sum;
}

/// The cut Σ_j weights[j] · cuts[j], on the union of their ends. Precondition: as many weights as cuts.
template <class Value>
Cut<float> interpolate_cuts(std::span<const float> weights, std::span<const CutView<Value>> cuts) {
  COPPICE_ASSERT(weights.size() == cuts.size());
  Cut<float> result;
  merge_cut_list(cuts, [&](LeafRange r, std::span<const Value> values) {
    float v = 0;
    for (std::size_t j = 0; j < values.size(); ++j) v += weights[j] * float(values[j]);
    result.ends.push_back(r.end);
    result.values.push_back(v);
  });
  return result;
}

/// The cut Σ_j cuts[j].
template <class Value>
Cut<float> sum_cuts(std::span<const CutView<Value>> cuts) {
  const std::vector<float> ones(cuts.size(), 1.0f);
  return interpolate_cuts(std::span<const float>(ones), cuts);
}

}  // namespace coppice
