// One invocation a component of a cluster and four points of a light: their features, which the coefficients of
// the cluster's samples are multiplied by.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference : require
#define COPPICE_GLSL
#include <coppice/shared/transfer.h>

layout(local_size_x = KERNEL_GROUP_SIZE) in;
layout(push_constant, scalar) uniform Push { LatticeFeaturesParameters parameters; };

// The row of a lattice point among those of a cluster.
uint row_of(LatticeClusterRows cluster, uint point) {
  uint word = parameters.bits.at[cluster.first_word + point / 32u], bit = 1u << (point % 32u);
  if ((word & bit) == 0u) return 0u;
  return 1u + parameters.before.at[cluster.first_word + point / 32u] + uint(bitCount(word & (bit - 1u)));
}

float row_value(LatticeClusterRows cluster, uint row, uint component) {
  uint byte = cluster.first_byte + row * parameters.rank + component;
  return float(int(parameters.rows.at[byte / 4u] << (24u - 8u * (byte % 4u))) >> 24);
}

float feature_of(uint cluster, uint component, uint point) {
  LatticeClusterRows rows = parameters.clusters.at[cluster];
  float scale = parameters.scales.at[cluster * parameters.rank + component], sum = 0.0;
  uint count = parameters.points.at[point].count;
  for (uint c = 0u; c < count; ++c) {
    uint row = row_of(rows, parameters.points.at[point].points[c]);
    sum += parameters.points.at[point].weights[c] * scale * row_value(rows, row, component);
  }
  return sum;
}

void main() {
  uint index = parameters.range.begin + gl_GlobalInvocationID.x;
  if (index >= parameters.range.end) return;
  uint component = index % parameters.rank, block = index / parameters.rank % parameters.block_count;
  uint cluster = index / parameters.rank / parameters.block_count;
  uint first = parameters.first_point + LATTICE_BLOCK * block;
  vec4 features = vec4(0.0);
  if (parameters.known > 0.0) {
    for (uint p = first; p < parameters.end_point; ++p) features.x += feature_of(cluster, component, p);
    features.x /= parameters.known;
  } else {
    uint end = min(first + LATTICE_BLOCK, parameters.end_point);
    for (uint p = first; p < end; ++p) features[p - first] = feature_of(cluster, component, p);
  }
  parameters.features.at[index] = features;
}
