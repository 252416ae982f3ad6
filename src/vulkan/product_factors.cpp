#include "product_factors.hpp"

#include <coppice/core/config.hpp>
#include <limits>

namespace coppice {

FactorCuts::FactorCuts(std::span<const PlacedField> fields) {
  for (const PlacedField& field : fields) {
    const MaskedCuts<std::uint8_t>& cuts = field.cuts;
    COPPICE_ASSERT(values.size() + cuts.values().size() <= std::numeric_limits<std::uint32_t>::max());
    first_cut.push_back(count());
    for (std::size_t i = 0; i < cuts.size(); ++i)
      first_value.push_back(std::uint32_t(values.size()) + cuts.first_value()[i]);
    masks.insert(masks.end(), cuts.masks().begin(), cuts.masks().end());
    values.insert(values.end(), cuts.values().begin(), cuts.values().end());
  }
}

namespace {

ProductFactor factor_of(const SampleBlend& blend, std::uint32_t first_cut) {
  ProductFactor factor{};
  for (; factor.count < blend.count; ++factor.count) {
    factor.cuts[factor.count] = first_cut + blend.samples[factor.count];
    factor.weights[factor.count] = blend.weights[factor.count];
  }
  return factor;
}

}  // namespace

FactorBlends::FactorBlends(const FieldBlends& blends, std::span<const std::uint32_t> first_cut,
                           std::size_t receiver_count)
    : first_factor{0} {
  for (std::size_t i = 0; i < receiver_count; ++i) {
    const auto of_receiver = blends.of(i);
    COPPICE_ASSERT(of_receiver.size() == first_cut.size());
    for (std::size_t k = 0; k < of_receiver.size(); ++k)
      if (of_receiver[k].count > 0) factors.push_back(factor_of(of_receiver[k], first_cut[k]));
    first_factor.push_back(std::uint32_t(factors.size()));
  }
}

}  // namespace coppice
