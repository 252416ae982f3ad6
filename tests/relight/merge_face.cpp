// The merged clusters of a face: registers against one end at a time, and this against the merge of unpacked
// cuts.
#include <doctest/doctest.h>

#include <cmath>
#include <coppice/cut/merge.hpp>
#include <coppice/reference/merge_face.hpp>
#include <coppice/relight/merge_face.hpp>
#include <coppice/relight/shade.hpp>
#include <limits>
#include <numeric>
#include <support/shading.hpp>

using namespace coppice;
using namespace support;

namespace {

constexpr ReceiverHorizon all_below{vec3(0), 1};

bool same(float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); }

/// The places of the clusters in the list, by heap id.
std::vector<std::size_t> order_of(const ClusterList& list) {
  std::vector<std::size_t> order(list.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t i) { return list.nodes()[i]; });
  return order;
}

/// The same clusters in any order, in every field, and nothing but zeros behind them.
void check_equal(const ClusterList& list, const ClusterList& expected) {
  REQUIRE(list.size() == expected.size());
  const auto order = order_of(list), expected_order = order_of(expected);
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::size_t i = order[k], j = expected_order[k];
    REQUIRE(list.nodes()[i] == expected.nodes()[j]);
    for (int f = 0; f < ClusterList::field_count; ++f) {
      CAPTURE(f);
      REQUIRE(same(list.field(ClusterList::Field(f))[i], expected.field(ClusterList::Field(f))[j]));
    }
  }
  REQUIRE(list.padded_size() == (list.size() + Lanes::width - 1) / Lanes::width * Lanes::width);
  for (int f = 0; f < ClusterList::field_count; ++f)
    for (std::size_t i = list.size(); i < list.padded_size(); ++i)
      REQUIRE(list.field(ClusterList::Field(f))[i] == 0);
}

template <Quantised Value>
void check_merge(FaceMerger<Value>& merger, const MaskedCuts<Value>& cuts, const uvec3& receivers,
                 const FrameLighting& frame, ClusterList& list) {
  merger.merge(receivers, list);
  ClusterList expected;
  reference::merge_face(cuts, receivers, frame, expected);
  check_equal(list, expected);
}

/// Merges the unpacked cuts, each cluster's visibility as the horizon leaves it.
template <Quantised Value>
ClusterList merge_unpacked(const MaskedCuts<Value>& cuts, const uvec3& r, const FrameLighting& frame) {
  const Cut<Value> illumination{frame.ends, std::vector<Value>(frame.ends.size())};
  ClusterList clusters;
  clusters.reset(cuts.leaf_count());
  merge_cuts(
      [&](LeafRange range, float a, float b, float c, Value) {
        const std::uint32_t h = node_of_range(cuts.leaf_count(), range.begin, range.end);
        const LightNode& node = frame.nodes[h];
        std::array<float, 3> visible{a, b, c};
        for (int j = 0; j < 3; ++j) {
          const ReceiverHorizon horizon = cuts.horizons()[r[j]];
          if (!(dot(horizon.normal, node.direction) > horizon.cosine)) visible[std::size_t(j)] = 0;
        }
        if (visible[0] + visible[1] + visible[2] > 0 && node.power != vec3(0))
          clusters.push(h, node, visible);
      },
      cuts.unpack(r.x), cuts.unpack(r.y), cuts.unpack(r.z), illumination);
  clusters.pad();
  return clusters;
}

ReceiverHorizon random_horizon(Random& random) {
  switch (random.below(4)) {
    case 0:
      return no_horizon;
    case 1:
      return all_below;
    default:
      return {random.direction(), -0.5f * random.uniform()};
  }
}

template <Quantised Value>
MaskedCuts<Value> random_cuts(std::uint32_t leaves, std::uint32_t granule_log2, Random& random) {
  MaskedCuts<Value> cuts(leaves, granule_log2);
  for (int i = 0; i < 5; ++i)
    cuts.append(random_visibility_cut<Value>(leaves, granule_log2, random), random_horizon(random));
  cuts.append(Cut<Value>{{leaves}, {Value(-1)}});
  cuts.append(Cut<Value>{{leaves}, {Value(0)}});
  return cuts;
}

