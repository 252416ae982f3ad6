// What the kernels lattice_features, lattice_visibility, sample_light, light_project, light_mix and
// light_expand read and write: lights that move through a room, and the light that they cause there.
#ifndef COPPICE_SHARED_TRANSFER_H
#define COPPICE_SHARED_TRANSFER_H
#include <coppice/shared/cut_shade.h>

COPPICE_BEGIN

/// Products that a sample sums up in one dispatch at most. What is left over goes on in the next (as with
/// VPL_NODES_PER_DISPATCH).
COPPICE_CONST uint LATTICE_TERMS_PER_DISPATCH = 32768u;

/// Points of one light at most.
COPPICE_CONST uint LATTICE_POINTS = 4096u;

/// Points that share a load of coefficients.
COPPICE_CONST uint LATTICE_BLOCK = 4u;

/// The part of one cluster in fields of one signed byte a sample. A field of a cluster is as long as the
/// cluster has samples, filled up to whole words with zeros: four samples, a quad, to a word, the first
/// lowest. Clusters without samples or without fields are allowed.
struct FieldCluster {
  uint first_sample;
  uint end_sample;
  uint first_quad;  ///< quads of the clusters before
  uint first_field;
  uint end_field;
  uint first_word;  ///< of its first field; the others follow
};

/// Where the feature rows of one cluster lie.
struct LatticeClusterRows {
  uint first_word;  ///< of its FeatureIndex, in bits and in before
  uint first_byte;  ///< of its rows
};

/// What a LatticeCorners is to kernels.
struct LatticeCornerList {
  uint points[8];
  float weights[8];
  uint count;  ///< 0 … 8
};

/// A light as it shines on samples.
struct SampleLight {
  vec3 position;  ///< as that of a LocalLight, like the rest but where told
  float w;
  vec3 axis;
  float offset;
  vec3 intensity;
  float square;
  float softness;   ///< area / π
  float softening;  ///< squared: brightness falls as 1/√(d⁴ + softening²) in place of 1/d²; 0: as it is
};

/// Irradiance (W/m²) of a point of a surface that sees the light, at an intensity of 1 W/sr (path_to, and
/// softened as for light_by_visibility).
COPPICE_FUNCTION float sample_irradiance(SampleLight light, vec3 position, vec3 normal) {
  vec3 across = light.position - light.w * position;
  float along = dot(across, normal);
  if (!(along > 0.0f)) return 0.0f;
  float nearness = dot(across, across), distance2 = max(nearness, 1e-12f), distance = sqrt(distance2);
  float s = min(max(light.offset - dot(light.axis, across) / distance, 0.0f), 1.0f);
  float irradiance =
      s * (1.0f - light.square + light.square * s) * along / distance / (distance2 + light.softness);
  if (light.w > 0.0f && light.softening > 0.0f) {
    float ratio = nearness / light.softening;
    irradiance *=
        ratio < 1.0f ? ratio / sqrt(1.0f + ratio * ratio) : 1.0f / sqrt(1.0f + 1.0f / (ratio * ratio));
  }
  return irradiance;
}

COPPICE_END

