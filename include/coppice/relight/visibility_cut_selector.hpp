// From one row of visibility bits to a cut: which lights count how much, and where to split.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <coppice/cut/masked_cuts.hpp>
#include <coppice/cut/select.hpp>
#include <coppice/relight/visibility.hpp>
#include <memory>
#include <span>
#include <vector>

namespace coppice {

/// How much a light counts at a receiver. uniform: 1. cosine: as much as it can light the surface there, w =
/// max(0, (cos - c)/(1 - c)), with cos towards the light and c that of the receiver's horizon; the values of
/// the cut are then means weighted by w.
enum class CutWeight { uniform, cosine };

/// threshold: every node with error > σ² is split (Cuts Eq. 6). optimal: the least Σ error +
/// price_of_piece(σ) · pieces.
enum class CutSearch { threshold, optimal };

/// (σ/3)²: at equal σ cosine weights and this price give about the image error of the paper's cuts.
inline double price_of_piece(double sigma) { return sigma * sigma / 9; }

/// The error of a node is Σ w (v - v̄)² over its lights, which for weight 1 is |C|·var. A cut that would need
/// more than max_size pieces is split at the worst nodes first (threshold), or the price is doubled until it
/// fits (optimal).
struct VisibilityCutOptions {
  double sigma = 2;             ///< smaller is finer; the paper: 1.5 to 3
  std::size_t max_size = 1000;  ///< pieces a cut at most
  CutWeight weight = CutWeight::cosine;
  CutSearch search = CutSearch::optimal;
};

/// The horizon under which a cut of this receiver is selected and stored. For cosine weights it is the
/// receiver's, or lower where normal maps bend the surface; its cosine is in [-1, 0].
inline ReceiverHorizon horizon_of(const Receiver& receiver, CutWeight weight) {
  if (weight == CutWeight::uniform) return no_horizon;
  return {receiver.normal, std::clamp(std::min(receiver.horizon, -receiver.bend), -1.0f, 0.0f)};
}

/// The leaves' directions in the order in which granules are summed, 16 granules at once.
class GranuleDirections {
 public:
  static constexpr std::uint32_t lanes = 16;
  /// Σ of weights in each of 16 granules, over all lights and over the visible ones: visible <= all, exactly.
  struct Sums {
    std::array<float, lanes> all{}, visible{};
  };

  GranuleDirections(const LightTree& tree, const DirectionPackets& leaf_lights, std::uint32_t granule_log2)
      : granule_(1u << granule_log2), rows_((tree.leaf_count() / granule_ + lanes - 1) / lanes * granule_) {
    COPPICE_ASSERT(leaf_lights.count() == tree.leaf_count());
    for (std::uint32_t leaf = 0; leaf < tree.leaf_count(); ++leaf) {
      if (tree.light_of_leaf[leaf] == no_light) continue;
      const std::uint32_t granule = leaf / granule_, lane = granule % lanes;
      Row& row = rows_[granule / lanes * granule_ + leaf % granule_];
      const vec3 d = leaf_lights.direction(leaf);
      row.x[lane] = d.x, row.y[lane] = d.y, row.z[lane] = d.z, row.is_light[lane] = 1;
    }
  }

  /// Sums of the granules from 16 · block on; bit k of seen[lane] is the visibility of the granule's leaf k.
  Sums sum(std::uint32_t block, const std::array<std::uint32_t, lanes>& seen,
           const ReceiverHorizon& horizon) const {
    const vec3 n = horizon.normal;
    const float c = horizon.cosine, scale = 1 / (1 - c);
    Sums sums;
    for (std::uint32_t k = 0; k < granule_; ++k) {
      const Row& row = rows_[block * granule_ + k];
      for (std::uint32_t i = 0; i < lanes; ++i) {
        const float above = n.x * row.x[i] + n.y * row.y[i] + n.z * row.z[i] - c * row.is_light[i];
        const float weight = above > 0 ? above : 0.0f;
        sums.all[i] += weight;
        sums.visible[i] += weight * float(seen[i] >> k & 1u);
      }
    }
    for (std::uint32_t i = 0; i < lanes; ++i) sums.all[i] *= scale, sums.visible[i] *= scale;
    return sums;
  }

 private:
  struct Row {  // the k-th leaf of each of 16 granules; zero where there is no light
    std::array<float, lanes> x{}, y{}, z{}, is_light{};
  };

