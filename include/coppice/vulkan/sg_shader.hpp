// Relighting with spherical Gaussians on a Vulkan device: environments fitted, cones traced, and the light
// under products of Gaussians.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <coppice/shared/sg_kernels.h>

#include <coppice/sg/environment_fit.hpp>
#include <coppice/voxel/contact_masks.hpp>
#include <coppice/vulkan/device.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace coppice {

/// Fits environments as an EnvironmentFitter does: texels are gathered, peaks found and energy kept on the
/// CPU; means and Jacobi passes run on the device, where the matrices stay. Relative RMS differences of the
/// amplitudes are below 2e-4 on lavapipe; docs/vulkan.md. Each call waits for the device, and throws
/// InputError where its buffers do not fit into the device's memory.
class SgFitShader {
 public:
  /// Device and fitter outlive it.
  /// Preconditions: nside is at most 73, grid_nside 400.
  SgFitShader(VulkanDevice& device, const EnvironmentFitter& fitter);
  ~SgFitShader();
  SgFitShader(SgFitShader&&) noexcept;
  SgFitShader& operator=(SgFitShader&&) noexcept;

  /// EnvironmentFitter::fit. The executor is for the texels. Precondition: the map has the fitter's size.
  template <Executor E = Serial>
  EnvironmentFit fit(const Environment& environment, const E& executor = {}) {
    return fitter_->fit_by(environment, executor,
                           [&](const auto& cells, const auto& peaks) { return solve(cells, peaks); });
  }

  /// Of the last fit's kernels on the device; empty where its queue has no clock.
  std::optional<double> milliseconds() const;

 private:
  std::vector<vec3> solve(std::span<const EnvironmentCell> cells, std::span<const SgLight> peaks);

  struct State;
  const EnvironmentFitter* fitter_;
  std::unique_ptr<State> state_;
};

/// Traces cones as a ConeTracer does: exact rays near the surface on the CPU, marches through the grid on the
/// device, an invocation a cone. Relative RMS differences of the visibilities are below 1e-6 on lavapipe.
/// Each call waits for the device, and throws InputError where its buffers do not fit into its memory.
class ConeShader {
 public:
  /// The device outlives it. `cones_per_piece`: cones that are uploaded and traced at once, 20 bytes each;
  /// those of one receiver stay together. Precondition: it is positive, and rays · steps <=
  /// SG_STEPS_PER_CONE.
  explicit ConeShader(VulkanDevice& device, const ConeTracerOptions& options = {},
                      std::size_t cones_per_piece = std::size_t(1) << 21);
  ~ConeShader();
  ConeShader(ConeShader&&) noexcept;
  ConeShader& operator=(ConeShader&&) noexcept;

  /// Uploads a grid, byte for byte, for the calls to come; until then it is empty. Again after each build()
  /// or update() of it. The grid outlives its use. Precondition: below 2^32 bytes of distances.
  void set_grid(const BrickGrid& grid);

  /// ConeTracer::trace. Preconditions: those, and at most 8 rays a cone where the options have a contact.
  /// `Contacts` tells sources that are compiled for different processors apart.
  template <Occluder O, Executor E, class Contacts = ContactMasks>
  void trace(const O& occluder, std::span<const ConeReceiver> receivers, std::span<const SgShape> cones,
             std::span<float> visibility, const E& executor) {
    std::vector<std::uint8_t> closed;
    if (options().contact > 0) {
      closed.resize(cones.size());
      Contacts(grid(), options()).find(occluder, receivers, cones, closed, executor);
    }
    march(receivers, cones, closed, visibility);
  }

  /// The same where it is known which rays end near the surface (ContactMasks): bit k of closed[cone] is set
  /// where ray k does; empty where none does. Marches start as far out as those of trace() in any case.
  void march(std::span<const ConeReceiver> receivers, std::span<const SgShape> cones,
             std::span<const std::uint8_t> closed, std::span<float> visibility);

  /// Of the last call's kernels on the device; empty where its queue has no clock, or it had no cones.
  std::optional<double> milliseconds() const;

 private:
  const ConeTracerOptions& options() const;
  const BrickGrid& grid() const;

  struct State;
  std::unique_ptr<State> state_;
};

/// The light under products of two Gaussians, the lobe of a BRDF and a cone: what
/// PreconvolvedEnvironment::mean looks up, from all lights and without a table. Relative RMS differences from
/// the closed forms on the CPU are below 1e-5 on lavapipe. Each call waits for the device, and throws
/// InputError where its buffers do not fit into its memory.
class SgProductShader {
 public:
  /// The device outlives it. `pairs_per_piece`: pairs that are uploaded and multiplied at once, 48 bytes
  /// each; at least 1.
  explicit SgProductShader(VulkanDevice& device, std::size_t pairs_per_piece = std::size_t(1) << 21);
  ~SgProductShader();
  SgProductShader(SgProductShader&&) noexcept;
  SgProductShader& operator=(SgProductShader&&) noexcept;

  /// Uploads the lights; until then there are none, and all means are 0.
  void set_lights(std::span<const SgLight> lights);

  /// By pair. Cost: one inner product a light, and a dispatch every SG_LIGHTS_PER_DISPATCH of them.
  /// Precondition: all sharpnesses are in the domain of shared/sg.h.
  std::vector<SgPairMean> means(std::span<const SgPair> pairs);

  /// Of the last call's kernels on the device; empty where its queue has no clock, or it had no pairs.
  std::optional<double> milliseconds() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// ∫ lobe · cone · light, summed over the lights.
inline vec3 sg_pair_light(const SgPair& pair, const SgPairMean& mean) {
  return mean.scale * sg_integral(sg_product(pair.lobe, pair.cone).sharpness) * mean.mean;
}

}  // namespace coppice