#ifdef COPPICE_GLSL
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer FieldClusters {
  FieldCluster at[];
};
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer LatticeRows {
  LatticeClusterRows at[];
};
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer LatticeLists {
  LatticeCornerList at[];
};
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer SampleLights {
  SampleLight at[];
};
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer LatticeFeatures { vec4 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer SampleValues { float at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer SampleColours { vec3 at[]; };
#endif

COPPICE_BEGIN

/// Features of a block of points, an invocation for each cluster, block and component: as add_features().
struct LatticeFeaturesParameters {
  COPPICE_ADDRESS(LatticeRows) clusters;
  COPPICE_ADDRESS(Words) bits;                ///< of the clusters' FeatureIndex
  COPPICE_ADDRESS(Words) before;              ///< the same
  COPPICE_ADDRESS(Words) rows;                ///< signed bytes
  COPPICE_ADDRESS(Scales) scales;             ///< by cluster, then component
  COPPICE_ADDRESS(LatticeLists) points;       ///< of all lights
  COPPICE_ADDRESS(LatticeFeatures) features;  ///< by cluster, block, component: of LATTICE_BLOCK points each
  DispatchRange range;                        ///< of features
  uint rank;
  uint block_count;
  uint first_point;  ///< of the first block
  uint end_point;    ///< blocks are filled up with points that see nothing
  float known;       ///< 0: each point by itself; else one block with the sum of all, over this many
};

/// Visibility from a block of points, an invocation a quad.
struct LatticeVisibilityParameters {
  COPPICE_ADDRESS(FieldClusters) clusters;
  COPPICE_ADDRESS(Words) coefficients;  ///< a field a component
  COPPICE_ADDRESS(LatticeFeatures) features;
  COPPICE_ADDRESS(SampleValues) visibility;
  DispatchRange range;  ///< of quads
  uint cluster_count;
  uint rank;
  uint block_count;
  uint smooth_edges;  ///< 0: hard decisions
  float share;        ///< that one point, or all known ones where smooth, have in the light
  uint continues;     ///< 0: visibility starts anew
};

/// Direct irradiance of one light at the samples, an invocation each.
struct SampleLightParameters {
  COPPICE_ADDRESS(Positions) positions;
  COPPICE_ADDRESS(Positions) normals;
  COPPICE_ADDRESS(SampleValues) visibility;
  COPPICE_ADDRESS(SampleLights) lights;
  COPPICE_ADDRESS(SampleColours) direct;
  DispatchRange range;  ///< of samples
  uint light;
  uint continues;  ///< 0: the light of none before it is there
};

/// Coefficients of direct irradiance, a workgroup each (project()).
struct LightProjectParameters {
  COPPICE_ADDRESS(FieldClusters) clusters;
  COPPICE_ADDRESS(Words) values;               ///< a field a coefficient
  COPPICE_ADDRESS(Scales) scales;              ///< a field
  COPPICE_ADDRESS(Scales) offsets;             ///< a field
  COPPICE_ADDRESS(SampleColours) direct;       ///< a sample
  COPPICE_ADDRESS(SampleValues) coefficients;  ///< a channel after the other
  vec3 intensity;
  uint cluster_count;
  DispatchRange range;  ///< of coefficients: after those of the fields one for the mean, or none
  uint field_count;
  uint stride;      ///< from channel to channel
  uint is_centred;  ///< 0: no offsets
};

/// Weights of patterns, a workgroup each (mix()).
struct LightMixParameters {
  COPPICE_ADDRESS(Words) values;               ///< rows of row_words words, by channel, then pattern
  COPPICE_ADDRESS(Scales) scales;              ///< by channel, then pattern
  COPPICE_ADDRESS(SampleValues) coefficients;  ///< 4 · row_words a channel, filled up with zeros
  COPPICE_ADDRESS(SampleColours) weights;      ///< a pattern
  DispatchRange range;                         ///< of patterns
  uint pattern_count;
  uint row_words;
};

/// Indirect irradiance, an invocation a quad (expand()).
struct LightExpandParameters {
  COPPICE_ADDRESS(FieldClusters) clusters;
  COPPICE_ADDRESS(Words) values;            ///< a field a pattern
  COPPICE_ADDRESS(Scales) scales;           ///< a pattern
  COPPICE_ADDRESS(SampleColours) weights;   ///< a pattern
  COPPICE_ADDRESS(SampleColours) indirect;  ///< a sample
  DispatchRange range;                      ///< of quads
  uint cluster_count;
};

COPPICE_END

#ifndef COPPICE_GLSL
namespace coppice {
static_assert(sizeof(FieldCluster) == 24 && offsetof(FieldCluster, first_word) == 20);
static_assert(sizeof(LatticeClusterRows) == 8 && offsetof(LatticeClusterRows, first_byte) == 4);
static_assert(sizeof(LatticeCornerList) == 68 && offsetof(LatticeCornerList, count) == 64);
static_assert(sizeof(SampleLight) == 56 && offsetof(SampleLight, softening) == 52);
static_assert(sizeof(LatticeFeaturesParameters) == 88 && offsetof(LatticeFeaturesParameters, known) == 80);
static_assert(sizeof(LatticeVisibilityParameters) == 64 &&
              offsetof(LatticeVisibilityParameters, continues) == 60);
static_assert(sizeof(SampleLightParameters) == 56 && offsetof(SampleLightParameters, continues) == 52);
static_assert(sizeof(LightProjectParameters) == 88 && offsetof(LightProjectParameters, is_centred) == 80);
static_assert(sizeof(LightMixParameters) == 48 && offsetof(LightMixParameters, row_words) == 44);
static_assert(sizeof(LightExpandParameters) == 56 && offsetof(LightExpandParameters, cluster_count) == 48);
static_assert(sizeof(LatticeFeaturesParameters) <= 128, "every device takes 128 bytes of push constants");
}  // namespace coppice
#endif
#endif
