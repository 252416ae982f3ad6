// Products of cuts leaf by leaf: the slow twin of CutMultiplier.
#pragma once

#include <coppice/reference/merge_per_leaf.hpp>
#include <cstdint>
#include <vector>

namespace coppice::reference {

/// Σ weight · cut over some cuts: one factor of a product.
struct MeanOfCuts {
  std::vector<Cut<std::uint8_t>> cuts;
  std::vector<float> weights;  ///< a cut; sum 1
};

/// base · Π_k (mean k / 255) at every leaf, not rounded: in units of 1/255 (Cuts section 4.2).
inline std::vector<double> product_per_leaf(const Cut<std::uint8_t>& base,
                                            std::span<const MeanOfCuts> factors) {
  std::vector<double> product = expand(CutView<std::uint8_t>(base));
  for (const MeanOfCuts& factor : factors) {
    std::vector<double> mean(product.size(), 0.0);
    for (std::size_t s = 0; s < factor.cuts.size(); ++s) {
      const std::vector<double> values = expand(CutView<std::uint8_t>(factor.cuts[s]));
      for (std::size_t leaf = 0; leaf < mean.size(); ++leaf)
        mean[leaf] += double(factor.weights[s]) * values[leaf];
    }
    for (std::size_t leaf = 0; leaf < mean.size(); ++leaf) product[leaf] *= mean[leaf] / 255;
  }
  return product;
}

}  // namespace coppice::reference
