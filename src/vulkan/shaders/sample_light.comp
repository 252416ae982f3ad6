// One invocation a sample: the direct irradiance that one light adds.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference : require
#define COPPICE_GLSL
#include <coppice/shared/transfer.h>

layout(local_size_x = KERNEL_GROUP_SIZE) in;
layout(push_constant, scalar) uniform Push { SampleLightParameters parameters; };

void main() {
  uint i = parameters.range.begin + gl_GlobalInvocationID.x;
  if (i >= parameters.range.end) return;
  vec3 direct = parameters.continues == 0u ? vec3(0.0) : parameters.direct.at[i];
  float visibility = parameters.visibility.at[i];
  if (visibility > 0.0) {
    SampleLight light = parameters.lights.at[parameters.light];
    float irradiance = sample_irradiance(light, parameters.positions.at[i], parameters.normals.at[i]);
    direct += visibility * irradiance * light.intensity;
  }
  parameters.direct.at[i] = direct;
}
