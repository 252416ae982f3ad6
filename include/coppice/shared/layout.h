// The buffers that CPU and compute kernels both read, byte for byte: scalar block layout, every vec3 followed
// by a scalar. Sizes and offsets are asserted below and compared with the SPIR-V's in a test.
#ifndef COPPICE_SHARED_LAYOUT_H
#define COPPICE_SHARED_LAYOUT_H
#include <coppice/shared/language.h>

COPPICE_BEGIN

/// What the current lighting puts into one node of the light tree; an array by heap id.
struct LightNode {
  vec3 power;         ///< Σ radiance · solid angle over the node's lights, linear RGB
  float spread;       ///< 1 - |luminance-weighted mean of the directions|, in [0, 1]
  vec3 direction;     ///< unit; that mean, normalised; towards the lights
  float solid_angle;  ///< Σ solid angle, steradians
};

/// What the lights of the scene put into one node of their tree; an array by heap id. Positions are
/// homogeneous: a light is at position / w, or, where w = 0, infinitely far away in the direction of its
/// position. The vector to it, position - w · x, is linear in both, so that their means give its mean. All
/// means are weighted by luminance.
struct LocalLightNode {
  vec3 power;      ///< Σ intensity, linear RGB
  float variance;  ///< mean squared distance of the lights' positions from their mean
  vec3 position;   ///< mean
  float w;         ///< mean: 1 near, 0 far
};

/// How a node of local lights shines; an array beside that of the nodes. Towards the unit direction d that
/// leaves it a light shines with the share s·(1 - square + square·s) of its intensity, s = clamp(dot(axis, d)
/// + offset, 0, 1), and of that 1 / (distance² + softening) arrives across the direction.
struct LocalEmission {
  vec3 axis;        ///< mean
  float offset;     ///< mean
  float square;     ///< mean
  float softening;  ///< mean of area / π: of one light's surface, not of the node's
  float radius;     ///< of a ball around the mean position that holds those of all lights
  float luminance;  ///< of the power
};

/// Where a receiver's visibility cut has a meaning: towards directions d with dot(normal, d) > cosine.
/// Towards the others it sees nothing, whatever its cut says. A cut that tells all is given the normal 0 and
/// the cosine -1.
struct ReceiverHorizon {
  vec3 normal;
  float cosine;
};

/// One point to be shaded, from the deferred buffer. Colour = Σ over clusters of
/// power · visibility · (diffuse · t0 + specular · t1 + fresnel · t2), the terms t of brdf.h.
struct ShadingPoint {
  vec3 normal;     ///< unit shading normal, on the viewer's side
  float alpha_x;   ///< roughness of the BRDF along the tangent, or its exponent
  vec3 tangent;    ///< unit, orthogonal to normal
  float alpha_y;   ///< roughness across the tangent (Ward)
  vec3 to_viewer;  ///< unit
  uint brdf;       ///< one of the BRDF_ constants
  vec3 diffuse;    ///< coefficient of term 0
  float weight_0;  ///< barycentric weight of the face's first receiver
  vec3 specular;   ///< coefficient of term 1
  float weight_1;  ///< of its second; the third has 1 - weight_0 - weight_1
  vec3 fresnel;    ///< coefficient of term 2
  uint face;       ///< index into the faces
};

/// A triangle between three receivers, and the run of points that lie in it: points are sorted by face.
struct ShadingFace {
  uvec3 receivers;  ///< indices of visibility cuts
  uint first_point;
};

COPPICE_END

#ifndef COPPICE_GLSL
#include <cstddef>
namespace coppice {
static_assert(sizeof(ReceiverHorizon) == 16 && offsetof(ReceiverHorizon, cosine) == 12);
static_assert(sizeof(LightNode) == 32 && offsetof(LightNode, direction) == 16);
static_assert(sizeof(LocalLightNode) == 32 && offsetof(LocalLightNode, position) == 16);
static_assert(sizeof(LocalEmission) == 32 && offsetof(LocalEmission, square) == 16);
static_assert(sizeof(ShadingPoint) == 96 && offsetof(ShadingPoint, to_viewer) == 32 &&
              offsetof(ShadingPoint, fresnel) == 80);
static_assert(sizeof(ShadingFace) == 16 && offsetof(ShadingFace, first_point) == 12);
}  // namespace coppice
#endif
#endif
