// What a compute kernel needs of a device: buffers with addresses, the kernel itself, and commands. Free of
// Vulkan-Hpp, so that only device.cpp and compute.cpp pay for compiling it.
#pragma once

#include <coppice/shared/cut_shade.h>

#include <algorithm>
#include <coppice/vulkan/device.hpp>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace coppice::compute {

enum class Memory {
  device,    ///< kernels read and write it by its address
  upload,    ///< the host writes it
  download,  ///< the host reads it
};

/// At least 4 bytes, uninitialised. Throws InputError where the device has no room for them.
class Buffer {
 public:
  Buffer(const VulkanDevice& device, Memory memory, std::size_t byte_count);
  ~Buffer();
  Buffer(Buffer&&) noexcept;
  Buffer& operator=(Buffer&&) noexcept;

  std::size_t byte_count() const;
  std::uint64_t address() const;        ///< Precondition: Memory::device.
  std::span<std::byte> mapped() const;  ///< Precondition: not Memory::device.

  struct State;
  const State& state() const { return *state_; }

 private:
  std::unique_ptr<State> state_;
};

/// A pipeline without descriptors, whose parameters are push constants.
class Kernel {
 public:
  Kernel(const VulkanDevice& device, std::span<const std::uint32_t> code, std::uint32_t parameter_byte_count);
  ~Kernel();
  Kernel(Kernel&&) noexcept;
  Kernel& operator=(Kernel&&) noexcept;

  struct State;
  const State& state() const { return *state_; }

 private:
  std::unique_ptr<State> state_;
};

/// Records commands, then submits them once. All that precedes a barrier ends before anything after it
/// begins.
class Commands {
 public:
  explicit Commands(const VulkanDevice& device);
  ~Commands();

  void copy(const Buffer& from, std::size_t from_offset, const Buffer& to, std::size_t to_offset,
            std::size_t byte_count);
  void fill_with_zeros(const Buffer& buffer);
  void barrier();
  void dispatch(const Kernel& kernel, std::uint32_t group_count, std::span<const std::byte> parameters);
  /// The clock is read at each call, once what was recorded before has ended: most_readings times at most.
  void read_clock();
  /// Waits for the end of all commands.
  void submit();
  /// Milliseconds between the first reading and the last one, where the queue has a clock. Precondition:
  /// submitted.
  std::optional<double> milliseconds() const;
  /// Milliseconds from each reading to the next; empty where the queue has no clock. Precondition: submitted.
  std::vector<double> laps() const;

  static constexpr std::uint32_t most_readings = 8;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Workgroups that one dispatch may have.
std::uint32_t max_group_count(const VulkanDevice& device);

/// Copies bytes to the start of a buffer on the device, and waits for it.
void upload(const VulkanDevice& device, std::span<const std::byte> bytes, const Buffer& to);
/// Copies bytes from the start of a buffer on the device, and waits for them.
void download(const VulkanDevice& device, const Buffer& from, std::span<std::byte> bytes);

/// A buffer on the device that holds these items.
template <class T>
Buffer buffer_of(const VulkanDevice& device, std::span<const T> items) {
  Buffer buffer(device, Memory::device, items.size_bytes());
  upload(device, std::as_bytes(items), buffer);
  return buffer;
}

/// The first `count` items of a buffer on the device.
template <class T>
std::vector<T> items_of(const VulkanDevice& device, const Buffer& buffer, std::size_t count) {
  std::vector<T> items(count);
  download(device, buffer, std::as_writable_bytes(std::span(items)));
  return items;
}

/// Runs a kernel of one invocation an item on the items [0, count), in dispatches of at most `most`.
/// parameters.range tells each of them which are its own.
template <class Parameters>
void dispatch_items(Commands& commands, const VulkanDevice& device, const Kernel& kernel,
                    Parameters parameters, std::uint32_t count,
                    std::uint32_t most = std::numeric_limits<std::uint32_t>::max()) {
  const std::uint64_t largest = std::uint64_t(max_group_count(device)) * KERNEL_GROUP_SIZE;
  const auto step = std::uint32_t(std::min<std::uint64_t>(largest, most));
  for (std::uint32_t first = 0; first < count; first = parameters.range.end) {
    const std::uint32_t size = std::min(step, count - first);
    parameters.range = {first, first + size};
    commands.dispatch(kernel, (size - 1) / KERNEL_GROUP_SIZE + 1, std::as_bytes(std::span(&parameters, 1)));
  }
}

}  // namespace coppice::compute
