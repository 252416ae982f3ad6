// One invocation four samples: how much of a light they see.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference : require
#define COPPICE_GLSL
#include <coppice/shared/transfer.h>

layout(local_size_x = KERNEL_GROUP_SIZE) in;
layout(push_constant, scalar) uniform Push { LatticeVisibilityParameters parameters; };

#include "sample_fields.glsl"

vec4 above_zero(vec4 margins) { return vec4(greaterThan(margins, vec4(0.0))); }

// Points of a block that each of the four samples sees. `word` is where the samples' coefficients begin. Written
// out, as drivers count the passes of loops.
vec4 seen_of_block(uint word, uint words, uint first_feature) {
  vec4 a = vec4(0.0), b = vec4(0.0), c = vec4(0.0), d = vec4(0.0);
  for (uint k = 0u; k < parameters.rank; ++k) {
    vec4 coefficients = signed_bytes(parameters.coefficients.at[word + k * words]);
    vec4 features = parameters.features.at[first_feature + k];
    a += features.x * coefficients;
    b += features.y * coefficients;
    c += features.z * coefficients;
    d += features.w * coefficients;
  }
  if (parameters.smooth_edges != 0u) return clamp(0.5 * a + 0.5, 0.0, 1.0);
  return above_zero(a) + above_zero(b) + above_zero(c) + above_zero(d);
}

void main() {
  uint quad = parameters.range.begin + gl_GlobalInvocationID.x;
  if (quad >= parameters.range.end) return;
  uint index = cluster_of(parameters.clusters, parameters.cluster_count, quad, true);
  FieldCluster cluster = parameters.clusters.at[index];
  uint word = quad - cluster.first_quad, words = field_words(cluster);
  uint first_feature = index * parameters.block_count * parameters.rank;
  vec4 seen = vec4(0.0);
  for (uint b = 0u; b < parameters.block_count; ++b)
    seen += seen_of_block(cluster.first_word + word, words, first_feature + b * parameters.rank);
  uint first = cluster.first_sample + 4u * word, count = min(cluster.end_sample - first, 4u);
  for (uint i = 0u; i < count; ++i) {
    float before = parameters.continues == 0u ? 0.0 : parameters.visibility.at[first + i];
    parameters.visibility.at[first + i] = before + parameters.share * seen[i];
  }
}
