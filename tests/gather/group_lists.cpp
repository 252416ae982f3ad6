// Cuts for groups of points against plain recursion, and what they gather against the sum over all VPLs.
#include <doctest/doctest.h>

#include <algorithm>
#include <coppice/gather/group_lists.hpp>
#include <cstring>

#include "gather/vpls.hpp"
#include "support/executors.hpp"

using namespace coppice;

namespace {

constexpr std::uint32_t mixed_sizes[] = {1, 5, 64, 2, 17};

/// What a float sum over the VPLs may be off, for exponents up to `most`: lobes turn the rounding of
/// directions into error by about the root of their exponents.
double tolerance(double exact, double scale, double most) {
  return (2e-6 + 1e-6 * std::sqrt(most)) * exact + 1e-9 * scale;
}

VplArrays all_of(std::span<const VplNode> nodes) {
  std::vector<std::uint32_t> ids(nodes.size());
  std::iota(ids.begin(), ids.end(), 0u);
  VplArrays arrays;
  arrays.assign(nodes, ids);
  return arrays;
}

/// What the VPLs would bring, were all their lobes and the point's turned to each other.
double scale_of(std::span<const VplNode> vpls, GlossyPoint p) {
  double sum = 0;
  p.normal = vec3(0, 1, 0), p.position = vec3(0), p.mirror = vec3(0, 1, 0);
  for (VplNode n : vpls) {
    n.position = vec3(0, 1, 0), n.normal = n.lobe = vec3(0, -1, 0);
    sum += support::most(reference::reflected(n, p));
  }
  return sum;
}

void check_brute(Random& random, float most_exponent) {
  for (const std::size_t count : {0u, 1u, 2u, 15u, 16u, 17u, 300u}) {
    const auto vpls = support::room_vpls(random, count, most_exponent);
    const VplArrays arrays = all_of(vpls);
    for (const GlossyPoint& p : support::room_points(random, 40, std::min(most_exponent, 1e5f))) {
      const glm::dvec3 exact = reference::reflected_by_all(vpls, p);
      const vec3 fast = reflect_nodes<VplKind::single>(arrays, p);
      const double scale = scale_of(vpls, p);
      CAPTURE(count);
      for (int c = 0; c < 3; ++c)
        CHECK(std::abs(double(fast[c]) - exact[c]) <= tolerance(exact[c], scale, double(most_exponent)));
    }
  }
}

/// All of GroupCutter's nodes, from left to right.
std::vector<std::uint32_t> from_left(std::span<const std::uint32_t> ids, std::uint32_t leaf_count) {
  std::vector<std::uint32_t> sorted(ids.begin(), ids.end());
  std::ranges::sort(sorted, {}, [&](std::uint32_t h) { return leaves_below(leaf_count, h).begin; });
  return sorted;
}

struct Bounds {
  const VplTree& tree;
  PointBound points;

  std::pair<double, double> operator()(std::uint32_t h) const {
    const bool is_leaf = h >= tree.leaf_count();
    return support::bounded(points, tree.bounds()[h], is_leaf ? 0.0f : std::sqrt(tree.nodes()[h].area));
  }
};

bool same_bits(const Gathered& a, const Gathered& b) {
  return a.nodes == b.nodes && a.tests == b.tests && a.radiance.size() == b.radiance.size() &&
         std::memcmp(a.radiance.data(), b.radiance.data(), a.radiance.size() * sizeof(vec3)) == 0;
}

/// Root of the mean squared relative error over the points, in luminance; those in the dark left out.
double error(const Gathered& g, std::span<const GlossyPoint> points, std::span<const VplNode> vpls) {
  double sum = 0, total = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double exact = support::luminance(reference::reflected_by_all(vpls, points[i]));
    const double off = double(luminance(g.radiance[i])) - exact;
    sum += off * off, total += exact * exact;
  }
  return std::sqrt(sum / total);
}

}  // namespace

TEST_CASE("the sum over all VPLs, a register at a time, is the plain sum in double") {
  Random random(1);
  for (int round = 0; round < 5; ++round) {
    check_brute(random, 10);
    check_brute(random, 1e3f);
    check_brute(random, 1e6f);
  }
}

