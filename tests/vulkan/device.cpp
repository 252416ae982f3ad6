#include <doctest/doctest.h>

#include <array>
#include <coppice/vulkan/device.hpp>

#include "random_local_input.hpp"

using namespace coppice;
using namespace coppice::test;

namespace {

/// A renderer that has its own device, through the C interface only.
class HostRenderer {
 public:
  HostRenderer() {
    const VkApplicationInfo application{.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                        .pNext = nullptr,
                                        .pApplicationName = "host",
                                        .applicationVersion = 0,
                                        .pEngineName = nullptr,
                                        .engineVersion = 0,
                                        .apiVersion = VK_API_VERSION_1_3};
    VkInstanceCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
    info.pApplicationInfo = &application;
    REQUIRE(vkCreateInstance(&info, nullptr, &host_.instance) == VK_SUCCESS);
    std::uint32_t count = 1;
    REQUIRE(vkEnumeratePhysicalDevices(host_.instance, &count, &host_.physical_device) >= VK_SUCCESS);
    create_device();
  }
  ~HostRenderer() {
    vkDestroyDevice(host_.device, nullptr);
    vkDestroyInstance(host_.instance, nullptr);
  }
  HostRenderer(const HostRenderer&) = delete;
  HostRenderer& operator=(const HostRenderer&) = delete;

  const VulkanHost& handles() const { return host_; }
  bool alive() const { return vkDeviceWaitIdle(host_.device) == VK_SUCCESS; }
  std::string name() const {
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(host_.physical_device, &properties);
    return properties.deviceName;
  }

 private:
  void create_device() {
    VkPhysicalDeviceVulkan13Features features13{};
    features13.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES;
    features13.maintenance4 = VK_TRUE;
    VkPhysicalDeviceVulkan12Features features{};
    features.pNext = &features13;
    features.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES;
    features.bufferDeviceAddress = features.scalarBlockLayout = VK_TRUE;
    const float priority = 1;
    VkDeviceQueueCreateInfo queue{};
    queue.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO;
    queue.queueCount = 1;
    queue.pQueuePriorities = &priority;
    VkDeviceCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
    info.pNext = &features;
    info.queueCreateInfoCount = 1;
    info.pQueueCreateInfos = &queue;
    REQUIRE(vkCreateDevice(host_.physical_device, &info, nullptr, &host_.device) == VK_SUCCESS);
  }

  VulkanHost host_;
};

std::vector<vec3> shade_some(VulkanDevice& device) {
  const auto input = random_input({.leaf_count = 512, .granule_log2 = 3, .point_count = 70});
  return CutShader(device, input.view()).shade(input.frame.nodes, input.frame.mask).radiance;
}

std::vector<vec3> shade_some_locally(VulkanDevice& device) {
  const auto input = random_local_input({.leaf_count = 512, .granule_log2 = 3, .point_count = 70});
  return LocalCutShader(device, input.view()).shade(input.frame.nodes, input.frame.mask).radiance;
}

}  // namespace

TEST_CASE("a device has a name, by which it can be chosen") {
  if (!has_device()) return;
  const std::string name = VulkanDevice().name();
  CHECK(!name.empty());
  CHECK(VulkanDevice({.name = name.substr(1, 4)}).name().find(name.substr(1, 4)) != std::string::npos);
}

TEST_CASE("an unknown device is refused with its name and a remedy") {
  if (!has_device()) return;
  const auto error = VulkanDevice::unavailable({.name = "no such device"});
  REQUIRE(error);
  CHECK(error->problem().find("no such device") != std::string::npos);
  CHECK(error->remedy().find("driver") != std::string::npos);
  CHECK_THROWS_AS(VulkanDevice({.name = "no such device"}), InputError);
}

TEST_CASE("a host's device computes the same, and stays the host's") {
  if (!has_device()) return;
  const HostRenderer host;
  VulkanDevice own({.name = host.name()});
  const auto expected = shade_some(own);
  {
    VulkanDevice device(host.handles());
    CHECK(device.name() == host.name());
    CHECK(shade_some(device) == expected);
    VulkanDevice moved(std::move(device));
    CHECK(shade_some(moved) == expected);
  }
  CHECK(host.alive());
}

TEST_CASE("a host's queue family that does not compute is refused, and the device stays the host's") {
  if (!has_device()) return;
  const HostRenderer host;
  VulkanHost handles = host.handles();
  handles.queue_family = 1000;
  CHECK_THROWS_WITH_AS(VulkanDevice{handles}, doctest::Contains("queue family 1000"), InputError);
  CHECK(host.alive());
}

TEST_CASE("the validation layer has nothing to say") {
  if (!has_device({.validation = true})) return;
  VulkanDevice device({.validation = true});
  CHECK(!shade_some(device).empty());
  CHECK(!shade_some_locally(device).empty());
  for (const std::string& message : device.validation_messages()) FAIL_CHECK(message);
}
