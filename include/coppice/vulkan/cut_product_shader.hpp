// Products of visibility cuts on a Vulkan device: what receivers see past objects that move.
#pragma once

#include <coppice/relight/field_products.hpp>
#include <coppice/vulkan/device_cuts.hpp>
#include <memory>
#include <optional>

namespace coppice {

struct CutProduct {
  DeviceCuts cuts;                     ///< for CutShader::set_cuts
  std::optional<double> milliseconds;  ///< of the kernels on the device; empty where its queue has no clock
};

/// Computes what multiply_by_fields does (Cuts section 4.2): the cut of every receiver times its blends of
/// the fields' cuts, on the union of all ends but for those inside pieces where the receiver's own cut is 0.
/// The operations are those of CutMultiplier in their order: masks are the same bit for bit, and so are
/// values where the CPU does not fuse products with sums.
class CutProductShader {
 public:
  /// Uploads the cuts of the receivers, of which the caller need keep nothing. Throws InputError where they
  /// do not fit into the device's memory.
  CutProductShader(VulkanDevice& device, const MaskedCuts<std::uint8_t>& cuts);
  ~CutProductShader();
  CutProductShader(CutProductShader&&) noexcept;
  CutProductShader& operator=(CutProductShader&&) noexcept;

  /// Uploads the fields' cuts and the blends, and waits for the device. Throws InputError where the products
  /// do not fit into its memory. Precondition: the fields are those of the blends, the blends are of these
  /// receivers, and all cuts are of one tree and granule.
  CutProduct multiply(const FieldBlends& blends, std::span<const PlacedField> fields);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace coppice
