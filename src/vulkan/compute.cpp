#include "compute.hpp"

#include <algorithm>
#include <coppice/core/config.hpp>
#include <cstring>
#include <limits>

#include "device_state.hpp"

namespace coppice {
namespace compute {
namespace {

using Properties = vk::MemoryPropertyFlagBits;

constexpr std::size_t largest_staging = std::size_t(64) << 20;  // bytes

vk::MemoryPropertyFlags required_properties(Memory memory) {
  if (memory == Memory::device) return Properties::eDeviceLocal;
  return Properties::eHostVisible | Properties::eHostCoherent;
}

/// Of the memory types that serve, the one that is cached where the host reads, and is not where it does not.
std::uint32_t memory_type(const vk::raii::PhysicalDevice& physical, std::uint32_t allowed, Memory memory) {
  const auto types = physical.getMemoryProperties();
  const auto required = required_properties(memory);
  std::uint32_t chosen = types.memoryTypeCount;
  for (std::uint32_t i = types.memoryTypeCount; i-- > 0;) {
    const auto flags = types.memoryTypes[i].propertyFlags;
    if (!(allowed >> i & 1) || (flags & required) != required) continue;
    const bool wanted = bool(flags & Properties::eHostCached) == (memory == Memory::download);
    if (wanted || chosen == types.memoryTypeCount) chosen = i;
  }
  COPPICE_ASSERT(chosen < types.memoryTypeCount);  // the specification promises both kinds
  return chosen;
}

vk::BufferUsageFlags usage(Memory memory) {
  using Usage = vk::BufferUsageFlagBits;
  if (memory == Memory::upload) return Usage::eTransferSrc;
  if (memory == Memory::download) return Usage::eTransferDst;
  return Usage::eTransferSrc | Usage::eTransferDst | Usage::eStorageBuffer | Usage::eShaderDeviceAddress;
}

/// The size of a buffer for that many bytes, which is never 0.
std::size_t buffer_size(const VulkanDevice::State& gpu, std::size_t byte_count) {
  const auto properties =
      gpu.physical.getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceMaintenance4Properties>();
  if (byte_count > properties.get<vk::PhysicalDeviceMaintenance4Properties>().maxBufferSize)
    throw vk::OutOfDeviceMemoryError("maxBufferSize");
  return std::max<std::size_t>(byte_count, 4);
}

vk::raii::DeviceMemory allocate(const VulkanDevice::State& gpu, const vk::raii::Buffer& buffer,
                                Memory memory) {
  const auto needs = buffer.getMemoryRequirements();
  const vk::MemoryAllocateFlagsInfo flags{.flags = vk::MemoryAllocateFlagBits::eDeviceAddress};
  return {gpu.device,
          vk::MemoryAllocateInfo{.pNext = memory == Memory::device ? &flags : nullptr,
                                 .allocationSize = needs.size,
                                 .memoryTypeIndex = memory_type(gpu.physical, needs.memoryTypeBits, memory)}};
}

}  // namespace

struct Buffer::State {
  std::size_t byte_count;
  vk::raii::Buffer buffer;
  vk::raii::DeviceMemory memory;
  std::byte* mapped = nullptr;
  std::uint64_t address = 0;

  State(const VulkanDevice::State& gpu, Memory kind, std::size_t bytes)
      : byte_count(buffer_size(gpu, bytes)),
        buffer(gpu.device, vk::BufferCreateInfo{.size = byte_count, .usage = usage(kind)}),
        memory(allocate(gpu, buffer, kind)) {
    buffer.bindMemory(*memory, 0);
    if (kind == Memory::device)
      address = gpu.device.getBufferAddress({.buffer = *buffer});
    else
      mapped = static_cast<std::byte*>(memory.mapMemory(0, VK_WHOLE_SIZE));
  }
};

Buffer::Buffer(const VulkanDevice& device, Memory memory, std::size_t byte_count) try
    : state_(std::make_unique<State>(device.state(), memory, byte_count)) {
} catch (const vk::SystemError&) {
  throw InputError("Vulkan device " + device.name(),
                   "no room for " + std::to_string(byte_count >> 20) + " MiB in its memory",
                   "use fewer points, coarser cuts or another device");
}
Buffer::~Buffer() = default;
Buffer::Buffer(Buffer&&) noexcept = default;
Buffer& Buffer::operator=(Buffer&&) noexcept = default;
std::size_t Buffer::byte_count() const { return state_->byte_count; }

std::uint64_t Buffer::address() const {
  COPPICE_ASSERT(state_->address != 0);
  return state_->address;
}

std::span<std::byte> Buffer::mapped() const {
  COPPICE_ASSERT(state_->mapped != nullptr);
  return {state_->mapped, state_->byte_count};
}

struct Kernel::State {
  vk::PushConstantRange parameters;
  vk::raii::PipelineLayout layout;
  vk::raii::ShaderModule code;
  vk::raii::Pipeline pipeline;

