#include <coppice/shared/cut_shade.h>

#include <algorithm>
#include <bit>
#include <coppice/core/config.hpp>
#include <coppice/vulkan/cut_shader.hpp>
#include <cstring>
#include <limits>

#include "compute.hpp"
#include "shaders/cut_shade.h"

namespace coppice {
namespace {

using compute::Buffer;
using compute::Memory;

template <class T>
Buffer buffer_of(const VulkanDevice& device, std::span<const T> items) {
  Buffer buffer(device, Memory::device, items.size_bytes());
  compute::upload(device, std::as_bytes(items), buffer);
  return buffer;
}

/// The kernel reads whole words, and the byte after a cut's last.
Buffer buffer_of_values(const VulkanDevice& device, std::span<const std::uint8_t> values) {
  Buffer buffer(device, Memory::device, (values.size() / 4 + 1) * 4);
  compute::upload(device, std::as_bytes(values), buffer);
  return buffer;
}

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

/// Every receiver has a whole mask, and a value for each of its ends.
bool has_all_values(const CutShadeInput& input) {
  const std::size_t words = words_per_cut(input.leaf_count, input.granule_log2);
  const std::size_t receivers = input.visibility_masks.size() / words;
  if (input.visibility_masks.size() % words != 0 || input.first_value.size() < receivers) return false;
  for (std::size_t r = 0; r < receivers; ++r) {
    std::size_t end = input.first_value[r];
    for (const std::uint32_t word : input.visibility_masks.subspan(r * words, words))
      end += std::popcount(word);
    if (end > input.values.size()) return false;
  }
  return true;
}

[[maybe_unused]] bool is_consistent(const CutShadeInput& input) {
  const std::size_t receivers =
      input.visibility_masks.size() / words_per_cut(input.leaf_count, input.granule_log2);
  const auto has_receivers = [&](const ShadingFace& face) {
    return std::max({face.receivers.x, face.receivers.y, face.receivers.z}) < receivers;
  };
  const auto has_face = [&](const ShadingPoint& point) { return point.face < input.faces.size(); };
  return input.horizons.size() >= receivers &&
         input.points.size() <= std::numeric_limits<std::uint32_t>::max() && input.points_per_dispatch > 0 &&
         has_all_values(input) && std::ranges::all_of(input.faces, has_receivers) &&
         std::ranges::all_of(input.points, has_face);
}

/// Refinement ends at leaves because one light does not spread.
[[maybe_unused]] bool has_single_lights(std::span<const LightNode> nodes) {
  return std::ranges::all_of(nodes.subspan(nodes.size() / 2), [](const auto& n) { return n.spread == 0; });
}

}  // namespace

struct CutShader::State {
  VulkanDevice& device;
  std::uint32_t leaf_count, granule_log2, point_count, points_per_dispatch;
  compute::Kernel kernel;
  Buffer visibility_masks, first_value, values, horizons, faces, points;
  Buffer nodes, illumination_ends, illumination_granules, radiance, cluster_count;
  Buffer staging, readback;

