// What a node brings at most, against the double sum over its VPLs, whatever the VPLs and the points.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>

#include "gather/vpls.hpp"

using namespace coppice;

namespace {

/// A group with its tree, node by node: the most that any point gets in any channel.
struct Compared {
  const VplTree& tree;
  std::vector<GlossyPoint> points;
  PointBound bound;
  std::vector<double> exact;  ///< by heap id

  Compared(const VplTree& t, std::vector<GlossyPoint> p)
      : tree(t), points(std::move(p)), bound(bound_of_points(points)), exact(t.nodes().size()) {
    for (const GlossyPoint& point : points) {
      const auto sums = aggregate(
          tree.leaf_count(),
          [&](std::uint32_t i) { return reference::reflected(tree.nodes()[tree.leaf_count() + i], point); },
          [](const glm::dvec3& a, const glm::dvec3& b) { return a + b; });
      for (std::size_t h = 1; h < sums.size(); ++h) exact[h] = std::max(exact[h], support::most(sums[h]));
    }
  }

  double bounded(std::uint32_t h) const { return support::bounded(bound, tree.bounds()[h], 0).first; }
};

/// How often bounds fail by more than the rounding of their own product. Floats may lose what is below 1e-30.
struct Violations {
  std::size_t bright = 0, count = 0;

  void add(const Compared& compared) {
    for (std::uint32_t h = 1; h < compared.exact.size(); ++h) {
      const double exact = compared.exact[h], bound = compared.bounded(h);
      CHECK(std::isfinite(bound));
      bright += exact > 0;
      count += exact > bound * (1 + 1e-5) + 1e-30;
    }
  }
};

std::vector<VplNode> any_vpls(Random& random, int kind, std::size_t count) {
  return kind % 2 == 0 ? support::room_vpls(random, count) : support::wild_vpls(random, count);
}

/// At each of the VPLs: a point a little off, whose mirror and the VPL's lobe meet exactly.
std::vector<GlossyPoint> points_in_lobes(Random& random, std::vector<VplNode>& vpls, std::size_t count) {
  std::vector<GlossyPoint> points;
  for (std::size_t i = 0; i < count; ++i) {
    VplNode& n = vpls[random.below(std::uint32_t(vpls.size()))];
    const vec3 away = normalize(n.normal + 0.9f * random.direction());
    const vec3 place = n.position + support::spread(random, 1e-3f, 5) * away;
    GlossyPoint p = support::any_point(random, place, normalize(0.9f * random.direction() - away));
    p.mirror = normalize(n.position - p.position), n.lobe = -p.mirror;
    points.push_back(p);
  }
  return points;
}

/// Points whose horizons pass through VPLs, or in the planes of patches.
std::vector<GlossyPoint> grazing_points(Random& random, std::span<const VplNode> vpls, std::size_t count) {
  std::vector<GlossyPoint> points;
  for (std::size_t i = 0; i < count; ++i) {
    const VplNode& n = vpls[random.below(std::uint32_t(vpls.size()))];
    const vec3 across = normalize(cross(n.normal, random.direction()));
    const vec3 lift = support::spread(random, 1e-7f, 1e-1f) * n.normal;
    const vec3 place = n.position + support::spread(random, 1e-2f, 3) * across + lift;
    const vec3 normal = random.below(2) == 0 ? n.normal : normalize(cross(across, random.direction()));
    points.push_back(support::any_point(random, place, normal));
  }
  return points;
}

/// Bound over exact, the median over the nodes that are four of their own diagonals away from a point.
/// Exponents up to `most`; 0: nothing has a lobe.
double median_ratio(Random& random, float most) {
  std::vector<double> ratios;
  for (int round = 0; round < 20; ++round) {
    auto vpls = support::room_vpls(random, 256, std::max(most, 1.0f));
    if (most == 0)
      for (VplNode& n : vpls) n.specular = vec3(0);
    const VplTree tree(vpls);
    for (GlossyPoint p : support::room_points(random, 10, std::max(most, 1.0f))) {
      if (most == 0) p.specular = vec3(0), p.diffuse = vec3(0.5f);
      const Compared compared(tree, {p});
      for (std::uint32_t h = 2; h < tree.leaf_count(); ++h) {
        const VplBound& b = tree.bounds()[h];
        const vec3 apart = 0.5f * (b.low + b.high) - p.position;
        if (length(apart) < 4 * length(b.high - b.low) || compared.exact[h] == 0) continue;
        ratios.push_back(compared.bounded(h) / compared.exact[h]);
      }
    }
  }
  REQUIRE(ratios.size() > 2000);
  std::ranges::sort(ratios);
  return ratios[ratios.size() / 2];
}

}  // namespace

