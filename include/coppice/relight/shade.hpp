// Shading of points from merged clusters: Σ power · interpolated visibility · BRDF.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <coppice/shared/layout.h>

#include <algorithm>
#include <bit>
#include <coppice/brdf/with_brdf.hpp>
#include <coppice/relight/clusters.hpp>
#include <coppice/relight/light_kinds.hpp>
#include <coppice/relight/lobes.hpp>
#include <coppice/relight/node_queue.hpp>
#include <span>
#include <vector>

namespace coppice::inline HWY_NAMESPACE {

/// Rows that take a world direction to a point's local frame.
struct LocalFrame {
  vec3 tangent, bitangent, normal;
  explicit LocalFrame(const ShadingPoint& p)
      : tangent(p.tangent), bitangent(cross(p.normal, p.tangent)), normal(p.normal) {}

  static Lanes along(const vec3& axis, Lanes x, Lanes y, Lanes z) {
    return mul_add(Lanes(axis.x), x, mul_add(Lanes(axis.y), y, Lanes(axis.z) * z));
  }
};

/// Σ_k power_k · visibility_k · term_j, for the terms of one BRDF: nine sums, coloured once at the end.
class TermSums {
 public:
  template <int terms, class Terms>
  HWY_INLINE void add(const Terms& t, Lanes visibility, Lanes red, Lanes green, Lanes blue) {
    const Lanes term[3] = {t.diffuse, t.specular, t.fresnel};
    for (int j = 0; j < terms; ++j) {
      const Lanes seen = term[j] * visibility;
      sums_[j][0] = mul_add(red, seen, sums_[j][0]);
      sums_[j][1] = mul_add(green, seen, sums_[j][1]);
      sums_[j][2] = mul_add(blue, seen, sums_[j][2]);
    }
  }

  vec3 colour(const ShadingPoint& p) const {
    const auto sum = [this](int j) {
      return vec3(sum_of_lanes(sums_[j][0]), sum_of_lanes(sums_[j][1]), sum_of_lanes(sums_[j][2]));
    };
    return p.diffuse * sum(0) + p.specular * sum(1) + p.fresnel * sum(2);
  }

 private:
  Lanes sums_[3][3] = {{0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f}};
};

/// Radiance of a point, and how many clusters it took.
struct ShadedPoint {
  vec3 radiance{0};
  std::uint32_t clusters = 0;
};

/// One point on its way through the clusters of its face, with its BRDF as a type.
template <Brdf B, class Lights>
class PointShader {
 public:
  using Node = typename Lights::Node;

  /// `scale` turns the clusters' units of visibility into [0, 1].
  PointShader(const ShadingPoint& point, const B& brdf, float scale, const Lights& lights)
      : point_(point),
        brdf_(brdf),
        lights_(lights),
        frame_(point),
        weights_{Lanes(point.weight_0 * scale), Lanes(point.weight_1 * scale),
                 Lanes((1 - point.weight_0 - point.weight_1) * scale)},
        luminance_{luminance(point.diffuse), luminance(point.specular), luminance(point.fresnel)} {}

  /// Cuts Eq. 5: the BRDF at each cluster's mean direction.
  vec3 sampled(const ClusterList& clusters) {
    for_each_register(clusters, [&](std::size_t i, const Incoming& d, const Light& light) {
      sums_.template add<B::terms>(brdf_(d.x, d.y, d.z), visibility(clusters, i), light.red, light.green,
                                   light.blue);
    });
    return sums_.colour(point_);
  }

  /// The BRDF's mean over each cluster.
  vec3 filtered(const ClusterList& clusters) {
    for_each_register(clusters, [&](std::size_t i, const Incoming& d, const Light& light) {
      sums_.template add<B::terms>(brdf_.filtered(d.x, d.y, d.z, d.spread), visibility(clusters, i),
                                   light.red, light.green, light.blue);
    });
    return sums_.colour(point_);
  }

