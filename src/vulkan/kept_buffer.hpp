// A buffer that outlives a call.
#pragma once

#include "compute.hpp"
#include "cut_buffers.hpp"

namespace coppice {

/// Is made anew where it is too small. Kernels can read a word after what it holds.
class KeptBuffer {
 public:
  explicit KeptBuffer(const VulkanDevice& device, compute::Memory memory = compute::Memory::device)
      : device_(&device), memory_(memory), buffer_(device, memory, 0) {}

  void make_room(std::size_t byte_count) {
    if (buffer_.byte_count() < byte_count) buffer_ = compute::Buffer(*device_, memory_, byte_count);
  }
  /// The buffer begins with these items. Precondition: Memory::device.
  template <class T>
  void set(std::span<const T> items) {
    make_room(packed_size(items.size_bytes()));
    compute::upload(*device_, std::as_bytes(items), buffer_);
  }
  const compute::Buffer& buffer() const { return buffer_; }
  std::uint64_t address() const { return buffer_.address(); }

 private:
  const VulkanDevice* device_;
  compute::Memory memory_;
  compute::Buffer buffer_;
};

}  // namespace coppice
