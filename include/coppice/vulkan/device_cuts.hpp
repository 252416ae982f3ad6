// Visibility cuts in the memory of a Vulkan device.
#pragma once

#include <coppice/cut/masked_cuts.hpp>
#include <coppice/vulkan/device.hpp>
#include <memory>

namespace coppice {

/// The cuts of receivers towards distant lights, in the arrays of MaskedCuts.
class DeviceCuts {
 public:
  /// Uploads the cuts, of which the caller need keep nothing. Throws InputError where they do not fit into
  /// the device's memory.
  DeviceCuts(const VulkanDevice& device, const MaskedCuts<std::uint8_t>& cuts);
  ~DeviceCuts();
  DeviceCuts(DeviceCuts&&) noexcept;
  DeviceCuts& operator=(DeviceCuts&&) noexcept;

  std::uint32_t size() const;  ///< number of cuts
  /// A copy for the host. Waits for the device.
  MaskedCuts<std::uint8_t> download() const;

  struct State;
  explicit DeviceCuts(State state);
  const State& state() const { return *state_; }  ///< for Coppice's own kernels

 private:
  std::unique_ptr<State> state_;
};

}  // namespace coppice
