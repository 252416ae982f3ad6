#include "point_shading.hpp"

#include <algorithm>
#include <cstring>

namespace coppice {
namespace {

using compute::Memory;

/// The ends of the cut that are ends of granules: bit k where `ends` has bit (k + 1) · granule - 1.
std::vector<std::uint32_t> ends_of_granules(std::span<const std::uint32_t> ends, std::uint32_t leaf_count,
                                            std::uint32_t granule_log2) {
  std::vector<std::uint32_t> mask(words_per_cut(leaf_count, granule_log2), 0);
  for (std::uint32_t k = 0; k < leaf_count >> granule_log2; ++k) {
    const std::uint32_t bit = ((k + 1) << granule_log2) - 1;
    mask[k / 32] |= (ends[bit / 32] >> (bit % 32) & 1) << (k % 32);
  }
  return mask;
}

static_assert(CUT_SHADE_SAMPLED == std::uint32_t(Lobes::sampled) &&
              CUT_SHADE_FILTERED == std::uint32_t(Lobes::filtered) &&
              CUT_SHADE_REFINED == std::uint32_t(Lobes::refined));

}  // namespace

std::uint32_t count_receivers(std::span<const ShadingFace> faces) {
  std::uint32_t count = 0;
  for (const ShadingFace& f : faces)
    count = std::max({count, f.receivers.x + 1, f.receivers.y + 1, f.receivers.z + 1});
  return count;
}

PointShading::PointShading(VulkanDevice& device, compute::Kernel kernel, const Tree& tree,
                           std::span<const ShadingFace> faces, std::span<const ShadingPoint> points,
                           std::uint32_t points_per_dispatch, std::size_t node_size)
    : device_(&device),
      kernel_(std::move(kernel)),
      tree_(tree),
      point_count_(std::uint32_t(points.size())),
      receiver_count_(count_receivers(faces)),
      points_per_dispatch_(points_per_dispatch),
      faces_(compute::buffer_of(device, faces)),
      points_(compute::buffer_of(device, points)),
      nodes_(device, Memory::device, 2 * node_size * tree.leaf_count),
      illumination_ends_(device, Memory::device, 4 * words_per_cut(tree.leaf_count, 0)),
      illumination_granules_(device, Memory::device, 4 * words_per_cut(tree.leaf_count, tree.granule_log2)),
      radiance_(device, Memory::device, sizeof(vec3) * point_count_),
      cluster_count_(device, Memory::device, sizeof(std::uint32_t) * point_count_),
      staging_(device, Memory::upload,
               nodes_.byte_count() + illumination_ends_.byte_count() + illumination_granules_.byte_count()),
      readback_(device, Memory::download, radiance_.byte_count() + cluster_count_.byte_count()) {}

ShadingTask PointShading::task(const CutStore& cuts, const LobeOptions& lobes) const {
  return {.cuts = cuts,
          .faces = faces_.address(),
          .points = points_.address(),
          .illumination_ends = illumination_ends_.address(),
          .illumination_granules = illumination_granules_.address(),
          .radiance = radiance_.address(),
          .cluster_count = cluster_count_.address(),
          .leaf_count = tree_.leaf_count,
          .granule_log2 = tree_.granule_log2,
          .lobes = std::uint32_t(lobes.lobes),
          .tolerance = lobes.tolerance};
}

void PointShading::stage(compute::Commands& commands, std::span<const std::byte> nodes,
                         std::span<const std::uint32_t> illumination_mask) const {
  std::size_t offset = 0;
  const auto put = [&](std::span<const std::byte> bytes, const compute::Buffer& to) {
    std::memcpy(staging_.mapped().data() + offset, bytes.data(), bytes.size());
    commands.copy(staging_, offset, to, 0, bytes.size());
    offset += bytes.size();
  };
  const auto granules = ends_of_granules(illumination_mask, tree_.leaf_count, tree_.granule_log2);
  put(nodes, nodes_);
  put(std::as_bytes(illumination_mask), illumination_ends_);
  put(std::as_bytes(std::span(granules)), illumination_granules_);
}

/// Submits the commands and waits.
void PointShading::read_back(compute::Commands& commands, std::span<vec3> colours,
                             std::span<std::uint32_t> counts) const {
  commands.copy(radiance_, 0, readback_, 0, colours.size_bytes());
  if (!counts.empty()) commands.copy(cluster_count_, 0, readback_, colours.size_bytes(), counts.size_bytes());
  commands.submit();
  std::memcpy(colours.data(), readback_.mapped().data(), colours.size_bytes());
  if (!counts.empty())
    std::memcpy(counts.data(), readback_.mapped().data() + colours.size_bytes(), counts.size_bytes());
}

}  // namespace coppice