TEST_CASE("no single point gets more of a node than the node's bound") {
  Random random(1);
  Violations v;
  for (int round = 0; round < 60; ++round) {
    const VplTree tree(any_vpls(random, round, 1 + random.below(256)));
    for (const GlossyPoint& p : support::room_points(random, 8)) v.add({tree, {p}});
  }
  CHECK(v.count == 0);
  CHECK(v.bright > 10000);
}

TEST_CASE("no point of a group gets more of a node than the node's bound") {
  Random random(2);
  Violations v;
  for (int round = 0; round < 60; ++round) {
    const VplTree tree(any_vpls(random, round, 1 + random.below(128)));
    v.add({tree, support::coherent_points(random, 64)});
    v.add({tree, support::room_points(random, 5)});
  }
  CHECK(v.count == 0);
  CHECK(v.bright > 10000);
}

TEST_CASE("bounds hold in the middle of the narrowest lobes") {
  Random random(3);
  Violations v;
  for (int round = 0; round < 60; ++round) {
    auto vpls = any_vpls(random, round, 1 + random.below(128));
    const auto points = points_in_lobes(random, vpls, 12);
    const VplTree tree(vpls);
    for (const GlossyPoint& p : points) v.add({tree, {p}});
    v.add({tree, points});
  }
  CHECK(v.count == 0);
  CHECK(v.bright > 10000);
}

TEST_CASE("bounds hold among the VPLs of a node") {
  Random random(4);
  Violations v;
  for (int round = 0; round < 60; ++round) {
    const auto vpls = any_vpls(random, round, 1 + random.below(128));
    const VplTree tree(vpls);
    for (int i = 0; i < 8; ++i) {
      const vec3 place = vpls[random.below(std::uint32_t(vpls.size()))].position;
      const vec3 near = place + support::in_cube(random, support::spread(random, 1e-4f, 1));
      v.add({tree, {support::any_point(random, near, random.direction())}});
    }
  }
  CHECK(v.count == 0);
  CHECK(v.bright > 10000);
}

TEST_CASE("bounds hold where VPLs and points lie in each other's planes") {
  Random random(5);
  Violations v;
  for (int round = 0; round < 60; ++round) {
    const auto vpls = any_vpls(random, round, 1 + random.below(128));
    const VplTree tree(vpls);
    const auto points = grazing_points(random, vpls, 8);
    for (const GlossyPoint& p : points) v.add({tree, {p}});
    v.add({tree, points});
  }
  CHECK(v.count == 0);
  CHECK(v.bright > 10000);
}

TEST_CASE("bounds hold far from the origin") {
  Random random(6);
  Violations v;
  for (int round = 0; round < 60; ++round) {
    const vec3 far = support::spread(random, 10, 1e4f) * random.direction();
    auto vpls = any_vpls(random, round, 1 + random.below(128));
    for (VplNode& n : vpls) n.position += far;
    const VplTree tree(vpls);
    for (int i = 0; i < 8; ++i) {
      const vec3 place = vpls[random.below(std::uint32_t(vpls.size()))].position;
      const vec3 near = place + support::in_cube(random, support::spread(random, 1e-3f, 3));
      v.add({tree, {support::any_point(random, near, random.direction())}});
    }
    auto points = grazing_points(random, vpls, 8);
    for (const GlossyPoint& p : points) v.add({tree, {p}});
    v.add({tree, points});
  }
  CHECK(v.count == 0);
  CHECK(v.bright > 10000);
}

