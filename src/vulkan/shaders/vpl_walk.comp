// One invocation a point: a walk of the tree without a stack, which takes nodes of a small solid angle whole.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference : require
#define COPPICE_GLSL
#include <coppice/shared/vpl_gather.h>
#include <coppice/shared/node.h>

layout(local_size_x = KERNEL_GROUP_SIZE) in;
layout(push_constant, scalar) uniform Push { VplWalkParameters parameters; };

#include "vpl_reflect.glsl"

uint mark_of(uint h) {
  if (parameters.has_marks == 0u) return 0u;
  return bitfieldExtract(parameters.marks.at[h >> 2], int(8u * (h & 3u)), 8);
}

bool is_near(uint h, vec3 position) {
  vec3 apart = parameters.gather.nodes.at[h].position - position;
  return dot(apart, apart) < parameters.nearest * parameters.gather.nodes.at[h].area;
}

bool is_split(uint h, vec3 position) {
  if (h >= parameters.leaf_count) return false;
  uint mark = mark_of(h);
  return mark == VPL_MARK_SPLIT || (mark != VPL_MARK_TAKE && is_near(h, position));
}

// Where the walk goes on after a node, dark nodes passed over: 1 after the last.
uint visit(inout Gathering gathering, uint h) {
  if (!(parameters.gather.nodes.at[h].energy <= 0.0)) {
    if (is_split(h, gathering.point.position)) return 2u * h;
    add(gathering, parameters.gather.nodes.at[h]);
  }
  return node_after(h);
}

void main() {
  uint index = parameters.range.begin + gl_GlobalInvocationID.x;
  if (index >= parameters.range.end) return;
  uint h = parameters.gather.next.at[index];
  if (h == 1u) return;
  h = max(h, 1u);
  Gathering gathering = gathering_of(index);
  for (uint i = 0u; i < VPL_NODES_PER_DISPATCH; ++i) {
    h = visit(gathering, h);
    if (h == 1u) break;
  }
  parameters.gather.next.at[index] = h;
  store(gathering, index);
}
