#include <coppice/shared/cut_product.h>

#include <coppice/core/config.hpp>
#include <coppice/vulkan/cut_product_shader.hpp>
#include <limits>

#include "device_cuts_state.hpp"
#include "product_factors.hpp"
#include "shaders/cut_product_masks.h"
#include "shaders/cut_product_values.h"
#include "shaders/cut_ranks.h"

namespace coppice {
namespace {

using compute::Buffer;
using compute::Memory;

/// The factors of one call, on the device.
struct FactorBuffers {
  CutBuffers cuts;
  Buffer ranks, first_factor, blends;
  std::uint32_t cut_count;

  FactorBuffers(const VulkanDevice& device, const FactorCuts& all, const FactorBlends& of_receivers)
      : cuts(upload_cuts<std::uint8_t>(device, all.masks, all.first_value, all.values)),
        ranks(device, Memory::device, cuts.masks.byte_count()),
        first_factor(compute::buffer_of(device, std::span(of_receivers.first_factor))),
        blends(compute::buffer_of(device, std::span(of_receivers.factors))),
        cut_count(all.count()) {}
};

/// Where the values of each cut begin, and behind the last. Throws InputError where there are more than an
/// index can tell.
std::vector<std::uint32_t> first_values(const VulkanDevice& device, std::span<const std::uint32_t> counts) {
  std::vector<std::uint32_t> first{0};
  std::uint64_t sum = 0;
  for (const std::uint32_t count : counts) first.push_back(std::uint32_t(sum += count));
  if (sum > std::numeric_limits<std::uint32_t>::max())
    throw InputError("Vulkan device " + device.name(),
                     "products of cuts have " + std::to_string(sum >> 20) + " MiB of values",
                     "use fewer receivers or coarser cuts, for less than 4096 MiB");
  return first;
}

std::optional<double> sum(std::optional<double> a, std::optional<double> b) {
  if (!a || !b) return std::nullopt;
  return *a + *b;
}

}  // namespace

struct CutProductShader::State {
  VulkanDevice& device;
  compute::Kernel ranks, masks, values;
  DeviceCuts base;
  Buffer base_ranks;

