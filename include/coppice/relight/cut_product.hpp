// Products of visibility cuts: what is seen past several objects at once.
#pragma once

#include <algorithm>
#include <bit>
#include <coppice/cut/masked_cuts.hpp>
#include <span>
#include <vector>

namespace coppice {

/// A weighted mean of cuts, a factor of a product.
struct CutFactor {
  std::span<const MaskedCutView<std::uint8_t>> cuts;
  std::span<const float> weights;  ///< a cut; sum 1
};

/// Multiplies a cut with means of others: V · Π_k Σ_s w_ks V_ks on the union of all ends (Cuts section 4.2),
/// rounded to 8 bits, but with no ends inside pieces where V is 0. Scratch is kept between calls.
class CutMultiplier {
 public:
  /// All cuts are of one tree and granule; `words`: those of a mask.
  void multiply(const MaskedCutView<std::uint8_t>& base, std::span<const CutFactor> factors,
                std::uint32_t words) {
    mask_.assign(words, 0);
    values_.clear();
    const std::uint8_t* base_value = base.values;
    start(factors);
    for (std::uint32_t w = 0; w < words; ++w) {
      std::uint32_t ends = base.mask[w];
      for (const Cursor& c : cursors_) ends |= c.mask[w];
      for (; ends != 0; ends &= ends - 1) {
        const std::uint32_t bit = ends & -ends;
        const bool ends_base = (base.mask[w] & bit) != 0;
        if (*base_value != 0 || ends_base) {
          mask_[w] |= bit;
          values_.push_back(product(*base_value, factors));
        }
        base_value += ends_base;
        for (Cursor& c : cursors_) c.value += (c.mask[w] & bit) != 0;
      }
    }
  }

  std::span<const std::uint32_t> mask() const { return mask_; }
  std::span<const std::uint8_t> values() const { return values_; }

 private:
  struct Cursor {
    const std::uint32_t* mask;
    const std::uint8_t* value;  // of the piece that holds the next leaf
  };

  void start(std::span<const CutFactor> factors) {
    cursors_.clear();
    for (const CutFactor& f : factors)
      for (const auto& cut : f.cuts) cursors_.push_back({cut.mask, cut.values});
  }

  std::uint8_t product(std::uint8_t base, std::span<const CutFactor> factors) const {
    float value = base;
    const Cursor* c = cursors_.data();
    for (const CutFactor& f : factors) {
      float mean = 0;
      for (const float weight : f.weights) mean += weight * float(*(c++)->value);
      value *= mean * (1 / 255.0f);
    }
    return std::uint8_t(std::min(value, 255.0f) + 0.5f);
  }

  std::vector<std::uint32_t> mask_;
  std::vector<std::uint8_t> values_;
  std::vector<Cursor> cursors_;
};

/// A cut that takes the place of another in a store: its mask, and a value for each end. Empty: none does.
struct CutReplacement {
  std::vector<std::uint32_t> mask;
  std::vector<std::uint8_t> values;
};

/// The store with some cuts replaced, and the normals of all horizons turned.
inline MaskedCuts<std::uint8_t> replace_cuts(const MaskedCuts<std::uint8_t>& cuts,
                                             std::span<const CutReplacement> replacements,
                                             const glm::quat& turn = glm::quat(1, 0, 0, 0)) {
  COPPICE_ASSERT(replacements.size() == cuts.size());
  std::vector<std::uint32_t> masks(cuts.masks().begin(), cuts.masks().end());
  std::vector<std::uint8_t> values;
  values.reserve(cuts.values().size());
  std::vector<ReceiverHorizon> horizons(cuts.horizons().begin(), cuts.horizons().end());
  for (ReceiverHorizon& h : horizons) h.normal = turn * h.normal;
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    const CutReplacement& r = replacements[i];
    if (r.mask.empty()) {
      values.insert(values.end(), cuts[i].values, cuts[i].values + cuts.piece_count(i));
      continue;
    }
    std::ranges::copy(r.mask, masks.begin() + std::ptrdiff_t(i * cuts.words_per_cut()));
    values.insert(values.end(), r.values.begin(), r.values.end());
  }
  auto made = MaskedCuts<std::uint8_t>::from_arrays(cuts.leaf_count(), cuts.granule_log2(), std::move(masks),
                                                    std::move(values), std::move(horizons));
  COPPICE_ASSERT(made.has_value());
  return std::move(*made);
}

}  // namespace coppice
