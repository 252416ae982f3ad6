// One workgroup a coefficient: a field's product with the direct light on its cluster.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference : require
#define COPPICE_GLSL
#include <coppice/shared/transfer.h>

layout(local_size_x = KERNEL_GROUP_SIZE) in;
layout(push_constant, scalar) uniform Push { LightProjectParameters parameters; };

#include "group_sum.glsl"
#include "sample_fields.glsl"

vec3 direct_light(uint sample_index, uint end) {
  if (sample_index >= end) return vec3(0.0);
  return parameters.direct.at[sample_index];
}

// The part of this invocation: every KERNEL_GROUP_SIZE-th quad. What fills up the last one meets no light.
vec3 part_of(uint field, FieldCluster cluster) {
  uint words = field_words(cluster), end = cluster.end_sample;
  uint first_word = cluster.first_word + (field - cluster.first_field) * words;
  vec3 sum = vec3(0.0);
  for (uint w = gl_LocalInvocationID.x; w < words; w += KERNEL_GROUP_SIZE) {
    vec4 values = signed_bytes(parameters.values.at[first_word + w]);
    uint i = cluster.first_sample + 4u * w;
    sum += values.x * direct_light(i, end) + values.y * direct_light(i + 1u, end) +
           values.z * direct_light(i + 2u, end) + values.w * direct_light(i + 3u, end);
  }
  return sum;
}

void main() {
  uint index = parameters.range.begin + gl_WorkGroupID.x;
  vec3 coefficient = parameters.intensity;
  if (index < parameters.field_count) {
    uint c = cluster_of(parameters.clusters, parameters.cluster_count, index, false);
    coefficient = parameters.scales.at[index] * sum_of_group(part_of(index, parameters.clusters.at[c]));
    if (parameters.is_centred != 0u) coefficient -= parameters.intensity * parameters.offsets.at[index];
  }
  if (gl_LocalInvocationID.x < 3u)
    parameters.coefficients.at[gl_LocalInvocationID.x * parameters.stride + index] =
        coefficient[gl_LocalInvocationID.x];
}
