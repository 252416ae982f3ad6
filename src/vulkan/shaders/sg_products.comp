// One invocation a pair of a lobe and a cone: their product, and the mean of the lights under it.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference : require
#define COPPICE_GLSL
#include <coppice/shared/sg_kernels.h>

layout(local_size_x = KERNEL_GROUP_SIZE) in;
layout(push_constant, scalar) uniform Push { ProductsParameters parameters; };

void main() {
  uint index = parameters.range.begin + gl_GlobalInvocationID.x;
  if (index >= parameters.range.end) return;
  SgProduct product = sg_product(parameters.pairs.at[index].lobe, parameters.pairs.at[index].cone);
  SgShape shape = SgShape(product.axis, product.sharpness);
  float scale = sg_normalisation(shape.sharpness);
  vec3 mean = parameters.first_light == 0u ? vec3(0.0) : parameters.means.at[index].mean;
  for (uint i = parameters.first_light; i < parameters.end_light; ++i) {
    SgLight light = parameters.lights.at[i];
    mean += scale * sg_inner_product(shape, SgShape(light.axis, light.sharpness)) * light.amplitude;
  }
  parameters.means.at[index] = SgPairMean(mean, product.scale);
}