TEST_CASE("far nodes bring about as much as their bounds say") {
  Random random(7);
  const double diffuse = median_ratio(random, 0), glossy = median_ratio(random, 100);
  CHECK(diffuse < 2);  // measured: 1.10
  CHECK(glossy < 4);   // measured: 3.2
}

TEST_CASE("a single VPL that a diffuse point sees is bounded to rounding") {
  Random random(8);
  for (int i = 0; i < 200; ++i) {
    VplNode n = support::room_vpls(random, 1)[0];
    GlossyPoint p = support::room_points(random, 1)[0];
    n.specular = p.specular = vec3(0), n.diffuse = vec3(2, 1, 1), p.diffuse = vec3(0.5f, 0.5f, 0.1f);
    const VplTree tree(std::vector{n});
    const Compared compared(tree, {p});
    const glm::dvec3 d = glm::normalize(glm::dvec3(n.position) - glm::dvec3(p.position));
    if (dot(d, glm::dvec3(p.normal)) < 0.1 || -dot(d, glm::dvec3(n.normal)) < 0.1) continue;
    CHECK(compared.bounded(1) == doctest::Approx(compared.exact[1]).epsilon(1e-4));
  }
}

TEST_CASE("nodes without light, and those wholly below a horizon, are bounded by 0") {
  Random random(9);
  auto vpls = support::room_vpls(random, 50);
  for (VplNode& n : vpls) n.diffuse = n.specular = vec3(0), n.energy = 0;
  const VplTree dark(vpls);
  const Compared in_the_dark(dark, support::room_points(random, 3));
  for (std::uint32_t h = 1; h < 2 * dark.leaf_count(); ++h) {
    CHECK(dark.bounds()[h].is_dark());
    CHECK(in_the_dark.bounded(h) == 0);
  }
  vpls = support::room_vpls(random, 50);
  const VplTree tree(vpls);
  GlossyPoint above = support::any_point(random, {0.3f, 5, 0.1f}, {0, 1, 0});
  GlossyPoint outside = support::any_point(random, {0, 2.5f, 0}, {0, -1, 0});
  outside.position = vec3(0, 2.001f, 0);
  for (VplNode& n : vpls) n.position.y = 2, n.normal = vec3(0, -1, 0);
  const VplTree ceiling(vpls);
  CHECK(Compared(tree, {above}).bounded(1) == 0);       // they are below its horizon
  CHECK(Compared(ceiling, {outside}).bounded(1) == 0);  // it is below theirs
}

TEST_CASE("the angle is the most that a node's size covers, up to the whole sphere's root") {
  Random random(10);
  for (int i = 0; i < 300; ++i) {
    const VplTree tree(any_vpls(random, i, 1 + random.below(32)));
    const auto points = support::room_points(random, 4);
    const PointBound bound = bound_of_points(points);
    const float size = support::spread(random, 1e-3f, 10);
    for (std::uint32_t h = 1; h < 2 * tree.leaf_count(); ++h) {
      if (tree.bounds()[h].is_dark()) continue;
      double most = 0;
      for (const VplNode& n : support::vpls_below(tree, h))
        for (const GlossyPoint& p : points)
          if (n.energy > 0)
            most = std::max(
                most, double(size) / std::sqrt(double(dot(n.position - p.position, n.position - p.position) +
                                                      n.softening)));
      const double angle = support::bounded(bound, tree.bounds()[h], size).second;
      CHECK(angle >= std::min(most, std::sqrt(4 * std::numbers::pi)) * (1 - 1e-5));
      CHECK(angle <= std::sqrt(4 * std::numbers::pi) * (1 + 1e-6));
    }
    CHECK(support::bounded(bound, tree.bounds()[1], 0).second == 0);
  }
}
