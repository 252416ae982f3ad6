// One invocation a point: the union of the ends of four cuts, a word of 32 granules at a time, and below its
// clusters those of their descendants that a narrow lobe tells apart.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference : require
#define COPPICE_GLSL
#include <coppice/shared/cut_shade.h>
#include <coppice/shared/brdf_filtered.h>
#include <coppice/shared/node.h>

layout(local_size_x = CUT_SHADE_GROUP_SIZE) in;
layout(push_constant, scalar) uniform Push { CutShadeParameters parameters; };

// A visibility cut on its way through the leaves.
struct VisibilityCut {
  ReceiverHorizon horizon;
  uint first_word;
  uint ends;   // of the current word
  uint piece;  // index of the byte that covers the next leaf
  float value;
};

struct FaceCuts {
  VisibilityCut a, b, c;
};

// A point, its viewer in its own frame, and the sum over clusters of power · visibility · term, a column a term.
struct Shading {
  ShadingPoint point;
  vec3 to_viewer;
  vec3 weights;  // of the face's receivers
  mat3 sums;
  uint clusters;
  bool refines;  // replaces clusters whose error exceeds the limit
  float limit;
};

float visibility(uint piece) {
  return float(bitfieldExtract(parameters.values.at[piece >> 2], int(8u * (piece & 3u)), 8)) / 255.0;
}

