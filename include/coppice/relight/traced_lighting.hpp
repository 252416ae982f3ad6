// Lights in the scene without precomputation: a cut for each point, and a shadow ray to each of its clusters.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <coppice/core/parallel.hpp>
#include <coppice/core/random.hpp>
#include <coppice/relight/light_rays.hpp>
#include <coppice/relight/local_lighting.hpp>
#include <coppice/relight/node_bounds.hpp>
#include <coppice/relight/shade.hpp>
#include <coppice/relight/shading_buffer.hpp>
#include <coppice/scene/occluder.hpp>

namespace coppice {

struct TracedOptions {
  /// A cluster is split while it could add more than this share of the point's radiance, both as luminance;
  /// lights that add less than a quarter of it share their rays. 0: a ray to every light.
  float tolerance = 0.05f;
  std::uint64_t seed = 0;  ///< of the choice of representatives
};

}  // namespace coppice

namespace coppice::inline HWY_NAMESPACE {

/// Shades points by a cut of the tree each, refined while a cluster could add more than the tolerance allows
/// (Lightcuts, Walter et al. 2005). The lights of the clusters are candidates, of large clusters those of a
/// block drawn by luminance; candidates that add much without shadows get a ray each, the others share rays.
/// The mean over all draws is the sum over all lights: what steers the cut are rays of its own. Keeps its
/// scratch between points.
template <Occluder O>
class TracedShader {
 public:
  TracedShader(const LocalLighting& lighting, const O& occluder, const TracedOptions& options)
      : lighting_(lighting), options_(options), light_rays_(lighting, occluder) {
    for_each_piece(lighting_.frame().ends, [&](LeafRange r, std::size_t) {
      illumination_.push(lighting_, node_of_range(leaf_count(), r.begin, r.end), 1, 0);
    });
  }

  /// `index` tells the draws of one point from those of others. Adds the rays it traced to `rays`.
  vec3 shade(const ShadingPoint& point, const vec3& position, std::uint64_t index, std::size_t& rays) {
    if (is_black(point)) return vec3(0);
    seed_ = options_.seed ^ (index * 0x9e3779b97f4a7c15u);
    return with_brdf(point, [&](const auto& brdf) {
      using B = std::decay_t<decltype(brdf)>;
      const NodeBounds<B> bounds(lighting_, point, position, brdf);
      const float unshadowed = evaluate(bounds, illumination_);
      const float seen = seen_share(unshadowed, position, point.normal, rays);
      descend(bounds, options_.tolerance * unshadowed * seen);
      // By the square root of what is seen images have the least relative error for their rays.
      const float step = 0.25f * options_.tolerance * unshadowed * std::sqrt(seen);
      draw_blocks(step);
      evaluate(bounds, candidates_);
      const ClusterList& reached = trace(step, position, point.normal, rays);
      return PointShader<B, LocalLights>(point, brdf, 1, LocalLights(position)).sampled(reached);
    });
  }

 private:
  static constexpr std::uint32_t pilot_rays = 8, large_block = 16, small_block = 2;

  struct Chosen {
    std::uint32_t node;
    float bound;
  };
  struct Descendant {
    std::uint32_t node;
    float weight;  ///< one over its probability
  };

  static bool is_black(const ShadingPoint& point) {
    return point.diffuse == vec3(0) && point.specular == vec3(0) && point.fresnel == vec3(0);
  }

  std::uint32_t leaf_count() const { return lighting_.tree().leaf_count(); }
  Random random_of(std::uint64_t stream) const { return Random(seed_ ^ (stream << 40)); }

  /// Estimates of all nodes, by index. Returns their sum.
  template <class Bounds>
  float evaluate(const Bounds& bounds, const LocalNodeList& nodes) {
    estimates_.resize(nodes.size() + Lanes::width);
    Lanes sum = 0.0f;
    for (std::size_t i = 0; i < nodes.size(); i += Lanes::width) {
      const std::size_t count = std::min(Lanes::width, nodes.size() - i);
      const Lanes e = select(first_lanes(count), bounds.estimate(nodes.load(i, count, leaf_count())), 0.0f);
      e.store(&estimates_[i]);
      sum += e;
    }
    return sum_of_lanes(sum);
  }

