// Small rooms to store, and whether they came back.
#pragma once

#include <doctest/doctest.h>

#include <bit>
#include <coppice/core/random.hpp>
#include <coppice/store/room_store.hpp>

namespace store_test {

using namespace coppice;

/// The sizes of a room.
struct RoomSizes {
  std::vector<std::uint32_t> clusters{5, 0, 9};  ///< samples of each
  glm::ivec3 lattice{3, 4, 5};
  std::uint32_t rank = 3, fields = 2, patterns = 4;  ///< the latter two of each cluster that has samples
  bool centred = true;
};

template <class Integer>
std::vector<Integer> random_integers(Random& random, std::size_t count) {
  std::vector<Integer> values(count);
  for (Integer& v : values) v = Integer(random.bits());
  return values;
}

inline std::vector<float> random_floats(Random& random, std::size_t count) {
  std::vector<float> values(count);
  for (float& v : values) v = random.uniform();
  return values;
}

inline ClusteredSamples random_samples(Random& random, const RoomSizes& sizes) {
  ClusteredSamples clustered;
  for (const std::uint32_t size : sizes.clusters) {
    for (std::uint32_t i = 0; i < size; ++i)
      clustered.samples.push_back({random.direction(),
                                   random.uniform(),
                                   random.direction(),
                                   vec3(random.uniform()),
                                   {random.below(1000), random.below(2) == 1},
                                   random.uniform(),
                                   random.uniform()});
    clustered.ends.push_back(std::uint32_t(clustered.samples.size()));
  }
  return clustered;
}

/// About half of its places have points.
inline LightLattice random_lattice(Random& random, const glm::ivec3& size) {
  LightLattice lattice{random.direction(), 0.25f, size, {}, {}};
  const std::size_t places = std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z);
  for (std::size_t i = 0; i < places; ++i) {
    const bool counts = random.below(2) == 1;
    lattice.numbers.push_back(counts ? std::uint32_t(lattice.count()) : LightLattice::none);
    if (counts) lattice.positions.push_back(random.direction());
  }
  return lattice;
}

template <class Integer>
LatticeVisibility<Integer> random_lattice_visibility(Random& random, const ClusteredSamples& samples,
                                                     const RoomSizes& sizes) {
  LatticeVisibility<Integer> v{random_lattice(random, sizes.lattice), sizes.rank, samples.ends, {}};
  const std::size_t points = v.lattice.count();
  for (std::size_t c = 0; c < samples.cluster_count(); ++c) {
    LatticeCluster<Integer>& cluster = v.clusters.emplace_back();
    std::uint32_t rows = 0;
    cluster.index.bits.resize((points + 31) / 32);
    for (std::size_t p = 0; p < points; ++p) cluster.index.bits[p / 32] |= random.below(2) << (p % 32);
    for (const std::uint32_t word : cluster.index.bits)
      cluster.index.before.push_back(rows), rows += std::uint32_t(std::popcount(word));
    if (points > 0) ++rows;
    cluster.scales = random_floats(random, sizes.rank);
    cluster.coefficients = random_integers<Integer>(random, sizes.rank * samples.size(c));
    cluster.rows = random_integers<Integer>(random, rows * sizes.rank);
  }
  return v;
}

template <class Value>
ClusterFields<Value> random_fields(Random& random, const ClusteredSamples& samples, std::uint32_t each) {
  ClusterFields<Value> fields;
  for (std::size_t c = 0; c < samples.cluster_count(); ++c) {
    const std::uint32_t count = samples.size(c) > 0 ? each : 0;
    if (c == 0) fields.first.push_back(0);
    for (std::uint32_t f = 0; f < count; ++f) {
      fields.first.push_back(fields.first.back() + std::uint32_t(samples.size(c)));
      fields.scales.push_back(random.uniform());
    }
    fields.ends.push_back(std::uint32_t(fields.count()));
  }
  fields.values = random_integers<Value>(random, fields.first.empty() ? 0 : fields.first.back());
  return fields;
}

