// Several levels of a tree of VPLs, from the lowest up: a workgroup joins the nodes below one heap id.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference : require
#define COPPICE_GLSL
#include <coppice/shared/vpl_gather.h>

layout(local_size_x = KERNEL_GROUP_SIZE) in;
layout(push_constant, scalar) uniform Push { VplFilterParameters parameters; };

void join(uint h) {
  parameters.nodes.at[h] = vpl_cluster(parameters.nodes.at[2u * h], parameters.nodes.at[2u * h + 1u]);
}

void main() {
  uint root = parameters.first + gl_WorkGroupID.x;
  for (uint level = parameters.levels; level-- > 0u;) {
    uint i = gl_LocalInvocationID.x;
    if (i < 1u << level) join((root << level) + i);
    memoryBarrierBuffer();
    barrier();
  }
}
