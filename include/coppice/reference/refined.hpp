// Refined shading one cluster after the other: the slow twin of PointShader::refined.
#pragma once

#include <coppice/shared/brdf_filtered.h>

#include <cstdint>
#include <span>

namespace coppice::reference {

/// A cluster by its heap id, and its visibility in [0, 1] at the point.
struct SeenCluster {
  std::uint32_t node;
  double visibility;
};

/// Radiance of a point, and how many clusters were evaluated for it.
struct RefinedPoint {
  glm::dvec3 radiance{0};
  std::uint32_t clusters = 0;
};

/// Shading of one point from nodes of a light tree, in double from the local directions on.
class Refinement {
 public:
  /// `tree` are the nodes of a frame by heap id; they and the point outlive this.
  Refinement(const ShadingPoint& point, std::span<const LightNode> tree)
      : point_(point),
        tree_(tree),
        viewer_(brdf_viewer_to_local(point.normal, point.tangent, point.to_viewer)) {}

  /// The BRDF's mean over each cluster.
  glm::dvec3 filtered(std::span<const SeenCluster> clusters) const {
    glm::dvec3 sum(0);
    for (const SeenCluster& c : clusters) sum += evaluate(c).radiance;
    return sum;
  }

  /// The same, and each cluster whose error exceeds the share `tolerance` of all clusters' brightness is
  /// replaced by its grandchildren (children right above the leaves), and these in turn. Brightness is the
  /// luminance of the light times that of the reflectance.
  RefinedPoint refined(std::span<const SeenCluster> clusters, double tolerance) const {
    double brightness = 0;
    for (const SeenCluster& c : clusters) brightness += evaluate(c).brightness;
    const double limit = tolerance * brightness;
    RefinedPoint result;
    for (const SeenCluster& c : clusters) descend(c, limit, result);
    return result;
  }

 private:
  struct Evaluated {
    glm::dvec3 radiance;
    double brightness, error;  ///< error: the specular part of the brightness times the growth of the lobe
  };

  static double luminance(const glm::dvec3& rgb) { return 0.2126 * rgb.x + 0.7152 * rgb.y + 0.0722 * rgb.z; }

  Evaluated evaluate(const SeenCluster& c) const {
    const LightNode& node = tree_[c.node];
    const glm::dvec3 normal(point_.normal), tangent(point_.tangent), direction(node.direction);
    const auto spread = light_spread<double>(node.spread);
    const auto t = brdf_filtered_terms<double>(
        point_.brdf, point_.alpha_x, point_.alpha_y, dot(direction, tangent),
        dot(direction, cross(normal, tangent)), dot(direction, normal), spread, viewer_);
    const glm::dvec3 light = glm::dvec3(node.power) * c.visibility;
    const glm::dvec3 lobe = glm::dvec3(point_.specular) * t.specular + glm::dvec3(point_.fresnel) * t.fresnel;
    const glm::dvec3 reflectance = glm::dvec3(point_.diffuse) * t.diffuse + lobe;
    return {light * reflectance, luminance(light) * luminance(reflectance),
            luminance(light) * luminance(lobe) * t.growth};
  }

  void descend(const SeenCluster& c, double limit, RefinedPoint& result) const {
    const Evaluated here = evaluate(c);
    ++result.clusters;
    if (here.error > limit)
      for_each_below(c, [&](const SeenCluster& below) { descend(below, limit, result); });
    else
      result.radiance += here.radiance;
  }

  template <class Visit>
  void for_each_below(const SeenCluster& c, Visit&& visit) const {
    const std::uint32_t leaf_count = std::uint32_t(tree_.size() / 2);
    const std::uint32_t count = 2 * c.node < leaf_count ? 4 : 2;
    for (std::uint32_t k = 0; k < count; ++k) visit(SeenCluster{count * c.node + k, c.visibility});
  }

  const ShadingPoint& point_;
  std::span<const LightNode> tree_;
  vec3 viewer_;
};

}  // namespace coppice::reference
