// The visibility of cones by rays: what a march through voxels approximates.
#pragma once

#include <coppice/shared/cones.h>

#include <array>
#include <bit>
#include <coppice/core/config.hpp>
#include <coppice/core/parallel.hpp>
#include <coppice/core/random.hpp>
#include <coppice/scene/occluder.hpp>
#include <limits>
#include <span>

namespace coppice {

/// The direction of a Gaussian's distribution at u in [0, 1), the share of the integral that is nearer to the
/// axis, and at an angle about it. x, y and the axis are an orthonormal frame. Error: some 2e-7.
inline vec3 sg_sample(const SgShape& shape, const vec3& x, const vec3& y, float u, float angle) {
  const float decay = -std::expm1(-2 * shape.sharpness);
  const float drop =
      shape.sharpness > 1e-4f ? std::fmin(-std::log1p(-u * decay) / shape.sharpness, 2.0f) : 2 * u;
  const float across = std::sqrt(drop * (2 - drop));
  return (1 - drop) * shape.axis + across * (std::cos(angle) * x + std::sin(angle) * y);
}

/// Traces shadow rays for cones, the same number for each, spread evenly over the integral of its Gaussian.
template <Occluder O>
class RayCones {
 public:
  /// Precondition: rays > 0. Error: that of stratified sampling, some 0.33/√rays where half a cone is hidden.
  explicit RayCones(const O& occluder, std::uint32_t rays = 16, std::uint64_t seed = 0)
      : occluder_(occluder), rays_(rays), seed_(seed) {
    COPPICE_ASSERT(rays > 0);
  }

  /// visibility[cone], in [0, 1]; 0 where nothing of a cone is above the horizon. The same for any executor.
  template <Executor E>
  void trace(std::span<const ConeReceiver> receivers, std::span<const SgShape> cones,
             std::span<float> visibility, const E& executor) const {
    executor(receivers.size(), 64, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const std::uint32_t first = i > 0 ? receivers[i - 1].cones_end : 0;
        for (std::uint32_t c = first; c < receivers[i].cones_end; ++c)
          visibility[c] = visibility_of(receivers[i], cones[c], c - first);
      }
    });
  }

 private:
  float visibility_of(const ConeReceiver& receiver, const SgShape& cone, std::uint32_t number) const {
    Random random(seed_ ^ (receiver.index * 0x9e3779b97f4a7c15u) ^ (std::uint64_t(number) << 32));
    vec3 x, y;
    make_frame(cone.axis, x, y);
    const float turn = random.uniform(), start = random.uniform();
    std::uint32_t above = 0, seen = 0;
    for (std::uint32_t first = 0; first < rays_; first += 16) {
      ShadowPacket packet;
      std::uint32_t open = 0;
      for (std::uint32_t k = 0; k < std::min(16u, rays_ - first); ++k) {
        const float u = (float(first + k) + start) / float(rays_);
        const vec3 d = sg_sample(cone, x, y, u, 2 * pi * (turn + 0.618034f * float(first + k)));
        if (!(dot(d, receiver.shading_normal) > 0)) continue;
        ++above;
        if (dot(d, receiver.normal) > 0) open |= set(packet, k, receiver.position, d);
      }
      if (open != 0) seen += std::uint32_t(std::popcount(open & ~occluder_.occluded(packet, open)));
    }
    return above > 0 ? float(seen) / float(above) : 0.0f;
  }

  static std::uint32_t set(ShadowPacket& p, std::uint32_t k, const vec3& origin, const vec3& d) {
    p.origin_x[k] = origin.x, p.origin_y[k] = origin.y, p.origin_z[k] = origin.z;
    p.direction_x[k] = d.x, p.direction_y[k] = d.y, p.direction_z[k] = d.z;
    p.t_max[k] = std::numeric_limits<float>::infinity();
    return 1u << k;
  }

  const O& occluder_;
  std::uint32_t rays_;
  std::uint64_t seed_;
};

}  // namespace coppice
