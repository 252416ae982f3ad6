// One workgroup a Gaussian of a level: its amplitude after one Jacobi pass.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference : require
#define COPPICE_GLSL
#include <coppice/shared/sg_kernels.h>

layout(local_size_x = KERNEL_GROUP_SIZE) in;
layout(push_constant, scalar) uniform Push { FitPassParameters parameters; };

#include "group_sum.glsl"

void main() {
  uint row = gl_WorkGroupID.x;
  uint end = parameters.model.begins.at[row + 1u];
  vec3 sum = vec3(0.0);
  for (uint e = parameters.model.begins.at[row] + gl_LocalInvocationID.x; e < end; e += KERNEL_GROUP_SIZE)
    sum += parameters.model.values.at[e] * parameters.from.at[parameters.model.columns.at[e]];
  sum = sum_of_group(sum);
  uint own = parameters.first_gaussian + row;
  if (gl_LocalInvocationID.x == 0u)
    parameters.to.at[own] = parameters.from.at[own] + parameters.step * (parameters.means.at[row] - sum);
}
