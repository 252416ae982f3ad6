// One invocation a word of a mask that the first pass made: the value of the product at each of its ends, in the
// same operations and order as on the CPU (CutMultiplier), which `precise` keeps from being fused.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference : require
#define COPPICE_GLSL
#include <coppice/shared/cut_product.h>

layout(local_size_x = KERNEL_GROUP_SIZE) in;
layout(push_constant, scalar) uniform Push { ProductValuesParameters parameters; };

#include "cut_product.glsl"

// Bytes on their way into words, the first and last of which may be shared with other invocations.
struct Packer {
  uint index;
  uint word;
};

void flush(Packer packer) { atomicOr(parameters.values.at[(packer.index - 1u) >> 2], packer.word); }

void put(inout Packer packer, uint value) {
  packer.word |= value << (8u * (packer.index & 3u));
  packer.index += 1u;
  if ((packer.index & 3u) != 0u) return;
  flush(packer);
  packer.word = 0u;
}

// The value of one of the factors' cuts at a granule.
float factor_value(uint cut, uint granule) {
  uint word = granule >> 5;
  uint before = factor_ends(cut, word) & ((1u << (granule & 31u)) - 1u);
  uint rank = parameters.product.factor_ranks.at[cut * parameters.words + word] + uint(bitCount(before));
  return float(byte_at(parameters.product.factors.values, rank));
}

float mean_of(uint f, uint granule) {
  precise float mean = 0.0;
  uint count = parameters.product.blends.at[f].count;
  for (uint i = 0u; i < count; ++i) {
    float value = factor_value(parameters.product.blends.at[f].cuts[i], granule);
    precise float weighted = parameters.product.blends.at[f].weights[i] * value;
    mean = mean + weighted;
  }
  return mean;
}

uint product_at(uint receiver, uint granule, uint base) {
  if (base == 0u) return 0u;
  precise float value = float(base);
  uint end = parameters.product.first_factor.at[receiver + 1u];
  for (uint f = parameters.product.first_factor.at[receiver]; f < end; ++f) {
    precise float share = mean_of(f, granule) * (1.0 / 255.0);
    value = value * share;
  }
  return uint(min(value, 255.0) + 0.5);
}

void main() {
  uint item = parameters.range.begin + gl_GlobalInvocationID.x;
  if (item >= parameters.range.end) return;
  uint receiver = item / parameters.words, word = item % parameters.words;
  uint base = base_ends(receiver, word);
  uint piece = parameters.base_ranks.at[item];
  Packer packer = Packer(parameters.ranks.at[item], 0u);
  for (uint ends = parameters.masks.at[item]; ends != 0u; ends &= ends - 1u) {
    uint granule = count_trailing_zeros(ends);
    put(packer, product_at(receiver, 32u * word + granule, base_value(piece)));
    piece += base >> granule & 1u;
  }
  if (packer.word != 0u) flush(packer);
}
