// Shading by distant lights: their directions are the same for all points, and each receiver has a horizon.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference : require
#define COPPICE_GLSL
#include <coppice/shared/cut_shade.h>

layout(push_constant, scalar) uniform Push { CutShadeParameters parameters; };

#define NODE LightNode

struct Receiver {
  ReceiverHorizon horizon;
};

Receiver receiver_at(uint receiver) { return Receiver(parameters.horizons.at[receiver]); }

float value_at(uint piece) {
  uint word = parameters.shading.cuts.values.at[piece >> 2];
  return float(bitfieldExtract(word, int(8u * (piece & 3u)), 8)) / 255.0;
}

float visible_of(Receiver receiver, float value, LightNode node) {
  return dot(receiver.horizon.normal, node.direction) > receiver.horizon.cosine ? value : 0.0;
}

vec3 position_at(uint point) { return vec3(0.0); }
vec3 direction_to(LightNode node, vec3 position) { return node.direction; }
float spread_of(LightNode node, vec3 position) { return node.spread; }

#include "shade_points.glsl"