  /// The same, and each cluster over which the lobe changes by more than a share of the whole is replaced by
  /// its descendants. `tree` are the nodes of the frame, by heap id.
  HWY_INLINE ShadedPoint refined(const ClusterList& clusters, std::span<const Node> tree, float tolerance,
                                 RefinementScratchOf<Node>& scratch) {
    scratch.reset(clusters.padded_size());
    const float limit = tolerance * estimate(clusters, scratch);
    sum_fine(clusters, tree, limit, scratch);
    for (std::size_t i = 0; i < scratch.queue.size();) i += evaluate(tree, limit, i, scratch.queue);
    return {sums_.colour(point_), std::uint32_t(clusters.size() + scratch.queue.size())};
  }

 private:
  struct Light {
    Lanes red, green, blue;
  };

  template <class Visit>
  HWY_INLINE void for_each_register(const ClusterList& clusters, Visit&& visit) {
    const auto load = [&](ClusterList::Field f, std::size_t i) { return Lanes::load(clusters.field(f) + i); };
    for (std::size_t i = 0; i < clusters.padded_size(); i += Lanes::width)
      visit(i,
            incoming(load(ClusterList::x, i), load(ClusterList::y, i), load(ClusterList::z, i),
                     load(ClusterList::mean_length, i), load(ClusterList::widening, i)),
            Light{load(ClusterList::red, i), load(ClusterList::green, i), load(ClusterList::blue, i)});
  }

  /// Directions in the point's frame. The last two are what Lights keeps of a cluster.
  HWY_INLINE Incoming incoming(Lanes x, Lanes y, Lanes z, Lanes first, Lanes second) const {
    const Incoming world = lights_.incoming(x, y, z, first, second);
    return {LocalFrame::along(frame_.tangent, world.x, world.y, world.z),
            LocalFrame::along(frame_.bitangent, world.x, world.y, world.z),
            LocalFrame::along(frame_.normal, world.x, world.y, world.z), world.spread};
  }

  HWY_INLINE Lanes visibility(const ClusterList& clusters, std::size_t i) const {
    const auto load = [&](ClusterList::Field f) { return Lanes::load(clusters.field(f) + i); };
    return mul_add(
        weights_[0], load(ClusterList::visible_0),
        mul_add(weights_[1], load(ClusterList::visible_1), weights_[2] * load(ClusterList::visible_2)));
  }

  /// What a cluster adds to the point's luminance, and how much of that depends on which of its lights it
  /// comes from: its specular part times the growth of the lobe.
  struct Estimate {
    Lanes luminance, error;
  };
  HWY_INLINE Estimate estimate(const FilteredTerms<Lanes>& t, const Light& light, Lanes visible) const {
    const Lanes specular = mul_add(luminance_[1], t.specular, luminance_[2] * t.fresnel);
    const Lanes power =
        visible * mul_add(0.2126f, light.red, mul_add(0.7152f, light.green, Lanes(0.0722f) * light.blue));
    return {power * mul_add(luminance_[0], t.diffuse, specular), power * specular * t.growth};
  }

  /// Evaluates the clusters of the face into the scratch. Returns the luminance of their sum.
  HWY_INLINE float estimate(const ClusterList& clusters, RefinementScratchOf<Node>& scratch) {
    Lanes total = 0.0f;
    for_each_register(clusters, [&](std::size_t i, const Incoming& d, const Light& light) {
      const FilteredTerms<Lanes> t = brdf_.filtered(d.x, d.y, d.z, d.spread);
      const Lanes visible = visibility(clusters, i);
      const Estimate e = estimate(t, light, visible);
      total += e.luminance;
      scratch.store(i, {t.diffuse, t.specular, t.fresnel, visible, e.error});
    });
    return sum_of_lanes(total);
  }

