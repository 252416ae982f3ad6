// What LatticeVisibilityShader and LightTransferShader keep on the device, and record for a frame.
#pragma once

#include <coppice/vulkan/transfer_shader.hpp>
//
#include "kept_buffer.hpp"

namespace coppice {

/// Fields as kernels read them (FieldCluster).
struct PackedFields {
  std::vector<FieldCluster> clusters;
  std::vector<std::uint32_t> words;
  std::uint32_t quad_count = 0, field_count = 0;

  /// The next cluster: its samples follow those of the one before. Precondition: a field has a value a
  /// sample.
  void begin_cluster(std::uint32_t end_sample);
  void append(std::span<const std::int8_t> field);
};

struct FieldBuffers {
  std::uint32_t cluster_count, quad_count, field_count;
  compute::Buffer clusters, values;

  FieldBuffers(const VulkanDevice& device, const PackedFields& fields);
};

/// Copies items to the host's side of a buffer from a byte on, and from there to the start of a buffer on the
/// device. Preconditions: there is room in both.
template <class T>
void stage(compute::Commands& commands, std::span<const T> items, const KeptBuffer& staging, std::size_t at,
           const compute::Buffer& to) {
  std::ranges::copy(std::as_bytes(items), staging.buffer().mapped().begin() + std::ptrdiff_t(at));
  commands.copy(staging.buffer(), at, to, 0, items.size_bytes());
}

/// What the commands have copied to the host's side of a buffer. Precondition: they were submitted.
template <class T>
void fetch(const KeptBuffer& staging, std::size_t at, std::span<T> items) {
  std::ranges::copy(staging.buffer().mapped().subspan(at, items.size_bytes()),
                    std::as_writable_bytes(items).begin());
}

bool is_served(std::span<const LatticeCorners> points);

struct LatticeVisibilityShader::State {
  VulkanDevice& device;
  compute::Kernel features_kernel, visibility_kernel;
  std::uint32_t rank, sample_count;
  FieldBuffers coefficients;
  compute::Buffer clusters, bits, before, rows, scales;
  KeptBuffer corners, features, visibility, up, down;
  std::optional<double> milliseconds;

  State(VulkanDevice& vulkan, const LatticeVisibility<std::int8_t>& visibility);

  /// Before anything is recorded: for lights of so many points.
  void make_room(std::size_t points_of_a_light);
  /// The visibility of the light whose corners lie in `corners` from first_point on. Precondition: is_served.
  void record(compute::Commands& commands, std::span<const LatticeCorners> points, std::uint32_t first_point,
              LatticeShadow shadow);

 private:
  std::uint32_t blocks_per_dispatch() const;
};

struct LightTransferShader::State {
  VulkanDevice& device;
  compute::Kernel project_kernel, mix_kernel, expand_kernel;
  std::uint32_t sample_count, coefficient_count, row_words;
  FieldBuffers projection, patterns;
  compute::Buffer projection_scales, pattern_scales, offsets, matrices, matrix_scales, coefficients, weights,
      direct, indirect;
  KeptBuffer up, down;
  bool is_centred;
  std::optional<LightFrameTimes> times;

  State(VulkanDevice& vulkan, const LightTransfer<std::int8_t>& transfer);

  /// From `direct` to `indirect`. Reads the clock after each of the three stages.
  void record(compute::Commands& commands, const vec3& intensity) const;
};

}  // namespace coppice
