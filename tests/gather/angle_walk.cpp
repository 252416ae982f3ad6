// Gathering by solid angle against the recursive walk, point by point.
#include <doctest/doctest.h>

#include <algorithm>
#include <coppice/gather/angle_walk.hpp>
#include <cstring>

#include "gather/vpls.hpp"
#include "support/executors.hpp"

using namespace coppice;

namespace {

bool same_bits(const Gathered& a, const Gathered& b) {
  return a.nodes == b.nodes && a.tests == b.tests && a.radiance.size() == b.radiance.size() &&
         std::memcmp(a.radiance.data(), b.radiance.data(), a.radiance.size() * sizeof(vec3)) == 0;
}

/// Σ |n - n̄|² over the VPLs with light below a node, written out.
double normal_variance(std::span<const VplNode> vpls) {
  glm::dvec3 mean(0);
  double count = 0, sum = 0;
  for (const VplNode& n : vpls)
    if (n.energy > 0) mean += glm::dvec3(n.normal), count += 1;
  for (const VplNode& n : vpls)
    if (n.energy > 0)
      sum += glm::dot(glm::dvec3(n.normal) - mean / count, glm::dvec3(n.normal) - mean / count);
  return sum;
}

/// Single points against the twin; returns how many were compared.
std::size_t check_walks(Random& random, const VplTree& tree, std::span<const WalkMark> marks) {
  std::size_t compared = 0;
  for (const GlossyPoint& p : support::room_points(random, 4, 1e3f))
    for (const float threshold : {1e-4f, 0.01f, 0.3f, 3.0f, 6.2f}) {
      const auto plain = reference::walk_by_angle(tree.nodes(), p, double(threshold), marks);
      if (plain.margin < 2e-5 / double(std::min(threshold, 6.28f - threshold))) continue;
      const Gathered g = gather_by_angle(tree, std::span(&p, 1), threshold, marks, Serial());
      const double scale = 1e-4 * support::most(plain.radiance) + 1e-9;
      CHECK(g.nodes[0] == plain.nodes.size());
      for (int c = 0; c < 3; ++c) CHECK(std::abs(double(g.radiance[0][c]) - plain.radiance[c]) <= scale);
      ++compared;
    }
  return compared;
}

}  // namespace

TEST_CASE("a point's walk is the plain recursion with the paper's test") {
  Random random(1);
  std::size_t compared = 0;
  for (int round = 0; round < 40; ++round) {
    const VplTree tree(support::room_vpls(random, 1 + random.below(400), 1e3f));
    compared += check_walks(random, tree, {});
  }
  CHECK(compared > 500);
}

TEST_CASE("a point's walk obeys the marks of a min-max cut") {
  Random random(2);
  std::size_t compared = 0;
  for (int round = 0; round < 40; ++round) {
    const VplTree tree(support::room_vpls(random, 1 + random.below(400), 1e3f));
    compared += check_walks(random, tree, min_max_marks(tree, {.min = 30, .max = 2}));
  }
  CHECK(compared > 500);
}

TEST_CASE("points that walk together split what any of them would split") {
  Random random(3);
  const VplTree tree(support::room_vpls(random, 500, 1e3f));
  for (const std::size_t count : {std::size_t{1}, Lanes::width - 1, Lanes::width, Lanes::width + 1, 100ul}) {
    const auto points = support::room_points(random, count, 1e3f);
    const Gathered g = gather_by_angle(tree, points, 0.2f, {}, Serial());
    for (std::size_t i = 0; i < count; ++i) {
      CHECK(g.nodes[i] >= reference::walk_by_angle(tree.nodes(), points[i], 0.2000001).nodes.size());
      CHECK(g.nodes[i] == g.nodes[i / Lanes::width * Lanes::width]);
    }
  }
}

TEST_CASE("equal points that walk together walk as each alone") {
  Random random(4);
  const VplTree tree(support::room_vpls(random, 300, 1e3f));
  const GlossyPoint p = support::room_points(random, 1, 1e3f)[0];
  const std::vector<GlossyPoint> points(3 * Lanes::width + 1, p);
  const Gathered alone = gather_by_angle(tree, std::span(&p, 1), 0.1f, {}, Serial());
  const Gathered all = gather_by_angle(tree, points, 0.1f, {}, Serial());
  for (std::size_t i = 0; i < points.size(); ++i) {
    CHECK(all.nodes[i] == alone.nodes[0]);
    CHECK(all.radiance[i] == alone.radiance[0]);
  }
  CHECK(all.tests == 4 * alone.tests);  // a packet counts once
}

