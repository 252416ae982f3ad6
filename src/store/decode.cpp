#include <algorithm>

#include "encode.hpp"
#include "items.hpp"
#include "mesh_arrays.hpp"

namespace coppice::store {
namespace {

ReceiverMesh read_mesh(Hdf5Reader& reader) {
  const std::uint32_t corners = small_count(reader, "stored_corner_count"),
                      roots = small_count(reader, "root_count"), splits = small_count(reader, "split_count"),
                      children = small_count(reader, "child_count"),
                      middles = small_count(reader, "middle_count");
  require(std::uint64_t(roots) + children < no_face, "the mesh has too many faces");
  MeshArrays arrays;
  arrays.corner_count = small_count(reader, "corner_count");
  arrays.corner_positions = rows<3, float>(reader, "mesh/corner_position", corners);
  arrays.corner_normals = rows<3, float>(reader, "mesh/corner_normal", corners);
  arrays.root_corners = rows<3, std::uint32_t>(reader, "mesh/root_corners", roots);
  arrays.root_normals = rows<3, float>(reader, "mesh/root_normal", roots);
  arrays.root_triangles = list<std::uint32_t>(reader, "mesh/root_triangle", roots);
  arrays.root_fronts = list<std::uint8_t>(reader, "mesh/root_front", roots);
  arrays.split_faces = list<std::uint32_t>(reader, "mesh/split_face", splits);
  arrays.split_children = list<std::uint8_t>(reader, "mesh/split_children", splits);
  arrays.children = list<std::uint8_t>(reader, "mesh/child", children);
  arrays.middles = list<std::uint32_t>(reader, "mesh/middle", middles);
  return mesh_of(arrays);
}

std::vector<Receiver> read_receivers(Hdf5Reader& reader) {
  const std::uint32_t count = small_count(reader, "receiver_count");
  const auto positions = rows<3, float>(reader, "receivers/position", count);
  const auto normals = rows<3, float>(reader, "receivers/normal", count);
  const auto horizons = list<float>(reader, "receivers/horizon", count);
  const auto bends = list<float>(reader, "receivers/bend", count);
  std::vector<Receiver> receivers;
  receivers.reserve(count);
  for (std::size_t i = 0; i < count; ++i)
    receivers.push_back({positions[i], normals[i], vec3(0), horizons[i], bends[i]});
  return receivers;
}

CutWeight read_weight(const Hdf5Reader& reader) {
  const std::uint64_t cosine = reader.count("cosine_weight");
  require(cosine <= 1, "attribute cosine_weight is neither 0 nor 1");
  return cosine == 1 ? CutWeight::cosine : CutWeight::uniform;
}

template <Quantised Value>
MaskedCuts<Value> read_cuts(Hdf5Reader& reader, std::uint32_t leaf_count, std::span<const Receiver> receivers,
                            CutWeight weight) {
  const std::uint64_t granule_log2 = reader.count("granule_log2");
  require(granule_log2 < 32 && leaf_count >> granule_log2 << granule_log2 == leaf_count,
          "attribute granule_log2 is " + std::to_string(granule_log2) + ": more than the tree has");
  const std::uint32_t words = MaskedCuts<Value>(leaf_count, std::uint32_t(granule_log2)).words_per_cut();
  const std::uint32_t value_count = small_count(reader, "value_count");
  auto masks = reader.array<std::uint32_t>("cuts/mask", {receivers.size(), words});
  auto values = reader.array<Value>("cuts/value", {value_count});
  std::vector<ReceiverHorizon> horizons;
  horizons.reserve(receivers.size());
  for (const Receiver& receiver : receivers) horizons.push_back(horizon_of(receiver, weight));
  auto cuts = MaskedCuts<Value>::from_arrays(leaf_count, std::uint32_t(granule_log2), std::move(masks),
                                             std::move(values), std::move(horizons));
  require(cuts.has_value(), "dataset cuts/mask has a mask that is no cut, or not one piece a value");
  return std::move(*cuts);
}

template <Quantised Value>
void require_value_width(const Hdf5Reader& reader) {
  const std::uint64_t bits = reader.count("value_bits");
  if (bits != 8 * sizeof(Value))
    throw Refusal("holds values of " + std::to_string(bits) + " bits, and " +
                      std::to_string(8 * sizeof(Value)) + " are asked for",
                  "read it as what it is, or compute it again");
}

}  // namespace

Settings decode_settings(Hdf5Reader& reader) {
  const auto text = reader.array<std::uint8_t>("settings", {small_count(reader, "setting_bytes")});
  std::vector<std::string> parts;
  for (auto begin = text.begin(); begin != text.end();) {
    const auto end = std::find(begin, text.end(), std::uint8_t(0));
    require(end != text.end(), "dataset settings breaks off");
    parts.emplace_back(begin, end);
    begin = end + 1;
  }
  require(parts.size() % 2 == 0, "dataset settings ends in a key without a value");
  Settings settings;
  for (std::size_t i = 0; i < parts.size(); i += 2) settings.push_back({parts[i], parts[i + 1]});
  return settings;
}

template <Quantised Value>
StoredVisibility<Value> decode(Hdf5Reader& reader) {
  require_value_width<Value>(reader);
  StoredVisibility<Value> v;
  v.settings = decode_settings(reader);
  v.lights = rows<4, float>(reader, "lights", small_count(reader, "light_count"));
  auto light_of_leaf = list<std::uint32_t>(reader, "light_of_leaf", small_count(reader, "leaf_count"));
  require(are_leaves(light_of_leaf, v.lights.size()),
          "dataset light_of_leaf does not place every light once");
  v.tree = tree_over(std::move(light_of_leaf));
  v.mesh = read_mesh(reader);
  v.receivers = read_receivers(reader);
  require(v.mesh.corners().empty() || v.mesh.corners().size() == v.receivers.size(),
          "attribute receiver_count is not the number of corners");
  v.scales = list<float>(reader, "receivers/scale", small_count(reader, "scale_count"));
  require(v.scales.empty() || v.scales.size() == v.receivers.size(),
          "attribute scale_count is not that of receivers");
  v.weight = read_weight(reader);
  v.cuts = read_cuts<Value>(reader, v.tree.leaf_count(), v.receivers, v.weight);
  return v;
}

template StoredVisibility<std::uint8_t> decode(Hdf5Reader&);
template StoredVisibility<std::uint16_t> decode(Hdf5Reader&);

}  // namespace coppice::store