  /// Sums the clusters whose error is within the limit, and queues what is below the others.
  HWY_INLINE void sum_fine(const ClusterList& clusters, std::span<const Node> tree, float limit,
                           RefinementScratchOf<Node>& scratch) {
    const auto load = [&](ClusterList::Field f, std::size_t i) { return Lanes::load(clusters.field(f) + i); };
    for (std::size_t i = 0; i < clusters.padded_size(); i += Lanes::width) {
      const EvaluatedLanes e = scratch.load(i);
      const LaneMask is_coarse = e.error > limit;
      sums_.template add<B::terms>(e, select(is_coarse, 0.0f, e.visible), load(ClusterList::red, i),
                                   load(ClusterList::green, i), load(ClusterList::blue, i));
      for (std::uint64_t coarse = bits_of(is_coarse); coarse != 0; coarse &= coarse - 1) {
        const std::size_t k = i + std::size_t(std::countr_zero(coarse));
        split(tree, clusters.nodes()[k], scratch.visibility(k), scratch.queue);
      }
    }
  }

  /// Queues the grandchildren of a node, or its children where it has no others: of the two steps down, the
  /// first is seldom enough, and four nodes side by side cost little more than two.
  static HWY_INLINE void split(std::span<const Node> tree, std::uint32_t node, float visible,
                               NodeQueue<Node>& queue) {
    if (node < tree.size() / 4) return queue.template push<4>(tree.data(), 4 * node, visible);
    queue.template push<2>(tree.data(), 2 * node, visible);
  }

  /// A register of the queue from element i on: sums what is fine enough, queues what is below the rest.
  /// Returns how many elements it took.
  HWY_INLINE std::size_t evaluate(std::span<const Node> tree, float limit, std::size_t i,
                                  NodeQueue<Node>& queue) {
    const std::size_t count = std::min(Lanes::width, queue.size() - i);
    const NodeLanes n = load_nodes(queue.nodes() + i);
    const Light light{n.red, n.green, n.blue};
    const LightSpread<Lanes> kept = Lights::kept(n);
    const Incoming d = incoming(n.x, n.y, n.z, kept.mean_length, kept.widening);
    const FilteredTerms<Lanes> t = brdf_.filtered(d.x, d.y, d.z, d.spread);
    const Lanes visible = select(first_lanes(count), Lanes::load(queue.visibility() + i), 0.0f);
    const LaneMask is_coarse = estimate(t, light, visible).error > limit;
    sums_.template add<B::terms>(t, select(is_coarse, 0.0f, visible), light.red, light.green, light.blue);
    for (std::uint64_t coarse = bits_of(is_coarse); coarse != 0; coarse &= coarse - 1) {
      const auto k = std::size_t(std::countr_zero(coarse));
      split(tree, queue.id(i + k), queue.visibility()[i + k], queue);
    }
    return count;
  }

  const ShadingPoint& point_;
  B brdf_;  // a copy: what is in it stays in registers, whatever the loops write
  Lights lights_;
  LocalFrame frame_;
  Lanes weights_[3];
  Lanes luminance_[3];  // of the coefficients of the terms
  TermSums sums_;
};

/// Radiance of one point from the clusters of its face; the visibility is the barycentric mean of the three
/// receivers'. `scale` turns the clusters' units of visibility into [0, 1]. `tree`, by heap id, is that of
/// which the clusters were merged: refinement descends in them.
template <class Lights>
ShadedPoint shade_point(const ShadingPoint& point, const ClusterList& clusters, float scale,
                        const LobeOptions& options, std::span<const typename Lights::Node> tree,
                        RefinementScratchOf<typename Lights::Node>& scratch, const Lights& lights) {
  return with_brdf(point, [&](const auto& brdf) {
    using B = std::decay_t<decltype(brdf)>;
    PointShader<B, Lights> shader(point, brdf, scale, lights);
    const auto count = std::uint32_t(clusters.size());
    if (options.lobes == Lobes::sampled) return ShadedPoint{shader.sampled(clusters), count};
    if (options.lobes == Lobes::filtered || B::terms == 1)
      return ShadedPoint{shader.filtered(clusters), count};
    return shader.refined(clusters, tree, options.tolerance, scratch);
  });
}

/// The same for distant lights.
inline ShadedPoint shade_point(const ShadingPoint& point, const ClusterList& clusters, float scale,
                               const LobeOptions& options, std::span<const LightNode> tree,
                               RefinementScratch& scratch) {
  return shade_point(point, clusters, scale, options, tree, scratch, DistantLights(vec3(0)));
}

}  // namespace coppice::inline HWY_NAMESPACE