  State(VulkanDevice& vulkan, const CutShadeInput& input);
  CutShadeParameters parameters(const LobeOptions& lobes) const;
  void stage(compute::Commands& commands, std::span<const LightNode> lights,
             std::span<const std::uint32_t> illumination_mask) const;
  void dispatch(compute::Commands& commands, const LobeOptions& lobes) const;
  void read_back(compute::Commands& commands, std::span<vec3> colours, std::span<std::uint32_t> counts) const;
  std::uint32_t dispatch_size() const;
};

CutShader::State::State(VulkanDevice& vulkan, const CutShadeInput& input)
    : device(vulkan),
      leaf_count(input.leaf_count),
      granule_log2(input.granule_log2),
      point_count(std::uint32_t(input.points.size())),
      points_per_dispatch(input.points_per_dispatch),
      kernel(device, shaders::cut_shade, sizeof(CutShadeParameters)),
      visibility_masks(buffer_of(device, input.visibility_masks)),
      first_value(buffer_of(device, input.first_value)),
      values(buffer_of_values(device, input.values)),
      horizons(buffer_of(device, input.horizons)),
      faces(buffer_of(device, input.faces)),
      points(buffer_of(device, input.points)),
      nodes(device, Memory::device, 2 * sizeof(LightNode) * leaf_count),
      illumination_ends(device, Memory::device, 4 * words_per_cut(leaf_count, 0)),
      illumination_granules(device, Memory::device, 4 * words_per_cut(leaf_count, granule_log2)),
      radiance(device, Memory::device, sizeof(vec3) * point_count),
      cluster_count(device, Memory::device, sizeof(std::uint32_t) * point_count),
      staging(device, Memory::upload,
              nodes.byte_count() + illumination_ends.byte_count() + illumination_granules.byte_count()),
      readback(device, Memory::download, radiance.byte_count() + cluster_count.byte_count()) {}

CutShadeParameters CutShader::State::parameters(const LobeOptions& lobes) const {
  return {.visibility_masks = visibility_masks.address(),
          .first_value = first_value.address(),
          .values = values.address(),
          .horizons = horizons.address(),
          .faces = faces.address(),
          .points = points.address(),
          .nodes = nodes.address(),
          .illumination_ends = illumination_ends.address(),
          .illumination_granules = illumination_granules.address(),
          .radiance = radiance.address(),
          .cluster_count = cluster_count.address(),
          .leaf_count = leaf_count,
          .granule_log2 = granule_log2,
          .lobes = std::uint32_t(lobes.lobes),
          .tolerance = lobes.tolerance,
          .first_point = 0,
          .end_point = 0};
}

void CutShader::State::stage(compute::Commands& commands, std::span<const LightNode> lights,
                             std::span<const std::uint32_t> illumination_mask) const {
  std::size_t offset = 0;
  const auto put = [&](std::span<const std::byte> bytes, const Buffer& to) {
    std::memcpy(staging.mapped().data() + offset, bytes.data(), bytes.size());
    commands.copy(staging, offset, to, 0, bytes.size());
    offset += bytes.size();
  };
  const auto granules = ends_of_granules(illumination_mask, leaf_count, granule_log2);
  put(std::as_bytes(lights), nodes);
  put(std::as_bytes(illumination_mask), illumination_ends);
  put(std::as_bytes(std::span(granules)), illumination_granules);
}

std::uint32_t CutShader::State::dispatch_size() const {
  const std::uint64_t most = std::uint64_t(compute::max_group_count(device)) * CUT_SHADE_GROUP_SIZE;
  return std::uint32_t(std::min<std::uint64_t>(most, points_per_dispatch));
}

void CutShader::State::dispatch(compute::Commands& commands, const LobeOptions& lobes) const {
  CutShadeParameters now = parameters(lobes);
  for (std::uint32_t first = 0; first < point_count; first = now.end_point) {
    const std::uint32_t count = std::min(dispatch_size(), point_count - first);
    now.first_point = first;
    now.end_point = first + count;
    commands.dispatch(kernel, (count - 1) / CUT_SHADE_GROUP_SIZE + 1, std::as_bytes(std::span(&now, 1)));
  }
}

/// Submits the commands and waits.
void CutShader::State::read_back(compute::Commands& commands, std::span<vec3> colours,
                                 std::span<std::uint32_t> counts) const {
  commands.copy(radiance, 0, readback, 0, colours.size_bytes());
  if (!counts.empty()) commands.copy(cluster_count, 0, readback, colours.size_bytes(), counts.size_bytes());
  commands.submit();
  std::memcpy(colours.data(), readback.mapped().data(), colours.size_bytes());
  if (!counts.empty())
    std::memcpy(counts.data(), readback.mapped().data() + colours.size_bytes(), counts.size_bytes());
}

CutShader::CutShader(VulkanDevice& device, const CutShadeInput& input) {
  COPPICE_ASSERT(std::has_single_bit(input.leaf_count) && input.granule_log2 <= 5 &&
                 input.leaf_count >> input.granule_log2 > 0);
  COPPICE_ASSERT(is_consistent(input));
  state_ = std::make_unique<State>(device, input);
}
CutShader::~CutShader() = default;
CutShader::CutShader(CutShader&&) noexcept = default;
CutShader& CutShader::operator=(CutShader&&) noexcept = default;

CutShadeResult CutShader::shade(std::span<const LightNode> nodes,
                                std::span<const std::uint32_t> illumination_mask, const LobeOptions& lobes,
                                std::span<std::uint32_t> cluster_count) {
  COPPICE_ASSERT(nodes.size() == 2 * std::size_t(state_->leaf_count));
  COPPICE_ASSERT(illumination_mask.size() == words_per_cut(state_->leaf_count, 0));
  COPPICE_ASSERT(lobes.lobes != Lobes::refined || has_single_lights(nodes));
  COPPICE_ASSERT(cluster_count.empty() || cluster_count.size() == state_->point_count);
  if (state_->point_count == 0) return {};
  compute::Commands commands(state_->device);
  state_->stage(commands, nodes, illumination_mask);
  commands.barrier();
  commands.read_clock();
  state_->dispatch(commands, lobes);
  commands.read_clock();
  commands.barrier();
  CutShadeResult result{.radiance = std::vector<vec3>(state_->point_count), .milliseconds = std::nullopt};
  state_->read_back(commands, result.radiance, cluster_count);
  result.milliseconds = commands.milliseconds();
  return result;
}

}  // namespace coppice
