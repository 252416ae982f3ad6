#include <coppice/vulkan/local_cut_shader.hpp>

#include "point_shading.hpp"
#include "shaders/local_cut_shade.h"

namespace coppice {
namespace {

/// Every receiver that the faces ask for has a cut and a scale, every point a position.
[[maybe_unused]] bool is_complete(const LocalCutShadeInput& input) {
  const std::size_t receivers = count_receivers(input.faces);
  return input.visibility_masks.size() >= receivers * words_per_cut(input.leaf_count, input.granule_log2) &&
         input.scales.size() >= receivers && input.positions.size() == input.points.size();
}

/// Refinement ends at leaves because one light does not spread.
[[maybe_unused]] bool has_single_lights(std::span<const LocalLightNode> nodes) {
  return std::ranges::all_of(nodes.subspan(nodes.size() / 2), [](const auto& n) { return n.variance == 0; });
}

}  // namespace

struct LocalCutShader::State {
  PointShading points;
  CutBuffers cuts;
  compute::Buffer scales, positions;
};

LocalCutShader::LocalCutShader(VulkanDevice& device, const LocalCutShadeInput& input) {
  COPPICE_ASSERT(is_consistent(input) && is_complete(input));
  state_ = std::make_unique<State>(State{
      PointShading::make<LocalCutShadeParameters, LocalLightNode>(device, shaders::local_cut_shade, input),
      upload_cuts(device, input.visibility_masks, input.first_value, input.values),
      compute::buffer_of(device, input.scales), compute::buffer_of(device, input.positions)});
}
LocalCutShader::~LocalCutShader() = default;
LocalCutShader::LocalCutShader(LocalCutShader&&) noexcept = default;
LocalCutShader& LocalCutShader::operator=(LocalCutShader&&) noexcept = default;

CutShadeResult LocalCutShader::shade(std::span<const LocalLightNode> nodes,
                                     std::span<const std::uint32_t> illumination_mask,
                                     const LobeOptions& lobes, std::span<std::uint32_t> cluster_count) {
  const auto& [points, cuts, scales, positions] = *state_;
  COPPICE_ASSERT(lobes.lobes != Lobes::refined || has_single_lights(nodes));
  const LocalCutShadeParameters parameters{.shading = points.task(cuts.store(), lobes),
                                           .range = {},
                                           .nodes = points.nodes_address(),
                                           .scales = scales.address(),
                                           .positions = positions.address()};
  return points.shade(parameters, nodes, illumination_mask, cluster_count);
}

}  // namespace coppice
