// Merging cuts leaf by leaf: expand each to one value a leaf and forget the tree.
#pragma once

#include <coppice/cut/cut.hpp>
#include <span>
#include <vector>

namespace coppice::reference {

/// The value of a cut at every leaf.
template <class Value>
std::vector<double> expand(CutView<Value> cut) {
  std::vector<double> leaves;
  for_each_piece(cut.ends, [&](LeafRange r, std::size_t i) {
    leaves.insert(leaves.end(), r.size(), double(cut.values[i]));
  });
  return leaves;
}

/// Σ over leaves of the product of all functions.
inline double product_integral_per_leaf(std::span<const std::vector<double>> functions) {
  double sum = 0;
  for (std::size_t i = 0; !functions.empty() && i < functions[0].size(); ++i) {
    double product = 1;
    for (const auto& f : functions) product *= f[i];
    sum += product;
  }
  return sum;
}

}  // namespace coppice::reference
