// What the kernels sg_fit_means, sg_fit_pass, sg_cones and sg_products read and write.
#ifndef COPPICE_SHARED_SG_KERNELS_H
#define COPPICE_SHARED_SG_KERNELS_H
#include <coppice/shared/cones.h>
#include <coppice/shared/cut_shade.h>
#include <coppice/shared/voxel.h>

COPPICE_BEGIN

/// Lights that one dispatch gives to a product at most. What is left over goes on in the next (as with
/// VPL_NODES_PER_DISPATCH).
COPPICE_CONST uint SG_LIGHTS_PER_DISPATCH = 32768u;

/// Steps that all rays of a cone may take together: drivers end kernels whose loops are longer.
COPPICE_CONST uint SG_STEPS_PER_CONE = 32768u;

/// Rays of a cone that a byte can close.
COPPICE_CONST uint SG_CONTACT_RAYS = 8u;

COPPICE_CONST float SG_TURN_COSINE = -0.73736882f;  ///< of VOXEL_TURN
COPPICE_CONST float SG_TURN_SINE = 0.67549036f;

/// What an EnvironmentCell is to kernels.
struct FitCell {
  vec3 energy;
  vec3 centre;  ///< unit
};

/// A Gaussian lobe of a BRDF, and a cone: what of the lights is under both.
struct SgPair {
  SgShape lobe;
  SgShape cone;
};

/// The product of a pair is scale · G. ∫ lobe · cone · light, summed over all lights, is mean · scale · ∫ G.
struct SgPairMean {
  vec3 mean;  ///< radiance: Σ amplitude ∫ light G / ∫ G
  float scale;
};

/// How a batch of cones is traced.
struct ConeSettings {
  VoxelGrid grid;
  VoxelTrace trace;
};

COPPICE_END

#ifdef COPPICE_GLSL
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer FitCells { FitCell at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer SgLights { SgLight at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer SgShapes { SgShape at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer SgPairs { SgPair at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer SgPairMeans { SgPairMean at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ConeReceivers {
  ConeReceiver at[];
};
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ConeSettingsOfBatch {
  ConeSettings at[];
};
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer ConeVisibilities {
  float at[];
};
#endif

COPPICE_BEGIN

/// A sparse matrix, row by row: row i has the entries begins[i] … begins[i + 1] - 1.
struct SparseMatrix {
  COPPICE_ADDRESS(Words) begins;
  COPPICE_ADDRESS(Words) columns;
  COPPICE_ADDRESS(Scales) values;
};

/// Means under the windows of one level of a fit, a workgroup each, of the cells less the peaks
/// (FitLevel::means).
struct FitMeansParameters {
  SparseMatrix windows;                ///< over cells
  COPPICE_ADDRESS(FitCells) cells;     ///< by cell
  COPPICE_ADDRESS(Positions) centres;  ///< by cell: where it lies if its light is even
  COPPICE_ADDRESS(Positions) axes;     ///< by window
  COPPICE_ADDRESS(SgLights) peaks;
  COPPICE_ADDRESS(Radiance) means;  ///< by window
  float sharpness;                  ///< of the windows
  uint peak_count;
};

/// One Jacobi pass over a level, a workgroup an amplitude (FitLevel::solve).
struct FitPassParameters {
  SparseMatrix model;                ///< over the Gaussians of the levels before and this
  COPPICE_ADDRESS(Positions) means;  ///< by row
  COPPICE_ADDRESS(Positions) from;   ///< amplitudes by Gaussian of all levels, before the pass
  COPPICE_ADDRESS(Radiance) to;      ///< after it: only this level's are written
  float step;                        ///< that a difference of means is multiplied by
  uint first_gaussian;               ///< of the level
};

/// The visibility of the cones of some receivers, an invocation each.
struct ConesParameters {
  COPPICE_ADDRESS(ConeSettingsOfBatch) settings;  ///< one; its trace.start is where marches begin
  COPPICE_ADDRESS(Words) slots;                   ///< as VoxelGrid tells
  COPPICE_ADDRESS(Words) distances;               ///< the same, and a word that is not used
  COPPICE_ADDRESS(ConeReceivers) receivers;
  COPPICE_ADDRESS(SgShapes) cones;
  COPPICE_ADDRESS(Words) closed;                 ///< by cone, a byte each: bit k is set where ray k is closed
  COPPICE_ADDRESS(ConeVisibilities) visibility;  ///< by cone
  DispatchRange range;                           ///< of cones
  uint receiver_count;
  uint before;      ///< cones of the batch before the first: ConeReceiver::cones_end counts them
  uint has_closed;  ///< 0: all rays are open at their start
};

/// The light under products of Gaussians, an invocation a pair.
struct ProductsParameters {
  COPPICE_ADDRESS(SgLights) lights;
  COPPICE_ADDRESS(SgPairs) pairs;
  COPPICE_ADDRESS(SgPairMeans) means;  ///< by pair
  DispatchRange range;                 ///< of pairs
  uint first_light;                    ///< the dispatch sums up the lights from here; at 0 it starts anew
  uint end_light;
};

COPPICE_END

#ifndef COPPICE_GLSL
namespace coppice {
static_assert(sizeof(FitCell) == 24 && offsetof(FitCell, centre) == 12);
static_assert(sizeof(SgPair) == 32 && offsetof(SgPair, cone) == 16);
static_assert(sizeof(SgPairMean) == 16 && offsetof(SgPairMean, scale) == 12);
static_assert(sizeof(ConeSettings) == 68 && offsetof(ConeSettings, trace) == 36);
static_assert(sizeof(SparseMatrix) == 24 && offsetof(SparseMatrix, values) == 16);
static_assert(sizeof(FitMeansParameters) == 72 && offsetof(FitMeansParameters, peak_count) == 68);
static_assert(sizeof(FitPassParameters) == 56 && offsetof(FitPassParameters, first_gaussian) == 52);
static_assert(sizeof(ConesParameters) == 80 && offsetof(ConesParameters, has_closed) == 72);
static_assert(sizeof(ProductsParameters) == 40 && offsetof(ProductsParameters, end_light) == 36);
static_assert(sizeof(ConesParameters) <= 128, "every device takes 128 bytes of push constants");
}  // namespace coppice
#endif
#endif
