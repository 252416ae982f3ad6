// Relighting by lights in the scene on a Vulkan device: per point, the merge of three cuts of visibility ·
// geometry with the illumination cut.
#pragma once

#include <coppice/vulkan/cut_shader.hpp>

namespace coppice {

/// What stays the same from frame to frame. Values times the scale of their receiver are visibility ·
/// geometry: the share of a light's intensity that arrives, 1/m².
struct LocalCutShadeInput : CutShadeInputOf<std::uint16_t> {
  std::span<const float> scales;    ///< by receiver: what the squares of its values are multiplied by
  std::span<const vec3> positions;  ///< by point, in the world
};

/// Computes for every point what shade_faces does for LocalLights: the sum of power · visibility · geometry ·
/// BRDF over the clusters of the union of four cuts, or over their descendants where these tell a lobe's
/// shape. The direction to a cluster and its spread are those from the point.
class LocalCutShader {
 public:
  /// Uploads the input, of which the caller need keep nothing. Throws InputError where it does not fit into
  /// the device's memory.
  LocalCutShader(VulkanDevice& device, const LocalCutShadeInput& input);
  ~LocalCutShader();
  LocalCutShader(LocalCutShader&&) noexcept;
  LocalCutShader& operator=(LocalCutShader&&) noexcept;

  /// As CutShader::shade; where lobes are refined, leaves have variance 0.
  CutShadeResult shade(std::span<const LocalLightNode> nodes,
                       std::span<const std::uint32_t> illumination_mask, const LobeOptions& lobes = {},
                       std::span<std::uint32_t> cluster_count = {});

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace coppice
