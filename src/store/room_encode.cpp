#include "items.hpp"
#include "room.hpp"

namespace coppice::store {
namespace {

template <class To, class From>
void append(std::vector<To>& to, const std::vector<From>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

void add_samples(Encoder& e, const ClusteredSamples& clustered) {
  const std::vector<SurfaceSample>& samples = clustered.samples;
  e.count("sample_count", samples.size());
  e.count("cluster_count", clustered.ends.size());
  e.list("samples/cluster_end", clustered.ends);
  e.rows("samples/position", gather<vec3>(samples, [](const SurfaceSample& s) { return s.position; }));
  e.rows("samples/normal", gather<vec3>(samples, [](const SurfaceSample& s) { return s.normal; }));
  e.rows("samples/colour", gather<vec3>(samples, [](const SurfaceSample& s) { return s.colour; }));
  e.list("samples/area", gather<float>(samples, [](const SurfaceSample& s) { return s.area; }));
  e.list("samples/triangle",
         gather<std::uint32_t>(samples, [](const SurfaceSample& s) { return s.side.triangle; }));
  e.list("samples/front",
         gather<std::uint8_t>(samples, [](const SurfaceSample& s) { return s.side.front ? 1 : 0; }));
  e.rows("samples/barycentric", gather<vec2>(samples, [](const SurfaceSample& s) { return vec2(s.u, s.v); }));
}

void add_lattice(Encoder& e, const LightLattice& lattice) {
  e.count("lattice_x", std::uint64_t(lattice.size.x));
  e.count("lattice_y", std::uint64_t(lattice.size.y));
  e.count("lattice_z", std::uint64_t(lattice.size.z));
  e.count("lattice_point_count", lattice.count());
  e.list("lattice/place",
         std::vector<float>{lattice.origin.x, lattice.origin.y, lattice.origin.z, lattice.spacing});
  e.list("lattice/number", lattice.numbers);
  e.rows("lattice/position", lattice.positions);
}

void add_visibility(Encoder& e, std::monostate) { e.count("visibility_bits", 0); }

template <class Integer>
void add_visibility(Encoder& e, const LatticeVisibility<Integer>& v) {
  e.count("visibility_bits", 8 * sizeof(Integer));
  e.count("visibility_rank", v.rank);
  add_lattice(e, v.lattice);
  const std::size_t words = (v.lattice.count() + 31) / 32;
  std::vector<std::uint32_t> bits;
  std::vector<float> scales;
  std::vector<Integer> coefficients, rows;
  std::uint64_t row_sum = 0;
  for (const LatticeCluster<Integer>& cluster : v.clusters) {
    append(bits, cluster.index.bits), append(scales, cluster.scales);
    append(coefficients, cluster.coefficients), append(rows, cluster.rows);
    row_sum += row_count(cluster.index.bits);
  }
  e.table("visibility/index", v.clusters.size(), words, bits);
  e.table("visibility/scale", v.clusters.size(), v.rank, scales);
  e.list("visibility/coefficient", coefficients);
  e.table("visibility/row", row_sum, v.rank, rows);
}

/// The datasets GROUP/cluster_end and so on.
template <class Value>
void add_fields(Encoder& e, const std::string& group, const ClusterFields<Value>& fields) {
  e.list((group + "/cluster_end").c_str(), fields.ends);
  e.list((group + "/scale").c_str(), fields.scales);
  e.list((group + "/value").c_str(), fields.values);
}

template <class Value>
void add_transfer(Encoder& e, const LightTransfer<Value>& t) {
  e.count("transfer_bits", 8 * sizeof(Value));
  e.count("coefficient_count", t.projection.count());
  e.count("pattern_count", t.patterns.count());
  e.count("mix_width", t.coefficient_count());
  e.count("offset_count", t.offsets.size());
  add_fields(e, "projection", t.projection);
  add_fields(e, "pattern", t.patterns);
  std::vector<Value> values;
  std::vector<float> scales;
  for (const auto& mix : t.mix) append(values, mix.values), append(scales, mix.scales);
  e.table("mix/value", 3 * t.pattern_count(), t.coefficient_count(), values);
  e.list("mix/scale", scales);
  e.list("mix/offset", t.offsets);
}

}  // namespace

Contents encode(const StoredRoom& room) {
  require_invariants(room, "cannot be written: ", "hand over what belongs together");
  Encoder e;
  add_settings(e, room.settings);
  add_samples(e, room.samples);
  std::visit([&](const auto& visibility) { add_visibility(e, visibility); }, room.visibility);
  std::visit([&](const auto& transfer) { add_transfer(e, transfer); }, room.transfer);
  for (const Array& array : e.contents.arrays) require_finite(array);
  return std::move(e.contents);
}

}  // namespace coppice::store
