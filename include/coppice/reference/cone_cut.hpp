// Cones from every leaf of a light tree, and the light that they approximate: the slow twin of ConeCut.
#pragma once

#include <coppice/shared/brdf.h>
#include <coppice/shared/cones.h>
#include <coppice/shared/node.h>

#include <algorithm>
#include <coppice/cut/cut.hpp>
#include <coppice/reference/lobe.hpp>
#include <coppice/reference/sg.hpp>
#include <coppice/scene/occluder.hpp>
#include <limits>
#include <span>
#include <vector>

namespace coppice::reference {

/// What lights add at a point: radiance, its luminance, and luminance times direction.
struct ReflectedSum {
  glm::dvec3 radiance{0};
  double luminance = 0;
  glm::dvec3 moment{0};

  /// 1 - the length of the mean direction; 0 without light.
  double spread() const {
    return luminance > 0 ? std::clamp(1 - glm::length(moment / luminance), 0.0, 1.0) : 0.0;
  }
  friend ReflectedSum operator+(const ReflectedSum& a, const ReflectedSum& b) {
    return {a.radiance + b.radiance, a.luminance + b.luminance, a.moment + b.moment};
  }
};

/// Power (radiance · steradians) from a unit direction times BRDF · cos of a point, in double.
inline ReflectedSum reflected(const ShadingPoint& point, const glm::dvec3& power,
                              const glm::dvec3& direction) {
  const glm::dvec3 normal(point.normal), tangent(point.tangent);
  const vec3 viewer = brdf_viewer_to_local(point.normal, point.tangent, point.to_viewer);
  const auto t = brdf_terms<double>(point.brdf, point.alpha_x, point.alpha_y, glm::dot(direction, tangent),
                                    glm::dot(direction, glm::cross(normal, tangent)),
                                    glm::dot(direction, normal), viewer);
  ReflectedSum sum;
  sum.radiance = power * (glm::dvec3(point.diffuse) * t.diffuse + glm::dvec3(point.specular) * t.specular +
                          glm::dvec3(point.fresnel) * t.fresnel);
  sum.luminance = glm::dot(sum.radiance, glm::dvec3(0.2126, 0.7152, 0.0722));
  sum.moment = sum.luminance * direction;
  return sum;
}

/// The same of a Gaussian light, by rings · turns directions under it. Error: that of the quadrature, some
/// 1e-4 where the BRDF is wider than the light. The weights are brought to the light's exact energy.
/// `is_seen(direction)` tells whether a direction counts.
template <class IsSeen>
ReflectedSum reflected(const ShadingPoint& point, const SgLight& light, const IsSeen& is_seen, int rings = 48,
                       int turns = 32) {
  const Gaussian g{glm::normalize(glm::dvec3(light.axis)), double(light.sharpness)};
  const auto nodes = sphere_nodes(g.axis, 0.7 / std::sqrt(g.sharpness + 1), rings, turns);
  double whole = 0;
  ReflectedSum sum;
  for (const SphereNode& n : nodes) {
    const double share = n.weight * g(n.direction);
    whole += share;
    if (is_seen(n.direction)) sum = sum + reflected(point, share * glm::dvec3(light.amplitude), n.direction);
  }
  const double energy = -2 * std::numbers::pi * std::expm1(-2 * g.sharpness) / g.sharpness;
  const double scale = (g.sharpness > 0 ? energy : 4 * std::numbers::pi) / whole;
  return {scale * sum.radiance, scale * sum.luminance, scale * sum.moment};
}

/// A node of the light × BRDF that stays whole.
struct ReflectedCone {
  Gaussian shape;  ///< of the same mean direction and of mean length up to 1 - 1e-7
  ReflectedSum sum;
};

struct ReflectedCones {
  std::vector<ReflectedCone> cones;
  glm::dvec3 untraced{0};
};

/// Cones placed as ConeCut does it, with every leaf's light × BRDF summed up the tree, one point after the
/// other. `nodes` are those of a frame by heap id and outlive this; `ends` are of its illumination cut, below
/// which nothing is split. Cost: 4 evaluations of the BRDF a leaf and point.
class ConeCutOfLeaves {
 public:
  ConeCutOfLeaves(std::span<const LightNode> nodes, std::span<const std::uint32_t> ends)
      : nodes_(nodes), is_piece_(nodes.size(), false) {
    for_each_piece(ends, [&](LeafRange r, std::size_t) {
      is_piece_[node_of_range(std::uint32_t(nodes.size() / 2), r.begin, r.end)] = true;
    });
  }

