#include <coppice/vulkan/transfer_shader.hpp>
//
#include <algorithm>
#include <cstring>
#include <limits>

#include "shaders/lattice_features.h"
#include "shaders/lattice_visibility.h"
#include "shaders/light_expand.h"
#include "shaders/light_mix.h"
#include "shaders/light_project.h"
#include "transfer_state.hpp"

namespace coppice {
namespace {

using compute::Buffer;
using compute::Memory;

constexpr std::size_t most_bytes = std::numeric_limits<std::uint32_t>::max();

static_assert(sizeof(LatticeCorners) == sizeof(LatticeCornerList) &&
              offsetof(LatticeCorners, points) == offsetof(LatticeCornerList, points) &&
              offsetof(LatticeCorners, weights) == offsetof(LatticeCornerList, weights) &&
              offsetof(LatticeCorners, count) == offsetof(LatticeCornerList, count));

/// Adds bytes, filled up to a whole word with zeros.
void append_bytes(std::span<const std::int8_t> bytes, std::vector<std::uint32_t>& words) {
  const std::size_t at = words.size();
  words.resize(at + (bytes.size() + 3) / 4);
  if (!bytes.empty()) std::memcpy(&words[at], bytes.data(), bytes.size());
}

template <class T>
Buffer buffer_of(const VulkanDevice& device, const std::vector<T>& items) {
  return compute::buffer_of(device, std::span<const T>(items));
}

PackedFields packed_coefficients(const LatticeVisibility<std::int8_t>& visibility) {
  PackedFields packed;
  for (std::size_t c = 0; c < visibility.clusters.size(); ++c) {
    packed.begin_cluster(visibility.ends[c]);
    const std::size_t size = visibility.ends[c] - visibility.begin(c);
    const std::span all(visibility.clusters[c].coefficients);
    COPPICE_ASSERT(all.size() == size * visibility.rank);
    for (std::size_t k = 0; k < visibility.rank; ++k) packed.append(all.subspan(k * size, size));
  }
  return packed;
}

PackedFields packed_fields(const ClusterFields<std::int8_t>& fields,
                           std::span<const std::uint32_t> sample_ends) {
  COPPICE_ASSERT(fields.ends.size() == sample_ends.size());
  PackedFields packed;
  for (std::size_t c = 0; c < sample_ends.size(); ++c) {
    packed.begin_cluster(sample_ends[c]);
    for (std::size_t f = fields.begin(c); f < fields.end(c); ++f) packed.append(fields[f]);
  }
  return packed;
}

/// The rows of all clusters one after the other, and where each cluster's begin.
struct PackedRows {
  std::vector<LatticeClusterRows> clusters;
  std::vector<std::uint32_t> bits, before;
  std::vector<std::int8_t> rows;
  std::vector<float> scales;