VisibilityCut cut_of(uint receiver) {
  VisibilityCut cut;
  cut.horizon = parameters.horizons.at[receiver];
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

float visible_towards(VisibilityCut cut, vec3 direction) {
  return dot(cut.horizon.normal, direction) > cut.horizon.cosine ? cut.value : 0.0;
}

vec3 visible_towards(FaceCuts cuts, vec3 direction) {
  return vec3(visible_towards(cuts.a, direction), visible_towards(cuts.b, direction),
              visible_towards(cuts.c, direction));
}

bool is_seen(FaceCuts cuts) { return cuts.a.value + cuts.b.value + cuts.c.value > 0.0; }

float luminance(vec3 colour) { return dot(colour, vec3(0.2126, 0.7152, 0.0722)); }

Shading shading_of(ShadingPoint point) {
  Shading shading;
  shading.point = point;
  shading.to_viewer = brdf_viewer_to_local(point.normal, point.tangent, point.to_viewer);
  shading.weights = vec3(point.weight_0, point.weight_1, 1.0 - point.weight_0 - point.weight_1);
  shading.sums = mat3(0.0);
  shading.clusters = 0u;
  shading.refines = false;
  shading.limit = 0.0;
  return shading;
}

vec3 colour_of(Shading shading) {
  ShadingPoint point = shading.point;
  return point.diffuse * shading.sums[0] + point.specular * shading.sums[1] + point.fresnel * shading.sums[2];
}

// The BRDF's mean over a node's lights; at their mean direction where it is sampled, as if they were one.
FilteredTerms terms_of(Shading shading, LightNode node) {
  ShadingPoint point = shading.point;
  vec3 to_light = brdf_to_local(point.normal, point.tangent, node.direction);
  LightSpread spread = light_spread(parameters.lobes == CUT_SHADE_SAMPLED ? 0.0 : node.spread);
  return brdf_filtered_terms(point.brdf, point.alpha_x, point.alpha_y, to_light.x, to_light.y, to_light.z,
                             spread, shading.to_viewer);
}

// How much of the reflected light depends on which of the node's lights it comes from, as luminance.
float error_of(Shading shading, LightNode node, FilteredTerms terms, float v) {
  float specular =
      luminance(shading.point.specular) * terms.specular + luminance(shading.point.fresnel) * terms.fresnel;
  return luminance(node.power) * v * specular * terms.growth;
}

// What replaces a node: four grandchildren, or two children where these are leaves.
bool has_grandchildren(uint h) { return h < parameters.leaf_count / 2u; }

// The node after h and all below it, among the descendants of a cluster that replacements reach, depth-first;
// 0 after the last. All steps down are of two levels, but for a step of one to leaves.
uint next_below(uint cluster, uint h) {
  uint levels = (findMSB(h) - findMSB(cluster)) % 2 == 0 ? 2u : 1u;
  for (; h != cluster; h >>= levels, levels = 2u) {
    uint last = (1u << levels) - 1u;
    if ((h & last) != last) return h + 1u;
  }
  return 0u;
}

// Adds a cluster, or those of its descendants that are within the limit.
void add_refined(inout Shading shading, uint cluster, LightNode node, float v) {
  uint h = cluster;
  while (true) {
    FilteredTerms terms = terms_of(shading, node);
    if (shading.refines && error_of(shading, node, terms, v) > shading.limit) {
      uint below = has_grandchildren(h) ? 4u : 2u;
      shading.clusters += below;
      h *= below;
    } else {
      shading.sums += outerProduct(node.power * v, vec3(terms.diffuse, terms.specular, terms.fresnel));
      h = next_below(cluster, h);
    }
    if (h == 0u) return;
    node = parameters.nodes.at[h];
  }
}

void add_node(inout Shading shading, FaceCuts cuts, uint begin, uint end) {
  uint h = node_of_range(parameters.leaf_count, begin, end);
  LightNode node = parameters.nodes.at[h];
  if (node.power == vec3(0.0)) return;
  vec3 visible = visible_towards(cuts, node.direction);
  if (visible == vec3(0.0)) return;
  shading.clusters += 1u;
  add_refined(shading, h, node, dot(shading.weights, visible));
}

// The ends of the illumination cut strictly inside the granule that begins at `begin`: bit i for begin + i + 1.
uint ends_inside(uint begin) {
  int count = (1 << parameters.granule_log2) - 1;
  return bitfieldExtract(parameters.illumination_ends.at[begin >> 5], int(begin & 31u), count);
}

void add_piece(inout Shading shading, FaceCuts cuts, uint begin, uint end) {
  bool is_granule = end - begin == 1u << parameters.granule_log2;
  uint inside = is_granule ? ends_inside(begin) : 0u;
  uint first = begin;
  do {
    uint last = inside != 0u ? begin + count_trailing_zeros(inside) + 1u : end;
    add_node(shading, cuts, first, last);
    first = last;
    inside &= inside - 1u;
  } while (first != end);
}

void add_all_pieces(inout Shading shading) {
  uvec3 receivers = parameters.faces.at[shading.point.face].receivers;
  FaceCuts cuts = FaceCuts(cut_of(receivers.x), cut_of(receivers.y), cut_of(receivers.z));
  uint begin = 0u, words = words_per_cut(parameters.leaf_count, parameters.granule_log2);
  for (uint word = 0u; word < words; ++word) {
    read_word(cuts.a, word);
    read_word(cuts.b, word);
    read_word(cuts.c, word);
    uint ends = cuts.a.ends | cuts.b.ends | cuts.c.ends | parameters.illumination_granules.at[word];
    for (; ends != 0u; ends &= ends - 1u) {
      uint granule = 32u * word + count_trailing_zeros(ends);
      uint end = (granule + 1u) << parameters.granule_log2;
      if (is_seen(cuts)) add_piece(shading, cuts, begin, end);
      pass(cuts.a, granule);
      pass(cuts.b, granule);
      pass(cuts.c, granule);
      begin = end;
    }
  }
}

// Lambert's lobe tells no lights apart.
bool is_refined(ShadingPoint point) {
  return parameters.lobes == CUT_SHADE_REFINED && point.brdf >= BRDF_GGX && point.brdf <= BRDF_WARD;
}

// Of the light times that of the reflectance: a linear function of the sums.
float luminance_of(Shading shading) {
  ShadingPoint point = shading.point;
  return luminance(point.diffuse) * luminance(shading.sums[0]) +
         luminance(point.specular) * luminance(shading.sums[1]) +
         luminance(point.fresnel) * luminance(shading.sums[2]);
}

// Again from the start, now that the sum of all clusters tells how much error is too much.
void start_refining(inout Shading shading) {
  shading.limit = parameters.tolerance * luminance_of(shading);
  shading.refines = true;
  shading.sums = mat3(0.0);
  shading.clusters = 0u;
}

void main() {
  uint index = parameters.first_point + gl_GlobalInvocationID.x;
  if (index >= parameters.end_point) return;
  Shading shading = shading_of(parameters.points.at[index]);
  add_all_pieces(shading);
  if (is_refined(shading.point)) {
    start_refining(shading);
    add_all_pieces(shading);
  }
  parameters.radiance.at[index] = colour_of(shading);
  parameters.cluster_count.at[index] = shading.clusters;
}