TEST_CASE("a cluster's terms, a register at a time, are the plain ones in double") {
  Random random(2);
  for (int round = 0; round < 20; ++round) {
    const VplTree tree(support::room_vpls(random, 100, 1e3f));
    for (const GlossyPoint& p : support::room_points(random, 5, 1e3f))
      for (std::uint32_t h = 1; h < tree.leaf_count(); ++h) {
        const VplNode& n = tree.nodes()[h];
        const glm::dvec3 exact = reference::reflected(n, p);
        const vec3 fast = reflect_nodes<VplKind::cluster>(all_of(std::span(&n, 1)), p);
        const double scale = scale_of(std::span(&n, 1), p);
        for (int c = 0; c < 3; ++c)
          CHECK(std::abs(double(fast[c]) - exact[c]) <= tolerance(exact[c], 100 * scale, 1e3));
      }
  }
}

TEST_CASE("a VPL at the point itself, a dark one and one behind give nothing") {
  Random random(3);
  for (int i = 0; i < 50; ++i) {
    const GlossyPoint p = support::room_points(random, 1)[0];
    VplNode at = support::any_vpl(random, p.position, -p.normal);
    VplNode behind = support::any_vpl(random, p.position - p.normal, p.normal);
    CHECK(reflect_nodes<VplKind::single>(all_of(std::vector{at, behind, VplNode{}}), p) == vec3(0));
    CHECK(reflect_nodes<VplKind::cluster>(all_of(std::vector{at, behind, VplNode{}}), p) == vec3(0));
  }
}

TEST_CASE("cuts are those of plain recursion on the same bounds") {
  Random random(4);
  std::size_t compared = 0, taken = 0;
  for (int round = 0; round < 120; ++round) {
    const auto count = 1 + random.below(300);
    const VplTree tree(round % 3 == 0 ? support::wild_vpls(random, count)
                                      : support::room_vpls(random, count));
    const auto points = round % 2 == 0 ? support::room_points(random, 1 + random.below(4))
                                       : support::coherent_points(random, 64);
    const Bounds bounds{tree, bound_of_points(points)};
    GroupCutter cutter(tree.blocks());
    for (const float limit : {0.0f, 1e-9f, 1e-6f, 1e-4f, 1e-2f, 1e30f}) {
      const SplitBy split = random.below(2) == 0 ? SplitBy::bound : SplitBy::bound_and_angle;
      const auto plain = reference::group_cut(tree.leaf_count(), bounds, double(limit), split);
      const auto cut = from_left(cutter.cut(bounds.points, limit, split), tree.leaf_count());
      CHECK((cutter.tests() > 0) == (tree.leaf_count() > 1));
      if (plain.margin < 1e-5) continue;
      CHECK(cut == plain.nodes);
      ++compared, taken += cut.size();
    }
  }
  CHECK(compared > 600);
  CHECK(taken > 10000);
}

TEST_CASE("the nodes of a cut are disjoint, and hold every VPL that brings anything") {
  Random random(5);
  for (int round = 0; round < 60; ++round) {
    const auto count = 1 + random.below(300);
    const VplTree tree(round % 2 == 0 ? support::wild_vpls(random, count)
                                      : support::room_vpls(random, count));
    const auto points = support::room_points(random, 3);
    GroupCutter cutter(tree.blocks());
    for (const float limit : {0.0f, 1e-6f, 1e-3f, 1e30f}) {
      std::vector<int> times(tree.leaf_count());
      const SplitBy split = random.below(2) == 0 ? SplitBy::bound : SplitBy::bound_and_angle;
      for (const std::uint32_t h : cutter.cut(bound_of_points(points), limit, split)) {
        const LeafRange range = leaves_below(tree.leaf_count(), h);
        for (std::uint32_t i = range.begin; i < range.end; ++i) ++times[i];
      }
      CHECK(*std::ranges::max_element(times) <= 1);
      for (std::uint32_t i = 0; i < tree.leaf_count(); ++i)
        for (const GlossyPoint& p : points)
          if (support::most(reference::reflected(tree.nodes()[tree.leaf_count() + i], p)) > 1e-30)
            CHECK(times[i] == 1);
    }
  }
}

