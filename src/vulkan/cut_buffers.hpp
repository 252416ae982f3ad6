// A store of cuts in the buffers of a device.
#pragma once

#include <coppice/shared/cut_shade.h>

#include <bit>
#include <coppice/cut/quantise.hpp>

#include "compute.hpp"

namespace coppice {

/// One cut after the other, of one tree and granule (CutStore).
struct CutBuffers {
  compute::Buffer masks, first_value, values;

  CutStore store() const { return {masks.address(), first_value.address(), values.address()}; }
};

/// Bytes of a buffer for packed values: kernels read whole words, and one value after the last.
inline std::size_t packed_size(std::size_t byte_count) { return (byte_count / 4 + 1) * 4; }

/// Uploads cuts as MaskedCuts stores them.
template <Quantised Value>
CutBuffers upload_cuts(const VulkanDevice& device, std::span<const std::uint32_t> masks,
                       std::span<const std::uint32_t> first_value, std::span<const Value> values) {
  CutBuffers buffers{compute::buffer_of(device, masks), compute::buffer_of(device, first_value),
                     compute::Buffer(device, compute::Memory::device, packed_size(values.size_bytes()))};
  compute::upload(device, std::as_bytes(values), buffers.values);
  return buffers;
}

/// Ends of a cut.
inline std::size_t count_ends(std::span<const std::uint32_t> mask) {
  std::size_t count = 0;
  for (const std::uint32_t word : mask) count += std::size_t(std::popcount(word));
  return count;
}

}  // namespace coppice
