// Small visibility to store, and whether it came back.
#pragma once

#include <doctest/doctest.h>

#include <coppice/light/directions.hpp>
#include <coppice/relight/refine.hpp>
#include <coppice/store/store.hpp>

#include "relight/receiver_meshes.hpp"
#include "support/generators.hpp"
#include "support/occluders.hpp"
#include "support/scenes.hpp"

namespace store_test {

using namespace coppice;

/// A refined patch of ground with as many corners at most.
inline ReceiverMesh refined_mesh(std::size_t corners) {
  const Mesh mesh = support::bumpy_mesh(2, 0.2f, 4);
  ReceiverMesh receivers(mesh, relight_test::all_fronts(mesh));
  const support::SphereOccluder ball{{{{0.5f, 0.5f, -0.5f}, 0.2f}}};
  refine_receivers(
      receivers, ball, DirectionPackets(even_directions(64)), {0.01, corners},
      [](const vec3&) { return EdgeLimits{}; }, Serial());
  return receivers;
}

/// A tree over `lights` lights in a random order, padded in random places.
inline LightTree random_tree(Random& random, std::uint32_t lights) {
  std::vector<std::uint32_t> leaves(leaf_count_for(lights), no_light);
  std::iota(leaves.begin(), leaves.begin() + lights, 0u);
  for (std::uint32_t i = std::uint32_t(leaves.size()); i-- > 1;)
    std::swap(leaves[i], leaves[random.below(i + 1)]);
  return tree_over(std::move(leaves));
}

template <Quantised Value>
void add_receivers(StoredVisibility<Value>& v, Random& random, std::size_t count,
                   std::uint32_t granule_log2) {
  v.cuts = MaskedCuts<Value>(v.tree.leaf_count(), granule_log2);
  for (std::size_t i = 0; i < count; ++i) {
    v.receivers.push_back({random.direction(), random.direction(), vec3(0), -random.uniform(), 0.2f});
    const auto cut = test_support::random_cut<Value>(random, v.tree.leaf_count(), 0.9f * random.uniform(),
                                                     1u << granule_log2);
    v.cuts.append(cut, horizon_of(v.receivers.back(), v.weight));
  }
}

/// One receiver a corner of the mesh.
template <Quantised Value>
StoredVisibility<Value> random_visibility(std::uint64_t seed, std::uint32_t lights, ReceiverMesh mesh,
                                          std::uint32_t granule_log2, CutWeight weight = CutWeight::cosine) {
  Random random(seed);
  StoredVisibility<Value> v;
  v.settings = {{"scene", "0123abcd"}, {"sigma", "2"}, {"note", ""}};
  v.tree = random_tree(random, lights);
  for (std::uint32_t i = 0; i < lights; ++i) v.lights.push_back(vec4(random.direction(), float(i % 2)));
  v.mesh = std::move(mesh);
  v.weight = weight;
  add_receivers(v, random, v.mesh.corners().size(), granule_log2);
  for (std::size_t i = 0; i < v.receivers.size(); ++i) v.scales.push_back(random.uniform());
  return v;
}

/// Large enough for every item, small enough to be damaged at every byte.
inline StoredVisibility<std::uint8_t> small_visibility() {
  return random_visibility<std::uint8_t>(1, 100, refined_mesh(20), 1);
}

inline bool same(const Receiver& a, const Receiver& b) {
  return a.position == b.position && a.normal == b.normal && a.horizon == b.horizon && a.bend == b.bend;
}

inline bool same(const ReceiverMesh::Face& a, const ReceiverMesh::Face& b) {
  return a.corners == b.corners && a.uv == b.uv && a.normal == b.normal && a.triangle == b.triangle &&
         a.child_count == b.child_count && (a.child_count == 0 || a.first_child == b.first_child);
}

inline bool same(const ReceiverMesh::Corner& a, const ReceiverMesh::Corner& b) {
  return a.position == b.position && length(a.normal - b.normal) <= 1e-6f;
}

inline bool same(const SidedTriangle& a, const SidedTriangle& b) {
  return a.triangle == b.triangle && a.front == b.front;
}

inline bool same(const ReceiverHorizon& a, const ReceiverHorizon& b) {
  return a.normal == b.normal && a.cosine == b.cosine;
}

template <class Range>
bool all_same(const Range& a, const Range& b) {
  return std::ranges::equal(a, b, [](const auto& x, const auto& y) { return same(x, y); });
}

template <Quantised Value>
void check_same(const StoredVisibility<Value>& a, const StoredVisibility<Value>& b) {
  CHECK(a.settings == b.settings);
  CHECK(a.tree.light_of_leaf == b.tree.light_of_leaf);
  CHECK(a.tree.light_count == b.tree.light_count);
  CHECK(a.lights == b.lights);
  CHECK(all_same(a.mesh.corners(), b.mesh.corners()));
  CHECK(all_same(a.mesh.faces(), b.mesh.faces()));
  CHECK(all_same(a.mesh.sides(), b.mesh.sides()));
  CHECK(all_same(a.receivers, b.receivers));
  CHECK((a.weight == b.weight));
  CHECK(a.scales == b.scales);
  CHECK(a.cuts.size() == b.cuts.size());
  CHECK(a.cuts.granule_log2() == b.cuts.granule_log2());
  CHECK(std::ranges::equal(a.cuts.masks(), b.cuts.masks()));
  CHECK(std::ranges::equal(a.cuts.values(), b.cuts.values()));
  CHECK(std::ranges::equal(a.cuts.first_value(), b.cuts.first_value()));
  CHECK(all_same(a.cuts.horizons(), b.cuts.horizons()));
}

}  // namespace store_test
