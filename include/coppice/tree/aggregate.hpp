// Fills an array over nodes from one over leaves, by one sweep from the leaves to the root.
#pragma once

#include <coppice/core/config.hpp>
#include <coppice/tree/light_tree.hpp>
#include <span>
#include <vector>

namespace coppice {

/// Values by heap id: entries N … 2N-1 are `of_leaf(rank)`, entry h is combine(value[2h], value[2h + 1]),
/// entry 0 a default value. Sums are pairwise by construction, so that float sums over 10^7 lights lose no
/// more than about log2(10^7) roundings. Cost: N calls of each. Empty without leaves.
template <class OfLeaf, class Combine>
auto aggregate(std::uint32_t leaf_count, OfLeaf&& of_leaf, Combine&& combine) {
  using Value = std::decay_t<decltype(of_leaf(0u))>;
  std::vector<Value> values(2 * std::size_t(leaf_count));
  for (std::uint32_t i = 0; i < leaf_count; ++i) values[leaf_count + i] = of_leaf(i);
  for (std::uint32_t h = leaf_count; h-- > 1;) values[h] = combine(values[2 * h], values[2 * h + 1]);
  return values;
}

/// Count, mean and sum of squared deviations of the samples below a node, joined without the cancellation of
/// E[x²] - E[x]² (Chan, Golub, LeVeque 1979).
struct Moments {
  double count = 0;
  double mean = 0;
  double squared_deviations = 0;  ///< = count · variance, the left side of Cuts Eq. 6

  static Moments of(double value) { return {1, value, 0}; }

  friend Moments operator+(const Moments& a, const Moments& b) {
    const double count = a.count + b.count;
    if (count == 0) return {};
    const double delta = b.mean - a.mean;
    return {count, a.mean + delta * (b.count / count),
            a.squared_deviations + b.squared_deviations + delta * delta * (a.count * (b.count / count))};
  }
};

/// Moments by heap id of a function known at the lights: values[i] belongs to light i; padding counts for
/// nothing.
inline std::vector<Moments> aggregate_moments(const LightTree& tree, std::span<const float> values) {
  return aggregate(
      tree.leaf_count(),
      [&](std::uint32_t leaf) {
        const std::uint32_t light = tree.light_of_leaf[leaf];
        return light == no_light ? Moments{} : Moments::of(values[light]);
      },
      [](const Moments& a, const Moments& b) { return a + b; });
}

}  // namespace coppice
