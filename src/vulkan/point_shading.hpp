// The shading of points by cuts as far as it is the same for all kinds of lights: its buffers, and a frame.
#pragma once

#include <coppice/shared/cut_shade.h>

#include <algorithm>
#include <bit>
#include <coppice/core/config.hpp>
#include <coppice/vulkan/cut_shader.hpp>
#include <limits>

#include "cut_buffers.hpp"

namespace coppice {

/// What all kinds of lights ask of an input: see CutShadeInputOf.
template <Quantised Value>
bool is_consistent(const CutShadeInputOf<Value>& input) {
  if (!std::has_single_bit(input.leaf_count) || input.granule_log2 > 5 ||
      input.leaf_count >> input.granule_log2 == 0 || input.points_per_dispatch == 0 ||
      input.points.size() > std::numeric_limits<std::uint32_t>::max())
    return false;
  const std::size_t words = words_per_cut(input.leaf_count, input.granule_log2);
  const std::size_t receivers = input.visibility_masks.size() / words;
  if (input.visibility_masks.size() % words != 0 || input.first_value.size() < receivers) return false;
  for (std::size_t r = 0; r < receivers; ++r)
    if (input.first_value[r] + count_ends(input.visibility_masks.subspan(r * words, words)) >
        input.values.size())
      return false;
  return std::ranges::all_of(input.points, [&](const auto& p) { return p.face < input.faces.size(); });
}

/// Receivers that the faces ask for: one more than the highest index.
std::uint32_t count_receivers(std::span<const ShadingFace> faces);

class PointShading {
 public:
  /// `code`: a kernel with these parameters; `node`: a struct of layout.h.
  template <class Parameters, class Node, Quantised Value>
  static PointShading make(VulkanDevice& device, std::span<const std::uint32_t> code,
                           const CutShadeInputOf<Value>& input) {
    const Tree tree{input.leaf_count, input.granule_log2};
    return {device,       {device, code, sizeof(Parameters)}, tree,        input.faces,
            input.points, input.points_per_dispatch,          sizeof(Node)};
  }

  std::uint32_t point_count() const { return point_count_; }
  std::uint32_t receiver_count() const { return receiver_count_; }  ///< that the cuts must have at least
  std::uint64_t nodes_address() const { return nodes_.address(); }
  ShadingTask task(const CutStore& cuts, const LobeOptions& lobes) const;

  /// A frame. Preconditions: those of CutShader::shade.
  template <class Parameters, class Node>
  CutShadeResult shade(const Parameters& parameters, std::span<const Node> nodes,
                       std::span<const std::uint32_t> illumination_mask,
                       std::span<std::uint32_t> cluster_count) const {
    COPPICE_ASSERT(nodes.size() == 2 * std::size_t(tree_.leaf_count));
    COPPICE_ASSERT(illumination_mask.size() == words_per_cut(tree_.leaf_count, 0));
    COPPICE_ASSERT(cluster_count.empty() || cluster_count.size() == point_count_);
    if (point_count_ == 0) return {};
    compute::Commands commands(*device_);
    stage(commands, std::as_bytes(nodes), illumination_mask);
    commands.barrier();
    commands.read_clock();
    compute::dispatch_items(commands, *device_, kernel_, parameters, point_count_, points_per_dispatch_);
    commands.read_clock();
    commands.barrier();
    CutShadeResult result{.radiance = std::vector<vec3>(point_count_), .milliseconds = std::nullopt};
    read_back(commands, result.radiance, cluster_count);
    result.milliseconds = commands.milliseconds();
    return result;
  }

 private:
  struct Tree {
    std::uint32_t leaf_count, granule_log2;
  };

  PointShading(VulkanDevice& device, compute::Kernel kernel, const Tree& tree,
               std::span<const ShadingFace> faces, std::span<const ShadingPoint> points,
               std::uint32_t points_per_dispatch, std::size_t node_size);

  void stage(compute::Commands& commands, std::span<const std::byte> nodes,
             std::span<const std::uint32_t> illumination_mask) const;
  void read_back(compute::Commands& commands, std::span<vec3> colours, std::span<std::uint32_t> counts) const;

  VulkanDevice* device_;
  compute::Kernel kernel_;
  Tree tree_;
  std::uint32_t point_count_, receiver_count_, points_per_dispatch_;
  compute::Buffer faces_, points_;
  compute::Buffer nodes_, illumination_ends_, illumination_granules_, radiance_, cluster_count_;
  compute::Buffer staging_, readback_;
};

}  // namespace coppice
