// The tree that joins the pieces of an illumination cut.
#include "sg/skies.hpp"
//
#include <doctest/doctest.h>

using namespace coppice;
using namespace sg_test;
using namespace test_support;

namespace {

std::vector<SgLight> some_peaks(Random& random, int count) {
  std::vector<SgLight> peaks;
  for (int i = 0; i < count; ++i)
    peaks.push_back(sg_light({random.direction(), std::exp(12 * random.uniform())},
                             100.0f * support::random_colour(random)));
  return peaks;
}

/// The heap id of each node, from those of its children, which stand before it.
std::vector<std::uint32_t> heap_ids(const ProductTree& tree) {
  std::vector<std::uint32_t> ids(tree.clusters().nodes(), tree.clusters().nodes() + tree.piece_count());
  for (const uvec2& children : tree.joints()) {
    REQUIRE(children.x < ids.size());
    REQUIRE(children.y < ids.size());
    const std::uint32_t a = ids[children.x], b = ids[children.y];
    REQUIRE(a % 2 == 0);
    REQUIRE(b == a + 1);
    ids.push_back(a / 2);
  }
  return ids;
}

}  // namespace

TEST_CASE("joints are the tree above the cut: siblings, each once, children before parents") {
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    Random random(seed);
    const std::uint32_t count = 1u << random.below(11);
    const auto lit = support::random_lit_tree(count, 1 + random.below(count), 0, random);
    const ProductTree tree(lit.frame, some_peaks(random, int(random.below(5))));
    REQUIRE(tree.piece_count() == lit.frame.ends.size());
    REQUIRE(tree.joints().size() == tree.piece_count() - 1);
    auto ids = heap_ids(tree);
    CHECK(ids[tree.root()] == 1);
    std::ranges::sort(ids);
    CHECK(std::ranges::adjacent_find(ids) == ids.end());
  }
}

TEST_CASE("clusters are the pieces in their order, then the peaks, all visible") {
  Random random(20);
  const auto lit = support::random_lit_tree(512, 100, 0, random);
  const auto peaks = some_peaks(random, 7);
  const ProductTree tree(lit.frame, peaks);
  const ClusterList& c = tree.clusters();
  REQUIRE(c.size() == tree.piece_count() + 7);
  CHECK(tree.peak_count() == 7);
  const auto vector = [&](ClusterList::Field first, std::size_t i) {
    return vec3(c.field(first)[i], c.field(ClusterList::Field(first + 1))[i],
                c.field(ClusterList::Field(first + 2))[i]);
  };
  for_each_piece(lit.frame.ends, [&](LeafRange r, std::size_t i) {
    const LightNode& node = lit.frame.nodes[node_of_range(512, r.begin, r.end)];
    CHECK(vector(ClusterList::x, i) == node.direction);
    CHECK(vector(ClusterList::red, i) == node.power);
    CHECK(c.field(ClusterList::mean_length)[i] == 1 - node.spread);
  });
  for (std::size_t k = 0; k < 7; ++k) {
    const std::size_t i = tree.piece_count() + k;
    CHECK(vector(ClusterList::x, i) == peaks[k].axis);
    CHECK(apart(glm::dvec3(vector(ClusterList::red, i)), sg_energy(std::span(&peaks[k], 1))) < 1e-6);
    CHECK(std::abs(c.field(ClusterList::mean_length)[i] - sg_mean_length(peaks[k].sharpness)) < 1e-6f);
    CHECK(c.nodes()[i] == 0);
  }
}

TEST_CASE("the sum over pieces is the power of the root") {
  Random random(21);
  const auto lit = support::random_lit_tree(1024, 77, 0, random);
  const ProductTree tree(lit.frame, {});
  glm::dvec3 sum(0);
  const ClusterList& c = tree.clusters();
  for (std::size_t i = 0; i < c.size(); ++i)
    sum += glm::dvec3(c.field(ClusterList::red)[i], c.field(ClusterList::green)[i],
                      c.field(ClusterList::blue)[i]);
  CHECK(apart(sum, glm::dvec3(lit.frame.nodes[1].power)) < 1e-6);
}

TEST_CASE("one piece is its own root; no lights are no pieces; peaks may be alone") {
  Random random(22);
  const auto lit = support::random_lit_tree(64, 1, 0, random);
  const ProductTree one(lit.frame, {});
  CHECK(one.piece_count() == 1);
  CHECK(one.joints().empty());
  CHECK(one.root() == 0);
  const FrameLighting nothing;
  const ProductTree empty(nothing, {}), peaks(nothing, some_peaks(random, 3));
  CHECK(empty.piece_count() == 0);
  CHECK(empty.clusters().size() == 0);
  CHECK(peaks.piece_count() == 0);
  CHECK(peaks.peak_count() == 3);
  CHECK(ProductTree().clusters().size() == 0);
}
