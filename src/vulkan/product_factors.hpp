// The factors of products of cuts as kernels read them.
#pragma once

#include <coppice/shared/cut_product.h>

#include <coppice/relight/field_products.hpp>
#include <span>
#include <vector>

namespace coppice {

/// The cuts of all fields, one store after the other.
struct FactorCuts {
  std::vector<std::uint32_t> masks, first_value;
  std::vector<std::uint8_t> values;
  std::vector<std::uint32_t> first_cut;  ///< by field

  explicit FactorCuts(std::span<const PlacedField> fields);
  std::uint32_t count() const { return std::uint32_t(first_value.size()); }
};

/// The factors of all receivers. Blends without samples are left out.
struct FactorBlends {
  std::vector<std::uint32_t> first_factor;  ///< by receiver, and one more
  std::vector<ProductFactor> factors;

  /// `first_cut`: FactorCuts::first_cut.
  FactorBlends(const FieldBlends& blends, std::span<const std::uint32_t> first_cut,
               std::size_t receiver_count);
};

}  // namespace coppice
