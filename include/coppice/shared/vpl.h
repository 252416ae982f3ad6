// Virtual point lights (VPLs), clusters of them, and what a point reflects of one: the buffers and closed
// forms of reflectance filtering, for C++ and GLSL.
#ifndef COPPICE_SHARED_VPL_H
#define COPPICE_SHARED_VPL_H
#include <coppice/shared/lobe.h>

COPPICE_BEGIN

/// A VPL or a cluster of them; an array by heap id. Towards the unit direction d it shines with
///   (diffuse + specular (k + 1)/2π max(0, d·lobe)^k) · max(0, d·normal), W/sr, linear RGB.
/// Means count each VPL by its energy. Nodes without energy are all zero but for finite means.
struct VplNode {
  vec3 diffuse;     ///< Σ area · diffuse radiance
  float energy;     ///< luminance of π diffuse + specular
  vec3 specular;    ///< Σ area · energy of the lobe of radiance (Filtering Eq. 1)
  float exponent;   ///< k of the lobe, [-1, inf); shines as lobe_shining(k)
  vec3 position;    ///< mean
  float variance;   ///< mean squared distance from it, m²
  vec3 normal;      ///< mean of the unit normals, not normalised
  float softening;  ///< mean of one VPL's area / π, m²
  vec3 lobe;        ///< unit
  float area;       ///< Σ area, m²
};

/// A point that reflects light towards one viewer as Lambert and a Phong lobe about the mirror direction
/// (brdf_phong of brdf.h). Radiance = diffuse · E/π + specular · (n + 2)/2π Σ max(0, mirror·ω)^n E(ω).
struct GlossyPoint {
  vec3 position;   ///< above the surface by rounding
  float exponent;  ///< n, [1, 1e5]
  vec3 normal;     ///< unit
  uint pixel;
  vec3 mirror;  ///< unit; the viewer's direction mirrored by the normal
  uint group;
  vec3 diffuse;  ///< linear RGB
  uint padding;
  vec3 specular;
  uint padding_2;
};

/// A node without its colours.
COPPICE_STRUCT_OF_REAL struct VplShape {
  REAL x, y, z, variance;
  REAL normal_x, normal_y, normal_z, softening;
  REAL lobe_x, lobe_y, lobe_z, exponent;
};

/// A point without its colours.
COPPICE_STRUCT_OF_REAL struct PointShape {
  REAL x, y, z, exponent;
  REAL normal_x, normal_y, normal_z;
  REAL mirror_x, mirror_y, mirror_z;
};

/// What a point reflects of a node: (node.diffuse + node.specular · lobe) · (point.diffuse · diffuse +
/// point.specular · specular).
COPPICE_STRUCT_OF_REAL struct VplTerms {
  REAL lobe;      ///< 1/sr
  REAL diffuse;   ///< 1/m² · 1/sr
  REAL specular;  ///< 1/m² · 1/sr
};

/// How a node meets a point: what arrives across the direction to it, and that direction.
COPPICE_STRUCT_OF_REAL struct VplArrival {
  REAL x, y, z;   ///< unit, from the point to the node
  REAL geometry;  ///< cos(node) cos(point) / (distance² + softening), 1/m²; 0 below either horizon
  REAL widening;  ///< variance of the directions to the node's VPLs
};

/// Distances below a micrometre count as one: a VPL at the point itself has no direction, and gives nothing.
COPPICE_FUNCTION_OF_REAL COPPICE_OF_REAL(VplArrival)
    vpl_arrival(COPPICE_OF_REAL(VplShape) node, COPPICE_OF_REAL(PointShape) point) {
  const REAL dx = node.x - point.x;
  const REAL dy = node.y - point.y;
  const REAL dz = node.z - point.z;
  const REAL squared = max(mul_add(dx, dx, mul_add(dy, dy, dz * dz)), REAL(1e-12f));
  const REAL inverse = 1.0f / sqrt(squared);
  COPPICE_OF_REAL(VplArrival) a;
  a.x = dx * inverse;
  a.y = dy * inverse;
  a.z = dz * inverse;
  const REAL here = mul_add(a.x, point.normal_x, mul_add(a.y, point.normal_y, a.z * point.normal_z));
  const REAL there = -mul_add(a.x, node.normal_x, mul_add(a.y, node.normal_y, a.z * node.normal_z));
  a.geometry = max(here, REAL(0.0f)) * max(there, REAL(0.0f)) / (squared + node.softening);
  a.widening = node.variance * (inverse * inverse) * COPPICE_SCALAR(0.33333333f);
  return a;
}

/// Half the squared distance of (x, y, z) from a unit vector.
COPPICE_FUNCTION_OF_REAL REAL vpl_drop(REAL x, REAL y, REAL z, REAL ax, REAL ay, REAL az) {
  const REAL dx = x - ax;
  const REAL dy = y - ay;
  const REAL dz = z - az;
  return 0.5f * mul_add(dx, dx, mul_add(dy, dy, dz * dz));
}

