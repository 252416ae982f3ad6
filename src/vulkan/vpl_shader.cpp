#include <coppice/shared/vpl_gather.h>

#include <algorithm>
#include <bit>
#include <coppice/core/config.hpp>
#include <coppice/vulkan/vpl_shader.hpp>
#include <limits>

#include "compute.hpp"
#include "cut_buffers.hpp"
#include "shaders/vpl_filter.h"
#include "shaders/vpl_lists.h"
#include "shaders/vpl_walk.h"

namespace coppice {
namespace {

using compute::Buffer;
using compute::Memory;

/// The points of one call on the device, and what they have gathered.
struct PointBuffers {
  std::uint32_t count;
  Buffer points, radiance, taken, next;

  PointBuffers(const VulkanDevice& device, std::span<const GlossyPoint> all)
      : count(std::uint32_t(all.size())),
        points(compute::buffer_of(device, all)),
        radiance(device, Memory::device, sizeof(vec3) * all.size()),
        taken(device, Memory::device, sizeof(std::uint32_t) * all.size()),
        next(device, Memory::device, taken.byte_count()) {
    COPPICE_ASSERT(all.size() <= std::numeric_limits<std::uint32_t>::max());
  }

  void clear(compute::Commands& commands) const {
    commands.fill_with_zeros(radiance);
    commands.fill_with_zeros(taken);
    commands.fill_with_zeros(next);
    commands.barrier();
  }
};

std::uint32_t longest(const VplLists& lists) {
  std::uint32_t most = 0, begin = 0;
  for (const std::uint32_t end : lists.ends) most = std::max(most, end - begin), begin = end;
  return most;
}

[[maybe_unused]] bool is_consistent(std::span<const GlossyPoint> points, const VplLists& lists,
                                    std::uint32_t leaf_count) {
  const bool ends_there = (lists.ends.empty() ? 0 : lists.ends.back()) == lists.nodes.size();
  return ends_there && std::ranges::is_sorted(lists.ends) &&
         std::ranges::all_of(lists.nodes, [&](auto h) { return h > 0 && h < 2 * leaf_count; }) &&
         std::ranges::all_of(points, [&](const auto& p) { return p.group < lists.ends.size(); });
}

VplGatherResult dark(std::size_t point_count) {
  return {std::vector<vec3>(point_count, vec3(0)), std::vector<std::uint32_t>(point_count), std::nullopt};
}

}  // namespace

struct VplShader::State {
  VulkanDevice& device;
  compute::Kernel joins, walk, lists;
  std::uint32_t leaf_count = 0;
  Buffer nodes;

  explicit State(VulkanDevice& vulkan)
      : device(vulkan),
        joins(device, shaders::vpl_filter, sizeof(VplFilterParameters)),
        walk(device, shaders::vpl_walk, sizeof(VplWalkParameters)),
        lists(device, shaders::vpl_lists, sizeof(VplListsParameters)),
        nodes(device, Memory::device, 0) {}

