// Shadow rays from points to lights of the scene, and what arrives by them.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <coppice/relight/clusters.hpp>
#include <coppice/relight/light_kinds.hpp>
#include <coppice/relight/local_lighting.hpp>
#include <coppice/relight/shade.hpp>
#include <coppice/relight/visibility.hpp>
#include <coppice/scene/occluder.hpp>

namespace coppice {

/// What reaches a point from a leaf's light if nothing is between them.
struct LightAim {
  vec3 direction{0};   ///< unit
  float t_max = 0;     ///< a little before the light; +infinity for distant ones
  float arriving = 0;  ///< of the intensity, 1/m²; 0 where the light is below the horizon or shines away
};

inline LightAim aim_at(const LocalLighting& lighting, std::uint32_t leaf, const vec3& position,
                       const vec3& normal) {
  const LocalLightNode& node = lighting.frame().nodes[leaf];
  const LocalEmission& e = lighting.emissions()[leaf];
  const vec3 to_light = node.position - node.w * position;
  const float squared = dot(to_light, to_light), distance = std::sqrt(squared);
  if (!(squared > 0) || dot(to_light, normal) <= 0) return {};
  const vec3 d = to_light / distance;
  const float s = std::clamp(e.offset - dot(e.axis, d), 0.0f, 1.0f);
  return {d, node.w > 0 ? distance * (1 - 1e-4f) : std::numeric_limits<float>::infinity(),
          s * (1 - e.square + e.square * s) / (squared + e.softening)};
}

}  // namespace coppice

namespace coppice::inline HWY_NAMESPACE {

/// Shadow rays from one point, sixteen at a time, and the lights that they reach as clusters to be shaded.
/// Keeps its memory from point to point.
template <Occluder O>
class LightRays {
 public:
  LightRays(const LocalLighting& lighting, const O& occluder) : lighting_(lighting), occluder_(occluder) {}

  /// The rays that follow start here and reach `capacity` lights at most, in place of those before.
  void begin(const vec3& position, const vec3& normal, std::size_t capacity) {
    position_ = position, normal_ = normal;
    std::fill_n(packet_.origin_x, 16, position.x);
    std::fill_n(packet_.origin_y, 16, position.y);
    std::fill_n(packet_.origin_z, 16, position.z);
    reached_.reset(capacity);
    count_ = 0, traced_ = 0;
  }

  /// A ray to the light of a leaf (heap id), which counts `weight` times. None where the light adds nothing.
  void add(std::uint32_t leaf, float weight) {
    const LightAim aim = aim_at(lighting_, leaf, position_, normal_);
    if (!(aim.arriving > 0)) return;
    packet_.direction_x[count_] = aim.direction.x;
    packet_.direction_y[count_] = aim.direction.y;
    packet_.direction_z[count_] = aim.direction.z;
    packet_.t_max[count_] = aim.t_max;
    rays_[count_] = {leaf, weight * aim.arriving};
    if (++count_ == 16) trace();
  }

  /// The lights that the rays have reached, ready to be shaded: visibility is the share that arrives times
  /// the weight.
  const ClusterList& end() {
    if (count_ > 0) trace();
    reached_.pad();
    return reached_;
  }
  /// Since begin().
  std::size_t traced() const { return traced_; }

 private:
  struct Ray {
    std::uint32_t leaf;
    float arriving;
  };

  void trace() {
    const std::uint32_t lanes = (1u << count_) - 1, free = lanes & ~occluder_.occluded(packet_, lanes);
    for (std::uint32_t bits = free; bits != 0; bits &= bits - 1) {
      const Ray& ray = rays_[std::size_t(std::countr_zero(bits))];
      reached_.push(ray.leaf, lighting_.frame().nodes[ray.leaf], ray.arriving);
    }
    traced_ += count_;
    count_ = 0;
  }

  const LocalLighting& lighting_;
  const O& occluder_;
  vec3 position_{0}, normal_{0};
  ShadowPacket packet_{};
  std::array<Ray, 16> rays_;
  std::uint32_t count_ = 0;
  std::size_t traced_ = 0;
  ClusterList reached_;
};

}  // namespace coppice::inline HWY_NAMESPACE