  explicit PackedRows(const LatticeVisibility<std::int8_t>& visibility) {
    for (const auto& cluster : visibility.clusters) {
      COPPICE_ASSERT(cluster.scales.size() == visibility.rank);
      COPPICE_ASSERT(rows.size() + cluster.rows.size() <= most_bytes);
      clusters.push_back({std::uint32_t(bits.size()), std::uint32_t(rows.size())});
      bits.insert(bits.end(), cluster.index.bits.begin(), cluster.index.bits.end());
      before.insert(before.end(), cluster.index.before.begin(), cluster.index.before.end());
      rows.insert(rows.end(), cluster.rows.begin(), cluster.rows.end());
      scales.insert(scales.end(), cluster.scales.begin(), cluster.scales.end());
    }
  }
};

Buffer packed_buffer(const VulkanDevice& device, std::span<const std::int8_t> bytes) {
  Buffer buffer(device, Memory::device, packed_size(bytes.size()));
  compute::upload(device, std::as_bytes(bytes), buffer);
  return buffer;
}

/// Rows of whole words, by channel, then pattern.
std::vector<std::uint32_t> packed_matrices(const LightTransfer<std::int8_t>& transfer) {
  std::vector<std::uint32_t> words;
  for (const auto& matrix : transfer.mix) {
    COPPICE_ASSERT(matrix.count() == transfer.pattern_count());
    COPPICE_ASSERT(matrix.width == transfer.coefficient_count());
    for (std::size_t row = 0; row < matrix.count(); ++row) append_bytes(matrix[row], words);
  }
  COPPICE_ASSERT(words.size() <= most_bytes / 4);
  return words;
}

std::vector<float> matrix_scales_of(const LightTransfer<std::int8_t>& transfer) {
  std::vector<float> scales;
  for (const auto& matrix : transfer.mix)
    scales.insert(scales.end(), matrix.scales.begin(), matrix.scales.end());
  return scales;
}

/// Zeros: kernels read the end of the last word.
Buffer cleared_buffer(const VulkanDevice& device, std::size_t byte_count) {
  Buffer buffer(device, Memory::device, byte_count);
  compute::Commands commands(device);
  commands.fill_with_zeros(buffer);
  commands.submit();
  return buffer;
}

/// As compute::dispatch_items, with a workgroup an item.
template <class Parameters>
void dispatch_groups(compute::Commands& commands, const VulkanDevice& device, const compute::Kernel& kernel,
                     Parameters parameters, std::uint32_t count) {
  const std::uint32_t most = compute::max_group_count(device);
  for (std::uint32_t first = 0; first < count; first = parameters.range.end) {
    parameters.range = {first, first + std::min(most, count - first)};
    commands.dispatch(kernel, parameters.range.end - first, std::as_bytes(std::span(&parameters, 1)));
  }
}

}  // namespace

void PackedFields::begin_cluster(std::uint32_t end_sample) {
  const std::uint32_t first = clusters.empty() ? 0 : clusters.back().end_sample;
  COPPICE_ASSERT(first <= end_sample && words.size() <= most_bytes / 4);
  clusters.push_back({first, end_sample, quad_count, field_count, field_count, std::uint32_t(words.size())});
  quad_count += (end_sample - first + 3) / 4;
}

void PackedFields::append(std::span<const std::int8_t> field) {
  COPPICE_ASSERT(field.size() == clusters.back().end_sample - clusters.back().first_sample);
  append_bytes(field, words);
  clusters.back().end_field = ++field_count;
}

FieldBuffers::FieldBuffers(const VulkanDevice& device, const PackedFields& fields)
    : cluster_count(std::uint32_t(fields.clusters.size())),
      quad_count(fields.quad_count),
      field_count(fields.field_count),
      clusters(buffer_of(device, fields.clusters)),
      values(buffer_of(device, fields.words)) {
  COPPICE_ASSERT(fields.words.size() <= most_bytes / 4);
}

bool is_served(std::span<const LatticeCorners> points) {
  return std::ranges::any_of(points, [](const LatticeCorners& c) { return c.count > 0; });
}

LatticeVisibilityShader::State::State(VulkanDevice& vulkan, const LatticeVisibility<std::int8_t>& from)
    : device(vulkan),
      features_kernel(device, shaders::lattice_features, sizeof(LatticeFeaturesParameters)),
      visibility_kernel(device, shaders::lattice_visibility, sizeof(LatticeVisibilityParameters)),
      rank(std::uint32_t(from.rank)),
      sample_count(std::uint32_t(from.size())),
      coefficients(device, packed_coefficients(from)),
      clusters(device, Memory::device, 0),
      bits(device, Memory::device, 0),
      before(device, Memory::device, 0),
      rows(device, Memory::device, 0),
      scales(device, Memory::device, 0),
      corners(device),
      features(device),
      visibility(device),
      up(device, Memory::upload),
      down(device, Memory::download) {
  COPPICE_ASSERT(from.rank <= LATTICE_TERMS_PER_DISPATCH && from.clusters.size() == from.ends.size());
  const PackedRows packed(from);
  clusters = buffer_of(device, packed.clusters);
  bits = buffer_of(device, packed.bits);
  before = buffer_of(device, packed.before);
  rows = packed_buffer(device, packed.rows);
  scales = buffer_of(device, packed.scales);
  visibility.make_room(sample_count * sizeof(float));
}

std::uint32_t LatticeVisibilityShader::State::blocks_per_dispatch() const {
  return LATTICE_TERMS_PER_DISPATCH / std::max(rank, 1u);
}

void LatticeVisibilityShader::State::make_room(std::size_t points_of_a_light) {
  COPPICE_ASSERT(points_of_a_light <= LATTICE_POINTS);
  const std::size_t blocks =
      std::min<std::size_t>((points_of_a_light + LATTICE_BLOCK - 1) / LATTICE_BLOCK, blocks_per_dispatch());
  features.make_room(coefficients.cluster_count * blocks * rank * LATTICE_BLOCK * sizeof(float));
}

void LatticeVisibilityShader::State::record(compute::Commands& commands,
                                            std::span<const LatticeCorners> points, std::uint32_t first_point,
                                            LatticeShadow shadow) {
  const bool smooth = shadow == LatticeShadow::smooth;
  const auto count = std::uint32_t(points.size());
  const auto known = float(std::ranges::count_if(points, [](const auto& c) { return c.count > 0; }));
  LatticeFeaturesParameters find{.clusters = clusters.address(),
                                 .bits = bits.address(),
                                 .before = before.address(),
                                 .rows = rows.address(),
                                 .scales = scales.address(),
                                 .points = corners.address(),
                                 .features = features.address(),
                                 .range = {},
                                 .rank = rank,
                                 .block_count = 0,
                                 .first_point = first_point,
                                 .end_point = first_point + count,
                                 .known = smooth ? known : 0.0f};
  LatticeVisibilityParameters see{.clusters = coefficients.clusters.address(),
                                  .coefficients = coefficients.values.address(),
                                  .features = features.address(),
                                  .visibility = visibility.address(),
                                  .range = {},
                                  .cluster_count = coefficients.cluster_count,
                                  .rank = rank,
                                  .block_count = 0,
                                  .smooth_edges = smooth ? 1u : 0u,
                                  .share = (smooth ? known : 1.0f) / float(count),
                                  .continues = 0};
  const std::uint32_t blocks = smooth ? 1 : (count + LATTICE_BLOCK - 1) / LATTICE_BLOCK;
  for (std::uint32_t block = 0; block < blocks; block += find.block_count) {
    find.block_count = see.block_count = std::min(blocks - block, blocks_per_dispatch());
    find.first_point = first_point + LATTICE_BLOCK * block;
    see.continues = block > 0 ? 1 : 0;
    compute::dispatch_items(commands, device, features_kernel, find,
                            coefficients.cluster_count * find.block_count * rank);
    commands.barrier();
    compute::dispatch_items(commands, device, visibility_kernel, see, coefficients.quad_count);
    commands.barrier();
  }
}

LatticeVisibilityShader::LatticeVisibilityShader(VulkanDevice& device,
                                                 const LatticeVisibility<std::int8_t>& visibility)
    : state_(std::make_unique<State>(device, visibility)) {}
LatticeVisibilityShader::~LatticeVisibilityShader() = default;
LatticeVisibilityShader::LatticeVisibilityShader(LatticeVisibilityShader&&) noexcept = default;
LatticeVisibilityShader& LatticeVisibilityShader::operator=(LatticeVisibilityShader&&) noexcept = default;
std::optional<double> LatticeVisibilityShader::milliseconds() const { return state_->milliseconds; }

bool LatticeVisibilityShader::visibility(std::span<const LatticeCorners> points, LatticeShadow shadow,
                                         std::span<float> out) {
  State& state = *state_;
  COPPICE_ASSERT(out.size() == state.sample_count);
  state.milliseconds.reset();
  if (!is_served(points)) return false;
  if (out.empty()) return true;
  state.make_room(points.size());
  state.corners.make_room(points.size_bytes());
  state.up.make_room(points.size_bytes());
  state.down.make_room(out.size_bytes());
  compute::Commands commands(state.device);
  stage(commands, points, state.up, 0, state.corners.buffer());
  commands.barrier();
  commands.read_clock();
  state.record(commands, points, 0, shadow);
  commands.read_clock();
  commands.copy(state.visibility.buffer(), 0, state.down.buffer(), 0, out.size_bytes());
  commands.submit();
  state.milliseconds = commands.milliseconds();
  fetch(state.down, 0, out);
  return true;
}

LightTransferShader::State::State(VulkanDevice& vulkan, const LightTransfer<std::int8_t>& transfer)
    : device(vulkan),
      project_kernel(device, shaders::light_project, sizeof(LightProjectParameters)),
      mix_kernel(device, shaders::light_mix, sizeof(LightMixParameters)),
      expand_kernel(device, shaders::light_expand, sizeof(LightExpandParameters)),
      sample_count(std::uint32_t(transfer.sample_count())),
      coefficient_count(std::uint32_t(transfer.coefficient_count())),
      row_words((coefficient_count + 3) / 4),
      projection(device, packed_fields(transfer.projection, transfer.sample_ends)),
      patterns(device, packed_fields(transfer.patterns, transfer.sample_ends)),
      projection_scales(buffer_of(device, transfer.projection.scales)),
      pattern_scales(buffer_of(device, transfer.patterns.scales)),
      offsets(buffer_of(device, transfer.offsets)),
      matrices(buffer_of(device, packed_matrices(transfer))),
      matrix_scales(buffer_of(device, matrix_scales_of(transfer))),
      coefficients(cleared_buffer(device, 3 * std::size_t(row_words) * 4 * sizeof(float))),
      weights(device, Memory::device, patterns.field_count * sizeof(vec3)),
      direct(device, Memory::device, sample_count * sizeof(vec3)),
      indirect(device, Memory::device, sample_count * sizeof(vec3)),
      up(device, Memory::upload),
      down(device, Memory::download),
      is_centred(!transfer.offsets.empty()) {
  COPPICE_ASSERT(coefficient_count >= projection.field_count &&
                 coefficient_count <= projection.field_count + 1);
}

void LightTransferShader::State::record(compute::Commands& commands, const vec3& intensity) const {
  const LightProjectParameters project{.clusters = projection.clusters.address(),
                                       .values = projection.values.address(),
                                       .scales = projection_scales.address(),
                                       .offsets = offsets.address(),
                                       .direct = direct.address(),
                                       .coefficients = coefficients.address(),
                                       .intensity = intensity,
                                       .cluster_count = projection.cluster_count,
                                       .range = {},
                                       .field_count = projection.field_count,
                                       .stride = 4 * row_words,
                                       .is_centred = is_centred ? 1u : 0u};
  const LightMixParameters mix{.values = matrices.address(),
                               .scales = matrix_scales.address(),
                               .coefficients = coefficients.address(),
                               .weights = weights.address(),
                               .range = {},
                               .pattern_count = patterns.field_count,
                               .row_words = row_words};
  const LightExpandParameters expand{.clusters = patterns.clusters.address(),
                                     .values = patterns.values.address(),
                                     .scales = pattern_scales.address(),
                                     .weights = weights.address(),
                                     .indirect = indirect.address(),
                                     .range = {},
                                     .cluster_count = patterns.cluster_count};
  dispatch_groups(commands, device, project_kernel, project, coefficient_count);
  commands.barrier();
  commands.read_clock();
  dispatch_groups(commands, device, mix_kernel, mix, patterns.field_count);
  commands.barrier();
  commands.read_clock();
  compute::dispatch_items(commands, device, expand_kernel, expand, patterns.quad_count);
  commands.barrier();
  commands.read_clock();
}

LightTransferShader::LightTransferShader(VulkanDevice& device, const LightTransfer<std::int8_t>& transfer)
    : state_(std::make_unique<State>(device, transfer)) {}
LightTransferShader::~LightTransferShader() = default;
LightTransferShader::LightTransferShader(LightTransferShader&&) noexcept = default;
LightTransferShader& LightTransferShader::operator=(LightTransferShader&&) noexcept = default;
std::optional<LightFrameTimes> LightTransferShader::times() const { return state_->times; }

void LightTransferShader::indirect(std::span<const vec3> direct, std::span<vec3> indirect,
                                   const vec3& intensity) {
  State& state = *state_;
  COPPICE_ASSERT(direct.size() == state.sample_count && indirect.size() == state.sample_count);
  state.times.reset();
  if (direct.empty()) return;
  state.up.make_room(direct.size_bytes());
  state.down.make_room(indirect.size_bytes());
  compute::Commands commands(state.device);
  stage(commands, direct, state.up, 0, state.direct);
  commands.barrier();
  commands.read_clock();
  state.record(commands, intensity);
  commands.copy(state.indirect, 0, state.down.buffer(), 0, indirect.size_bytes());
  commands.submit();
  if (const auto laps = commands.laps(); !laps.empty()) state.times = {0, laps[0], laps[1], laps[2]};
  fetch(state.down, 0, indirect);
}

}  // namespace coppice
