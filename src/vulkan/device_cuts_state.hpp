// What DeviceCuts holds.
#pragma once

#include <coppice/vulkan/device_cuts.hpp>

#include "cut_buffers.hpp"

namespace coppice {

struct DeviceCuts::State {
  const VulkanDevice* device;
  std::uint32_t leaf_count, granule_log2, count;
  std::size_t value_count;
  CutBuffers cuts;
  compute::Buffer horizons;
};

}  // namespace coppice
