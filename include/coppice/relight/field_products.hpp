// What receivers see past everything that hides lights from them: their own cuts times those of shadow
// fields.
#pragma once

#include <coppice/relight/cut_product.hpp>
#include <coppice/relight/shadow_field.hpp>
#include <coppice/scene/motion.hpp>

namespace coppice {

/// A shadow field where its object stands now.
struct PlacedField {
  const ShadowField* field;
  RigidTransform to_field;          ///< from the world
  MaskedCuts<std::uint8_t> cuts{};  ///< of its samples, on the world's tree, where they are used
};

/// The samples of fields that receivers need.
class FieldBlends {
 public:
  /// `positions` in the world. Marks the samples used by field k in used[k]. Receivers that are not wanted
  /// need none.
  template <Executor E>
  FieldBlends(std::span<const PlacedField> fields, std::span<const vec3> positions,
              std::span<const std::uint8_t> wanted, std::vector<std::vector<std::uint8_t>>& used,
              const E& executor)
      : field_count_(fields.size()), blends_(fields.size() * positions.size()) {
    executor(positions.size(), 256, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        for (std::size_t k = 0; wanted[i] && k < field_count_; ++k) {
          const SampleBlend blend = fields[k].field->locate(fields[k].to_field.point(positions[i]));
          if (!fields[k].field->is_clear(blend)) blends_[i * field_count_ + k] = blend;
        }
    });
    for (std::size_t b = 0; b < blends_.size(); ++b)
      for (std::uint32_t s = 0; s < blends_[b].count; ++s) used[b % field_count_][blends_[b].samples[s]] = 1;
  }

  /// A blend a field; those without samples hide nothing from the receiver.
  std::span<const SampleBlend> of(std::size_t receiver) const {
    return std::span(blends_).subspan(receiver * field_count_, field_count_);
  }

 private:
  std::size_t field_count_;
  std::vector<SampleBlend> blends_;
};

namespace detail {

/// The factors of one receiver's product.
class ProductFactors {
 public:
  std::span<const CutFactor> gather(std::span<const SampleBlend> blends,
                                    std::span<const PlacedField> fields) {
    cuts_.clear();
    for (std::size_t k = 0; k < blends.size(); ++k)
      for (std::uint32_t s = 0; s < blends[k].count; ++s)
        cuts_.push_back(fields[k].cuts[blends[k].samples[s]]);
    factors_.clear();
    std::size_t first = 0;
    for (const SampleBlend& blend : blends) {
      if (blend.count == 0) continue;
      factors_.push_back(
          {std::span(cuts_).subspan(first, blend.count), std::span(blend.weights).first(blend.count)});
      first += blend.count;
    }
    return factors_;
  }

 private:
  std::vector<MaskedCutView<std::uint8_t>> cuts_;
  std::vector<CutFactor> factors_;
};

}  // namespace detail

/// The cuts of receivers times their blends of the fields' cuts. `shadowed`, where given, receives how many
/// have any.
template <Executor E>
MaskedCuts<std::uint8_t> multiply_by_fields(const MaskedCuts<std::uint8_t>& cuts, const FieldBlends& blends,
                                            std::span<const PlacedField> fields, const E& executor,
                                            std::size_t* shadowed = nullptr) {
  std::vector<CutReplacement> made(cuts.size());
  executor(made.size(), 64, [&](std::size_t begin, std::size_t end) {
    CutMultiplier multiplier;
    detail::ProductFactors factors;
    for (std::size_t i = begin; i < end; ++i) {
      const auto all = factors.gather(blends.of(i), fields);
      if (all.empty()) continue;
      multiplier.multiply(cuts[i], all, cuts.words_per_cut());
      made[i] = {{multiplier.mask().begin(), multiplier.mask().end()},
                 {multiplier.values().begin(), multiplier.values().end()}};
    }
  });
  if (shadowed)
    *shadowed =
        std::size_t(std::ranges::count_if(made, [](const CutReplacement& r) { return !r.mask.empty(); }));
  return replace_cuts(cuts, made);
}

}  // namespace coppice
