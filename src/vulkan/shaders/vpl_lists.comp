// One invocation a point: the nodes of its group's list.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference : require
#define COPPICE_GLSL
#include <coppice/shared/vpl_gather.h>

layout(local_size_x = KERNEL_GROUP_SIZE) in;
layout(push_constant, scalar) uniform Push { VplListsParameters parameters; };

#include "vpl_reflect.glsl"

uint first_of(uint group) { return group == 0u ? 0u : parameters.ends.at[group - 1u]; }

void main() {
  uint index = parameters.range.begin + gl_GlobalInvocationID.x;
  if (index >= parameters.range.end) return;
  uint group = parameters.gather.points.at[index].group;
  uint begin = first_of(group) + parameters.gather.next.at[index], end = parameters.ends.at[group];
  if (begin == end) return;
  uint count = min(end - begin, VPL_NODES_PER_DISPATCH);
  Gathering gathering = gathering_of(index);
  for (uint i = begin; i < begin + count; ++i)
    add(gathering, parameters.gather.nodes.at[parameters.lists.at[i]]);
  parameters.gather.next.at[index] += count;
  store(gathering, index);
}