/// What a point reflects of a node if k is the exponent of the node's lobe and n that of the point's.
COPPICE_FUNCTION_OF_REAL COPPICE_OF_REAL(VplTerms)
    vpl_terms_of_exponents(COPPICE_OF_REAL(VplShape) node, COPPICE_OF_REAL(PointShape) point,
                           COPPICE_OF_REAL(VplArrival) a, REAL k, REAL n) {
  const REAL sent = lobe_power(vpl_drop(-a.x, -a.y, -a.z, node.lobe_x, node.lobe_y, node.lobe_z), k);
  const REAL seen = lobe_power(vpl_drop(a.x, a.y, a.z, point.mirror_x, point.mirror_y, point.mirror_z), n);
  COPPICE_OF_REAL(VplTerms) terms;
  terms.lobe = sent * (k + 1.0f) * COPPICE_SCALAR(0.15915494309189534);
  terms.diffuse = a.geometry * COPPICE_SCALAR(0.31830988618379067);
  terms.specular = a.geometry * (seen * (n + 2.0f)) * COPPICE_SCALAR(0.15915494309189534);
  return terms;
}

/// Filtering Eq. 2 for one VPL.
COPPICE_FUNCTION_OF_REAL COPPICE_OF_REAL(VplTerms)
    vpl_terms(COPPICE_OF_REAL(VplShape) node, COPPICE_OF_REAL(PointShape) point,
              COPPICE_OF_REAL(VplArrival) a) {
  return vpl_terms_of_exponents(node, point, a, lobe_shining(node.exponent), point.exponent);
}

/// The same for a cluster: its VPLs stand at their mean position, and both lobes are as much wider as the
/// directions to the VPLs spread, by variance / 3 distance².
COPPICE_FUNCTION_OF_REAL COPPICE_OF_REAL(VplTerms)
    vpl_cluster_terms(COPPICE_OF_REAL(VplShape) node, COPPICE_OF_REAL(PointShape) point,
                      COPPICE_OF_REAL(VplArrival) a) {
  return vpl_terms_of_exponents(node, point, a, lobe_widened(lobe_shining(node.exponent), a.widening),
                                lobe_widened(point.exponent, a.widening));
}

/// A node covers more than so many steradians of a point where their squared distance is below this times the
/// node's area. The node counts as a disc of area A that faces the point, which covers 2π(1 - r/√(r² + A/π))
/// at distance r, near and far; no root is needed. Precondition: 0 < steradians < 2π.
COPPICE_FUNCTION float vpl_reach(float steradians) {
  const float share = steradians / 6.2831853f;
  const float c = 1.0f - share;
  return c * c / (share * (1.0f + c) * 3.14159265f);
}

COPPICE_FUNCTION float vpl_luminance(vec3 rgb) { return dot(rgb, vec3(0.2126f, 0.7152f, 0.0722f)); }

/// Luminance of π diffuse + specular.
COPPICE_FUNCTION float vpl_energy(vec3 diffuse, vec3 specular) {
  return vpl_luminance(3.14159265f * diffuse + specular);
}

/// The share of a in a + b, 1/2 where both are 0.
COPPICE_FUNCTION float vpl_share(float a, float b) {
  const float sum = a + b;
  return sum > 0.0f ? a / sum : 0.5f;
}

/// The cluster of two nodes: energies add up; position, normal and softening are their means by energy, the
/// lobe that of lobe_sum by the lobes' energies. Variances join without cancellation (Chan, Golub, LeVeque
/// 1979).
COPPICE_FUNCTION VplNode vpl_cluster(VplNode a, VplNode b) {
  const float wa = vpl_share(a.energy, b.energy);
  const float wb = 1.0f - wa;
  const vec3 apart = b.position - a.position;
  LobeShape la;
  la.direction = a.lobe;
  la.exponent = a.exponent;
  LobeShape lb;
  lb.direction = b.lobe;
  lb.exponent = b.exponent;
  const float sa = vpl_share(vpl_luminance(a.specular), vpl_luminance(b.specular));
  const LobeShape lobe = lobe_sum(la, sa, lb, 1.0f - sa);
  VplNode c;
  c.diffuse = a.diffuse + b.diffuse;
  c.energy = a.energy + b.energy;
  c.specular = a.specular + b.specular;
  c.exponent = lobe.exponent;
  c.position = a.position + wb * apart;
  c.variance = wa * a.variance + wb * b.variance + wa * wb * dot(apart, apart);
  c.normal = wa * a.normal + wb * b.normal;
  c.softening = wa * a.softening + wb * b.softening;
  c.lobe = lobe.direction;
  c.area = a.area + b.area;
  return c;
}

COPPICE_END

#ifndef COPPICE_GLSL
#include <cstddef>
namespace coppice {
static_assert(sizeof(VplNode) == 80 && offsetof(VplNode, position) == 32 && offsetof(VplNode, area) == 76);
static_assert(sizeof(GlossyPoint) == 80 && offsetof(GlossyPoint, diffuse) == 48);
}  // namespace coppice
#endif
#endif
