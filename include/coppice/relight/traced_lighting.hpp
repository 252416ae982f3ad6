// Lights in the scene without precomputation: a cut for each point, and a shadow ray to each of its clusters.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <coppice/core/random.hpp>
#include <coppice/relight/local_lighting.hpp>
#include <coppice/relight/occluder.hpp>
#include <coppice/relight/shade.hpp>
#include <coppice/relight/shading_buffer.hpp>
#include <coppice/relight/visibility.hpp>

namespace coppice {

struct TracedOptions {
  /// A cluster is split while it could add more than this share of the point's radiance, both as luminance.
  float tolerance = 0.05f;
  std::uint64_t seed = 0;  ///< of the choice of representatives
};

}  // namespace coppice

namespace coppice::inline HWY_NAMESPACE {

/// What the nodes of local lights can add to one point, as luminance.
template <Brdf B>
class NodeBounds {
 public:
  NodeBounds(const LocalLighting& lighting, const ShadingPoint& point, const vec3& position, const B& brdf)
      : lighting_(lighting),
        point_(point),
        position_(position),
        brdf_(brdf),
        bitangent_(cross(point.normal, point.tangent)),
        luminance_{luminance(point.diffuse), luminance(point.specular), luminance(point.fresnel)} {}

  /// At the node's mean position.
  float estimate(std::uint32_t h) const {
    const Arrival a = arrival(h);
    const LocalEmission& e = lighting_.emissions()[h];
    const float geometry = emission(e, dot(e.axis, -a.direction) + e.offset) /
                           std::max(a.squared + lighting_.frame().nodes[h].variance + e.softening, 1e-30f);
    const float cosine = std::max(0.0f, dot(point_.normal, a.direction));
    return e.luminance * geometry * (luminance_[0] * cosine / pi + specular(a));
  }

  /// With the lights of the node as near, as high above the horizon and facing the point as much as a ball
  /// around them allows; of narrow lobes the mean over the node. Infinite inside the ball.
  float bound(std::uint32_t h) const {
    const Arrival a = arrival(h);
    const LocalEmission& e = lighting_.emissions()[h];
    const float distance = std::sqrt(a.squared), nearest = distance - e.radius;
    if (!(e.luminance > 0)) return 0;
    if (!(nearest > 0)) return std::numeric_limits<float>::infinity();
    const float sine = e.radius / distance, cosine = std::min(1.0f, dot(point_.normal, a.direction) + sine);
    if (cosine <= 0) return 0;
    const float turned = length(e.axis) * sine + std::max(0.0f, 1 - e.offset - length(e.axis));
    const float geometry =
        emission(e, dot(e.axis, -a.direction) + e.offset + turned) / (nearest * nearest + e.softening);
    return e.luminance * geometry * (luminance_[0] * cosine / pi + specular(a));
  }

 private:
  struct Arrival {
    vec3 direction;
    float squared, spread;
  };

  Arrival arrival(std::uint32_t h) const {
    const LocalLightNode& node = lighting_.frame().nodes[h];
    const vec3 to_light = node.position - node.w * position_;
    const float squared = dot(to_light, to_light);
    return {to_light / std::sqrt(std::max(squared, 1e-30f)), squared,
            std::min(0.99f, node.variance / std::max(3 * squared, 1e-30f))};
  }

  static float emission(const LocalEmission& e, float towards) {
    const float s = std::clamp(towards, 0.0f, 1.0f);
    return s * (1 - e.square + e.square * s);
  }

  float specular(const Arrival& a) const {
    if constexpr (B::terms == 1) return 0;
    const vec3 d = a.direction;
    const auto t = brdf_.filtered(dot(point_.tangent, d), dot(bitangent_, d), dot(point_.normal, d),
                                  light_spread(a.spread));
    return luminance_[1] * t.specular + luminance_[2] * t.fresnel;
  }

  const LocalLighting& lighting_;
  const ShadingPoint& point_;
  vec3 position_;
  const B& brdf_;
  vec3 bitangent_;
  float luminance_[3];
};

/// Shades points by a cut of the tree each, refined while a cluster could add more than the tolerance allows,
/// with one shadow ray a cluster, to a light drawn in proportion to luminance and with that light's value:
/// the mean over all draws is the sum over all lights (Lightcuts, Walter et al. 2005; unbiased, unlike rays
/// to a fixed representative). Keeps its scratch between points.
template <Occluder O>
class TracedShader {
 public:
  TracedShader(const LocalLighting& lighting, const O& occluder, const TracedOptions& options)
      : lighting_(lighting), occluder_(occluder), options_(options) {}

  /// `index` tells the draws of one point from those of others. Adds the rays it traced to `rays`.
  vec3 shade(const ShadingPoint& point, const vec3& position, std::uint64_t index, std::size_t& rays) {
    return with_brdf(point, [&](const auto& brdf) {
      using B = std::decay_t<decltype(brdf)>;
      const NodeBounds<B> bounds(lighting_, point, position, brdf);
      const float limit = options_.tolerance * estimate(bounds);
      chosen_.clear();
      descend(bounds, 1, limit);
      const vec3 first = trace(point, position, index, brdf, rays);
      const float finer =
          std::max(options_.tolerance * luminance(first), limit / 8);  // also where all is dark
      if (finer >= 0.5f * limit) return first;
      coarse_.swap(chosen_);
      chosen_.clear();
      for (const Chosen& c : coarse_)
        if (c.bound > finer)
          descend(bounds, c.node, finer);
        else
          chosen_.push_back(c);
      return trace(point, position, index, brdf, rays);
    });
  }

