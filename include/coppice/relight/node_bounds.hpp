// What nodes of local lights can add to a point.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <array>
#include <coppice/relight/local_node_list.hpp>
#include <coppice/relight/shade.hpp>
#include <limits>

namespace coppice::inline HWY_NAMESPACE {

/// What the nodes of local lights add to one point, as luminance, where nothing is in between.
template <Brdf B>
class NodeBounds {
 public:
  NodeBounds(const LocalLighting& lighting, const ShadingPoint& point, const vec3& position, const B& brdf)
      : lighting_(lighting),
        position_(position),
        brdf_(brdf),
        frame_(point),
        far_(length(position)),
        luminance_{luminance(point.diffuse), luminance(point.specular), luminance(point.fresnel)} {}

  /// As if all lights were at the node's mean position; narrow lobes are widened by the lights' spread. Of
  /// one light exact, and 0 only where it adds nothing.
  Lanes estimate(const LocalNodeLanes& n) const {
    const Arrival a = arrival(n);
    const Lanes geometry =
        emission(n, n.offset - towards(n, a)) / max(a.squared + n.variance + n.softening, 1e-30f);
    const Lanes reflected = mul_add(luminance_[0] / pi, max(a.z, 0.0f), specular(a, n));
    return select(a.z > 0.0f, min(n.luminance * geometry * reflected, 1e30f), 0.0f);
  }

  /// At least what the node adds where the point is Lambertian, as the luminance of its light times that of
  /// the reflectance; narrow lobes count with their mean over the node. All lights are taken to be as near
  /// and as high above the horizon as the ball around them allows. Infinite inside the ball; 0 only where no
  /// light of the node can add anything.
  Lanes bound(const LocalNodeLanes& n) const {
    const Arrival a = arrival(n);
    const Lanes distance = sqrt(a.squared), ball = radius(n), nearest = distance - ball;
    const Lanes sine = min(ball / distance, 1.0f), across = sqrt(1.0f - sine * sine);
    const Lanes cosine = nearer(a.z, sine, across), emitted = most_emitted(n, a, across);
    const Lanes geometry = emitted / mul_add(nearest, nearest, select(n.is_leaf, n.softening, 0.0f));
    const Lanes reflected = mul_add(luminance_[0] / pi, cosine, specular(raised(a, sine, cosine), n));
    const Lanes most = max(n.luminance * geometry * reflected, std::numeric_limits<float>::min());
    const LaneMask reaches = (cosine > 0.0f) & (emitted > 0.0f), is_outside = nearest > 0.0f;
    const Lanes bound = select(is_outside, select(reaches, most, 0.0f), infinity);
    return select(n.luminance > 0.0f, bound, 0.0f);
  }

  float estimate(std::uint32_t h) const { return first_lane(estimate(node(h))); }
  float bound(std::uint32_t h) const { return first_lane(bound(node(h))); }

 private:
  static constexpr float infinity = std::numeric_limits<float>::infinity();

  /// Unit directions to the nodes: in the world, and in the point's frame.
  struct Arrival {
    Lanes world_x, world_y, world_z, x, y, z, squared;
  };

  Arrival arrival(const LocalNodeLanes& n) const {
    const Lanes x = n.x - n.w * position_.x, y = n.y - n.w * position_.y, z = n.z - n.w * position_.z;
    const Lanes squared = max(mul_add(x, x, mul_add(y, y, z * z)), 1e-30f), scale = 1.0f / sqrt(squared);
    const Lanes dx = x * scale, dy = y * scale, dz = z * scale;
    return {dx,
            dy,
            dz,
            LocalFrame::along(frame_.tangent, dx, dy, dz),
            LocalFrame::along(frame_.bitangent, dx, dy, dz),
            LocalFrame::along(frame_.normal, dx, dy, dz),
            squared};
  }

