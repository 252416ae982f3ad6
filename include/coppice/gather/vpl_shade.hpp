// What one point receives and reflects of many nodes, a register of nodes at a time.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <coppice/gather/vpl_arrays.hpp>

namespace coppice {

/// What nodes are to a point: single VPLs, or clusters whose extent widens lobes.
enum class VplKind { single, cluster };

}  // namespace coppice

namespace coppice::inline HWY_NAMESPACE {

inline PointShape<Lanes> point_lanes(const GlossyPoint& p) {
  return {p.position.x, p.position.y, p.position.z, p.exponent, p.normal.x,
          p.normal.y,   p.normal.z,   p.mirror.x,   p.mirror.y, p.mirror.z};
}

template <VplKind kind>
VplTerms<Lanes> terms_of(const VplShape<Lanes>& node, const PointShape<Lanes>& point,
                         const VplArrival<Lanes>& arrival) {
  if constexpr (kind == VplKind::single) return vpl_terms(node, point, arrival);
  return vpl_cluster_terms(node, point, arrival);
}

/// Σ of what arrives, for both terms of the point's reflectance.
struct ReflectedSums {
  Lanes diffuse[3]{0.0f, 0.0f, 0.0f};
  Lanes specular[3]{0.0f, 0.0f, 0.0f};

  void add(const VplLanes& n, const VplTerms<Lanes>& t) {
    for (int c = 0; c < 3; ++c) {
      const Lanes shining = mul_add(n.specular[c], t.lobe, n.diffuse[c]);
      diffuse[c] = mul_add(shining, t.diffuse, diffuse[c]);
      specular[c] = mul_add(shining, t.specular, specular[c]);
    }
  }
  vec3 radiance(const GlossyPoint& p) const {
    vec3 sum;
    for (int c = 0; c < 3; ++c)
      sum[c] = p.diffuse[c] * sum_of_lanes(diffuse[c]) + p.specular[c] * sum_of_lanes(specular[c]);
    return sum;
  }
};

/// Radiance of the point by the nodes: Filtering Eq. 2. Registers of nodes below either horizon are passed
/// over. Of VplKind::single over all lit VPLs, the baseline of every speed-up: what an engineer would write
/// without a tree.
template <VplKind kind>
vec3 reflect_nodes(const VplArrays& nodes, const GlossyPoint& point) {
  const PointShape<Lanes> shape = point_lanes(point);
  ReflectedSums sums;
  for (std::size_t i = 0; i < nodes.size(); i += Lanes::width) {
    const VplLanes n = nodes.load(i);
    const VplArrival<Lanes> a = vpl_arrival(n.shape, shape);
    if (any(a.geometry > 0.0f)) sums.add(n, terms_of<kind>(n.shape, shape, a));
  }
  return sums.radiance(point);
}

}  // namespace coppice::inline HWY_NAMESPACE
