// One invocation a receiver: the ends of its product, which are those of all that is multiplied, but none
// inside pieces where the receiver's own cut is 0.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference : require
#define COPPICE_GLSL
#include <coppice/shared/cut_product.h>

layout(local_size_x = KERNEL_GROUP_SIZE) in;
layout(push_constant, scalar) uniform Push { ProductMasksParameters parameters; };

#include "cut_product.glsl"

uint ends_of_factors(uint receiver, uint word) {
  uint ends = 0u;
  uint end = parameters.product.first_factor.at[receiver + 1u];
  for (uint f = parameters.product.first_factor.at[receiver]; f < end; ++f) {
    uint count = parameters.product.blends.at[f].count;
    for (uint i = 0u; i < count; ++i) ends |= factor_ends(parameters.product.blends.at[f].cuts[i], word);
  }
  return ends;
}

// `piece` is that of the word's first granule before, and of the next word's first granule after.
uint ends_outside_dark(uint base, uint ends, inout uint piece) {
  uint kept = base;
  uint ahead = 0xffffffffu;
  for (; base != 0u; base &= base - 1u, ++piece) {
    uint inside = ahead & (base ^ (base - 1u));
    if (base_value(piece) != 0u) kept |= ends & inside;
    ahead &= ~inside;
  }
  if (ahead != 0u && base_value(piece) != 0u) kept |= ends & ahead;
  return kept;
}

void main() {
  uint receiver = parameters.range.begin + gl_GlobalInvocationID.x;
  if (receiver >= parameters.range.end) return;
  uint piece = parameters.product.base.first_value.at[receiver];
  uint count = 0u;
  for (uint word = 0u; word < parameters.words; ++word) {
    uint ends = ends_outside_dark(base_ends(receiver, word), ends_of_factors(receiver, word), piece);
    parameters.masks.at[receiver * parameters.words + word] = ends;
    count += uint(bitCount(ends));
  }
  parameters.counts.at[receiver] = count;
}
