// One invocation a cut: where the values of every word of its mask begin.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference : require
#define COPPICE_GLSL
#include <coppice/shared/cut_product.h>

layout(local_size_x = KERNEL_GROUP_SIZE) in;
layout(push_constant, scalar) uniform Push { CutRanksParameters parameters; };

void main() {
  uint cut = parameters.range.begin + gl_GlobalInvocationID.x;
  if (cut >= parameters.range.end) return;
  uint rank = parameters.first_value.at[cut];
  uint first_word = cut * parameters.words;
  for (uint word = first_word; word < first_word + parameters.words; ++word) {
    parameters.ranks.at[word] = rank;
    rank += uint(bitCount(parameters.masks.at[word]));
  }
}
