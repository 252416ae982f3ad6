// Relighting on a Vulkan device: per point, the merge of three visibility cuts with the illumination cut.
#pragma once

#include <coppice/shared/layout.h>

#include <coppice/cut/quantise.hpp>
#include <coppice/relight/lobes.hpp>
#include <coppice/vulkan/device_cuts.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace coppice {

/// What stays the same from frame to frame, for all kinds of lights. A granule is 1 << granule_log2 leaves. A
/// receiver's cut is a mask of max(1, leaf_count / granule / 32) words and a value for each of its ends, in
/// their order. Bit k of the mask says that the cut has the end of granule k, which is leaf (k + 1) ·
/// granule. The last end, leaf_count, is always there.
template <Quantised Value>
struct CutShadeInputOf {
  std::uint32_t leaf_count = 1;                     ///< of the light tree: a power of two
  std::uint32_t granule_log2 = 0;                   ///< 0 … 5; a granule is at most the whole tree
  std::span<const std::uint32_t> visibility_masks;  ///< by receiver
  std::span<const std::uint32_t> first_value;       ///< by receiver: index into values
  std::span<const Value> values;
  std::span<const ShadingFace> faces;
  std::span<const ShadingPoint> points;          ///< sorted by face, for speed
  std::uint32_t points_per_dispatch = 1u << 20;  ///< at least 1; smaller keeps a display responsive
};

/// Values are visibility · 255. Where there are no cuts at all, set_cuts comes before shade.
struct CutShadeInput : CutShadeInputOf<std::uint8_t> {
  std::span<const ReceiverHorizon> horizons;  ///< by receiver: it sees no cluster whose direction lies below
};

struct CutShadeResult {
  std::vector<vec3> radiance;          ///< by point
  std::optional<double> milliseconds;  ///< of the kernel on the device; empty where its queue has no clock
};

/// Computes Cuts section 3 for every point, as shade_faces does: the sum of power · visibility · BRDF over
/// the clusters of the union of four cuts, or over their descendants where these tell a lobe's shape. The
/// visibility is interpolated between the face's three receivers.
class CutShader {
 public:
  /// Uploads the input, of which the caller need keep nothing. Throws InputError where it does not fit into
  /// the device's memory.
  CutShader(VulkanDevice& device, const CutShadeInput& input);
  ~CutShader();
  CutShader(CutShader&&) noexcept;
  CutShader& operator=(CutShader&&) noexcept;

  /// Other cuts of the same receivers, tree and granule: those of objects that move, or products.
  void set_cuts(DeviceCuts cuts);

  /// Shades all points under the lighting `nodes`, 2 · leaf_count of them by heap id; where lobes are
  /// refined, leaves have spread 0. Bit e - 1 of `illumination_mask`, max(1, leaf_count / 32) words, says
  /// that the illumination cut has the end e. `cluster_count`, by point or empty, receives
  /// ShadedPoint::clusters. Waits for the device.
  CutShadeResult shade(std::span<const LightNode> nodes, std::span<const std::uint32_t> illumination_mask,
                       const LobeOptions& lobes = {}, std::span<std::uint32_t> cluster_count = {});

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace coppice
