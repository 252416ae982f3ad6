// What a compute kernel needs of a device: buffers with addresses, the kernel itself, and commands. Free of
// Vulkan-Hpp, so that only device.cpp and compute.cpp pay for compiling it.
#pragma once

#include <coppice/vulkan/device.hpp>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

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
  void barrier();
  void dispatch(const Kernel& kernel, std::uint32_t group_count, std::span<const std::byte> parameters);
  /// The clock is read at the first call and the second call, once what was recorded before has ended.
  void read_clock();
  /// Waits for the end of all commands.
  void submit();
  /// Milliseconds between the two readings, where the queue has a clock. Precondition: submitted.
  std::optional<double> milliseconds() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Workgroups that one dispatch may have.
std::uint32_t max_group_count(const VulkanDevice& device);

/// Copies bytes to the start of a buffer on the device, and waits for it.
void upload(const VulkanDevice& device, std::span<const std::byte> bytes, const Buffer& to);

}  // namespace coppice::compute
