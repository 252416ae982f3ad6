// The two kinds of lights that clusters hold, as the kernels see them: far away, or in the scene.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <coppice/shared/brdf_filtered.h>
#include <coppice/shared/layout.h>

#include <coppice/relight/frame_lighting.hpp>
#include <coppice/relight/node_lanes.hpp>

namespace coppice::inline HWY_NAMESPACE {

/// The unit direction to a register of clusters, and how their lights spread about it.
struct Incoming {
  Lanes x, y, z;
  LightSpread<Lanes> spread;
};

/// Distant lights: the same directions for all points. Of a cluster are kept its mean direction and the two
/// numbers of its LightSpread.
struct DistantLights {
  using Node = LightNode;

  explicit DistantLights(const vec3&) {}

  static HWY_INLINE LightSpread<Lanes> kept(const NodeLanes& n) { return light_spread(n.spread); }

  HWY_INLINE Incoming incoming(Lanes x, Lanes y, Lanes z, Lanes mean_length, Lanes widening) const {
    return {x, y, z, {mean_length, widening}};
  }
};

/// Lights in the scene, from a point. Of a cluster are kept its mean position, w and variance. The spread is
/// that of positions with equal variance along all axes: 1 - |mean direction| = variance / (3 distance²) to
/// first order.
struct LocalLights {
  using Node = LocalLightNode;

  vec3 point;

  explicit LocalLights(const vec3& at) : point(at) {}

  static HWY_INLINE LightSpread<Lanes> kept(const NodeLanes& n) { return {n.solid_angle, n.spread}; }

  HWY_INLINE Incoming incoming(Lanes x, Lanes y, Lanes z, Lanes w, Lanes variance) const {
    const Lanes dx = x - w * point.x, dy = y - w * point.y, dz = z - w * point.z;
    const Lanes squared = max(mul_add(dx, dx, mul_add(dy, dy, dz * dz)), 1e-30f),
                scale = 1.0f / sqrt(squared);
    return {dx * scale, dy * scale, dz * scale, light_spread(min(variance / (3.0f * squared), 0.99f))};
  }
};

}  // namespace coppice::inline HWY_NAMESPACE