  /// The same node in all lanes.
  LocalNodeLanes node(std::uint32_t h) const {
    std::array<LocalLightNode, Lanes::width> nodes;
    std::array<LocalEmission, Lanes::width> emissions;
    nodes.fill(lighting_.frame().nodes[h]), emissions.fill(lighting_.emissions()[h]);
    return load_local_nodes(nodes.data(), emissions.data(), h < lighting_.tree().leaf_count() ? 0 : ~0ull);
  }
  static float first_lane(Lanes a) { return hn::GetLane(a.values); }

  /// Of a ball around position - w · point that holds those of all lights of the node.
  Lanes radius(const LocalNodeLanes& n) const {
    const LaneMask is_mixed = (n.w > 0.0f) & (n.w < 1.0f);
    return n.radius + select(is_mixed, max(n.w, 1.0f - n.w) * far_, 0.0f);
  }

  /// The cosine to an axis of that direction of a cone which is nearest to the axis; the cone's own axis has
  /// `cosine` to it.
  static Lanes nearer(Lanes cosine, Lanes sine_of_cone, Lanes cosine_of_cone) {
    const Lanes sine = sqrt(max(1.0f - cosine * cosine, 0.0f));
    return select(cosine < cosine_of_cone, mul_add(cosine, cosine_of_cone, sine * sine_of_cone), 1.0f);
  }

  /// Nodes that reach below the horizon are seen by lobes as if all of them were above.
  static Arrival raised(Arrival a, Lanes sine, Lanes highest) {
    const Lanes z = select(a.z < sine, highest, a.z);
    const Lanes scale = 1.0f / sqrt(max(mul_add(a.x, a.x, mul_add(a.y, a.y, z * z)), 1e-30f));
    a.x = a.x * scale, a.y = a.y * scale, a.z = z * scale;
    return a;
  }

  static Lanes towards(const LocalNodeLanes& n, const Arrival& a) {
    return mul_add(n.axis_x, a.world_x, mul_add(n.axis_y, a.world_y, n.axis_z * a.world_z));
  }

  /// What the lights of a node can emit at most on average against directions in a cone. The share `offset`
  /// are points; the others are surfaces, whose mean max(0, n · d) follows from the mean and the variance of
  /// their normals. Spots may point anywhere.
  static Lanes most_emitted(const LocalNodeLanes& n, const Arrival& a, Lanes cosine_of_cone) {
    const Lanes surfaces = 1.0f - n.offset, mean = -towards(n, a);
    const Lanes axis2 = mul_add(n.axis_x, n.axis_x, mul_add(n.axis_y, n.axis_y, n.axis_z * n.axis_z));
    const Lanes variance = max(surfaces * surfaces - axis2, 0.0f);
    const Lanes chord = sqrt(max(2.0f * (1.0f - cosine_of_cone), 0.0f));
    const Lanes most = n.offset + positive_part(mean, variance) + surfaces * chord;
    const Lanes of_node = select(n.square > 0.0f, 1.0f, min(most, 1.0f));
    return select(n.is_leaf, emission(n, n.offset + mean), of_node);
  }

  /// The most that the mean of max(0, x) can be for x of this mean and variance (Scarf 1958).
  static Lanes positive_part(Lanes mean, Lanes variance) {
    return 0.5f * (mean + sqrt(mul_add(mean, mean, variance)));
  }

  static Lanes emission(const LocalNodeLanes& n, Lanes towards) {
    const Lanes s = min(max(towards, 0.0f), 1.0f);
    return s * mul_add(n.square, s, 1.0f - n.square);
  }

  Lanes specular(const Arrival& a, const LocalNodeLanes& n) const {
    if constexpr (B::terms == 1) return 0.0f;
    const Lanes spread = min(n.variance / (3.0f * a.squared), 0.99f);
    const FilteredTerms<Lanes> t = brdf_.filtered(a.x, a.y, a.z, light_spread(spread));
    return mul_add(luminance_[1], t.specular, luminance_[2] * t.fresnel);
  }

  const LocalLighting& lighting_;
  vec3 position_;
  B brdf_;
  LocalFrame frame_;
  float far_;
  float luminance_[3];
};

}  // namespace coppice::inline HWY_NAMESPACE
