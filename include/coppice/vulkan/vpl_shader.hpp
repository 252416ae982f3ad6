// Reflectance filtering on a Vulkan device: a tree of VPLs filtered from its leaves to its root, and its
// light gathered at points.
#pragma once

#include <coppice/shared/vpl.h>

#include <coppice/vulkan/device.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace coppice {

enum class WalkMark : std::uint8_t;  // gather/angle_walk.hpp

/// What came out, in the order of the points.
struct VplGatherResult {
  std::vector<vec3> radiance;          ///< W/(m² sr), linear RGB, without shadows
  std::vector<std::uint32_t> nodes;    ///< a point: nodes evaluated
  std::optional<double> milliseconds;  ///< of the kernel on the device; empty where its queue has no clock
};

/// Nodes for groups of points, as GroupLists::for_each finds them.
struct VplLists {
  std::vector<std::uint32_t> ends;   ///< a group: its nodes end before this index
  std::vector<std::uint32_t> nodes;  ///< heap ids, one group's after the other
};

/// Computes Filtering Eq. 2 over a tree whose nodes stay on the device, by the forms of shared/vpl.h as on
/// the CPU: relative RMS differences from it are below 1e-5 on lavapipe. Without nodes all points are dark.
/// Each call waits for the device, and throws InputError where its buffers do not fit into the device's
/// memory.
class VplShader {
 public:
  explicit VplShader(VulkanDevice& device);
  ~VplShader();
  VplShader(VplShader&&) noexcept;
  VplShader& operator=(VplShader&&) noexcept;

  /// Uploads leaves by rank, a power of two of them or none, and joins them by vpl_cluster up to the root, as
  /// VplTree does with VplFilter::moments. Returns the milliseconds of the kernels, where the queue has a
  /// clock. Cost: a dispatch every VPL_FILTER_LEVELS levels.
  std::optional<double> filter(std::span<const VplNode> leaves);

  /// Uploads a tree that was filtered elsewhere: 2N nodes by heap id, N a power of two, or none.
  void set_nodes(std::span<const VplNode> nodes);

  /// A copy of the nodes for the host, 2N of them by heap id; entry 0 is all 0 after filter().
  std::vector<VplNode> nodes() const;

  /// Every point walks the tree by itself: a node is split where it covers more than `threshold` steradians
  /// of the point, by the test of the CPU's gather_by_angle. That makes it for a register of points together,
  /// and so splits more. `marks`: by heap id, or empty. Cost: a dispatch for every VPL_NODES_PER_DISPATCH of
  /// 2N nodes; points that are done wait out the rest. Precondition: 0 < threshold < 2π; as many marks as
  /// nodes, or none.
  VplGatherResult gather_by_angle(std::span<const GlossyPoint> points, float threshold,
                                  std::span<const WalkMark> marks = {}) const;

  /// Every point gathers the nodes of its group's list, as gather_by_bound does. Cost: a dispatch for every
  /// VPL_NODES_PER_DISPATCH nodes of the longest list. Precondition: ends ascend to the number of nodes, each
  /// group is below their number, and each heap id is that of a node.
  VplGatherResult gather_lists(std::span<const GlossyPoint> points, const VplLists& lists) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace coppice
