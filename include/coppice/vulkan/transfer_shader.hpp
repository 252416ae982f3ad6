// Lights that move through a room on a Vulkan device: visibility from a lattice of light positions, direct
// light at the samples, and the indirect light that it causes.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <coppice/shared/transfer.h>

#include <coppice/light/surface_samples.hpp>
#include <coppice/transfer/lattice_visibility.hpp>
#include <coppice/transfer/light_transfer.hpp>
#include <coppice/vulkan/device.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace coppice {

/// Where points of a light lie in a lattice: lattice_corners of each.
template <Occluder O>
std::vector<LatticeCorners> corners_of(const LightLattice& lattice, std::span<const LocalLight> points,
                                       const O& occluder) {
  std::vector<LatticeCorners> corners;
  corners.reserve(points.size());
  for (const LocalLight& point : points)
    corners.push_back(lattice_corners(lattice, point.position, occluder));
  return corners;
}

/// Milliseconds of a frame's stages by the device's own clock.
struct LightFrameTimes {
  double direct = 0;  ///< visibility and direct light of all lights; 0 where it came from elsewhere
  double projection = 0, mix = 0, expansion = 0;
};

/// The visibility of lights at all samples as lattice_visibility() has it. Hard decisions are the CPU's but
/// where the rounding of a sum decides; smooth values have a relative RMS difference below 2e-6 on lavapipe.
/// Each call waits for the device, and throws InputError where its buffers do not fit into its memory.
class LatticeVisibilityShader {
 public:
  /// Uploads it, of which the caller need keep but the lattice. The device outlives the shader.
  /// Preconditions: its rank is at most LATTICE_TERMS_PER_DISPATCH, its rows take less than 2^32 bytes.
  LatticeVisibilityShader(VulkanDevice& device, const LatticeVisibility<std::int8_t>& visibility);
  ~LatticeVisibilityShader();
  LatticeVisibilityShader(LatticeVisibilityShader&&) noexcept;
  LatticeVisibilityShader& operator=(LatticeVisibilityShader&&) noexcept;

  /// lattice_visibility() of a light whose points have these corners. False, and nothing written, where none
  /// is served. Preconditions: as many values as samples; LATTICE_POINTS points at most.
  bool visibility(std::span<const LatticeCorners> points, LatticeShadow shadow, std::span<float> out);

  /// Of the last call's kernels on the device; empty where its queue has no clock, or it had nothing to do.
  std::optional<double> milliseconds() const;

 private:
  friend class LightFrameShader;
  struct State;
  std::unique_ptr<State> state_;
};

/// Indirect light from direct light, all three stages on the device. The relative RMS difference from
/// indirect_irradiance() is below 1e-6 on lavapipe. Each call waits for the device, and throws InputError
/// where its buffers do not fit into its memory.
class LightTransferShader {
 public:
  /// Uploads it; the caller need keep nothing. The device outlives the shader. Preconditions: below 2^24
  /// samples and 65,536 patterns a cluster, below 2^32 bytes of fields and of matrices.
  LightTransferShader(VulkanDevice& device, const LightTransfer<std::int8_t>& transfer);
  ~LightTransferShader();
  LightTransferShader(LightTransferShader&&) noexcept;
  LightTransferShader& operator=(LightTransferShader&&) noexcept;

  /// indirect_irradiance(). Precondition: both have as many values as there are samples.
  void indirect(std::span<const vec3> direct, std::span<vec3> indirect, const vec3& intensity = vec3(1));

  /// Of the last call; empty where the device's queue has no clock, or there was nothing to do.
  std::optional<LightFrameTimes> times() const;

 private:
  friend class LightFrameShader;
  struct State;
  std::unique_ptr<State> state_;
};

/// A light of a frame.
struct PlacedLight {
  LocalLight light;                        ///< as it shines, at its centre
  std::span<const LatticeCorners> points;  ///< corners_of its points
};

/// A whole frame without a round trip: lights go up, their visibility and direct light (light_by_visibility)
/// and the indirect light are found there, and the indirect light comes back.
class LightFrameShader {
 public:
  /// Uploads the samples, to which both shaders belong; these and the device outlive it. `softening` as for
  /// light_by_visibility(). Precondition: all three are of as many samples.
  LightFrameShader(VulkanDevice& device, LatticeVisibilityShader& visibility, LightTransferShader& transfer,
                   std::span<const SurfaceSample> samples, float softening = 0);
  ~LightFrameShader();
  LightFrameShader(LightFrameShader&&) noexcept;
  LightFrameShader& operator=(LightFrameShader&&) noexcept;

  /// The indirect irradiance that the lights cause and, where `direct` is not empty, the direct one as well.
  /// False, and nothing written, where the lattice serves no point of one of them. Preconditions: room for
  /// all samples; LATTICE_POINTS points a light at most.
  bool light(std::span<const PlacedLight> lights, LatticeShadow shadow, std::span<vec3> indirect,
             std::span<vec3> direct = {});

  /// Of the last call; empty where the device's queue has no clock, or there was nothing to do.
  std::optional<LightFrameTimes> times() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace coppice
