// One workgroup a window: the mean of an environment's cells under it, less that of the peaks.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference : require
#define COPPICE_GLSL
#include <coppice/shared/sg_kernels.h>

layout(local_size_x = KERNEL_GROUP_SIZE) in;
layout(push_constant, scalar) uniform Push { FitMeansParameters parameters; };

#include "group_sum.glsl"

// The window taken to where the cell's light lies: e^t to second order.
vec3 weighted_cell(uint entry, vec3 slope) {
  uint j = parameters.windows.columns.at[entry];
  float t = dot(slope, parameters.cells.at[j].centre - parameters.centres.at[j]);
  return parameters.windows.values.at[entry] * (1.0 + t * (1.0 + 0.5 * t)) * parameters.cells.at[j].energy;
}

void main() {
  uint row = gl_WorkGroupID.x;
  SgShape window = SgShape(parameters.axes.at[row], parameters.sharpness);
  vec3 slope = window.sharpness * window.axis, sum = vec3(0.0);
  uint end = parameters.windows.begins.at[row + 1u];
  for (uint e = parameters.windows.begins.at[row] + gl_LocalInvocationID.x; e < end; e += KERNEL_GROUP_SIZE)
    sum += weighted_cell(e, slope);
  float scale = sg_normalisation(window.sharpness);
  for (uint i = gl_LocalInvocationID.x; i < parameters.peak_count; i += KERNEL_GROUP_SIZE) {
    SgLight peak = parameters.peaks.at[i];
    sum -= scale * sg_inner_product(window, SgShape(peak.axis, peak.sharpness)) * peak.amplitude;
  }
  sum = sum_of_group(sum);
  if (gl_LocalInvocationID.x == 0u) parameters.means.at[row] = sum;
}