TEST_CASE("threshold 0 gathers the sum over all VPLs") {
  Random random(6);
  for (const std::size_t count : {1u, 2u, 3u, 100u, 500u}) {
    const auto vpls = support::room_vpls(random, count, 1e3f);
    const auto points = support::room_points(random, 120, 1e3f);
    const PointGroups groups = support::in_groups(points, mixed_sizes);
    const Gathered g = gather_by_bound(VplTree(vpls), groups, 0, Serial());
    for (std::size_t i = 0; i < points.size(); ++i) {
      const glm::dvec3 exact = reference::reflected_by_all(vpls, points[i]);
      const double scale = scale_of(vpls, points[i]);
      for (int c = 0; c < 3; ++c)
        CHECK(std::abs(double(g.radiance[i][c]) - exact[c]) <= tolerance(exact[c], scale, 1e3));
      CHECK(g.nodes[i] <= std::bit_ceil(count));
    }
  }
}

TEST_CASE("the lower the threshold, the more nodes and the smaller the error") {
  Random random(7);
  const auto vpls = support::room_vpls(random, 1000, 100);
  const VplTree tree(vpls);
  std::vector<GlossyPoint> points;
  for (int g = 0; g < 30; ++g)
    for (const GlossyPoint& p : support::coherent_points(random, 16, 100)) points.push_back(p);
  const PointGroups groups = support::in_groups(points, std::array{16u});
  double last = 1e30;
  std::uint32_t last_nodes = 0;
  for (const float threshold : {1.0f, 0.3f, 0.1f, 0.03f, 0.01f, 0.003f}) {
    const Gathered g = gather_by_bound(tree, groups, threshold, Serial());
    const double e = error(g, points, vpls);
    const auto nodes = std::accumulate(g.nodes.begin(), g.nodes.end(), 0u);
    CHECK(e < last);
    CHECK(nodes > last_nodes);
    last = e, last_nodes = nodes;
  }
  CHECK(last < 0.01);  // measured: 0.0023 at 269 of 1,000; 0.026 at 49
}

TEST_CASE("any executor gathers the same bits, and counts the same") {
  Random random(8);
  const VplTree tree(support::room_vpls(random, 400));
  const PointGroups groups = support::in_groups(support::room_points(random, 500), mixed_sizes);
  const Gathered one = gather_by_bound(tree, groups, 0.05f, Serial());
  CHECK(one.tests > 0);
  CHECK(same_bits(one, gather_by_bound(tree, groups, 0.05f, support::Backwards())));
  CHECK(same_bits(one, gather_by_bound(tree, groups, 0.05f, support::Backwards{1})));
  CHECK(same_bits(one, gather_by_bound(tree, groups, 0.05f, support::TwoThreads())));
  CHECK(!same_bits(one, gather_by_bound(tree, groups, 0.04f, Serial())));
}

TEST_CASE("gathering counts each group's nodes and tests") {
  Random random(9);
  const VplTree tree(support::room_vpls(random, 200));
  const PointGroups groups = support::in_groups(support::room_points(random, 90), mixed_sizes);
  const GroupLists lists(tree, groups, 0.02f, Serial());
  const Gathered g = gather_by_bound(tree, groups, 0.02f, Serial());
  std::size_t visited = 0;
  const std::size_t tests = lists.for_each(0, groups.size(), [&](std::size_t first, auto points, auto ids) {
    for (std::size_t i = 0; i < points.size(); ++i, ++visited) CHECK(g.nodes[first + i] == ids.size());
  });
  CHECK(visited == groups.points.size());
  CHECK(tests == g.tests);
}

TEST_CASE("without VPLs, points or light everything is dark") {
  Random random(10);
  const PointGroups groups = support::in_groups(support::room_points(random, 20), mixed_sizes);
  const auto is_dark = [](const Gathered& g) {
    return std::ranges::all_of(g.radiance, [](const vec3& r) { return r == vec3(0); });
  };
  const Gathered none = gather_by_bound(VplTree(std::vector<VplNode>{}), groups, 0.02f, Serial());
  CHECK(none.radiance.size() == 20);
  CHECK((is_dark(none) && none.tests == 0));
  auto vpls = support::room_vpls(random, 30);
  CHECK(gather_by_bound(VplTree(vpls), PointGroups{}, 0.02f, Serial()).radiance.empty());
  for (VplNode& n : vpls) n.diffuse = n.specular = vec3(0), n.energy = 0;
  const Gathered dark = gather_by_bound(VplTree(vpls), groups, 0.02f, Serial());
  CHECK(is_dark(dark));
  CHECK(std::ranges::all_of(dark.nodes, [](std::uint32_t n) { return n == 0; }));
}