  std::uint32_t granule_;
  std::vector<Row> rows_;
};

/// Selects the visibility cut of one row of bits. Weights are summed up the tree from granules of 4σ² leaves,
/// whose error never exceeds σ², as w <= 1: so no cut by threshold ends inside one, and for optimal cuts they
/// are the limit of resolution. Scratch is kept between calls; copies share the directions.
class VisibilityCutSelector {
 public:
  /// Precondition: `leaf_lights` has one direction a leaf of the tree, which outlives the selector.
  VisibilityCutSelector(const LightTree& tree, const DirectionPackets& leaf_lights,
                        const VisibilityCutOptions& options)
      : tree_(&tree),
        options_(options),
        granule_log2_(granule_log2_for(options.sigma, tree.leaf_count())),
        granule_count_(tree.leaf_count() >> granule_log2_) {
    if (options.weight == CutWeight::cosine)
      directions_ = std::make_shared<const GranuleDirections>(tree, leaf_lights, granule_log2_);
  }

  std::uint32_t granule_log2() const { return granule_log2_; }

  /// Bits by leaf rank; padding leaves must be zero. The horizon: horizon_of(receiver, options.weight). A
  /// piece whose lights all lie below it has the value 0.
  template <Quantised Value>
  Cut<Value> select(std::span<const std::uint64_t> bits, const ReceiverHorizon& horizon = no_horizon) {
    sum_granules(bits, horizon);
    for (std::uint32_t h = granule_count_; h-- > 1;) {
      all_[h] = all_[2 * h] + all_[2 * h + 1];
      visible_[h] = visible_[2 * h] + visible_[2 * h + 1];
    }
    auto cut = cut_with_values(granule_count_, select_ends(), [this](std::uint32_t h) {
      return quantise<Value>(all_[h] > 0 ? float(visible_[h] / all_[h]) : 0.0f);
    });
    for (auto& end : cut.ends) end <<= granule_log2_;
    return cut;
  }

 private:
  /// Heap ids of the tree over granules are those of the light tree above them.
  void sum_granules(std::span<const std::uint64_t> bits, const ReceiverHorizon& horizon) {
    COPPICE_ASSERT((options_.weight == CutWeight::uniform) == (horizon.normal == vec3(0)));
    all_.resize(2 * std::size_t(granule_count_));
    visible_.resize(all_.size());
    if (options_.weight == CutWeight::uniform)
      count_lights(bits);
    else
      sum_weights(bits, horizon);
  }

  void count_lights(std::span<const std::uint64_t> bits) {
    for (std::uint32_t g = 0; g < granule_count_; ++g) {
      all_[granule_count_ + g] = tree_->light_count[granule_count_ + g];
      visible_[granule_count_ + g] = std::popcount(granule_bits(bits, g));
    }
  }

  void sum_weights(std::span<const std::uint64_t> bits, const ReceiverHorizon& horizon) {
    constexpr std::uint32_t lanes = GranuleDirections::lanes;
    std::array<std::uint32_t, lanes> seen{};
    for (std::uint32_t first = 0; first < granule_count_; first += lanes) {
      const std::uint32_t count = std::min(lanes, granule_count_ - first);
      for (std::uint32_t i = 0; i < count; ++i) seen[i] = granule_bits(bits, first + i);
      const auto sums = directions_->sum(first / lanes, seen, horizon);
      std::copy_n(sums.all.begin(), count, all_.begin() + granule_count_ + first);
      std::copy_n(sums.visible.begin(), count, visible_.begin() + granule_count_ + first);
    }
  }

  std::uint32_t granule_bits(std::span<const std::uint64_t> bits, std::uint32_t granule) const {
    const std::uint32_t first = granule << granule_log2_;
    const std::uint64_t mask = (std::uint64_t{1} << (1u << granule_log2_)) - 1;
    return std::uint32_t(bits[first / 64] >> (first % 64) & mask);
  }

  std::vector<std::uint32_t> select_ends() {
    const double sigma2 = options_.sigma * options_.sigma;
    const auto error = [this](std::uint32_t h) {
      const double all = all_[h], visible = visible_[h];
      return all > 0 ? visible * (all - visible) / all : 0.0;
    };
    if (options_.search == CutSearch::threshold)
      return select_by_threshold(granule_count_, error, sigma2, options_.max_size);
    return optimal_.select(granule_count_, error, price_of_piece(options_.sigma), options_.max_size);
  }

  const LightTree* tree_;
  VisibilityCutOptions options_;
  std::uint32_t granule_log2_, granule_count_;
  std::shared_ptr<const GranuleDirections> directions_;
  std::vector<double> all_, visible_;  // a heap id; Σ w over the node's lights, and over the visible ones
  OptimalCutSelector optimal_;
};

}  // namespace coppice