TEST_CASE("a threshold next to 0 reaches every VPL with light, one next to 2π the root alone from afar") {
  Random random(5);
  const auto vpls = support::room_vpls(random, 300, 1e3f);
  const VplTree tree(vpls);
  const auto shining = std::ranges::count_if(vpls, [](const VplNode& n) { return n.energy > 0; });
  for (GlossyPoint p : support::room_points(random, 20, 1e3f)) {
    const Gathered fine = gather_by_angle(tree, std::span(&p, 1), 1e-9f, {}, Serial());
    CHECK(fine.nodes[0] == shining);
    const glm::dvec3 exact = reference::reflected_by_all(vpls, p);
    CHECK(glm::length(glm::dvec3(fine.radiance[0]) - exact) <= 1e-4 * glm::length(exact) + 1e-9);
    p.position *= 20.0f;
    const Gathered coarse = gather_by_angle(tree, std::span(&p, 1), 6.28f, {}, Serial());
    CHECK((coarse.nodes[0] == 1 && coarse.tests == 1));
  }
}

TEST_CASE("marks say what the normals' variance says, written out") {
  Random random(6);
  std::size_t of_kind[3]{};
  for (int round = 0; round < 30; ++round) {
    const VplTree tree(support::room_vpls(random, 1 + random.below(300)));
    const MinMaxCut cut{40, 9};
    const auto marks = min_max_marks(tree, cut);
    REQUIRE(marks.size() == 2 * tree.leaf_count());
    for (std::uint32_t h = 1; h < tree.leaf_count(); ++h) {
      const double variance = normal_variance(support::vpls_below(tree, h));
      if (std::abs(variance - 40) < 1e-3 || std::abs(variance - 9) < 1e-3) continue;
      CHECK(marks[h] == (variance > 40 ? WalkMark::split : variance <= 9 ? WalkMark::take : WalkMark::test));
      ++of_kind[int(marks[h])];
    }
    for (std::uint32_t h = tree.leaf_count(); h < 2 * tree.leaf_count(); ++h)
      CHECK(marks[h] == WalkMark::test);
  }
  CHECK((of_kind[0] > 50 && of_kind[1] > 50 && of_kind[2] > 50));
}

TEST_CASE("extreme marks: all split reaches the leaves, all taken stops at the root") {
  Random random(7);
  const auto vpls = support::room_vpls(random, 100);
  const VplTree tree(vpls);
  const auto points = support::room_points(random, 20);
  const auto with = [&](WalkMark mark) {
    const std::vector<WalkMark> marks(tree.nodes().size(), mark);
    return gather_by_angle(tree, points, 0.1f, marks, Serial());
  };
  const auto shining = std::ranges::count_if(vpls, [](const VplNode& n) { return n.energy > 0; });
  for (const std::uint32_t n : with(WalkMark::split).nodes) CHECK(n == shining);
  for (const std::uint32_t n : with(WalkMark::take).nodes) CHECK(n == 1);
  CHECK(same_bits(with(WalkMark::test), gather_by_angle(tree, points, 0.1f, {}, Serial())));
}

TEST_CASE("without light or VPLs walks end at once") {
  Random random(8);
  const auto points = support::room_points(random, 20);
  auto vpls = support::room_vpls(random, 30);
  for (VplNode& n : vpls) n.diffuse = n.specular = vec3(0), n.energy = 0;
  for (const VplTree& tree : {VplTree(vpls), VplTree(std::vector<VplNode>{})}) {
    const Gathered g = gather_by_angle(tree, points, 0.1f, min_max_marks(tree, {}), Serial());
    CHECK(g.tests == 0);
    for (std::size_t i = 0; i < 20; ++i) CHECK((g.radiance[i] == vec3(0) && g.nodes[i] == 0));
  }
  CHECK(gather_by_angle(VplTree(vpls), {}, 0.1f, {}, Serial()).radiance.empty());
}

TEST_CASE("any executor walks to the same bits") {
  Random random(9);
  const VplTree tree(support::room_vpls(random, 400));
  const auto points = support::room_points(random, 333);
  const Gathered one = gather_by_angle(tree, points, 0.1f, {}, Serial());
  CHECK(same_bits(one, gather_by_angle(tree, points, 0.1f, {}, support::Backwards())));
  CHECK(same_bits(one, gather_by_angle(tree, points, 0.1f, {}, support::TwoThreads())));
}
