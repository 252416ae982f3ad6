// One invocation a point: the union of the ends of four cuts, a word of 32 granules at a time.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference : require
#define COPPICE_GLSL
#include <coppice/shared/cut_shade.h>
#include <coppice/shared/brdf.h>
#include <coppice/shared/node.h>

layout(local_size_x = CUT_SHADE_GROUP_SIZE) in;
layout(push_constant, scalar) uniform Push { CutShadeParameters parameters; };

// A visibility cut on its way through the leaves.
struct VisibilityCut {
  uint first_word;
  uint ends;   // of the current word
  uint piece;  // index of the byte that covers the next leaf
  float value;
};

// A point, its viewer in its own frame, and the sum over clusters of power · visibility · term, a column a term.
struct Shading {
  ShadingPoint point;
  vec3 to_viewer;
  mat3 sums;
};

float visibility(uint piece) {
  return float(bitfieldExtract(parameters.values.at[piece >> 2], int(8u * (piece & 3u)), 8)) / 255.0;
}

VisibilityCut cut_of(uint receiver) {
  VisibilityCut cut;
  cut.first_word = receiver * words_per_cut(parameters.leaf_count, parameters.granule_log2);
  cut.ends = 0u;
  cut.piece = parameters.first_value.at[receiver];
  cut.value = visibility(cut.piece);
  return cut;
}

void read_word(inout VisibilityCut cut, uint word) {
  cut.ends = parameters.visibility_masks.at[cut.first_word + word];
}

// After the last end this reads the byte that follows, which the merge never uses.
void pass(inout VisibilityCut cut, uint granule) {
  if ((cut.ends >> (granule & 31u) & 1u) == 0u) return;
  cut.piece += 1u;
  cut.value = visibility(cut.piece);
}

Shading shading_of(ShadingPoint point) {
  return Shading(point, brdf_viewer_to_local(point.normal, point.tangent, point.to_viewer), mat3(0.0));
}

void add_node(inout Shading shading, uint begin, uint end, float v) {
  LightNode node = parameters.nodes.at[node_of_range(parameters.leaf_count, begin, end)];
  if (node.power == vec3(0.0)) return;
  ShadingPoint point = shading.point;
  vec3 to_light = brdf_to_local(point.normal, point.tangent, node.direction);
  BrdfTerms terms = brdf_terms(point.brdf, point.alpha_x, point.alpha_y, to_light.x, to_light.y, to_light.z,
                               shading.to_viewer);
  shading.sums += outerProduct(node.power * v, vec3(terms.diffuse, terms.specular, terms.fresnel));
}

// The ends of the illumination cut strictly inside the granule that begins at `begin`: bit i for begin + i + 1.
uint ends_inside(uint begin) {
  int count = (1 << parameters.granule_log2) - 1;
  return bitfieldExtract(parameters.illumination_ends.at[begin >> 5], int(begin & 31u), count);
}

void add_cluster(inout Shading shading, uint begin, uint end, float v) {
  bool is_granule = end - begin == 1u << parameters.granule_log2;
  uint inside = is_granule ? ends_inside(begin) : 0u;
  uint first = begin;
  do {
    uint last = inside != 0u ? begin + count_trailing_zeros(inside) + 1u : end;
    add_node(shading, first, last, v);
    first = last;
    inside &= inside - 1u;
  } while (first != end);
}

void add_all_clusters(inout Shading shading) {
  ShadingPoint point = shading.point;
  uvec3 receivers = parameters.faces.at[point.face].receivers;
  VisibilityCut a = cut_of(receivers.x), b = cut_of(receivers.y), c = cut_of(receivers.z);
  uint begin = 0u, words = words_per_cut(parameters.leaf_count, parameters.granule_log2);
  for (uint word = 0u; word < words; ++word) {
    read_word(a, word);
    read_word(b, word);
    read_word(c, word);
    uint ends = a.ends | b.ends | c.ends | parameters.illumination_granules.at[word];
    for (; ends != 0u; ends &= ends - 1u) {
      uint granule = 32u * word + count_trailing_zeros(ends);
      uint end = (granule + 1u) << parameters.granule_log2;
      float v = point.weight_0 * a.value + point.weight_1 * b.value +
                (1.0 - point.weight_0 - point.weight_1) * c.value;
      if (v != 0.0) add_cluster(shading, begin, end, v);
      pass(a, granule);
      pass(b, granule);
      pass(c, granule);
      begin = end;
    }
  }
}

void main() {
  uint index = parameters.first_point + gl_GlobalInvocationID.x;
  if (index >= parameters.end_point) return;
  ShadingPoint point = parameters.points.at[index];
  Shading shading = shading_of(point);
  add_all_clusters(shading);
  parameters.radiance.at[index] =
      point.diffuse * shading.sums[0] + point.specular * shading.sums[1] + point.fresnel * shading.sums[2];
}
