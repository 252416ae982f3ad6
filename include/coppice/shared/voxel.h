// A sparse grid of distances to the nearest surface, and the march of a cone through it, as closed forms for
// C++ and GLSL.
//
// The grid is a box of cubic voxels in bricks of 8³. A brick that a triangle meets holds 8³ distances, at
// places that lie 8/7 of a voxel apart so that the outermost lie on its faces: a lookup never leaves the
// brick. Elsewhere the distances at the eight corners of the brick serve. All lengths below are in voxels,
// and places are relative to the grid's low corner.
//
// A cone is split into rays of equal shares of its Gaussian. A ray is open as far as the surfaces that it
// passes leave room for its share, and a wall that it meets closes it.
#ifndef COPPICE_SHARED_VOXEL_H
#define COPPICE_SHARED_VOXEL_H
#include <coppice/shared/sg.h>

COPPICE_BEGIN

COPPICE_CONST uint VOXEL_BRICK = 8u;                  ///< voxels, and distances, along a brick's edge
COPPICE_CONST uint VOXEL_BRICK_SIZE = 512u;           ///< bytes of a filled brick
COPPICE_CONST float VOXEL_NEAR_UNIT = 8.0f / 255.0f;  ///< of a byte of a brick; 255: 8 voxels or more
COPPICE_CONST float VOXEL_FAR_UNIT = 1.0f / 64.0f;    ///< of the 16 bits of a corner
COPPICE_CONST float VOXEL_PLACES = 7.0f / 8.0f;       ///< distances of a filled brick, a voxel
COPPICE_CONST float VOXEL_TURN = 2.3999632f;          ///< radians from a ray to the next: the golden angle

/// Where a grid lies, and in which order its buffers are. `slots` are bricks.x · bricks.y · bricks.z words, x
/// fastest: 0 where a brick holds nothing, else 1 + its index. `distances` are the corners, 16 bits each,
/// (bricks.x + 1) · (bricks.y + 1) · (bricks.z + 1) of them, x fastest; from the byte first_brick on
/// VOXEL_BRICK_SIZE bytes a filled brick, x fastest; and 4 bytes that are read and not used.
struct VoxelGrid {
  vec3 low;  ///< world
  float voxels_per_unit;
  uvec3 bricks;
  float voxel;  ///< edge, world units
  uint first_brick;
};

/// How cones are traced.
struct VoxelTrace {
  uint rays;       ///< that a cone is split into
  uint steps;      ///< of a ray at most
  float lift;      ///< voxels along the normal: where the march starts from
  float start;     ///< voxels along the ray: what is nearer is left to exact rays
  float skin;      ///< voxels around surfaces that count as solid: what a sheet between two places loses
  float softness;  ///< half-width of a ray that is closed by degrees, in units of 1/√(rays · sharpness)
  float slack;     ///< of the receiver's own plane: surfaces nearer than this share of its distance close
  float growth;    ///< least stride as a share of the ray's half-width
};

/// The brick along an axis in which a place lies, clamped to the grid.
COPPICE_FUNCTION uint voxel_brick(float place, uint bricks) {
  const uint brick = uint(max(place, 0.0f) * 0.125f);
  return brick < bricks ? brick : bricks - 1u;
}

/// The width of a ray, radians: where the cone's Gaussian has one over so many parts of its energy.
/// Finite for all sharpness >= 0.
COPPICE_FUNCTION float voxel_ray_width(float sharpness, uint rays) {
  return 1.0f / sqrt(max(float(rays) * sharpness, 1.0f));
}

/// 1 - cosine of the angle to the axis within which the share u of the Gaussian's integral lies. Domain: u in
/// [0, 0.999], sharpness in [1e-4, 1e10]; relative error 1e-5.
COPPICE_FUNCTION_OF_REAL REAL voxel_ray_drop(REAL u, REAL sharpness) {
  const REAL all = 2.0f * sharpness * sg_mean_decay(2.0f * sharpness);  // 1 - e^(-2 sharpness)
  return min(-log1p(-u * all) / sharpness, REAL(2.0f));
}

/// The part of a ray that is above the horizon, when the cosine to the normal is `rise`.
COPPICE_FUNCTION_OF_REAL REAL voxel_ray_share(REAL rise, REAL width) {
  return min(max(0.5f + 0.5f * rise / width, REAL(0.0f)), REAL(1.0f));
}

/// The least cosine to the normal that a ray is turned up to.
COPPICE_FUNCTION_OF_REAL REAL voxel_ray_least_rise(REAL width) { return min(0.5f * width, REAL(0.5f)); }

/// How open a ray is at distance t: 1 where the nearest surface is beyond `reach` · t, or as far as the
/// receiver's own plane would be, which is at `rise`; 0 within the skin.
COPPICE_FUNCTION_OF_REAL REAL voxel_opening(REAL distance, REAL t, REAL rise, REAL reach, REAL skin,
                                            REAL slack) {
  const REAL room = max(min(reach * t, slack * (rise - skin)), REAL(1e-3f));
  return min(max((distance - skin) / room, REAL(0.0f)), REAL(1.0f));
}

/// How far the march may go on: to a voxel before the nearest surface, since empty bricks interpolate
/// distances too large by as much; at least a voxel or the given share of the ray's
/// reach.
COPPICE_FUNCTION_OF_REAL REAL voxel_stride(REAL distance, REAL t, REAL reach, REAL growth) {
  return max(max(distance - 1.0f, growth * reach * t), REAL(1.0f));
}

COPPICE_END

#ifndef COPPICE_GLSL
#include <cstddef>
namespace coppice {
static_assert(sizeof(VoxelGrid) == 36 && offsetof(VoxelGrid, bricks) == 16);
static_assert(sizeof(VoxelTrace) == 32 && offsetof(VoxelTrace, growth) == 28);
}  // namespace coppice
#endif
#endif
