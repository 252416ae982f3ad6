// One invocation a point: the union of the ends of four cuts, a word of 32 granules at a time, and below its
// clusters those of their descendants that a narrow lobe tells apart. Who includes this has defined
//   NODE      a node of the lights' tree, one of the structs of layout.h
//   Receiver  what a receiver knows besides its cut
//   parameters, receiver_at(), value_at(), visible_of(), position_at(), direction_to(), spread_of()
#include <coppice/shared/brdf_filtered.h>
#include <coppice/shared/node.h>

layout(local_size_x = KERNEL_GROUP_SIZE) in;

// A visibility cut on its way through the leaves.
struct VisibilityCut {
  Receiver receiver;
  uint first_word;
  uint ends;   // of the current word
  uint piece;  // index of the value that covers the next leaf
  float value;
};

struct FaceCuts {
  VisibilityCut a, b, c;
};

// A point, its viewer in its own frame, and the sum over clusters of power · visibility · term, a column a term.
struct Shading {
  ShadingPoint point;
  vec3 position;
  vec3 to_viewer;
  vec3 weights;  // of the face's receivers
  mat3 sums;
  uint clusters;
  bool refines;  // replaces clusters whose error exceeds the limit
  float limit;
};

uint leaf_count() { return parameters.shading.leaf_count; }
uint granule_log2() { return parameters.shading.granule_log2; }
uint word_count() { return words_per_cut(leaf_count(), granule_log2()); }

VisibilityCut cut_of(uint receiver) {
  VisibilityCut cut;
  cut.receiver = receiver_at(receiver);
  cut.first_word = receiver * word_count();
  cut.ends = 0u;
  cut.piece = parameters.shading.cuts.first_value.at[receiver];
  cut.value = value_at(cut.piece);
  return cut;
}

void read_word(inout VisibilityCut cut, uint word) {
  cut.ends = parameters.shading.cuts.masks.at[cut.first_word + word];
}

// After the last end this reads the value that follows, which the merge never uses.
void pass(inout VisibilityCut cut, uint granule) {
  if ((cut.ends >> (granule & 31u) & 1u) == 0u) return;
  cut.piece += 1u;
  cut.value = value_at(cut.piece);
}

vec3 visible_of(FaceCuts cuts, NODE node) {
  return vec3(visible_of(cuts.a.receiver, cuts.a.value, node), visible_of(cuts.b.receiver, cuts.b.value, node),
              visible_of(cuts.c.receiver, cuts.c.value, node));
}

bool is_seen(FaceCuts cuts) { return cuts.a.value + cuts.b.value + cuts.c.value > 0.0; }

float luminance(vec3 colour) { return dot(colour, vec3(0.2126, 0.7152, 0.0722)); }

Shading shading_of(uint index) {
  ShadingPoint point = parameters.shading.points.at[index];
  Shading shading;
  shading.point = point;
  shading.position = position_at(index);
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
FilteredTerms terms_of(Shading shading, NODE node) {
  ShadingPoint point = shading.point;
  vec3 to_light = brdf_to_local(point.normal, point.tangent, direction_to(node, shading.position));
  bool is_sampled = parameters.shading.lobes == CUT_SHADE_SAMPLED;
  LightSpread spread = light_spread(is_sampled ? 0.0 : spread_of(node, shading.position));
  return brdf_filtered_terms(point.brdf, point.alpha_x, point.alpha_y, to_light.x, to_light.y, to_light.z,
                             spread, shading.to_viewer);
}

// How much of the reflected light depends on which of the node's lights it comes from, as luminance.
float error_of(Shading shading, NODE node, FilteredTerms terms, float v) {
  float specular =
      luminance(shading.point.specular) * terms.specular + luminance(shading.point.fresnel) * terms.fresnel;
  return luminance(node.power) * v * specular * terms.growth;
}

// What replaces a node: four grandchildren, or two children where these are leaves.
bool has_grandchildren(uint h) { return h < leaf_count() / 2u; }

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
void add_refined(inout Shading shading, uint cluster, NODE node, float v) {
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
  uint h = node_of_range(leaf_count(), begin, end);
  NODE node = parameters.nodes.at[h];
  if (node.power == vec3(0.0)) return;
  vec3 visible = visible_of(cuts, node);
  if (visible == vec3(0.0)) return;
  shading.clusters += 1u;
  add_refined(shading, h, node, dot(shading.weights, visible));
}

// The ends of the illumination cut strictly inside the granule that begins at `begin`: bit i for begin + i + 1.
uint ends_inside(uint begin) {
  int count = (1 << granule_log2()) - 1;
  return bitfieldExtract(parameters.shading.illumination_ends.at[begin >> 5], int(begin & 31u), count);
}

void add_piece(inout Shading shading, FaceCuts cuts, uint begin, uint end) {
  bool is_granule = end - begin == 1u << granule_log2();
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
  uvec3 receivers = parameters.shading.faces.at[shading.point.face].receivers;
  FaceCuts cuts = FaceCuts(cut_of(receivers.x), cut_of(receivers.y), cut_of(receivers.z));
  uint begin = 0u;
  for (uint word = 0u; word < word_count(); ++word) {
    read_word(cuts.a, word);
    read_word(cuts.b, word);
    read_word(cuts.c, word);
    uint ends = cuts.a.ends | cuts.b.ends | cuts.c.ends | parameters.shading.illumination_granules.at[word];
    for (; ends != 0u; ends &= ends - 1u) {
      uint granule = 32u * word + count_trailing_zeros(ends);
      uint end = (granule + 1u) << granule_log2();
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
  return parameters.shading.lobes == CUT_SHADE_REFINED && point.brdf >= BRDF_GGX && point.brdf <= BRDF_WARD;
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
  shading.limit = parameters.shading.tolerance * luminance_of(shading);
  shading.refines = true;
  shading.sums = mat3(0.0);
  shading.clusters = 0u;
}

void main() {
  uint index = parameters.range.begin + gl_GlobalInvocationID.x;
  if (index >= parameters.range.end) return;
  Shading shading = shading_of(index);
  add_all_pieces(shading);
  if (is_refined(shading.point)) {
    start_refining(shading);
    add_all_pieces(shading);
  }
  parameters.shading.radiance.at[index] = colour_of(shading);
  parameters.shading.cluster_count.at[index] = shading.clusters;
}
