// Many cuts in one store: a bitmask of ends on a grid of granules, and the values in order.
#pragma once

#include <coppice/shared/layout.h>

#include <bit>
#include <coppice/cut/cut.hpp>
#include <coppice/cut/quantise.hpp>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace coppice {

/// log2 of the leaves in a granule for binary functions at threshold σ. Their variance is at most 1/4, so a
/// node of m <= 4σ² leaves always passes Cuts Eq. 6 and no cut ends inside it. At most 32 leaves, at least 1,
/// and never more than the tree has.
inline std::uint32_t granule_log2_for(double sigma, std::uint32_t leaf_count) {
  std::uint32_t log2 = 0;
  while (log2 < 5 && double(2u << log2) <= 4 * sigma * sigma && (2u << log2) <= leaf_count) ++log2;
  return log2;
}

/// One cut of a MaskedCuts.
template <Quantised Value>
struct MaskedCutView {
  const std::uint32_t* mask;  ///< bit k: the cut has the end (k + 1) · granule
  const Value* values;
  ReceiverHorizon horizon;
};

/// The horizon of a cut that has a meaning towards all directions.
inline constexpr ReceiverHorizon no_horizon{vec3(0), -1};

/// Appends to `first_value` where the values of each cut end, counted on from its last entry; false where a
/// mask is not that of a cut through the tree: every leaf covered once, by nodes. `masks` has words_per_cut
/// words a cut. Precondition: leaf_count is a power of two of at least one granule.
inline bool index_pieces(std::uint32_t leaf_count, std::uint32_t granule_log2,
                         std::span<const std::uint32_t> masks, std::vector<std::uint32_t>& first_value) {
  const std::uint32_t granules = leaf_count >> granule_log2, words = (granules + 31) / 32;
  COPPICE_ASSERT(std::has_single_bit(granules) && masks.size() % words == 0);
  std::uint64_t pieces = first_value.back();
  for (std::size_t first = 0; first < masks.size(); first += words) {
    std::uint32_t begin = 0;
    for (std::uint32_t w = 0; w < words; ++w)
      for (std::uint32_t m = masks[first + w]; m != 0; m &= m - 1, ++pieces) {
        const std::uint32_t end = 32 * w + std::uint32_t(std::countr_zero(m)) + 1, size = end - begin;
        if ((size & (size - 1)) != 0 || (begin & (size - 1)) != 0) return false;
        begin = end;
      }
    if (begin != granules || pieces > ~std::uint32_t{0}) return false;
    first_value.push_back(std::uint32_t(pieces));
  }
  return true;
}

/// Cuts over one tree whose ends all lie on granules. The same arrays are read by cut_shade.comp.
/// Bytes a cut: leaf_count / granule / 8 for the mask, one value a piece, 16 for the horizon, and 4.
template <Quantised Value>
class MaskedCuts {
 public:
  /// Values that can be read behind those of any cut, so that a register of them may begin at the last.
  static constexpr std::size_t value_slack = 8;

  MaskedCuts() = default;
  MaskedCuts(std::uint32_t leaf_count, std::uint32_t granule_log2)
      : leaf_count_(leaf_count),
        granule_log2_(granule_log2),
        words_per_cut_(((leaf_count >> granule_log2) + 31) / 32) {}

  /// From the arrays that masks(), values() and horizons() give; none where they are not those of cuts: a
  /// mask of words_per_cut words and a horizon for each, a value for each bit. Precondition: leaf_count is 0,
  /// or a power of two of at least one granule.
  static std::optional<MaskedCuts> from_arrays(std::uint32_t leaf_count, std::uint32_t granule_log2,
                                               std::vector<std::uint32_t> masks, std::vector<Value> values,
                                               std::vector<ReceiverHorizon> horizons) {
    MaskedCuts cuts(leaf_count, granule_log2);
    if (masks.size() != horizons.size() * cuts.words_per_cut_) return std::nullopt;
    cuts.first_value_.reserve(horizons.size() + 1);
    if (leaf_count == 0)
      cuts.first_value_.resize(horizons.size() + 1, 0);
    else if (!index_pieces(leaf_count, granule_log2, masks, cuts.first_value_))
      return std::nullopt;
    if (cuts.first_value_.back() != values.size()) return std::nullopt;
    values.insert(values.end(), value_slack, Value(0));
    cuts.masks_ = std::move(masks), cuts.values_ = std::move(values), cuts.horizons_ = std::move(horizons);
    return cuts;
  }

  std::uint32_t leaf_count() const { return leaf_count_; }
  std::uint32_t granule_log2() const { return granule_log2_; }
  std::uint32_t words_per_cut() const { return words_per_cut_; }
  std::size_t size() const { return first_value_.size() - 1; }
  std::size_t piece_count(std::size_t i) const { return first_value_[i + 1] - first_value_[i]; }
  std::size_t byte_count() const {
    return masks_.size() * sizeof(std::uint32_t) + values().size() * sizeof(Value) + first_value_.size() * 4 +
           horizons_.size() * sizeof(ReceiverHorizon);
  }
  std::span<const std::uint32_t> masks() const { return masks_; }
  std::span<const Value> values() const { return std::span(values_).first(values_.size() - value_slack); }
  std::span<const std::uint32_t> first_value() const { return first_value_; }  ///< size() + 1 offsets
  std::span<const ReceiverHorizon> horizons() const { return horizons_; }

  MaskedCutView<Value> operator[](std::size_t i) const {
    return {masks_.data() + i * words_per_cut_, values_.data() + first_value_[i], horizons_[i]};
  }

  /// Adds a cut whose ends are multiples of the granule.
  void append(CutView<Value> cut, const ReceiverHorizon& horizon = no_horizon) {
    const std::size_t base = masks_.size();
    masks_.resize(base + words_per_cut_, 0);
    for (const std::uint32_t end : cut.ends) {
      const std::uint32_t bit = (end >> granule_log2_) - 1;
      COPPICE_ASSERT(end % (1u << granule_log2_) == 0 && end <= leaf_count_);
      masks_[base + bit / 32] |= 1u << (bit % 32);
    }
    values_.erase(values_.end() - value_slack, values_.end());
    values_.insert(values_.end(), cut.values.begin(), cut.values.end());
    first_value_.push_back(std::uint32_t(values_.size()));
    values_.insert(values_.end(), value_slack, Value(0));
    horizons_.push_back(horizon);
  }

  /// Cut i with its ends spelled out.
  Cut<Value> unpack(std::size_t i) const {
    Cut<Value> cut;
    for (std::uint32_t w = 0; w < words_per_cut_; ++w)
      for (std::uint32_t m = masks_[i * words_per_cut_ + w]; m != 0; m &= m - 1)
        cut.ends.push_back((32 * w + std::uint32_t(std::countr_zero(m)) + 1) << granule_log2_);
    cut.values.assign(values_.begin() + first_value_[i], values_.begin() + first_value_[i + 1]);
    return cut;
  }

 private:
  std::uint32_t leaf_count_ = 0, granule_log2_ = 0, words_per_cut_ = 0;
  std::vector<std::uint32_t> masks_;
  std::vector<std::uint32_t> first_value_{0};
  std::vector<Value> values_ = std::vector<Value>(value_slack);
  std::vector<ReceiverHorizon> horizons_;
};

}  // namespace coppice
