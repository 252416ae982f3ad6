#include "encode.hpp"
#include "items.hpp"
#include "room.hpp"

namespace coppice::store {
namespace {

/// Of a list of ends, before anything is measured by it.
std::vector<std::uint32_t> ends(Hdf5Reader& reader, const std::string& name, std::uint32_t clusters,
                                std::uint32_t last) {
  auto values = list<std::uint32_t>(reader, name.c_str(), clusters);
  require(std::ranges::is_sorted(values) && (values.empty() ? 0 : values.back()) == last,
          "dataset " + name + " does not ascend to " + std::to_string(last));
  return values;
}

std::uint32_t size_of_cluster(std::span<const std::uint32_t> ends, std::size_t cluster) {
  return ends[cluster] - (cluster == 0 ? 0 : ends[cluster - 1]);
}

ClusteredSamples read_samples(Hdf5Reader& reader) {
  const std::uint32_t count = small_count(reader, "sample_count");
  ClusteredSamples clustered;
  clustered.ends = ends(reader, "samples/cluster_end", small_count(reader, "cluster_count"), count);
  const auto positions = rows<3, float>(reader, "samples/position", count);
  const auto normals = rows<3, float>(reader, "samples/normal", count);
  const auto colours = rows<3, float>(reader, "samples/colour", count);
  const auto areas = list<float>(reader, "samples/area", count);
  const auto triangles = list<std::uint32_t>(reader, "samples/triangle", count);
  const auto fronts = list<std::uint8_t>(reader, "samples/front", count);
  const auto uvs = rows<2, float>(reader, "samples/barycentric", count);
  clustered.samples.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    require(fronts[i] <= 1, "dataset samples/front has a side that is neither front nor back");
    clustered.samples.push_back(
        {positions[i], areas[i], normals[i], colours[i], {triangles[i], fronts[i] == 1}, uvs[i].x, uvs[i].y});
  }
  return clustered;
}

LightLattice read_lattice(Hdf5Reader& reader) {
  LightLattice lattice;
  constexpr std::uint32_t most = 1u << 30;
  std::uint64_t places = 1;
  for (int k = 0; k < 3; ++k) {
    const char* name = k == 0 ? "lattice_x" : k == 1 ? "lattice_y" : "lattice_z";
    const std::uint32_t size = small_count(reader, name);
    require(size < most, "attribute " + std::string(name) + " is " + std::to_string(size) + ": too many");
    lattice.size[k] = int(size);
    places *= size;
    require(places < no_light, "the lattice has too many places");
  }
  const auto place = list<float>(reader, "lattice/place", 4);
  lattice.origin = {place[0], place[1], place[2]}, lattice.spacing = place[3];
  lattice.numbers = list<std::uint32_t>(reader, "lattice/number", places);
  lattice.positions = rows<3, float>(reader, "lattice/position", small_count(reader, "lattice_point_count"));
  return lattice;
}

/// The next `count` of the values.
template <class T>
std::vector<T> take(const std::vector<T>& values, std::size_t& at, std::size_t count) {
  const auto first = values.begin() + std::ptrdiff_t(at);
  at += count;
  return {first, first + std::ptrdiff_t(count)};
}

template <class Integer>
LatticeVisibility<Integer> read_visibility(Hdf5Reader& reader, const ClusteredSamples& samples) {
  LatticeVisibility<Integer> v{
      read_lattice(reader), small_count(reader, "visibility_rank"), samples.ends, {}};
  const std::size_t clusters = samples.ends.size(), words = (v.lattice.count() + 31) / 32;
  const auto bits = table<std::uint32_t>(reader, "visibility/index", clusters, words);
  const auto scales = table<float>(reader, "visibility/scale", clusters, v.rank);
  const auto coefficients = list<Integer>(reader, "visibility/coefficient", v.rank * samples.size());
  std::vector<std::uint64_t> counts;
  std::uint64_t row_sum = 0;
  for (std::size_t c = 0; c < clusters; ++c)
    row_sum += counts.emplace_back(row_count(std::span(bits).subspan(c * words, words)));
  const auto rows = table<Integer>(reader, "visibility/row", row_sum, v.rank);
  std::size_t bit = 0, scale = 0, coefficient = 0, row = 0;
  for (std::size_t c = 0; c < clusters; ++c) {
    LatticeCluster<Integer>& cluster = v.clusters.emplace_back();
    cluster.index = index_of(take(bits, bit, words));
    cluster.scales = take(scales, scale, v.rank);
    cluster.coefficients = take(coefficients, coefficient, v.rank * samples.size(c));
    cluster.rows = take(rows, row, v.rank * counts[c]);
  }
  return v;
}

StoredLightVisibility read_light_visibility(Hdf5Reader& reader, const ClusteredSamples& samples) {
  switch (const std::uint64_t bits = reader.count("visibility_bits")) {
    case 0:
      return std::monostate();
    case 8:
      return read_visibility<std::int8_t>(reader, samples);
    case 16:
      return read_visibility<std::int16_t>(reader, samples);
    default:
      throw Refusal("attribute visibility_bits is " + std::to_string(bits) + ", and not 0, 8 or 16");
  }
}

/// The datasets GROUP/cluster_end and so on.
template <class Value>
ClusterFields<Value> read_fields(Hdf5Reader& reader, const std::string& group, std::uint32_t count,
                                 const ClusteredSamples& samples) {
  ClusterFields<Value> fields;
  const std::size_t clusters = samples.ends.size();
  fields.ends = ends(reader, group + "/cluster_end", std::uint32_t(clusters), count);
  fields.scales = list<float>(reader, (group + "/scale").c_str(), count);
  std::uint64_t at = 0;
  if (clusters > 0) fields.first.push_back(0);
  for (std::size_t c = 0; c < clusters; ++c)
    for (std::uint32_t f = size_of_cluster(fields.ends, c); f > 0; --f) {
      at += samples.size(c);
      require(at < no_light, "dataset " + group + "/value has too many elements");
      fields.first.push_back(std::uint32_t(at));
    }
  fields.values = list<Value>(reader, (group + "/value").c_str(), at);
  return fields;
}

template <class Value>
LightTransfer<Value> read_transfer(Hdf5Reader& reader, const ClusteredSamples& samples) {
  LightTransfer<Value> t;
  t.sample_ends = samples.ends;
  t.projection = read_fields<Value>(reader, "projection", small_count(reader, "coefficient_count"), samples);
  t.patterns = read_fields<Value>(reader, "pattern", small_count(reader, "pattern_count"), samples);
  const std::size_t width = small_count(reader, "mix_width"), count = t.pattern_count();
  const auto values = table<Value>(reader, "mix/value", 3 * count, width);
  const auto scales = list<float>(reader, "mix/scale", 3 * count);
  std::size_t value = 0, scale = 0;
  for (auto& mix : t.mix) {
    mix.width = width;
    mix.values = take(values, value, count * width);
    mix.scales = take(scales, scale, count);
  }
  t.offsets = list<float>(reader, "mix/offset", small_count(reader, "offset_count"));
  return t;
}

StoredLightTransfer read_light_transfer(Hdf5Reader& reader, const ClusteredSamples& samples) {
  const std::uint64_t bits = reader.count("transfer_bits");
  if (bits == 8) return read_transfer<std::int8_t>(reader, samples);
  if (bits == 16) return read_transfer<std::int16_t>(reader, samples);
  throw Refusal("attribute transfer_bits is " + std::to_string(bits) + ", and neither 8 nor 16");
}

}  // namespace

StoredRoom decode_room(Hdf5Reader& reader) {
  StoredRoom room;
  room.settings = decode_settings(reader);
  room.samples = read_samples(reader);
  room.visibility = read_light_visibility(reader, room.samples);
  room.transfer = read_light_transfer(reader, room.samples);
  require_invariants(room, "", Refusal("").remedy);
  return room;
}

}  // namespace coppice::store
