// From one row of visibility bits to a cut of V·G: how much of each light's intensity arrives.
#pragma once

#include <coppice/relight/local_light_packets.hpp>
#include <coppice/relight/visibility_cut_selector.hpp>
#include <coppice/tree/aggregate.hpp>

namespace coppice {

/// A cut whose values q stand for means of V·G over the lights of each piece (Cuts section 4.1): scale · q²,
/// in 1/m². The square root is stored because V·G ranges as widely as distances squared: a sun beside a lamp
/// at hand.
struct LocalCut {
  Cut<std::uint16_t> cut;
  float scale = 0;
};

/// Leaves in a granule for local lights: V·G has no bound that would tell, so that the cut is resolved to a
/// 4,096th of the lights.
inline std::uint32_t local_granule_log2(std::uint32_t leaf_count) {
  const int level = std::bit_width(leaf_count) - 1;
  return std::uint32_t(std::clamp(level - 12, 0, 5));
}

/// Selects the cut of V·G of one receiver. The error of a node is Σ (g - ḡ)² / mean(g²) over its lights,
/// which for binary g of which half is 1 is twice that of visibility cuts: it does not depend on units or on
/// how near the lights are. Scratch is kept between calls.
class LocalCutSelector {
 public:
  /// Precondition: `lights` has one light a leaf of the tree; both outlive the selector.
  LocalCutSelector(const LightTree& tree, const LocalLightPackets& lights,
                   const VisibilityCutOptions& options)
      : tree_(&tree),
        lights_(&lights),
        options_(options),
        granule_log2_(local_granule_log2(tree.leaf_count())),
        granule_count_(tree.leaf_count() >> granule_log2_),
        nodes_(2 * std::size_t(granule_count_)) {}

  std::uint32_t granule_log2() const { return granule_log2_; }

  /// Bits by leaf rank. Without lights there are no pieces.
  LocalCut select(std::span<const std::uint64_t> bits, const Receiver& receiver) {
    if (granule_count_ == 0) return {};
    double squares = 0;
    for (std::uint32_t g = 0; g < granule_count_; ++g)
      nodes_[granule_count_ + g] = granule_moments(bits, receiver, g, squares);
    for (std::uint32_t h = granule_count_; h-- > 1;) nodes_[h] = nodes_[2 * h] + nodes_[2 * h + 1];
    LocalCut result;
    const std::vector<std::uint32_t> ends = select_ends(squares / nodes_[1].count);
    double greatest = 0;
    for_each_piece(ends, [&](LeafRange r, std::size_t) {
      const double value = nodes_[node_of_range(granule_count_, r.begin, r.end)].mean;
      greatest = std::max(greatest, value);
    });
    constexpr float one = quantised_one<std::uint16_t>;
    result.scale = float(greatest) / (one * one);
    result.cut = cut_with_values(granule_count_, ends, [&](std::uint32_t h) {
      return quantise<std::uint16_t>(greatest > 0 ? float(std::sqrt(nodes_[h].mean / greatest)) : 0.0f);
    });
    for (auto& end : result.cut.ends) end <<= granule_log2_;
    return result;
  }

 private:
  Moments granule_moments(std::span<const std::uint64_t> bits, const Receiver& receiver,
                          std::uint32_t granule, double& squares) const {
    Moments sum;
    const std::uint32_t size = 1u << granule_log2_;
    for (std::uint32_t leaf = granule * size; leaf < (granule + 1) * size; ++leaf) {
      if (tree_->light_of_leaf[leaf] == no_light) continue;
      const double g = bit_at(bits.data(), leaf) ? double(lights_->geometry(leaf, receiver.position)) : 0.0;
      squares += g * g;
      sum = sum + Moments::of(g);
    }
    return sum;
  }

  std::vector<std::uint32_t> select_ends(double mean_square) {
    const auto error = [&](std::uint32_t h) {
      return mean_square > 0 ? nodes_[h].squared_deviations / mean_square : 0.0;
    };
    if (options_.search == CutSearch::threshold)
      return select_by_threshold(granule_count_, error, options_.sigma * options_.sigma, options_.max_size);
    return optimal_.select(granule_count_, error, price_of_piece(options_.sigma), options_.max_size);
  }

  const LightTree* tree_;
  const LocalLightPackets* lights_;
  VisibilityCutOptions options_;
  std::uint32_t granule_log2_, granule_count_;
  std::vector<Moments> nodes_;
  OptimalCutSelector optimal_;
};

/// Cuts of V·G of all receivers, and the scale of each.
struct LocalCuts {
  MaskedCuts<std::uint16_t> cuts;
  std::vector<float> scales;  ///< a receiver; LocalCut::scale
  std::size_t rays = 0;
};

/// Traces every receiver once and selects its cut. The result does not depend on the executor. Precondition:
/// `lights` has one light a leaf of the tree.
template <Occluder O, Executor E>
LocalCuts precompute_local_cuts(const O& occluder, const LightTree& tree, const LocalLightPackets& lights,
                                std::span<const Receiver> receivers, const VisibilityCutOptions& options,
                                const E& executor, const Progress& progress = {},
                                const VisibilityRows& known = {}) {
  COPPICE_ASSERT(lights.count() == tree.leaf_count());
  LocalCuts result{
      MaskedCuts<std::uint16_t>(tree.leaf_count(), local_granule_log2(tree.leaf_count())), {}, 0};
  std::vector<LocalCut> block(visibility_block);
  const auto select = [&, selector = LocalCutSelector(tree, lights, options)](
                          std::size_t i, std::span<const std::uint64_t> bits) mutable {
    block[i % visibility_block] = selector.select(bits, receivers[i]);
  };
  const auto store = [&](std::size_t first, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      result.cuts.append(block[i].cut);
      result.scales.push_back(block[i].scale);
    }
    if (progress) progress(first + count, receivers.size());
  };
  result.rays = for_each_visibility(occluder, lights, receivers, executor, select, store, known);
  return result;
}

}  // namespace coppice
