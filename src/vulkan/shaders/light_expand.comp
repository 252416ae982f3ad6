// One invocation four samples: the sum of their cluster's patterns.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference : require
#define COPPICE_GLSL
#include <coppice/shared/transfer.h>

layout(local_size_x = KERNEL_GROUP_SIZE) in;
layout(push_constant, scalar) uniform Push { LightExpandParameters parameters; };

#include "sample_fields.glsl"

void main() {
  uint quad = parameters.range.begin + gl_GlobalInvocationID.x;
  if (quad >= parameters.range.end) return;
  FieldCluster cluster =
      parameters.clusters.at[cluster_of(parameters.clusters, parameters.cluster_count, quad, true)];
  uint word = quad - cluster.first_quad, words = field_words(cluster);
  mat4x3 light = mat4x3(0.0);  // a column a sample
  for (uint f = cluster.first_field; f < cluster.end_field; ++f) {
    uint at = cluster.first_word + (f - cluster.first_field) * words + word;
    vec4 values = signed_bytes(parameters.values.at[at]);
    light += outerProduct(parameters.scales.at[f] * parameters.weights.at[f], values);
  }
  uint first = cluster.first_sample + 4u * word, count = min(cluster.end_sample - first, 4u);
  for (uint i = 0u; i < count; ++i) parameters.indirect.at[first + i] = light[i];
}