  void resize(std::size_t leaves);
  void join(compute::Commands& commands, VplFilterParameters parameters, std::uint32_t count) const;
  VplGatherTask task(const PointBuffers& points) const;
  template <class Parameters>
  VplGatherResult gather(const PointBuffers& points, const compute::Kernel& kernel,
                         const Parameters& parameters, std::size_t node_count) const;
};

/// Keeps the buffer where it has the size.
void VplShader::State::resize(std::size_t leaves) {
  COPPICE_ASSERT(leaves == 0 || std::has_single_bit(leaves));
  COPPICE_ASSERT(leaves <= std::numeric_limits<std::uint32_t>::max() / 2);
  if (leaves != leaf_count) nodes = Buffer(device, Memory::device, 2 * leaves * sizeof(VplNode));
  leaf_count = std::uint32_t(leaves);
}

/// Joins the nodes below the roots parameters.first … + count - 1, and them.
void VplShader::State::join(compute::Commands& commands, VplFilterParameters parameters,
                            std::uint32_t count) const {
  const std::uint32_t most = compute::max_group_count(device), end = parameters.first + count;
  for (; parameters.first < end; parameters.first += std::min(most, end - parameters.first))
    commands.dispatch(joins, std::min(most, end - parameters.first),
                      std::as_bytes(std::span(&parameters, 1)));
  commands.barrier();
}

VplGatherTask VplShader::State::task(const PointBuffers& points) const {
  return {.nodes = nodes.address(),
          .points = points.points.address(),
          .radiance = points.radiance.address(),
          .taken = points.taken.address(),
          .next = points.next.address()};
}

/// Dispatches until each point has met so many nodes.
template <class Parameters>
VplGatherResult VplShader::State::gather(const PointBuffers& points, const compute::Kernel& kernel,
                                         const Parameters& parameters, std::size_t node_count) const {
  compute::Commands commands(device);
  points.clear(commands);
  commands.read_clock();
  for (std::size_t met = 0; met < node_count; met += VPL_NODES_PER_DISPATCH) {
    compute::dispatch_items(commands, device, kernel, parameters, points.count);
    commands.barrier();
  }
  commands.read_clock();
  commands.submit();
  return {compute::items_of<vec3>(device, points.radiance, points.count),
          compute::items_of<std::uint32_t>(device, points.taken, points.count), commands.milliseconds()};
}

VplShader::VplShader(VulkanDevice& device) : state_(std::make_unique<State>(device)) {}
VplShader::~VplShader() = default;
VplShader::VplShader(VplShader&&) noexcept = default;
VplShader& VplShader::operator=(VplShader&&) noexcept = default;

std::optional<double> VplShader::filter(std::span<const VplNode> leaves) {
  state_->resize(leaves.size());
  if (leaves.empty()) return std::nullopt;
  const Buffer staging(state_->device, Memory::upload, leaves.size_bytes());
  std::ranges::copy(std::as_bytes(leaves), staging.mapped().begin());
  compute::Commands commands(state_->device);
  commands.fill_with_zeros(state_->nodes);  // entry 0
  commands.barrier();
  commands.copy(staging, 0, state_->nodes, leaves.size_bytes(), leaves.size_bytes());
  commands.barrier();
  commands.read_clock();
  for (std::uint32_t done = state_->leaf_count; done > 1;) {
    const std::uint32_t levels = std::min(std::uint32_t(std::bit_width(done)) - 1, VPL_FILTER_LEVELS);
    done >>= levels;
    state_->join(commands, {.nodes = state_->nodes.address(), .first = done, .levels = levels}, done);
  }
  commands.read_clock();
  commands.submit();
  return commands.milliseconds();
}

void VplShader::set_nodes(std::span<const VplNode> nodes) {
  COPPICE_ASSERT(nodes.size() % 2 == 0);
  state_->resize(nodes.size() / 2);
  compute::upload(state_->device, std::as_bytes(nodes), state_->nodes);
}

std::vector<VplNode> VplShader::nodes() const {
  return compute::items_of<VplNode>(state_->device, state_->nodes, 2 * std::size_t(state_->leaf_count));
}

VplGatherResult VplShader::gather_by_angle(std::span<const GlossyPoint> points, float threshold,
                                           std::span<const WalkMark> marks) const {
  const State& state = *state_;
  const std::size_t node_count = 2 * std::size_t(state.leaf_count);
  COPPICE_ASSERT(threshold > 0 && threshold < 2 * pi);
  COPPICE_ASSERT(marks.empty() || marks.size() == node_count);
  if (points.empty() || node_count == 0) return dark(points.size());
  const PointBuffers buffers(state.device, points);
  const Buffer packed(state.device, Memory::device, packed_size(marks.size()));
  compute::upload(state.device, std::as_bytes(marks), packed);
  const VplWalkParameters parameters{.gather = state.task(buffers),
                                     .marks = packed.address(),
                                     .range = {},
                                     .leaf_count = state.leaf_count,
                                     .has_marks = marks.empty() ? 0u : 1u,
                                     .nearest = vpl_reach(threshold)};
  return state.gather(buffers, state.walk, parameters, node_count);
}

VplGatherResult VplShader::gather_lists(std::span<const GlossyPoint> points, const VplLists& lists) const {
  const State& state = *state_;
  COPPICE_ASSERT(is_consistent(points, lists, state.leaf_count));
  if (points.empty() || lists.nodes.empty()) return dark(points.size());
  const PointBuffers buffers(state.device, points);
  const Buffer ends = compute::buffer_of(state.device, std::span(lists.ends));
  const Buffer nodes = compute::buffer_of(state.device, std::span(lists.nodes));
  const VplListsParameters parameters{
      .gather = state.task(buffers), .ends = ends.address(), .lists = nodes.address(), .range = {}};
  return state.gather(buffers, state.lists, parameters, longest(lists));
}

}  // namespace coppice