  /// How much of the light arrives, no less than 1/8, by a few rays to lights below the illumination cut.
  /// Without rays where every light gets its own anyway.
  float seen_share(float unshadowed, const vec3& position, const vec3& normal, std::size_t& rays) {
    constexpr float least = 1.0f / float(pilot_rays);
    if (options_.tolerance * float(leaf_count()) < 1) return least;
    Random random = random_of(leaf_count() * 2ull);
    const float step = unshadowed * least;
    float next = random.uniform() * step;
    light_rays_.begin(position, normal, pilot_rays + 1);
    for (std::size_t i = 0; i < illumination_.size() && step > 0; ++i)
      for (next -= estimates_[i]; next < 0; next += step)
        light_rays_.add(draw_below(illumination_.id(i), 1, random).node, 1);
    const std::size_t seen = light_rays_.end().size();
    rays += light_rays_.traced();
    return std::clamp(float(seen) * least, least, 1.0f);
  }

  /// Chooses clusters from the root on, a register at a time from the end of the open nodes: those whose
  /// bounds are above the limit give way to their children.
  template <class Bounds>
  void descend(const Bounds& bounds, float limit) {
    chosen_.clear();
    open_.clear();
    open_.push(lighting_, 1, 1, 0);
    while (open_.size() > 0) {
      const std::size_t count = std::min(Lanes::width, open_.size()), begin = open_.size() - count;
      const LocalNodeLanes nodes = open_.load(begin, count, leaf_count());
      const Lanes bound = bounds.bound(nodes);
      close(begin, count, bound, bits_of((bound > limit) & !nodes.is_leaf));
    }
  }

  void close(std::size_t begin, std::size_t count, Lanes bound, std::uint64_t coarse) {
    std::array<std::uint32_t, Lanes::width> ids;
    std::array<float, Lanes::width> bounds;
    bound.store(bounds.data());
    for (std::size_t k = 0; k < count; ++k) ids[k] = open_.id(begin + k);
    open_.shrink(begin);
    for (std::size_t k = 0; k < count; ++k)
      if (coarse >> k & 1)
        open_.push(lighting_, 2 * ids[k], 2, 0);
      else if (bounds[k] > 0)
        chosen_.push_back({ids[k], bounds[k]});
  }

  /// The leaves of a block below each cluster, with how many times they count. Of clusters that cannot add
  /// what a ray stands for, few are enough.
  void draw_blocks(float step) {
    candidates_.clear();
    for (const Chosen& c : chosen_) {
      Random random = random_of(c.node);
      const Descendant block = draw_below(c.node, c.bound < step ? small_block : large_block, random);
      const LeafRange leaves = leaves_below(leaf_count(), block.node);
      candidates_.push(lighting_, leaf_count() + leaves.begin, leaves.size(), block.weight);
    }
  }

  /// A node of at most so many leaves, drawn in proportion to luminance.
  Descendant draw_below(std::uint32_t h, std::uint32_t most_leaves, Random& random) const {
    double u = double(random.bits() >> 11) * 0x1p-53;
    float weight = 1;
    while (leaves_below(leaf_count(), h).size() > most_leaves) {
      const float left = lighting_.emissions()[2 * h].luminance,
                  right = lighting_.emissions()[2 * h + 1].luminance;
      const float share = left / (left + right);
      const bool is_left = u < share || !(right > 0);
      u = is_left ? u / share : (u - share) / (1 - share);
      weight /= is_left ? share : 1 - share;
      h = 2 * h + !is_left;
    }
    return {h, weight};
  }

  /// A ray for each candidate that adds at least `step`, and one for every `step` that the others add up to.
  const ClusterList& trace(float step, const vec3& position, const vec3& normal, std::size_t& rays) {
    light_rays_.begin(position, normal, candidates_.size());
    float next = random_of(0).uniform() * step;
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      const float weight = candidates_.value(i), added = weight * estimates_[i];
      if (!(added > 0)) continue;
      if (added >= step) {
        light_rays_.add(candidates_.id(i), weight);
      } else if ((next -= added) < 0) {
        next += step;
        light_rays_.add(candidates_.id(i), weight * (step / added));
      }
    }
    const ClusterList& reached = light_rays_.end();
    rays += light_rays_.traced();
    return reached;
  }

  const LocalLighting& lighting_;
  TracedOptions options_;
  std::uint64_t seed_ = 0;
  LocalNodeList illumination_, open_, candidates_;
  std::vector<Chosen> chosen_;
  std::vector<float> estimates_;
  LightRays<O> light_rays_;
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
