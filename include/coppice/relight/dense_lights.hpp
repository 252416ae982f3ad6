// All lights of a frame as arrays, for the sums that leave no tree to be used.
#pragma once

#include <coppice/relight/frame_lighting.hpp>
#include <cstdint>
#include <vector>

namespace coppice {

/// Lights by leaf rank as structure of arrays, padded with dark lights to a multiple of 64.
struct DenseLights {
  std::vector<float> x, y, z, red, green, blue;

  /// From the leaves of a frame's nodes.
  DenseLights(std::uint32_t leaf_count, const FrameLighting& frame) {
    for (auto* axis : {&x, &y, &z, &red, &green, &blue}) axis->assign((leaf_count + 63) / 64 * 64, 0.0f);
    for (std::uint32_t i = 0; i < leaf_count; ++i) {
      const LightNode& n = frame.nodes[leaf_count + i];
      x[i] = n.direction.x, y[i] = n.direction.y, z[i] = n.direction.z;
      red[i] = n.power.x, green[i] = n.power.y, blue[i] = n.power.z;
    }
  }
};

/// Which lights brute force leaves out.
enum class Skip { nothing, unseen };

}  // namespace coppice