  /// The sum of each node, by heap id.
  std::vector<ReflectedSum> sums(const ShadingPoint& point) const {
    const std::size_t leaf_count = nodes_.size() / 2;
    std::vector<ReflectedSum> result(nodes_.size());
    for (std::size_t h = nodes_.size(); h-- > 1;)
      result[h] = h < leaf_count
                      ? result[2 * h] + result[2 * h + 1]
                      : reflected(point, nodes_[h].power, glm::normalize(glm::dvec3(nodes_[h].direction)));
    return result;
  }

  /// At most `most` cones; what gives no more than the share `negligible` of the light has none.
  ReflectedCones place(const ShadingPoint& point, std::size_t most, double negligible) const {
    const std::vector<ReflectedSum> sums = this->sums(point);
    std::vector<std::uint32_t> open;
    if (sums[1].luminance > 0) open.push_back(1);
    while (open.size() < most && split(sums, open)) {
    }
    ReflectedCones result;
    for (const std::uint32_t h : open)
      if (sums[h].luminance > negligible * sums[1].luminance)
        result.cones.push_back({gaussian_of(sums[h]), sums[h]});
      else
        result.untraced += sums[h].radiance;
    return result;
  }

 private:
  /// Replaces the node of the greatest luminance · spread^(1/4) that is no piece by its children that have
  /// light; false where all are pieces.
  bool split(const std::vector<ReflectedSum>& sums, std::vector<std::uint32_t>& open) const {
    const auto priority = [&](std::uint32_t h) {
      return sums[h].luminance * std::pow(sums[h].spread(), 0.25);
    };
    auto best = open.end();
    for (auto h = open.begin(); h != open.end(); ++h)
      if (!is_piece_[*h] && (best == open.end() || priority(*h) > priority(*best))) best = h;
    if (best == open.end()) return false;
    const std::uint32_t h = *best;
    open.erase(best);
    for (const std::uint32_t child : {2 * h, 2 * h + 1})
      if (sums[child].luminance > 0) open.push_back(child);
    return true;
  }

  static Gaussian gaussian_of(const ReflectedSum& sum) {
    const glm::dvec3 mean = sum.moment / sum.luminance;
    const double size = std::min(glm::length(mean), 1 - 1e-7);
    return {glm::normalize(mean), SphericalGaussian(size).sharpness()};
  }

  std::span<const LightNode> nodes_;
  std::vector<bool> is_piece_;
};

/// What cones approximate: the radiance of a point from all leaves of a frame's nodes and from Gaussian
/// lights, each direction with its own visibility: above the surface's horizon, and nothing in the way.
/// `to_world` turns directions of the lights, and of the point, to those of the receiver and the occluder.
template <Occluder O, class ToWorld>
glm::dvec3 relit(const ShadingPoint& point, std::span<const LightNode> nodes, std::span<const SgLight> lights,
                 const ConeReceiver& receiver, const O& occluder, const ToWorld& to_world) {
  const auto is_seen = [&](const glm::dvec3& direction) {
    const vec3 d = to_world(vec3(direction));
    return dot(d, receiver.normal) > 0 &&
           !occluder.occluded(receiver.position, d, std::numeric_limits<float>::infinity());
  };
  ReflectedSum sum;
  for (std::size_t h = nodes.size() / 2; h < nodes.size(); ++h)
    if (const glm::dvec3 d(nodes[h].direction); nodes[h].power != vec3(0) && is_seen(d))
      sum = sum + reflected(point, nodes[h].power, glm::normalize(d));
  for (const SgLight& light : lights) sum = sum + reflected(point, light, is_seen);
  return sum.radiance;
}

}  // namespace coppice::reference
