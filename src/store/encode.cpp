#include "encode.hpp"

#include "items.hpp"
#include "mesh_arrays.hpp"

namespace coppice::store {
namespace {

void add_mesh(Encoder& e, const ReceiverMesh& mesh) {
  const MeshArrays arrays = arrays_of(mesh);
  e.count("corner_count", arrays.corner_count);
  e.count("stored_corner_count", arrays.corner_positions.size());
  e.count("root_count", arrays.root_corners.size());
  e.count("split_count", arrays.split_faces.size());
  e.count("child_count", arrays.children.size());
  e.count("middle_count", arrays.middles.size());
  e.rows("mesh/corner_position", arrays.corner_positions);
  e.rows("mesh/corner_normal", arrays.corner_normals);
  e.rows("mesh/root_corners", arrays.root_corners);
  e.rows("mesh/root_normal", arrays.root_normals);
  e.list("mesh/root_triangle", arrays.root_triangles);
  e.list("mesh/root_front", arrays.root_fronts);
  e.list("mesh/split_face", arrays.split_faces);
  e.list("mesh/split_children", arrays.split_children);
  e.list("mesh/child", arrays.children);
  e.list("mesh/middle", arrays.middles);
}

void add_receivers(Encoder& e, const std::vector<Receiver>& receivers, const std::vector<float>& scales) {
  constexpr std::size_t block = block_of_receivers;
  e.count("receiver_count", receivers.size());
  e.count("scale_count", scales.size());
  e.rows("receivers/position", gather<vec3>(receivers, [](const Receiver& r) { return r.position; }), block);
  e.rows("receivers/normal", gather<vec3>(receivers, [](const Receiver& r) { return r.normal; }), block);
  e.list("receivers/horizon", gather<float>(receivers, [](const Receiver& r) { return r.horizon; }), block);
  e.list("receivers/bend", gather<float>(receivers, [](const Receiver& r) { return r.bend; }), block);
  e.list("receivers/scale", scales, block);
}

template <Quantised Value>
void add_cuts(Encoder& e, const MaskedCuts<Value>& cuts, CutWeight weight) {
  const auto masks = cuts.masks();
  e.count("granule_log2", cuts.granule_log2());
  e.count("cosine_weight", weight == CutWeight::cosine);
  e.count("value_bits", 8 * sizeof(Value));
  e.count("value_count", cuts.values().size());
  e.contents.arrays.push_back(
      array_of("cuts/mask", {cuts.size(), cuts.words_per_cut()}, block_of_receivers, masks));
  e.contents.arrays.back().shuffled = false;
  e.contents.arrays.push_back(
      array_of("cuts/value", {cuts.values().size()}, block_of_elements, cuts.values()));
}

bool agree(const ReceiverHorizon& a, const ReceiverHorizon& b) {
  return a.normal == b.normal && a.cosine == b.cosine;
}

template <Quantised Value>
void require_invariants(const StoredVisibility<Value>& v) {
  const auto require = [](bool condition, const char* problem) {
    if (!condition)
      throw Refusal(std::string("cannot be written: ") + problem, "hand over what belongs together");
  };
  require(are_leaves(v.tree.light_of_leaf, v.lights.size()), "the tree is not one over the lights");
  require(v.mesh.corners().empty() || v.mesh.corners().size() == v.receivers.size(),
          "there is not one receiver a corner");
  require(v.cuts.size() == v.receivers.size(), "there is not one cut a receiver");
  require(v.cuts.leaf_count() == v.tree.leaf_count(), "the cuts are of another tree");
  require(v.scales.empty() || v.scales.size() == v.receivers.size(), "there is not one scale a receiver");
  for (std::size_t i = 0; i < v.receivers.size(); ++i)
    require(agree(v.cuts.horizons()[i], horizon_of(v.receivers[i], v.weight)),
            "a cut has not the horizon of its receiver under this weight");
}

}  // namespace

template <Quantised Value>
Contents encode(const StoredVisibility<Value>& visibility) {
  require_invariants(visibility);
  Encoder e;
  add_settings(e, visibility.settings);
  e.count("light_count", visibility.lights.size());
  e.count("leaf_count", visibility.tree.leaf_count());
  e.rows("lights", visibility.lights);
  e.list("light_of_leaf", visibility.tree.light_of_leaf);
  add_mesh(e, visibility.mesh);
  add_receivers(e, visibility.receivers, visibility.scales);
  add_cuts(e, visibility.cuts, visibility.weight);
  for (const Array& array : e.contents.arrays) require_finite(array);
  return std::move(e.contents);
}

template Contents encode(const StoredVisibility<std::uint8_t>&);
template Contents encode(const StoredVisibility<std::uint16_t>&);

}  // namespace coppice::store
