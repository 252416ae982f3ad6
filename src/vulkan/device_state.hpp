// What a VulkanDevice holds. Includes Vulkan-Hpp RAII, which is slow to compile: for device.cpp and
// compute.cpp only.
#pragma once

#define VULKAN_HPP_NO_STRUCT_CONSTRUCTORS
#define VULKAN_HPP_NO_STRUCT_SETTERS
#define VULKAN_HPP_NO_SPACESHIP_OPERATOR
#include <coppice/vulkan/device.hpp>
#include <mutex>
#include <vulkan/vulkan_raii.hpp>

namespace coppice {

/// What the validation layer says; any thread of a driver may speak.
struct Messages {
  std::mutex mutex;
  std::vector<std::string> texts;
};

/// A handle that is destroyed only where it is Coppice's own.
template <class Handle>
struct Lent : Handle {
  bool owned;
  ~Lent() {
    if (!owned) this->release();
  }
};

struct VulkanDevice::State {
  vk::raii::Context context;
  Messages messages;
  Lent<vk::raii::Instance> instance;
  vk::raii::DebugUtilsMessengerEXT messenger = nullptr;
  vk::raii::PhysicalDevice physical;
  std::uint32_t queue_family;
  Lent<vk::raii::Device> device;
  vk::raii::Queue queue;
  vk::raii::CommandPool pool;
  std::string name;

  explicit State(const VulkanOptions& options);
  explicit State(const VulkanHost& host);
};

}  // namespace coppice
