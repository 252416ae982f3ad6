// What the kernels vpl_filter, vpl_walk and vpl_lists read and write.
#ifndef COPPICE_SHARED_VPL_GATHER_H
#define COPPICE_SHARED_VPL_GATHER_H
#include <coppice/shared/cut_shade.h>
#include <coppice/shared/vpl.h>

#ifdef COPPICE_GLSL
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer VplNodes { VplNode at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) coherent buffer FilteredVplNodes {
  VplNode at[];
};
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer GlossyPoints {
  GlossyPoint at[];
};
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer RadianceSums { vec3 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Counters { uint at[]; };
#endif

COPPICE_BEGIN

/// Levels of the tree that one workgroup joins: the lowest of them has a node for each of its invocations.
COPPICE_CONST uint VPL_FILTER_LEVELS = 7u;

/// Nodes that one dispatch gives to a point at most. What is left over goes on in the next: drivers end
/// kernels whose loops are too long, on the CPU after 65,535 passes.
COPPICE_CONST uint VPL_NODES_PER_DISPATCH = 32768u;

COPPICE_CONST uint VPL_MARK_SPLIT = 1u;  ///< the values of WalkMark (gather/angle_walk.hpp)
COPPICE_CONST uint VPL_MARK_TAKE = 2u;

/// Joins the nodes below these heap ids, a workgroup each, and them. All below `levels` levels is there.
struct VplFilterParameters {
  COPPICE_ADDRESS(FilteredVplNodes) nodes;  ///< by heap id
  uint first;                               ///< heap id of the first workgroup's root
  uint levels;                              ///< 1 … VPL_FILTER_LEVELS, that of the root among them
};

/// The light of nodes at points. Sums and counters are 0 before the first dispatch.
struct VplGatherTask {
  COPPICE_ADDRESS(VplNodes) nodes;         ///< by heap id
  COPPICE_ADDRESS(GlossyPoints) points;    ///< by point
  COPPICE_ADDRESS(RadianceSums) radiance;  ///< by point
  COPPICE_ADDRESS(Counters) taken;         ///< by point: nodes evaluated
  COPPICE_ADDRESS(Counters) next;          ///< by point: where the next dispatch goes on
};

/// Gathering by solid angle. `next` is a heap id: 0 at the start, 1 after the end.
struct VplWalkParameters {
  VplGatherTask gather;
  COPPICE_ADDRESS(Words) marks;  ///< by heap id, a byte each
  DispatchRange range;           ///< of points
  uint leaf_count;               ///< a power of two
  uint has_marks;                ///< 0: every node is tested
  float nearest;                 ///< a node is split at distance² < nearest · area
};

/// Gathering by lists of nodes. `next` counts the nodes of the list that are done.
struct VplListsParameters {
  VplGatherTask gather;
  COPPICE_ADDRESS(Words) ends;   ///< by group: its list ends before this index
  COPPICE_ADDRESS(Words) lists;  ///< heap ids, one list after the other
  DispatchRange range;           ///< of points
};

COPPICE_END

#ifndef COPPICE_GLSL
namespace coppice {
static_assert(1u << (VPL_FILTER_LEVELS - 1) == KERNEL_GROUP_SIZE);
static_assert(offsetof(VplFilterParameters, levels) == 12);
static_assert(sizeof(VplGatherTask) == 40 && offsetof(VplGatherTask, next) == 32);
static_assert(offsetof(VplWalkParameters, range) == 48 && offsetof(VplWalkParameters, nearest) == 64);
static_assert(offsetof(VplListsParameters, lists) == 48 && offsetof(VplListsParameters, range) == 56);
static_assert(sizeof(VplWalkParameters) <= 128, "every device takes 128 bytes of push constants");
}  // namespace coppice
#endif
#endif
