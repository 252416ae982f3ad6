#include <algorithm>
#include <coppice/core/config.hpp>
#include <cstring>

#include "device_state.hpp"

namespace coppice {
namespace {

constexpr const char* validation_layer = "VK_LAYER_KHRONOS_validation";

VKAPI_ATTR VkBool32 VKAPI_CALL note_message(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                            VkDebugUtilsMessageTypeFlagsEXT,
                                            const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
  Messages& messages = *static_cast<Messages*>(user);
  const std::scoped_lock lock(messages.mutex);
  messages.texts.emplace_back(data->pMessage);
  return VK_FALSE;
}

vk::DebugUtilsMessengerCreateInfoEXT messenger_info(Messages& messages) {
  using Severity = vk::DebugUtilsMessageSeverityFlagBitsEXT;
  using Type = vk::DebugUtilsMessageTypeFlagBitsEXT;
  return {.messageSeverity = Severity::eWarning | Severity::eError,
          .messageType = Type::eValidation | Type::ePerformance,
          .pfnUserCallback = note_message,
          .pUserData = &messages};
}

vk::raii::Context load_vulkan() {
  try {
    return vk::raii::Context();
  } catch (const std::runtime_error&) {
    throw InputError("Vulkan", "its loader is not installed", "install libvulkan and the driver of your GPU");
  }
}

vk::raii::Instance make_instance(const vk::raii::Context& context, bool validation, Messages& messages) {
  const vk::ApplicationInfo application{.pApplicationName = "coppice", .apiVersion = VK_API_VERSION_1_3};
  const auto messenger = messenger_info(messages);
  const char* extension = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
  const std::uint32_t count = validation ? 1 : 0;
  try {
    return {context, vk::InstanceCreateInfo{.pNext = validation ? &messenger : nullptr,
                                            .pApplicationInfo = &application,
                                            .enabledLayerCount = count,
                                            .ppEnabledLayerNames = &validation_layer,
                                            .enabledExtensionCount = count,
                                            .ppEnabledExtensionNames = &extension}};
  } catch (const vk::LayerNotPresentError&) {
    throw InputError(validation_layer, "it is not installed", "install the Vulkan validation layers");
  } catch (const vk::SystemError& error) {
    throw InputError("Vulkan", error.what(),
                     "install the driver of your GPU, or Mesa's lavapipe for the CPU");
  }
}

std::optional<std::uint32_t> compute_family(const vk::raii::PhysicalDevice& physical) {
  const auto families = physical.getQueueFamilyProperties();
  const auto found = std::ranges::find_if(
      families, [](const auto& family) { return bool(family.queueFlags & vk::QueueFlagBits::eCompute); });
  if (found == families.end()) return std::nullopt;
  return std::uint32_t(found - families.begin());
}

/// The first requirement that the device does not meet; empty where it meets all.
std::string lack_of(const vk::raii::PhysicalDevice& physical) {
  if (physical.getProperties().apiVersion < VK_API_VERSION_1_3) return "Vulkan 1.3";
  const auto features = physical.getFeatures2<vk::PhysicalDeviceFeatures2, vk::PhysicalDeviceVulkan12Features,
                                              vk::PhysicalDeviceVulkan13Features>();
  const auto& features12 = features.get<vk::PhysicalDeviceVulkan12Features>();
  if (!features12.bufferDeviceAddress) return "bufferDeviceAddress";
  if (!features12.scalarBlockLayout) return "scalarBlockLayout";
  if (!features.get<vk::PhysicalDeviceVulkan13Features>().maintenance4) return "maintenance4";
  if (!compute_family(physical)) return "a queue that computes";
  return {};
}

std::string name_of(const vk::raii::PhysicalDevice& physical) { return physical.getProperties().deviceName; }

int preference(const vk::raii::PhysicalDevice& physical) {
  switch (physical.getProperties().deviceType) {
    case vk::PhysicalDeviceType::eDiscreteGpu:
      return 4;
    case vk::PhysicalDeviceType::eIntegratedGpu:
      return 3;
    case vk::PhysicalDeviceType::eVirtualGpu:
      return 2;
    case vk::PhysicalDeviceType::eCpu:
      return 1;
    default:
      return 0;
  }
}

[[noreturn]] void throw_no_device(const std::string& wanted, const std::string& lacks) {
  const std::string kind = wanted.empty() ? "" : " named '" + wanted + "'";
  throw InputError("Vulkan", "no device" + kind + " fits" + lacks,
                   "install a driver of Vulkan 1.3, or Mesa's lavapipe for the CPU");
}

vk::raii::PhysicalDevice choose_device(const vk::raii::Instance& instance, const std::string& wanted) {
  vk::raii::PhysicalDevice best(nullptr);
  int best_preference = -1;
  std::string lacks;
  for (const auto& physical : vk::raii::PhysicalDevices(instance)) {
    const std::string name = name_of(physical), lack = lack_of(physical);
    if (!lack.empty()) lacks += ", '" + name + "' lacks " + lack;
    if (!lack.empty() || name.find(wanted) == std::string::npos || preference(physical) <= best_preference)
      continue;
    best_preference = preference(physical);
    best = physical;
  }
  if (best_preference < 0) throw_no_device(wanted, lacks);
  return best;
}

vk::raii::Device make_device(const vk::raii::PhysicalDevice& physical, std::uint32_t queue_family) {
  const float priority = 1;
  const vk::DeviceQueueCreateInfo queue{
      .queueFamilyIndex = queue_family, .queueCount = 1, .pQueuePriorities = &priority};
  vk::PhysicalDeviceVulkan13Features features13{.maintenance4 = true};
  const vk::PhysicalDeviceVulkan12Features features{
      .pNext = &features13, .scalarBlockLayout = true, .bufferDeviceAddress = true};
  try {
    return {physical,
            vk::DeviceCreateInfo{.pNext = &features, .queueCreateInfoCount = 1, .pQueueCreateInfos = &queue}};
  } catch (const vk::SystemError& error) {
    throw InputError("Vulkan device " + name_of(physical), error.what(), "choose another by its name");
  }
}

/// The host's queue family, once the device is known to fit.
std::uint32_t check_host(const vk::raii::PhysicalDevice& physical, std::uint32_t queue_family) {
  const std::string item = "Vulkan device " + name_of(physical), lack = lack_of(physical);
  if (!lack.empty()) throw InputError(item, "it lacks " + lack, "hand in another, or let Coppice choose");
  const auto families = physical.getQueueFamilyProperties();
  if (queue_family >= families.size() || !(families[queue_family].queueFlags & vk::QueueFlagBits::eCompute))
    throw InputError(item, "queue family " + std::to_string(queue_family) + " does not compute",
                     "hand in a queue of a family with VK_QUEUE_COMPUTE_BIT");
  return queue_family;
}

}  // namespace

VulkanDevice::State::State(const VulkanOptions& options)
    : context(load_vulkan()),
      instance{make_instance(context, options.validation, messages), true},
      physical(choose_device(instance, options.name)),
      queue_family(*compute_family(physical)),
      device{make_device(physical, queue_family), true},
      queue(device, queue_family, 0),
      pool(device, vk::CommandPoolCreateInfo{.queueFamilyIndex = queue_family}),
      name(name_of(physical)) {
  if (options.validation) messenger = {instance, messenger_info(messages)};
}

VulkanDevice::State::State(const VulkanHost& host)
    : context(load_vulkan()),
      instance{vk::raii::Instance(context, host.instance), false},
      physical(instance, host.physical_device),
      queue_family(check_host(physical, host.queue_family)),
      device{vk::raii::Device(physical, host.device), false},
      queue(device, queue_family, host.queue_index),
      pool(device, vk::CommandPoolCreateInfo{.queueFamilyIndex = queue_family}),
      name(name_of(physical)) {}

VulkanDevice::VulkanDevice(const VulkanOptions& options) : state_(std::make_unique<State>(options)) {}
VulkanDevice::VulkanDevice(const VulkanHost& host) : state_(std::make_unique<State>(host)) {}
VulkanDevice::~VulkanDevice() = default;
VulkanDevice::VulkanDevice(VulkanDevice&&) noexcept = default;
VulkanDevice& VulkanDevice::operator=(VulkanDevice&&) noexcept = default;

std::optional<InputError> VulkanDevice::unavailable(const VulkanOptions& options) {
  try {
    const VulkanDevice device(options);
    return std::nullopt;
  } catch (const InputError& error) {
    return error;
  }
}

const std::string& VulkanDevice::name() const { return state_->name; }

std::vector<std::string> VulkanDevice::validation_messages() const {
  const std::scoped_lock lock(state_->messages.mutex);
  return state_->messages.texts;
}

}  // namespace coppice