template <class Value>
LightTransfer<Value> random_transfer(Random& random, const ClusteredSamples& samples,
                                     const RoomSizes& sizes) {
  LightTransfer<Value> t;
  t.sample_ends = samples.ends;
  t.projection = random_fields<Value>(random, samples, sizes.fields);
  t.patterns = random_fields<Value>(random, samples, sizes.patterns);
  if (sizes.centred) t.offsets = random_floats(random, t.projection.count());
  for (auto& mix : t.mix) {
    mix.width = t.projection.count() + (sizes.centred ? 1 : 0);
    mix.scales = random_floats(random, t.pattern_count());
    mix.values = random_integers<Value>(random, t.pattern_count() * mix.width);
  }
  return t;
}

/// Of `Integer` in both parts.
template <class Integer>
StoredRoom random_room(std::uint64_t seed, const RoomSizes& sizes) {
  Random random(seed);
  StoredRoom room;
  room.settings = {{"scene", "0123abcd"}, {"clusters", "3"}};
  room.samples = random_samples(random, sizes);
  room.visibility = random_lattice_visibility<Integer>(random, room.samples, sizes);
  room.transfer = random_transfer<Integer>(random, room.samples, sizes);
  return room;
}

/// With every item, and small enough to be damaged at every byte.
inline StoredRoom small_room() { return random_room<std::int8_t>(1, {}); }

inline bool same(const SurfaceSample& a, const SurfaceSample& b) {
  return a.position == b.position && a.area == b.area && a.normal == b.normal && a.colour == b.colour &&
         a.side.triangle == b.side.triangle && a.side.front == b.side.front && a.u == b.u && a.v == b.v;
}

inline void check_equal(std::monostate, std::monostate) {}

template <class Integer>
void check_equal(const LatticeVisibility<Integer>& a, const LatticeVisibility<Integer>& b) {
  CHECK(a.lattice.origin == b.lattice.origin);
  CHECK(a.lattice.spacing == b.lattice.spacing);
  CHECK(a.lattice.size == b.lattice.size);
  CHECK(a.lattice.numbers == b.lattice.numbers);
  CHECK(a.lattice.positions == b.lattice.positions);
  CHECK(a.rank == b.rank);
  CHECK(a.ends == b.ends);
  REQUIRE(a.clusters.size() == b.clusters.size());
  for (std::size_t c = 0; c < a.clusters.size(); ++c) {
    CHECK(a.clusters[c].index.bits == b.clusters[c].index.bits);
    CHECK(a.clusters[c].index.before == b.clusters[c].index.before);
    CHECK(a.clusters[c].scales == b.clusters[c].scales);
    CHECK(a.clusters[c].coefficients == b.clusters[c].coefficients);
    CHECK(a.clusters[c].rows == b.clusters[c].rows);
  }
}

template <class Value>
void check_equal(const ClusterFields<Value>& a, const ClusterFields<Value>& b) {
  CHECK(a.ends == b.ends);
  CHECK(a.first == b.first);
  CHECK(a.values == b.values);
  CHECK(a.scales == b.scales);
}

template <class Value>
void check_equal(const LightTransfer<Value>& a, const LightTransfer<Value>& b) {
  check_equal(a.projection, b.projection);
  check_equal(a.patterns, b.patterns);
  for (int c = 0; c < 3; ++c) {
    CHECK(a.mix[c].width == b.mix[c].width);
    CHECK(a.mix[c].values == b.mix[c].values);
    CHECK(a.mix[c].scales == b.mix[c].scales);
  }
  CHECK(a.offsets == b.offsets);
  CHECK(a.sample_ends == b.sample_ends);
}

/// Bit for bit, but for settings.
inline void check_same(const StoredRoom& a, const StoredRoom& b) {
  CHECK(a.samples.ends == b.samples.ends);
  CHECK(std::ranges::equal(a.samples.samples, b.samples.samples,
                           [](const auto& x, const auto& y) { return same(x, y); }));
  REQUIRE(a.visibility.index() == b.visibility.index());
  REQUIRE(a.transfer.index() == b.transfer.index());
  std::visit([&](const auto& v) { check_equal(v, std::get<std::decay_t<decltype(v)>>(b.visibility)); },
             a.visibility);
  std::visit([&](const auto& t) { check_equal(t, std::get<std::decay_t<decltype(t)>>(b.transfer)); },
             a.transfer);
}

}  // namespace store_test
