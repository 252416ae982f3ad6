// Shading by lights in the scene: their directions and spreads are those from the point that is shaded.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference : require
#define COPPICE_GLSL
#include <coppice/shared/cut_shade.h>

layout(push_constant, scalar) uniform Push { LocalCutShadeParameters parameters; };

#define NODE LocalLightNode

struct Receiver {
  float scale;
};

Receiver receiver_at(uint receiver) { return Receiver(parameters.scales.at[receiver]); }

float value_at(uint piece) {
  uint word = parameters.shading.cuts.values.at[piece >> 1];
  return float(bitfieldExtract(word, int(16u * (piece & 1u)), 16));
}

float visible_of(Receiver receiver, float value, LocalLightNode node) { return receiver.scale * value * value; }

vec3 position_at(uint point) { return parameters.positions.at[point]; }

vec3 vector_to(LocalLightNode node, vec3 position) { return node.position - node.w * position; }

float squared_length(vec3 v) { return max(dot(v, v), 1e-30); }

vec3 direction_to(LocalLightNode node, vec3 position) {
  vec3 v = vector_to(node, position);
  return v / sqrt(squared_length(v));
}

// 1 - |mean direction| to first order, as if positions varied alike along all axes (LocalLights).
float spread_of(LocalLightNode node, vec3 position) {
  return min(node.variance / (3.0 * squared_length(vector_to(node, position))), 0.99);
}

#include "shade_points.glsl"