/// Every sixth face of all the cuts.
template <class Visit>
void for_some_faces(Visit&& visit) {
  for (std::uint32_t i = 0; i < 7 * 7 * 7; i += 6) visit(uvec3(i / 49, i / 7 % 7, i % 7));
}

template <class Visit>
void for_each_tree(Random& random, Visit&& visit) {
  for (const std::uint32_t leaves : {1u, 2u, 16u, 1024u})
    for (std::uint32_t granule_log2 = 0; granule_log2 <= 5 && (1u << granule_log2) <= leaves; ++granule_log2)
      for (const std::uint32_t nodes : {1u, 7u, 300u, leaves})
        visit(random_lit_tree(leaves, nodes, granule_log2, random), granule_log2);
}

template <Quantised Value>
MaskedCuts<Value> one_cut(std::uint32_t leaves, const ReceiverHorizon& horizon = no_horizon) {
  MaskedCuts<Value> cuts(leaves, 0);
  cuts.append(Cut<Value>{{leaves}, {Value(-1)}}, horizon);
  return cuts;
}

}  // namespace

TEST_CASE_TEMPLATE("merging in registers equals merging one end at a time", Value, std::uint8_t,
                   std::uint16_t) {
  Random random(5);
  ClusterList list;  // reused: nothing of an earlier face may stay
  std::size_t clusters = 0;
  for_each_tree(random, [&](const LitTree& lit, std::uint32_t granule_log2) {
    const auto cuts = random_cuts<Value>(lit.leaf_count(), granule_log2, random);
    FaceMerger<Value> merger(cuts, lit.frame);
    for_some_faces([&](const uvec3& face) {
      check_merge(merger, cuts, face, lit.frame, list);
      clusters += list.size();
    });
  });
  CHECK(clusters > 50000);
}

TEST_CASE_TEMPLATE("merging one end at a time equals merging the unpacked cuts", Value, std::uint8_t,
                   std::uint16_t) {
  Random random(6);
  for_each_tree(random, [&](const LitTree& lit, std::uint32_t granule_log2) {
    const auto cuts = random_cuts<Value>(lit.leaf_count(), granule_log2, random);
    for_some_faces([&](const uvec3& face) {
      ClusterList clusters;
      reference::merge_face(cuts, face, lit.frame, clusters);
      check_equal(clusters, merge_unpacked(cuts, face, lit.frame));
    });
  });
}

TEST_CASE("scratch that served one face leaves nothing behind for the next") {
  Random random(7);
  const LitTree lit = random_lit_tree(4096, 1000, 0, random);
  const auto cuts = random_cuts<std::uint8_t>(4096, 0, random);
  FaceMerger<std::uint8_t> merger(cuts, lit.frame);
  ClusterList reused;
  for (const uvec3& face : {uvec3(0, 1, 5), uvec3(6, 6, 6), uvec3(6, 6, 2), uvec3(5, 5, 5), uvec3(3, 6, 6)}) {
    merger.merge(face, reused);
    ClusterList fresh;
    FaceMerger<std::uint8_t>(cuts, lit.frame).merge(face, fresh);
    check_equal(reused, fresh);
  }
}

TEST_CASE("an illumination cut finer than the granules splits them") {
  Random random(8);
  const LitTree lit = random_lit_tree(4096, 4096, 5, random);
  MaskedCuts<std::uint8_t> cuts(4096, 5);
  cuts.append(Cut<std::uint8_t>{{4096}, {255}});
  ClusterList list;
  FaceMerger<std::uint8_t> merger(cuts, lit.frame);
  check_merge(merger, cuts, {0, 0, 0}, lit.frame, list);
  CHECK(list.size() > 4096 / 4);
  CHECK(std::ranges::all_of(std::span(list.nodes(), list.size()), [](std::uint32_t h) { return h >= 2048; }));
}