 private:
  struct Chosen {
    std::uint32_t node;
    float bound;
  };

  std::uint32_t leaf_count() const { return lighting_.tree().leaf_count(); }

  template <class Bounds>
  float estimate(const Bounds& bounds) const {
    float sum = 0;
    for_each_piece(lighting_.frame().ends, [&](LeafRange r, std::size_t) {
      sum += bounds.estimate(node_of_range(leaf_count(), r.begin, r.end));
    });
    return sum;
  }

  template <class Bounds>
  void descend(const Bounds& bounds, std::uint32_t start, float limit) {
    stack_.assign(1, start);
    while (!stack_.empty()) {
      const std::uint32_t h = stack_.back();
      stack_.pop_back();
      const float bound = bounds.bound(h);
      if (bound > limit && h < leaf_count()) {
        stack_.push_back(2 * h + 1);
        stack_.push_back(2 * h);
      } else if (bound > 0) {
        chosen_.push_back({h, bound});
      }
    }
  }

  /// A leaf below the node, drawn in proportion to luminance.
  std::uint32_t draw(std::uint32_t h, std::uint64_t index) const {
    Random random(options_.seed ^ (index * 0x9e3779b97f4a7c15u) ^ (std::uint64_t(h) << 40));
    float u = random.uniform();
    while (h < leaf_count()) {
      const float left = lighting_.emissions()[2 * h].luminance,
                  right = lighting_.emissions()[2 * h + 1].luminance;
      const float share = left / (left + right);
      const bool is_left = u < share;
      u = is_left ? u / share : (u - share) / (1 - share);
      h = 2 * h + !is_left;
    }
    return h;
  }

  template <class B>
  vec3 trace(const ShadingPoint& point, const vec3& position, std::uint64_t index, const B& brdf,
             std::size_t& rays) {
    clusters_.reset(chosen_.size());
    ShadowPacket packet = packet_from(position);
    std::uint32_t count = 0;
    std::array<float, 16> geometry;
    std::array<std::uint32_t, 16> leaves, nodes;
    const auto flush = [&] {
      const std::uint32_t lanes = (1u << count) - 1, seen = lanes & ~occluder_.occluded(packet, lanes);
      rays += count;
      for (std::uint32_t i = 0; i < count; ++i)
        if (seen >> i & 1) push(nodes[i], leaves[i], geometry[i]);
      count = 0;
    };
    for (const Chosen& c : chosen_) {
      const std::uint32_t leaf = draw(c.node, index);
      const float g = aim(leaf, point, position, packet, count);
      if (!(g > 0)) continue;
      geometry[count] = g, leaves[count] = leaf, nodes[count] = c.node;
      if (++count == 16) flush();
    }
    if (count > 0) flush();
    clusters_.pad();
    return PointShader<B, LocalLights>(point, brdf, 1, LocalLights(position)).sampled(clusters_);
  }

  /// Aims a lane at a leaf's light. Returns what arrives of its intensity, 0 where it is below the horizon or
  /// shines away.
  float aim(std::uint32_t leaf, const ShadingPoint& point, const vec3& position, ShadowPacket& packet,
            std::uint32_t lane) const {
    const LocalLightNode& node = lighting_.frame().nodes[leaf];
    const LocalEmission& e = lighting_.emissions()[leaf];
    const vec3 to_light = node.position - node.w * position;
    const float squared = dot(to_light, to_light), distance = std::sqrt(squared);
    if (!(squared > 0) || dot(to_light, point.normal) <= 0) return 0;
    const vec3 d = to_light / distance;
    packet.direction_x[lane] = d.x, packet.direction_y[lane] = d.y, packet.direction_z[lane] = d.z;
    packet.t_max[lane] = node.w > 0 ? distance * (1 - 1e-4f) : std::numeric_limits<float>::infinity();
    const float s = std::clamp(e.offset - dot(e.axis, d), 0.0f, 1.0f);
    return s * (1 - e.square + e.square * s) / (squared + e.softening);
  }

  void push(std::uint32_t h, std::uint32_t leaf, float geometry) {
    const LocalLightNode& light = lighting_.frame().nodes[leaf];
    const float share = lighting_.emissions()[h].luminance / lighting_.emissions()[leaf].luminance;
    clusters_.push(h, light, share * geometry);
  }

  const LocalLighting& lighting_;
  const O& occluder_;
  TracedOptions options_;
  std::vector<Chosen> chosen_, coarse_;
  std::vector<std::uint32_t> stack_;
  ClusterList clusters_;
};

/// Shades all points of a buffer. `rays`, where not empty, receives the shadow rays of each point. Any split
/// over threads gives the same bits.
template <Occluder O, Executor E>
std::vector<vec3> shade_traced(const ShadingBuffer& buffer, const LocalLighting& lighting, const O& occluder,
                               const TracedOptions& options, const E& executor,
                               std::span<std::uint32_t> rays = {}) {
  std::vector<vec3> radiance(buffer.points.size());
  if (lighting.frame().ends.empty()) return radiance;
  executor(buffer.points.size(), 256, [&](std::size_t begin, std::size_t end) {
    TracedShader<O> shader(lighting, occluder, options);
    for (std::size_t p = begin; p < end; ++p) {
      std::size_t traced = 0;
      radiance[p] = shader.shade(buffer.points[p], buffer.positions[p], p, traced);
      if (!rays.empty()) rays[p] = std::uint32_t(traced);
    }
  });
  return radiance;
}

}  // namespace coppice::inline HWY_NAMESPACE