  State(const VulkanDevice::State& gpu, std::span<const std::uint32_t> words,
        std::uint32_t parameter_byte_count)
      : parameters{.stageFlags = vk::ShaderStageFlagBits::eCompute, .size = parameter_byte_count},
        layout(gpu.device,
               vk::PipelineLayoutCreateInfo{.pushConstantRangeCount = 1, .pPushConstantRanges = &parameters}),
        code(gpu.device, vk::ShaderModuleCreateInfo{.codeSize = words.size_bytes(), .pCode = words.data()}),
        pipeline(gpu.device, nullptr,
                 vk::ComputePipelineCreateInfo{
                     .stage = {.stage = vk::ShaderStageFlagBits::eCompute, .module = *code, .pName = "main"},
                     .layout = *layout}) {}
};

Kernel::Kernel(const VulkanDevice& device, std::span<const std::uint32_t> code,
               std::uint32_t parameter_byte_count)
    : state_(std::make_unique<State>(device.state(), code, parameter_byte_count)) {}
Kernel::~Kernel() = default;
Kernel::Kernel(Kernel&&) noexcept = default;
Kernel& Kernel::operator=(Kernel&&) noexcept = default;

struct Commands::State {
  const VulkanDevice::State& gpu;
  vk::raii::CommandBuffer buffer;
  vk::raii::QueryPool clock;
  std::uint32_t readings = 0;

  explicit State(const VulkanDevice::State& device)
      : gpu(device),
        buffer(std::move(vk::raii::CommandBuffers(
            gpu.device,
            vk::CommandBufferAllocateInfo{.commandPool = *gpu.pool, .commandBufferCount = 1})[0])),
        clock(gpu.device,
              vk::QueryPoolCreateInfo{.queryType = vk::QueryType::eTimestamp, .queryCount = most_readings}) {
    buffer.begin({.flags = vk::CommandBufferUsageFlagBits::eOneTimeSubmit});
    buffer.resetQueryPool(*clock, 0, most_readings);
  }

  std::uint32_t clock_bits() const {
    return gpu.physical.getQueueFamilyProperties()[gpu.queue_family].timestampValidBits;
  }

  /// All readings. Precondition: there is a clock, and at least one of them.
  std::vector<std::uint64_t> ticks() const {
    constexpr std::size_t stride = sizeof(std::uint64_t);
    const auto [result, values] =
        clock.getResults<std::uint64_t>(0, readings, readings * stride, stride,
                                        vk::QueryResultFlagBits::e64 | vk::QueryResultFlagBits::eWait);
    return values;
  }