  State(VulkanDevice& vulkan, const MaskedCuts<std::uint8_t>& cuts);
  std::uint32_t words() const { return words_per_cut(base.state().leaf_count, base.state().granule_log2); }
  ProductTask task(const FactorBuffers& factors) const;
  void dispatch_ranks(compute::Commands& commands, const CutBuffers& cuts, std::uint32_t count,
                      const Buffer& result) const;
  std::optional<double> write_masks(const FactorBuffers& factors, const Buffer& product_masks,
                                    const Buffer& counts) const;
  std::optional<double> write_values(const FactorBuffers& factors, const CutBuffers& product,
                                     const Buffer& horizons) const;
};

CutProductShader::State::State(VulkanDevice& vulkan, const MaskedCuts<std::uint8_t>& cuts)
    : device(vulkan),
      ranks(device, shaders::cut_ranks, sizeof(CutRanksParameters)),
      masks(device, shaders::cut_product_masks, sizeof(ProductMasksParameters)),
      values(device, shaders::cut_product_values, sizeof(ProductValuesParameters)),
      base(device, cuts),
      base_ranks(device, Memory::device, base.state().cuts.masks.byte_count()) {
  compute::Commands commands(device);
  dispatch_ranks(commands, base.state().cuts, base.size(), base_ranks);
  commands.submit();
}

ProductTask CutProductShader::State::task(const FactorBuffers& factors) const {
  return {.base = base.state().cuts.store(),
          .factors = factors.cuts.store(),
          .factor_ranks = factors.ranks.address(),
          .first_factor = factors.first_factor.address(),
          .blends = factors.blends.address()};
}

void CutProductShader::State::dispatch_ranks(compute::Commands& commands, const CutBuffers& cuts,
                                             std::uint32_t count, const Buffer& result) const {
  const CutRanksParameters parameters{.masks = cuts.masks.address(),
                                      .first_value = cuts.first_value.address(),
                                      .ranks = result.address(),
                                      .range = {},
                                      .words = words()};
  compute::dispatch_items(commands, device, ranks, parameters, count);
}

/// The first pass. Returns its milliseconds.
std::optional<double> CutProductShader::State::write_masks(const FactorBuffers& factors,
                                                           const Buffer& product_masks,
                                                           const Buffer& counts) const {
  const ProductMasksParameters parameters{.product = task(factors),
                                          .masks = product_masks.address(),
                                          .counts = counts.address(),
                                          .range = {},
                                          .words = words()};
  compute::Commands commands(device);
  commands.read_clock();
  compute::dispatch_items(commands, device, masks, parameters, base.size());
  commands.read_clock();
  commands.submit();
  return commands.milliseconds();
}

/// The second pass. Returns its milliseconds.
std::optional<double> CutProductShader::State::write_values(const FactorBuffers& factors,
                                                            const CutBuffers& product,
                                                            const Buffer& horizons) const {
  const Buffer product_ranks(device, Memory::device, product.masks.byte_count());
  const ProductValuesParameters parameters{.product = task(factors),
                                           .base_ranks = base_ranks.address(),
                                           .masks = product.masks.address(),
                                           .ranks = product_ranks.address(),
                                           .values = product.values.address(),
                                           .range = {},
                                           .words = words()};
  compute::Commands commands(device);
  commands.copy(base.state().horizons, 0, horizons, 0, horizons.byte_count());
  commands.fill_with_zeros(product.values);
  commands.read_clock();
  dispatch_ranks(commands, factors.cuts, factors.cut_count, factors.ranks);
  dispatch_ranks(commands, product, base.size(), product_ranks);
  commands.barrier();
  compute::dispatch_items(commands, device, values, parameters, base.size() * words());
  commands.read_clock();
  commands.submit();
  return commands.milliseconds();
}

CutProductShader::CutProductShader(VulkanDevice& device, const MaskedCuts<std::uint8_t>& cuts)
    : state_(std::make_unique<State>(device, cuts)) {}
CutProductShader::~CutProductShader() = default;
CutProductShader::CutProductShader(CutProductShader&&) noexcept = default;
CutProductShader& CutProductShader::operator=(CutProductShader&&) noexcept = default;

CutProduct CutProductShader::multiply(const FieldBlends& blends, std::span<const PlacedField> fields) {
  const VulkanDevice& device = state_->device;
  const auto& base = state_->base.state();
  for ([[maybe_unused]] const PlacedField& field : fields)
    COPPICE_ASSERT(field.cuts.leaf_count() == base.leaf_count &&
                   field.cuts.granule_log2() == base.granule_log2);
  const FactorCuts cuts(fields);
  const FactorBuffers factors(device, cuts, FactorBlends(blends, cuts.first_cut, base.count));
  Buffer masks(device, Memory::device, base.cuts.masks.byte_count());
  const Buffer counts(device, Memory::device, sizeof(std::uint32_t) * base.count);
  const auto of_masks = state_->write_masks(factors, masks, counts);
  const auto first_value = first_values(device, compute::items_of<std::uint32_t>(device, counts, base.count));
  CutBuffers product{std::move(masks), compute::buffer_of(device, std::span(first_value)),
                     Buffer(device, Memory::device, packed_size(first_value.back()))};
  Buffer horizons(device, Memory::device, base.horizons.byte_count());
  const auto of_values = state_->write_values(factors, product, horizons);
  return {DeviceCuts(DeviceCuts::State{&device, base.leaf_count, base.granule_log2, base.count,
                                       first_value.back(), std::move(product), std::move(horizons)}),
          sum(of_masks, of_values)};
}

}  // namespace coppice
