// A Vulkan device with one compute queue: Coppice's own, or that of a host renderer.
#pragma once

#include <vulkan/vulkan.h>

#include <coppice/core/error.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace coppice {

/// What a device of Coppice's own is to be.
struct VulkanOptions {
  std::string name{};       ///< part of the device's name; empty takes a GPU before a device of the CPU
  bool validation = false;  ///< enables VK_LAYER_KHRONOS_validation; see VulkanDevice::validation_messages()
};

/// The handles of a host renderer, which keeps their ownership. The instance and the device are of
/// Vulkan 1.3, the device was created with the features bufferDeviceAddress, scalarBlockLayout and
/// maintenance4, and the queue family computes.
struct VulkanHost {
  VkInstance instance = VK_NULL_HANDLE;
  VkPhysicalDevice physical_device = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  std::uint32_t queue_family = 0;
  std::uint32_t queue_index = 0;
};

/// Needs Vulkan 1.3 with bufferDeviceAddress, scalarBlockLayout and maintenance4, and a queue that computes.
/// It outlives all that is made with it; a device and what is made with it belong to one thread at a time.
/// Calls that submit work wait for its end, and a host must not use the queue meanwhile. A device that fails
/// at work raises std::system_error.
class VulkanDevice {
 public:
  /// Takes the best device that fits: discrete GPU, other GPU, CPU. Throws InputError where there is none,
  /// with what each of them lacks.
  explicit VulkanDevice(const VulkanOptions& options = {});
  /// Throws InputError where the physical device cannot do what is needed. Features that the host left
  /// disabled cannot be detected: the validation layer reports them.
  explicit VulkanDevice(const VulkanHost& host);
  ~VulkanDevice();
  VulkanDevice(VulkanDevice&&) noexcept;
  VulkanDevice& operator=(VulkanDevice&&) noexcept;

  /// The error that VulkanDevice(options) would throw, or nothing where it would succeed. Costs as much as
  /// creating the device.
  static std::optional<InputError> unavailable(const VulkanOptions& options = {});

  /// As the driver gives it, e.g. "NVIDIA GeForce RTX 3080".
  const std::string& name() const;
  /// What the validation layer has said so far: warnings and errors. Empty without VulkanOptions::validation.
  std::vector<std::string> validation_messages() const;

  struct State;
  State& state() const { return *state_; }  ///< for Coppice's own kernels

 private:
  std::unique_ptr<State> state_;
};

}  // namespace coppice
