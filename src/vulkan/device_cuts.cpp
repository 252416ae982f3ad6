#include <coppice/core/config.hpp>

#include "device_cuts_state.hpp"

namespace coppice {

DeviceCuts::DeviceCuts(const VulkanDevice& device, const MaskedCuts<std::uint8_t>& cuts)
    : DeviceCuts(State{&device, cuts.leaf_count(), cuts.granule_log2(), std::uint32_t(cuts.size()),
                       cuts.values().size(),
                       upload_cuts(device, cuts.masks(), cuts.first_value(), cuts.values()),
                       compute::buffer_of(device, cuts.horizons())}) {}
DeviceCuts::DeviceCuts(State state) : state_(std::make_unique<State>(std::move(state))) {}
DeviceCuts::~DeviceCuts() = default;
DeviceCuts::DeviceCuts(DeviceCuts&&) noexcept = default;
DeviceCuts& DeviceCuts::operator=(DeviceCuts&&) noexcept = default;

std::uint32_t DeviceCuts::size() const { return state_->count; }

MaskedCuts<std::uint8_t> DeviceCuts::download() const {
  const auto& [device, leaf_count, granule_log2, count, value_count, cuts, horizons] = *state_;
  const std::size_t words = words_per_cut(leaf_count, granule_log2);
  auto result = MaskedCuts<std::uint8_t>::from_arrays(
      leaf_count, granule_log2, compute::items_of<std::uint32_t>(*device, cuts.masks, count * words),
      compute::items_of<std::uint8_t>(*device, cuts.values, value_count),
      compute::items_of<ReceiverHorizon>(*device, horizons, count));
  COPPICE_ASSERT(result.has_value());
  return std::move(*result);
}

}  // namespace coppice
