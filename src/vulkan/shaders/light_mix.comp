// One workgroup a pattern: its weights in the three channels.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference : require
#define COPPICE_GLSL
#include <coppice/shared/transfer.h>

layout(local_size_x = KERNEL_GROUP_SIZE) in;
layout(push_constant, scalar) uniform Push { LightMixParameters parameters; };

#include "group_sum.glsl"
#include "sample_fields.glsl"

vec4 squares(vec4 q) { return q * abs(q); }

vec4 coefficients(uint word) {
  uint i = 4u * word;
  return vec4(parameters.coefficients.at[i], parameters.coefficients.at[i + 1u],
              parameters.coefficients.at[i + 2u], parameters.coefficients.at[i + 3u]);
}

void main() {
  uint pattern = parameters.range.begin + gl_WorkGroupID.x, words = parameters.row_words;
  vec3 sum = vec3(0.0), scales;
  for (uint c = 0u; c < 3u; ++c) {
    uint row = c * parameters.pattern_count + pattern;
    for (uint w = gl_LocalInvocationID.x; w < words; w += KERNEL_GROUP_SIZE)
      sum[c] += dot(squares(signed_bytes(parameters.values.at[row * words + w])), coefficients(c * words + w));
    scales[c] = parameters.scales.at[row];
  }
  sum = sum_of_group(sum);
  if (gl_LocalInvocationID.x == 0u) parameters.weights.at[pattern] = scales * sum;
}
