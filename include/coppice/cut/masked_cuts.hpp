// Many cuts in one store: a bitmask of ends on a grid of granules, and the values in order.
#pragma once

#include <coppice/shared/layout.h>

#include <bit>
#include <coppice/cut/cut.hpp>
#include <coppice/cut/quantise.hpp>
#include <cstdint>
#include <span>
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