  double milliseconds(std::uint64_t from, std::uint64_t to) const {
    const std::uint64_t elapsed = (to - from) & (~std::uint64_t(0) >> (64 - clock_bits()));
    return double(elapsed) * gpu.physical.getProperties().limits.timestampPeriod * 1e-6;
  }
};

Commands::Commands(const VulkanDevice& device) : state_(std::make_unique<State>(device.state())) {
  barrier();
}
Commands::~Commands() = default;

void Commands::copy(const Buffer& from, std::size_t from_offset, const Buffer& to, std::size_t to_offset,
                    std::size_t byte_count) {
  COPPICE_ASSERT(from_offset + byte_count <= from.byte_count() && to_offset + byte_count <= to.byte_count());
  if (byte_count == 0) return;
  const vk::BufferCopy range{.srcOffset = from_offset, .dstOffset = to_offset, .size = byte_count};
  state_->buffer.copyBuffer(*from.state().buffer, *to.state().buffer, range);
}

void Commands::fill_with_zeros(const Buffer& buffer) {
  state_->buffer.fillBuffer(*buffer.state().buffer, 0, VK_WHOLE_SIZE, 0);
}

void Commands::barrier() {
  using Stage = vk::PipelineStageFlagBits;
  using Access = vk::AccessFlagBits;
  const vk::MemoryBarrier everything{.srcAccessMask = Access::eMemoryWrite,
                                     .dstAccessMask = Access::eMemoryRead | Access::eMemoryWrite};
  state_->buffer.pipelineBarrier(Stage::eAllCommands, Stage::eAllCommands | Stage::eHost, {}, everything, {},
                                 {});
}

void Commands::dispatch(const Kernel& kernel, std::uint32_t group_count,
                        std::span<const std::byte> parameters) {
  const auto& buffer = state_->buffer;
  COPPICE_ASSERT(parameters.size() == kernel.state().parameters.size);
  buffer.bindPipeline(vk::PipelineBindPoint::eCompute, *kernel.state().pipeline);
  buffer.pushConstants<std::byte>(*kernel.state().layout, vk::ShaderStageFlagBits::eCompute, 0,
                                  {std::uint32_t(parameters.size()), parameters.data()});
  buffer.dispatch(group_count, 1, 1);
}

void Commands::read_clock() {
  COPPICE_ASSERT(state_->readings < most_readings);
  const std::uint32_t reading = state_->readings++;
  if (state_->clock_bits() == 0) return;
  state_->buffer.writeTimestamp(vk::PipelineStageFlagBits::eBottomOfPipe, *state_->clock, reading);
}

void Commands::submit() {
  barrier();
  state_->buffer.end();
  const vk::raii::Fence done(state_->gpu.device, vk::FenceCreateInfo{});
  const vk::SubmitInfo work{.commandBufferCount = 1, .pCommandBuffers = &*state_->buffer};
  state_->gpu.queue.submit(work, *done);
  constexpr auto forever = std::numeric_limits<std::uint64_t>::max();
  const vk::Result result = state_->gpu.device.waitForFences(*done, true, forever);
  COPPICE_ASSERT(result == vk::Result::eSuccess);
  static_cast<void>(result);
}

std::optional<double> Commands::milliseconds() const {
  if (state_->clock_bits() == 0 || state_->readings < 2) return std::nullopt;
  const auto ticks = state_->ticks();
  return state_->milliseconds(ticks.front(), ticks.back());
}

std::vector<double> Commands::laps() const {
  std::vector<double> laps;
  if (state_->clock_bits() == 0 || state_->readings < 2) return laps;
  const auto ticks = state_->ticks();
  for (std::size_t i = 1; i < ticks.size(); ++i) laps.push_back(state_->milliseconds(ticks[i - 1], ticks[i]));
  return laps;
}

std::uint32_t max_group_count(const VulkanDevice& device) {
  return device.state().physical.getProperties().limits.maxComputeWorkGroupCount[0];
}

void upload(const VulkanDevice& device, std::span<const std::byte> bytes, const Buffer& to) {
  const Buffer staging(device, Memory::upload, std::min(bytes.size(), largest_staging));
  for (std::size_t offset = 0; offset < bytes.size(); offset += largest_staging) {
    const auto part = bytes.subspan(offset, std::min(largest_staging, bytes.size() - offset));
    std::memcpy(staging.mapped().data(), part.data(), part.size());
    Commands commands(device);
    commands.copy(staging, 0, to, offset, part.size());
    commands.submit();
  }
}

void download(const VulkanDevice& device, const Buffer& from, std::span<std::byte> bytes) {
  const Buffer staging(device, Memory::download, std::min(bytes.size(), largest_staging));
  for (std::size_t offset = 0; offset < bytes.size(); offset += largest_staging) {
    const auto part = bytes.subspan(offset, std::min(largest_staging, bytes.size() - offset));
    Commands commands(device);
    commands.copy(from, offset, staging, 0, part.size());
    commands.submit();
    std::memcpy(part.data(), staging.mapped().data(), part.size());
  }
}

}  // namespace compute
}  // namespace coppice
