// VPLs one after the other, and their tree one node after the other: sums in double, and plain recursion.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <algorithm>
#include <coppice/gather/angle_walk.hpp>
#include <coppice/reference/lobe.hpp>
#include <limits>

namespace coppice::reference {

/// What arrives at a point.
struct ReceivedVpls {
  glm::dvec3 irradiance{0};  ///< W/m², linear RGB
  glm::dvec3 towards{0};     ///< Σ luminance of irradiance · unit direction to the VPL
};

namespace detail {

inline double vpl_luminance(const glm::dvec3& rgb) {
  return 0.2126 * rgb.x + 0.7152 * rgb.y + 0.0722 * rgb.z;
}

/// A VPL, or a cluster taken as one, as a point meets it.
class MetVpl {
 public:
  /// Distances below a micrometre count as one.
  MetVpl(const VplNode& n, const vec3& position, const vec3& normal) : node_(n) {
    const glm::dvec3 apart = glm::dvec3(n.position) - glm::dvec3(position);
    const double squared = std::max(glm::dot(apart, apart), 1e-12);
    direction_ = apart / std::sqrt(squared);
    variance_ = double(n.variance) / squared / 3;
    const double here = std::max(glm::dot(direction_, glm::dvec3(normal)), 0.0);
    const double there = std::max(-glm::dot(direction_, glm::dvec3(n.normal)), 0.0);
    geometry_ = here * there / (squared + double(n.softening));
  }

  const glm::dvec3& direction() const { return direction_; }
  /// Of directions; of a single VPL 0.
  double widened(double exponent) const { return exponent / (1 + exponent * variance_); }
  glm::dvec3 irradiance() const {
    if (geometry_ == 0) return glm::dvec3(0);
    const double k = double(node_.exponent);
    const double cosine = -glm::dot(direction_, glm::normalize(glm::dvec3(node_.lobe)));
    const double lobe = lobe_radiance(widened(std::max(k, (k + 1) / 2)), cosine);
    return geometry_ * (glm::dvec3(node_.diffuse) + lobe * glm::dvec3(node_.specular));
  }

 private:
  const VplNode& node_;
  glm::dvec3 direction_;
  double variance_, geometry_;
};

}  // namespace detail

/// What a point reflects of one VPL, W/m²/sr (Filtering Eq. 2); of a cluster taken as one by its variance.
/// Unit vectors are normalised in double.
inline glm::dvec3 reflected(const VplNode& vpl, const GlossyPoint& point) {
  const detail::MetVpl met(vpl, point.position, point.normal);
  const double n = met.widened(double(point.exponent));
  const double cosine = glm::dot(met.direction(), glm::normalize(glm::dvec3(point.mirror)));
  const double lobe = cosine > 0 ? (n + 2) / (2 * std::numbers::pi) * std::pow(cosine, n) : 0;
  const glm::dvec3 reflectance =
      std::numbers::inv_pi * glm::dvec3(point.diffuse) + lobe * glm::dvec3(point.specular);
  return reflectance * met.irradiance();
}

/// The sum over all VPLs.
inline glm::dvec3 reflected_by_all(std::span<const VplNode> vpls, const GlossyPoint& point) {
  glm::dvec3 sum(0);
  for (const VplNode& vpl : vpls) sum += reflected(vpl, point);
  return sum;
}

/// What all VPLs bring to a point of a surface.
inline ReceivedVpls received(std::span<const VplNode> vpls, const vec3& position, const vec3& normal) {
  ReceivedVpls sum;
  for (const VplNode& vpl : vpls) {
    const detail::MetVpl met(vpl, position, normal);
    const glm::dvec3 irradiance = met.irradiance();
    sum.irradiance += irradiance;
    sum.towards += detail::vpl_luminance(irradiance) * met.direction();
  }
  return sum;
}

/// What a walk found. `margin`: how near a decision was to falling otherwise, |value / threshold - 1|, the
/// least of all.
struct VplWalk {
  glm::dvec3 radiance{0};
  std::vector<std::uint32_t> nodes;  ///< those taken whole, from left to right
  double margin = std::numeric_limits<double>::infinity();

  bool is_above(double value, double threshold) {
    margin = std::min(margin, std::abs(value / threshold - 1));
    return value > threshold;
  }
};

namespace detail {

struct AngleWalk {
  std::span<const VplNode> nodes;
  const GlossyPoint& point;
  double threshold;
  std::span<const WalkMark> marks;
  VplWalk result{};

  /// Steradians of a disc of the node's area that faces the point.
  double solid_angle(const VplNode& n) const {
    const glm::dvec3 apart = glm::dvec3(n.position) - glm::dvec3(point.position);
    const double r2 = glm::dot(apart, apart), radius2 = double(n.area) / std::numbers::pi;
    return 2 * std::numbers::pi * (radius2 > 0 ? 1 - std::sqrt(r2 / (r2 + radius2)) : 0);
  }
  bool is_split(std::uint32_t h) {
    if (h >= nodes.size() / 2) return false;
    const WalkMark mark = marks.empty() ? WalkMark::test : marks[h];
    if (mark != WalkMark::test) return mark == WalkMark::split;
    return result.is_above(solid_angle(nodes[h]), threshold);
  }
  void visit(std::uint32_t h) {
    if (nodes[h].energy <= 0) return;
    if (is_split(h)) return visit(2 * h), visit(2 * h + 1);
    result.radiance += reflected(nodes[h], point);
    result.nodes.push_back(h);
  }
};

template <class Bounded>
struct GroupCut {
  std::uint32_t leaf_count;
  const Bounded& bounded;
  double limit;
  SplitBy split;
  VplWalk result{};

  void visit(std::uint32_t h) {
    const auto [radiance, angle] = bounded(h);
    const double factor = split == SplitBy::bound_and_angle ? angle : angle > 0 ? 1 : 0;
    const bool is_split =
        h < leaf_count && (h == 1 || result.is_above(double(float(radiance) * float(factor)), limit));
    if (is_split) return visit(2 * h), visit(2 * h + 1);
    if (radiance > 0 || h == 1) result.nodes.push_back(h);
  }
};

}  // namespace detail

/// gather_by_angle for one point (Filtering section 2.2). `nodes` and `marks` by heap id, `marks` may be
/// empty; threshold in steradians.
inline VplWalk walk_by_angle(std::span<const VplNode> nodes, const GlossyPoint& point, double threshold,
                             std::span<const WalkMark> marks = {}) {
  detail::AngleWalk walk{nodes, point, threshold, marks};
  if (!nodes.empty()) walk.visit(1);
  return walk.result;
}

/// GroupCutter::cut, its nodes from left to right; `bounded(h)` is a pair, what the node brings at most and
/// the most that its size covers; their product is a float, which may lose what is next to 0. Radiance stays
/// 0.
template <class Bounded>
VplWalk group_cut(std::uint32_t leaf_count, const Bounded& bounded, double limit, SplitBy split) {
  detail::GroupCut<Bounded> cut{leaf_count, bounded, limit, split};
  if (leaf_count > 0) cut.visit(1);
  return cut.result;
}

}  // namespace coppice::reference
