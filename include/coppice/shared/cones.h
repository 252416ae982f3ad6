// What is asked of whoever tells how much of a cone is visible, and what the cones carry.
#ifndef COPPICE_SHARED_CONES_H
#define COPPICE_SHARED_CONES_H
#include <coppice/shared/sg.h>

COPPICE_BEGIN

/// A point of a surface from which cones are traced. Of a cone's Gaussian only what lies above the horizon of
/// the shading normal counts, and of that what lies below the surface itself is hidden.
struct ConeReceiver {
  vec3 position;        ///< world space
  uint cones_end;       ///< its cones are those from the end of the receiver before to here
  vec3 normal;          ///< unit; geometric, on the viewer's side
  uint index;           ///< tells what is drawn at random for one receiver from that for others
  vec3 shading_normal;  ///< unit
};

/// The light that reaches the viewer through a Gaussian, if nothing is in the way.
struct LitCone {
  SgShape shape;
  vec3 radiance;
  float luminance;  ///< of the radiance
};

COPPICE_END

#ifndef COPPICE_GLSL
namespace coppice {
static_assert(sizeof(ConeReceiver) == 44 && offsetof(ConeReceiver, shading_normal) == 32);
static_assert(sizeof(LitCone) == 32 && offsetof(LitCone, radiance) == 16);
}  // namespace coppice
#endif
#endif