TEST_CASE("with everything visible the clusters carry the whole power") {
  Random random(9);
  ClusterList list;
  for (const std::uint32_t count : {1u, 3u, 1000u, 4096u})
    for (const std::size_t nodes : {1u, 50u, 4096u}) {
      const std::uint32_t leaves = leaf_count_for(count), granule_log2 = granule_log2_for(2, leaves);
      const LitTree lit = random_lit_tree(count, nodes, granule_log2, random);
      MaskedCuts<std::uint8_t> cuts(leaves, granule_log2);
      for (int i = 0; i < 3; ++i) {
        auto cut = random_visibility_cut<std::uint8_t>(leaves, granule_log2, random);
        std::ranges::fill(cut.values, std::uint8_t{255});
        cuts.append(cut);
      }
      FaceMerger<std::uint8_t>(cuts, lit.frame).merge({0, 1, 2}, list);
      glm::dvec3 sum(0);
      for (std::size_t i = 0; i < list.size(); ++i) sum += glm::dvec3(lit.frame.nodes[list.nodes()[i]].power);
      const glm::dvec3 total(lit.frame.nodes[1].power);
      CHECK(glm::length(sum - total) <= 1e-6 * glm::length(total));
    }
}

TEST_CASE("nothing visible or nothing lit leaves no clusters") {
  Random random(10);
  const LitTree lit = random_lit_tree(64, 16, 0, random);
  MaskedCuts<std::uint8_t> cuts(64, 0);
  cuts.append(Cut<std::uint8_t>{{32, 64}, {0, 0}});
  cuts.append(Cut<std::uint8_t>{{64}, {255}});
  cuts.append(Cut<std::uint8_t>{{64}, {255}}, all_below);
  ClusterList list;
  FaceMerger<std::uint8_t> merger(cuts, lit.frame);
  for (const uvec3& face : {uvec3(0), uvec3(2), uvec3(0, 2, 0)}) {
    merger.merge(face, list);
    CHECK(list.size() == 0);
    CHECK(list.padded_size() == 0);
  }
  merger.merge({0, 2, 1}, list);
  CHECK(list.size() > 0);
  const LitTree night(64, 16, 0, [](const vec3&) { return vec3(0); });
  FaceMerger<std::uint8_t>(cuts, night.frame).merge({1, 1, 1}, list);
  CHECK(list.size() == 0);
}

TEST_CASE("a cluster exactly on the horizon is below it, and one above is not") {
  Random random(11);
  const LitTree lit = random_lit_tree(64, 64, 0, random);
  for (std::uint32_t h = 64; h < 128; ++h) {
    const float height = lit.frame.nodes[h].direction.y;
    for (const float cosine : {height, std::nextafter(height, -2.0f)}) {
      const auto cuts = one_cut<std::uint8_t>(64, {vec3(0, 1, 0), cosine});
      FaceMerger<std::uint8_t> merger(cuts, lit.frame);
      ClusterList list;
      check_merge(merger, cuts, {0, 0, 0}, lit.frame, list);
      const bool kept = std::ranges::count(std::span(list.nodes(), list.size()), h) > 0;
      CHECK(kept == (cosine < height && lit.frame.nodes[h].power != vec3(0)));
    }
  }
}

TEST_CASE("NaN in the power of one node reaches the radiance, but not past who does not see it") {
  Random random(12);
  LitTree lit = random_lit_tree(256, 32, 0, random);
  const std::uint32_t bad_leaf = 100;
  for (std::uint32_t h = 256 + bad_leaf; h >= 1; h /= 2)
    lit.frame.nodes[h].power.y = std::numeric_limits<float>::quiet_NaN();
  MaskedCuts<std::uint8_t> cuts(256, 0);
  cuts.append(Cut<std::uint8_t>{{256}, {255}});
  cuts.append(Cut<std::uint8_t>{{64, 128, 256}, {255, 0, 255}});
  FaceMerger<std::uint8_t> merger(cuts, lit.frame);
  ClusterList list;
  RefinementScratch scratch;
  for (const Lobes lobes : {Lobes::sampled, Lobes::filtered, Lobes::refined})
    for (const ShadingPoint& p : random_points(wide_materials, 4, random)) {
      const auto radiance = [&](const uvec3& face) {
        check_merge(merger, cuts, face, lit.frame, list);
        return shade_point(p, list, 1.0f / 255, {lobes}, lit.frame.nodes, scratch).radiance;
      };
      CHECK(std::isnan(radiance({0, 0, 0}).y));
      CHECK(is_finite(radiance({1, 1, 1})));
    }
}
