#include <coppice/vulkan/cut_shader.hpp>

#include "device_cuts_state.hpp"
#include "point_shading.hpp"
#include "shaders/cut_shade.h"

namespace coppice {
namespace {

std::uint32_t cut_count(const CutShadeInput& input) {
  return std::uint32_t(input.visibility_masks.size() / words_per_cut(input.leaf_count, input.granule_log2));
}

DeviceCuts device_cuts(const VulkanDevice& device, const CutShadeInput& input) {
  return DeviceCuts(
      DeviceCuts::State{&device, input.leaf_count, input.granule_log2, cut_count(input), input.values.size(),
                        upload_cuts(device, input.visibility_masks, input.first_value, input.values),
                        compute::buffer_of(device, input.horizons)});
}

/// Refinement ends at leaves because one light does not spread.
[[maybe_unused]] bool has_single_lights(std::span<const LightNode> nodes) {
  return std::ranges::all_of(nodes.subspan(nodes.size() / 2), [](const auto& n) { return n.spread == 0; });
}

}  // namespace

struct CutShader::State {
  PointShading points;
  DeviceCuts cuts;
};

CutShader::CutShader(VulkanDevice& device, const CutShadeInput& input) {
  COPPICE_ASSERT(is_consistent(input) && input.horizons.size() >= cut_count(input));
  state_ = std::make_unique<State>(
      State{PointShading::make<CutShadeParameters, LightNode>(device, shaders::cut_shade, input),
            device_cuts(device, input)});
}
CutShader::~CutShader() = default;
CutShader::CutShader(CutShader&&) noexcept = default;
CutShader& CutShader::operator=(CutShader&&) noexcept = default;

void CutShader::set_cuts(DeviceCuts cuts) {
  COPPICE_ASSERT(cuts.state().leaf_count == state_->cuts.state().leaf_count &&
                 cuts.state().granule_log2 == state_->cuts.state().granule_log2);
  state_->cuts = std::move(cuts);
}

CutShadeResult CutShader::shade(std::span<const LightNode> nodes,
                                std::span<const std::uint32_t> illumination_mask, const LobeOptions& lobes,
                                std::span<std::uint32_t> cluster_count) {
  const auto& [points, cuts] = *state_;
  COPPICE_ASSERT(cuts.size() >= points.receiver_count());
  COPPICE_ASSERT(lobes.lobes != Lobes::refined || has_single_lights(nodes));
  const CutShadeParameters parameters{.shading = points.task(cuts.state().cuts.store(), lobes),
                                      .range = {},
                                      .nodes = points.nodes_address(),
                                      .horizons = cuts.state().horizons.address()};
  return points.shade(parameters, nodes, illumination_mask, cluster_count);
}

}  // namespace coppice
