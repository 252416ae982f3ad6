// Cuts over the directions of a frame that has turned against the world.
#pragma once

#include <coppice/core/parallel.hpp>
#include <coppice/cut/select.hpp>
#include <coppice/relight/cut_product.hpp>
#include <coppice/relight/visibility_cut_selector.hpp>

namespace coppice {

/// Where the lights of the world's tree lie in that of a turned frame: for each leaf the leaf of the light
/// nearest to its direction there. Padding stays where it is.
using LeafTurn = std::vector<std::uint32_t>;

/// `leaf_directions`: by leaf, zero for padding; nearest_leaf(direction) is the leaf of the nearest light.
template <class NearestLeaf>
LeafTurn turn_leaves(std::span<const vec3> leaf_directions, const glm::quat& frame_from_world,
                     NearestLeaf&& nearest_leaf) {
  LeafTurn turn(leaf_directions.size());
  for (std::uint32_t leaf = 0; leaf < turn.size(); ++leaf) {
    const vec3 d = leaf_directions[leaf];
    turn[leaf] = d == vec3(0) ? leaf : nearest_leaf(frame_from_world * d);
  }
  return turn;
}

/// Cuts anew what cuts in a turned frame say, on the world's tree: the optimal cut of price price_of_piece(σ)
/// of the granules' means. Scratch is kept between calls.
class CutTurner {
 public:
  CutTurner(const LightTree& tree, std::uint32_t granule_log2, double sigma)
      : tree_(&tree),
        granule_log2_(granule_log2),
        granule_count_(tree.leaf_count() >> granule_log2),
        price_(price_of_piece(sigma)),
        values_(granule_count_),
        sums_(2 * std::size_t(granule_count_)) {}

  /// The cut on granules of the world.
  CutReplacement turn(const MaskedCutView<std::uint8_t>& cut, std::span<const std::uint32_t> turn_of_leaf) {
    expand(cut);
    for (std::uint32_t g = 0; g < granule_count_; ++g)
      sums_[granule_count_ + g] = granule_sum(g, turn_of_leaf);
    for (std::uint32_t h = granule_count_; h-- > 1;)
      sums_[h] = {sums_[2 * h].values + sums_[2 * h + 1].values,
                  sums_[2 * h].squares + sums_[2 * h + 1].squares};
    const auto error = [this](std::uint32_t h) {
      const double count = tree_->light_count[h], values = double(sums_[h].values);
      return count > 0 ? std::max(0.0, double(sums_[h].squares) - values * values / count) / (255.0 * 255.0)
                       : 0.0;
    };
    CutReplacement result{std::vector<std::uint32_t>((granule_count_ + 31) / 32, 0), {}};
    const auto ends = optimal_.select(granule_count_, error, price_, unlimited);
    for_each_piece(ends, [&](LeafRange r, std::size_t) {
      result.mask[(r.end - 1) / 32] |= 1u << ((r.end - 1) % 32);
      result.values.push_back(mean(node_of_range(granule_count_, r.begin, r.end)));
    });
    return result;
  }

 private:
  struct Sum {
    std::uint64_t values = 0, squares = 0;
  };

  /// The value on each granule of the turned frame.
  void expand(const MaskedCutView<std::uint8_t>& cut) {
    const std::uint8_t* value = cut.values;
    for (std::uint32_t g = 0; g < granule_count_; ++g) {
      values_[g] = *value;
      value += cut.mask[g / 32] >> (g % 32) & 1;
    }
  }

  Sum granule_sum(std::uint32_t granule, std::span<const std::uint32_t> turn_of_leaf) const {
    Sum sum;
    for (std::uint32_t leaf = granule << granule_log2_; leaf < (granule + 1) << granule_log2_; ++leaf) {
      const std::uint32_t v =
          tree_->light_of_leaf[leaf] == no_light ? 0 : values_[turn_of_leaf[leaf] >> granule_log2_];
      sum.values += v;
      sum.squares += v * v;
    }
    return sum;
  }

  std::uint8_t mean(std::uint32_t h) const {
    const std::uint32_t count = tree_->light_count[h];
    return count == 0 ? std::uint8_t{0} : std::uint8_t((sums_[h].values + count / 2) / count);
  }

  const LightTree* tree_;
  std::uint32_t granule_log2_, granule_count_;
  double price_;
  std::vector<std::uint8_t> values_;
  std::vector<Sum> sums_;
  OptimalCutSelector optimal_;
};

/// The wanted cuts of a store on the world's tree; the others stay as they are. Cuts of one piece are the
/// same in every frame.
template <Executor E>
MaskedCuts<std::uint8_t> turn_cuts(const LightTree& tree, const MaskedCuts<std::uint8_t>& cuts,
                                   const LeafTurn& turn, std::span<const std::uint8_t> wanted, double sigma,
                                   const glm::quat& world_from_frame, const E& executor) {
  std::vector<CutReplacement> made(cuts.size());
  executor(made.size(), 64, [&](std::size_t begin, std::size_t end) {
    CutTurner turner(tree, cuts.granule_log2(), sigma);
    for (std::size_t i = begin; i < end; ++i)
      if (wanted[i] && cuts.piece_count(i) > 1) made[i] = turner.turn(cuts[i], turn);
  });
  return replace_cuts(cuts, made, world_from_frame);
}

}  // namespace coppice
