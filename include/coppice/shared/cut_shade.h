// What the kernel cut_shade reads and writes: one block of push constants that holds the addresses of all
// buffers, since a descriptor would be limited to maxStorageBufferRange (128 MiB on some devices).
#ifndef COPPICE_SHARED_CUT_SHADE_H
#define COPPICE_SHARED_CUT_SHADE_H
#include <coppice/shared/layout.h>

#ifdef COPPICE_GLSL
#define COPPICE_ADDRESS(Buffer) Buffer
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Words { uint at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer ReceiverHorizons {
  ReceiverHorizon at[];
};
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer ShadingFaces {
  ShadingFace at[];
};
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer ShadingPoints {
  ShadingPoint at[];
};
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer LightNodes { LightNode at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Radiance { vec3 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer ClusterCounts { uint at[]; };
#else
#define COPPICE_ADDRESS(Buffer) std::uint64_t
#endif

COPPICE_BEGIN

/// Points that one workgroup shades.
COPPICE_CONST uint CUT_SHADE_GROUP_SIZE = 64u;

COPPICE_CONST uint CUT_SHADE_SAMPLED = 0u;  ///< the values of Lobes (relight/lobes.hpp)
COPPICE_CONST uint CUT_SHADE_FILTERED = 1u;
COPPICE_CONST uint CUT_SHADE_REFINED = 2u;

/// Addresses and counts of one dispatch, for the points [first_point, end_point). A granule is
/// 1 << granule_log2 leaves; the ends of a visibility cut are multiples of it, and bit k of a mask is the end
/// of granule k.
struct CutShadeParameters {
  COPPICE_ADDRESS(Words) visibility_masks;       ///< words_per_cut() words a receiver
  COPPICE_ADDRESS(Words) first_value;            ///< by receiver: index of its first byte
  COPPICE_ADDRESS(Words) values;                 ///< bytes, visibility · 255; one follows the last
  COPPICE_ADDRESS(ReceiverHorizons) horizons;    ///< by receiver
  COPPICE_ADDRESS(ShadingFaces) faces;           ///< by face
  COPPICE_ADDRESS(ShadingPoints) points;         ///< by point
  COPPICE_ADDRESS(LightNodes) nodes;             ///< by heap id
  COPPICE_ADDRESS(Words) illumination_ends;      ///< bit e - 1: the cut has the end e, in leaves
  COPPICE_ADDRESS(Words) illumination_granules;  ///< bit k: it has the end of granule k
  COPPICE_ADDRESS(Radiance) radiance;            ///< by point
  COPPICE_ADDRESS(ClusterCounts) cluster_count;  ///< by point
  uint leaf_count;                               ///< a power of two
  uint granule_log2;                             ///< 0 … 5
  uint lobes;                                    ///< one of the CUT_SHADE_ constants
  float tolerance;                               ///< of refinement, a share of a point's radiance
  uint first_point;
  uint end_point;
};

/// Words of one visibility mask, and of the illumination mask with granule_log2 = 0.
COPPICE_FUNCTION uint words_per_cut(uint leaf_count, uint granule_log2) {
  return ((leaf_count >> granule_log2) + 31u) / 32u;
}

COPPICE_END

#ifndef COPPICE_GLSL
namespace coppice {
static_assert(sizeof(CutShadeParameters) == 112 && offsetof(CutShadeParameters, cluster_count) == 80 &&
              offsetof(CutShadeParameters, leaf_count) == 88 &&
              offsetof(CutShadeParameters, end_point) == 108);
static_assert(sizeof(CutShadeParameters) <= 128, "every device takes 128 bytes of push constants");
}  // namespace coppice
#endif
#endif
