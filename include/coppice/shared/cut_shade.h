// What the kernels cut_shade and local_cut_shade read and write: one block of push constants that holds the
// addresses of all buffers, since a descriptor would be limited to maxStorageBufferRange (128 MiB on some
// devices).
#ifndef COPPICE_SHARED_CUT_SHADE_H
#define COPPICE_SHARED_CUT_SHADE_H
#include <coppice/shared/layout.h>

#ifdef COPPICE_GLSL
#define COPPICE_ADDRESS(Buffer) Buffer
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Words { uint at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Scales { float at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Positions { vec3 at[]; };
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
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer LocalLightNodes {
  LocalLightNode at[];
};
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Radiance { vec3 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer WrittenWords { uint at[]; };
#else
#define COPPICE_ADDRESS(Buffer) std::uint64_t
#endif

COPPICE_BEGIN

/// Invocations of one workgroup, an item each.
COPPICE_CONST uint KERNEL_GROUP_SIZE = 64u;

/// The items [begin, end) of one dispatch.
struct DispatchRange {
  uint begin;
  uint end;
};

/// Cuts over one tree. A granule is 1 << granule_log2 leaves; the ends of a cut are multiples of it, and bit
/// k of its mask is the end of granule k. Values are of 8 or 16 bits, packed into words with the first
/// lowest.
struct CutStore {
  COPPICE_ADDRESS(Words) masks;        ///< words_per_cut() words a cut
  COPPICE_ADDRESS(Words) first_value;  ///< by cut: index of its first value
  COPPICE_ADDRESS(Words) values;       ///< one for each end, in order; one more can be read after the last
};

COPPICE_CONST uint CUT_SHADE_SAMPLED = 0u;  ///< the values of Lobes (relight/lobes.hpp)
COPPICE_CONST uint CUT_SHADE_FILTERED = 1u;
COPPICE_CONST uint CUT_SHADE_REFINED = 2u;

/// The shading of points by cuts, whatever the lights.
struct ShadingTask {
  CutStore cuts;                                 ///< by receiver
  COPPICE_ADDRESS(ShadingFaces) faces;           ///< by face
  COPPICE_ADDRESS(ShadingPoints) points;         ///< by point
  COPPICE_ADDRESS(Words) illumination_ends;      ///< bit e - 1: the cut has the end e, in leaves
  COPPICE_ADDRESS(Words) illumination_granules;  ///< bit k: it has the end of granule k
  COPPICE_ADDRESS(Radiance) radiance;            ///< by point
  COPPICE_ADDRESS(WrittenWords) cluster_count;   ///< by point
  uint leaf_count;                               ///< a power of two
  uint granule_log2;                             ///< 0 … 5
  uint lobes;                                    ///< one of the CUT_SHADE_ constants
  float tolerance;                               ///< of refinement, a share of a point's radiance
};

/// Shading by distant lights. Values are bytes, visibility · 255.
struct CutShadeParameters {
  ShadingTask shading;
  DispatchRange range;  ///< of points
  COPPICE_ADDRESS(LightNodes) nodes;
  COPPICE_ADDRESS(ReceiverHorizons) horizons;  ///< by receiver
};

/// Shading by lights in the scene. Values are of 16 bits; times the receiver's scale they are visibility ·
/// geometry, the share of a light's intensity that arrives.
struct LocalCutShadeParameters {
  ShadingTask shading;
  DispatchRange range;  ///< of points
  COPPICE_ADDRESS(LocalLightNodes) nodes;
  COPPICE_ADDRESS(Scales) scales;        ///< by receiver
  COPPICE_ADDRESS(Positions) positions;  ///< by point
};

/// Words of one visibility mask, and of the illumination mask with granule_log2 = 0.
COPPICE_FUNCTION uint words_per_cut(uint leaf_count, uint granule_log2) {
  return ((leaf_count >> granule_log2) + 31u) / 32u;
}

COPPICE_END

#ifndef COPPICE_GLSL
namespace coppice {
static_assert(sizeof(CutStore) == 24 && offsetof(CutStore, values) == 16);
static_assert(sizeof(ShadingTask) == 88 && offsetof(ShadingTask, cluster_count) == 64 &&
              offsetof(ShadingTask, leaf_count) == 72);
static_assert(sizeof(CutShadeParameters) == 112 && offsetof(CutShadeParameters, horizons) == 104);
static_assert(sizeof(LocalCutShadeParameters) == 120 && offsetof(LocalCutShadeParameters, positions) == 112);
static_assert(sizeof(LocalCutShadeParameters) <= 128, "every device takes 128 bytes of push constants");
}  // namespace coppice
#endif
#endif
