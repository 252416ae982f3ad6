// Clusters of VPLs against sums over their leaves, and what a point reflects of one against double.
#include <coppice/shared/vpl.h>
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <coppice/core/random.hpp>
#include <coppice/core/simd.hpp>
#include <coppice/reference/lobe.hpp>
#include <vector>

using namespace coppice;
using glm::dvec3;

namespace {

vec3 any_colour(Random& random) { return vec3(random.uniform(), random.uniform(), random.uniform()); }

float power_of_ten(Random& random, float low, float high) {
  return std::pow(10.0f, low + (high - low) * random.uniform());
}

/// A lit VPL in a box of 6 m; one in four has no lobe, one in four nothing but its lobe.
VplNode any_vpl(Random& random) {
  VplNode node{};
  const std::uint32_t kind = random.below(4);
  const float scale = power_of_ten(random, -4, 1);
  if (kind != 0) node.diffuse = scale * any_colour(random);
  if (kind != 1) node.specular = scale * any_colour(random);
  node.energy = vpl_energy(node.diffuse, node.specular);
  node.exponent = power_of_ten(random, 0, 4);
  node.position = 6.0f * any_colour(random) - vec3(3);
  node.normal = normalize(random.direction());
  node.lobe = normalize(node.normal + 0.7f * random.direction());
  node.area = power_of_ten(random, -4, -2);
  node.softening = node.area / pi;
  return node;
}

VplNode dark_vpl(Random& random) {
  VplNode node = any_vpl(random);
  node.diffuse = node.specular = vec3(0);
  node.energy = 0;
  return node;
}

std::vector<VplNode> any_vpls(Random& random, std::size_t count) {
  std::vector<VplNode> vpls;
  for (std::size_t i = 0; i < count; ++i) vpls.push_back(i % 3 == 0 ? dark_vpl(random) : any_vpl(random));
  return vpls;
}

/// Level by level, as up a light tree.
VplNode cluster_of(std::vector<VplNode> nodes) {
  while (nodes.size() > 1) {
    for (std::size_t i = 0; i < nodes.size() / 2; ++i) nodes[i] = vpl_cluster(nodes[2 * i], nodes[2 * i + 1]);
    nodes.resize(nodes.size() / 2);
  }
  return nodes[0];
}

/// Sums and means over the leaves in double.
struct Totals {
  dvec3 diffuse{0}, specular{0}, position{0}, normal{0}, lobe{0};
  double energy = 0, variance = 0, softening = 0, area = 0;
};
Totals totals_of(const std::vector<VplNode>& leaves) {
  Totals t;
  std::vector<reference::Lobe> lobes;
  for (const VplNode& leaf : leaves) {
    const auto e = double(leaf.energy);
    t.diffuse += dvec3(leaf.diffuse), t.specular += dvec3(leaf.specular);
    t.energy += e, t.area += double(leaf.area), t.softening += e * double(leaf.softening);
    t.position += e * dvec3(leaf.position), t.normal += e * dvec3(leaf.normal);
    lobes.push_back(
        {dvec3(leaf.lobe), double(leaf.exponent), glm::dot(dvec3(leaf.specular), {0.2126, 0.7152, 0.0722})});
  }
  t.position /= t.energy, t.normal /= t.energy, t.softening /= t.energy;
  for (const VplNode& leaf : leaves) {
    const dvec3 d = dvec3(leaf.position) - t.position;
    t.variance += double(leaf.energy) * (double(leaf.variance) + glm::dot(d, d)) / t.energy;
  }
  t.lobe = reference::mean_direction(lobes);
  return t;
}

bool is_near(const vec3& value, const dvec3& exact, double relative) {
  return glm::length(dvec3(value) - exact) <= relative * glm::length(exact);
}

bool is_sound(const VplNode& n) {
  return is_finite(n.diffuse) && is_finite(n.specular) && is_finite(n.position) && is_finite(n.normal) &&
         is_finite(n.lobe) && std::isfinite(n.energy + n.variance + n.softening + n.area + n.exponent) &&
         n.variance >= 0 && n.exponent >= -1;
}

void check_same(const VplNode& a, const VplNode& b) {
  CHECK(is_near(a.diffuse, dvec3(b.diffuse), 1e-6));
  CHECK(is_near(a.specular, dvec3(b.specular), 1e-6));
  CHECK(length(a.position - b.position) <= 1e-6f);
  CHECK(length(a.normal - b.normal) <= 1e-6f);
  CHECK(a.energy == doctest::Approx(b.energy).epsilon(1e-6));
  CHECK(a.variance == doctest::Approx(b.variance).epsilon(1e-6));
  CHECK(a.softening == doctest::Approx(b.softening).epsilon(1e-6));
  if (b.specular == vec3(0)) return;  // no lobe
  CHECK(length(a.lobe - b.lobe) <= 1e-6f);
  CHECK(a.exponent + 2 == doctest::Approx(b.exponent + 2).epsilon(2e-6));
}

GlossyPoint any_point(Random& random) {
  GlossyPoint p{};
  p.position = 6.0f * any_colour(random) - vec3(3);
  p.normal = normalize(random.direction());
  p.mirror = normalize(p.normal + 0.9f * random.direction());
  p.exponent = power_of_ten(random, 0, 5);
  return p;
}

/// Node and point as REALs of one value each.
template <class R>
VplShape<R> shape_of(const VplNode& n) {
  return {R(n.position.x), R(n.position.y), R(n.position.z), R(n.variance), R(n.normal.x), R(n.normal.y),
          R(n.normal.z),   R(n.softening),  R(n.lobe.x),     R(n.lobe.y),   R(n.lobe.z),   R(n.exponent)};
}
template <class R>
PointShape<R> shape_of(const GlossyPoint& p) {
  return {R(p.position.x), R(p.position.y), R(p.position.z), R(p.exponent), R(p.normal.x),
          R(p.normal.y),   R(p.normal.z),   R(p.mirror.x),   R(p.mirror.y), R(p.mirror.z)};
}

float first(float x) { return x; }
float first(Lanes x) {
  std::array<float, Lanes::width> all;
  x.store(all.data());
  return all[0];
}

/// Of one VPL, or of a cluster, whose extent widens both lobes.
enum class Of { vpl, cluster };

template <class R>
std::array<double, 4> terms_of(const VplNode& node, const GlossyPoint& point, Of of) {
  const auto n = shape_of<R>(node);
  const auto p = shape_of<R>(point);
  const auto arrival = vpl_arrival(n, p);
  const auto terms = of == Of::vpl ? vpl_terms(n, p, arrival) : vpl_cluster_terms(n, p, arrival);
  return {double(first(terms.lobe)), double(first(terms.diffuse)), double(first(terms.specular)),
          double(first(arrival.widening))};
}

/// The same from the definitions.
struct Twin {
  dvec3 direction;
  double geometry, widening, lobe, reflected;
  double lobe_peak, reflected_peak;
  double widened_by;

  Twin(const VplNode& node, const GlossyPoint& point, Of of) {
    const dvec3 apart = dvec3(node.position) - dvec3(point.position);
    const double squared = std::max(glm::dot(apart, apart), 1e-12);
    direction = apart / std::sqrt(squared);
    const double here = std::max(0.0, glm::dot(direction, dvec3(point.normal)));
    const double there = std::max(0.0, -glm::dot(direction, dvec3(node.normal)));
    geometry = here * there / (squared + double(node.softening));
    widening = double(node.variance) / (3 * squared);
    widened_by = of == Of::vpl ? 0 : widening;
    const double k = widened(std::max(0.0, double(node.exponent)));
    const double n = widened(double(point.exponent));
    lobe = reference::lobe_radiance(k, -glm::dot(direction, glm::normalize(dvec3(node.lobe))));
    lobe_peak = reference::lobe_radiance(k, 1);
    reflected_peak = (n + 2) / (2 * std::numbers::pi);
    reflected = reflected_peak / reference::lobe_radiance(n, 1) *
                reference::lobe_radiance(n, glm::dot(direction, glm::normalize(dvec3(point.mirror))));
  }
  double widened(double exponent) const { return exponent / (1 + exponent * widened_by); }
};

/// Node and point that shine and look at each other within their lobes, or all over.
void face_each_other(VplNode& node, GlossyPoint& point, Random& random) {
  const vec3 d = normalize(node.position - point.position);
  const float wide = 3 / std::sqrt(node.exponent + 1), narrow = 3 / std::sqrt(point.exponent + 1);
  node.lobe = normalize(-d + wide * random.uniform() * random.direction());
  point.mirror = normalize(d + narrow * random.uniform() * random.direction());
}

struct Worst {
  double lobe = 0, diffuse = 0, specular = 0, widening = 0;
};

/// Errors of the lobes are shares of their peaks over 1 + √exponent, those of the geometry shares of
/// 1/(distance² + softening).
template <class R>
Worst worst_errors(Of of) {
  Random random(9);
  Worst worst;
  const auto raise = [](double& w, double error) {
    w = std::isnan(error) ? INFINITY : std::max(w, std::abs(error));
  };
  for (int i = 0; i < 40000; ++i) {
    VplNode node = any_vpl(random);
    GlossyPoint point = any_point(random);
    if (i % 2) node.variance = power_of_ten(random, -6, 1);
    if (i % 4 > 1) face_each_other(node, point, random);
    const Twin exact(node, point, of);
    const auto [lobe, diffuse, specular, widening] = terms_of<R>(node, point, of);
    const dvec3 apart = dvec3(node.position) - dvec3(point.position);
    const double nearness = 1 / (glm::dot(apart, apart) + double(node.softening));
    const auto narrow = [&](double exponent) {
      return 1 + std::sqrt(std::max(0.0, exact.widened(exponent)));
    };
    raise(worst.lobe, (lobe - exact.lobe) / exact.lobe_peak / narrow(double(node.exponent)));
    raise(worst.diffuse, (diffuse * std::numbers::pi - exact.geometry) / nearness);
    raise(worst.specular, (specular - exact.geometry * exact.reflected) / nearness / exact.reflected_peak /
                              narrow(double(point.exponent)));
    if (exact.widening > 0) raise(worst.widening, widening / exact.widening - 1);
  }
  return worst;
}

}  // namespace

TEST_CASE("a cluster of 16,384 VPLs has the colours, energy and area of all") {
  Random random(1);
  for (const std::size_t count : {2u, 64u, 16384u}) {
    const auto leaves = any_vpls(random, count);
    const VplNode cluster = cluster_of(leaves);
    const Totals exact = totals_of(leaves);
    CHECK(is_near(cluster.diffuse, exact.diffuse, 1e-5));
    CHECK(is_near(cluster.specular, exact.specular, 1e-5));
    CHECK(cluster.energy == doctest::Approx(exact.energy).epsilon(1e-5));
    CHECK(cluster.area == doctest::Approx(exact.area).epsilon(1e-5));
    CHECK(cluster.energy == doctest::Approx(vpl_energy(cluster.diffuse, cluster.specular)).epsilon(1e-5));
  }
}

TEST_CASE("a cluster has the means of its VPLs by energy, and the variance and lobe of all") {
  Random random(2);
  for (const std::size_t count : {16u, 64u, 16384u}) {
    const auto leaves = any_vpls(random, count);
    const VplNode cluster = cluster_of(leaves);
    const Totals exact = totals_of(leaves);
    CHECK(glm::length(dvec3(cluster.position) - exact.position) <= 1e-5);
    CHECK(glm::length(dvec3(cluster.normal) - exact.normal) <= 1e-5);
    CHECK(cluster.variance == doctest::Approx(exact.variance).epsilon(1e-5));
    CHECK(cluster.softening == doctest::Approx(exact.softening).epsilon(1e-5));
    const double shortfall = 1 - glm::length(exact.lobe);
    CHECK(double(cluster.exponent) + 2 == doctest::Approx(1 / shortfall).epsilon(1e-4));
    CHECK(glm::length(dvec3(cluster.lobe) - glm::normalize(exact.lobe)) <= 1e-4);
  }
}

TEST_CASE("the variance of VPLs close together far from the origin keeps its digits") {
  Random random(3);
  auto leaves = any_vpls(random, 1024);
  for (VplNode& leaf : leaves) leaf.position = vec3(300, -200, 100) + leaf.position * 0.01f;
  const Totals exact = totals_of(leaves);
  CHECK(cluster_of(leaves).variance == doctest::Approx(exact.variance).epsilon(2e-3));
}

TEST_CASE("a dark VPL changes nothing of a cluster but its area, and dark ones make no NaN") {
  Random random(4);
  for (int i = 0; i < 100; ++i) {
    const VplNode lit = any_vpl(random), dark = dark_vpl(random);
    const VplNode left = vpl_cluster(lit, dark), right = vpl_cluster(dark, lit);
    check_same(left, lit);
    check_same(right, lit);
    CHECK(left.area == lit.area + dark.area);
    const VplNode none = vpl_cluster(dark, dark_vpl(random));
    CHECK(is_sound(none));
    CHECK(none.energy == 0);
    CHECK(none.diffuse + none.specular == vec3(0));
    CHECK(is_sound(vpl_cluster(VplNode{}, VplNode{})));
    CHECK(is_sound(vpl_cluster(VplNode{}, lit)));
    CHECK(is_sound(vpl_cluster(lit, VplNode{})));
  }
}

TEST_CASE("a VPL and itself are that VPL, twice") {
  Random random(5);
  for (int i = 0; i < 100; ++i) {
    const VplNode one = any_vpl(random);
    VplNode two = vpl_cluster(one, one);
    CHECK(two.energy == 2 * one.energy);
    CHECK(two.area == 2 * one.area);
    CHECK(two.position == one.position);
    CHECK(two.variance == 0);
    two.diffuse *= 0.5f, two.specular *= 0.5f, two.energy *= 0.5f;
    check_same(two, one);
  }
}

TEST_CASE("lobes that point apart give a cluster that shines as if evenly over half the sphere") {
  Random random(6);
  for (int i = 0; i < 100; ++i) {
    VplNode a = any_vpl(random);
    a.specular = vec3(1);
    VplNode b = a;
    b.lobe = -a.lobe;
    const VplNode c = vpl_cluster(a, b);
    CHECK(c.exponent == doctest::Approx(-1).epsilon(1e-5));
    CHECK(c.lobe == a.lobe);
    const auto radiance = [&](const vec3& from) {
      GlossyPoint point = any_point(random);
      point.position = c.position + from;
      return terms_of<float>(c, point, Of::cluster)[0];
    };
    CHECK(radiance(c.lobe) == doctest::Approx(0.5 * std::numbers::inv_pi).epsilon(1e-6));
    CHECK(radiance(-c.lobe) == 0);
  }
}

TEST_CASE("the means of a cluster lie between those of its parts") {
  Random random(7);
  for (int i = 0; i < 1000; ++i) {
    const VplNode a = any_vpl(random), b = any_vpl(random), c = vpl_cluster(a, b);
    CHECK(is_sound(c));
    for (int k = 0; k < 3; ++k) {
      CHECK(c.position[k] >= std::min(a.position[k], b.position[k]) - 1e-6f);
      CHECK(c.position[k] <= std::max(a.position[k], b.position[k]) + 1e-6f);
    }
    CHECK(length(c.normal) <= 1 + 1e-6f);
    CHECK(c.softening <= std::max(a.softening, b.softening) * (1 + 1e-6f));
    CHECK(c.exponent <= std::max(a.exponent, b.exponent) * (1 + 1e-5f));
    const vec3 apart = a.position - b.position;
    CHECK(c.variance <= 0.25f * dot(apart, apart) * (1 + 1e-6f));
  }
}

TEST_CASE("what a point reflects of a VPL keeps its error against double, one and a register of them") {
  for (const Worst& worst : {worst_errors<float>(Of::vpl), worst_errors<float>(Of::cluster),
                             worst_errors<Lanes>(Of::vpl), worst_errors<Lanes>(Of::cluster)}) {
    CAPTURE(worst.lobe);
    CAPTURE(worst.diffuse);
    CAPTURE(worst.specular);
    CAPTURE(worst.widening);
    CHECK(worst.lobe <= 3e-7);
    CHECK(worst.diffuse <= 5e-7);
    CHECK(worst.specular <= 4e-7);
    CHECK(worst.widening <= 1e-6);
    CHECK(worst.lobe > 0);
  }
}

TEST_CASE("a VPL below a horizon, or at the point itself, gives nothing, and no NaN") {
  Random random(8);
  for (int i = 0; i < 300; ++i) {
    VplNode node = any_vpl(random);
    GlossyPoint point = any_point(random);
    if (i % 3 == 0) node.softening = node.variance = 0;
    if (i % 2) point.position = node.position;
    const Of of = i % 4 < 2 ? Of::vpl : Of::cluster;
    const Twin exact(node, point, of);
    const auto terms = terms_of<float>(node, point, of);
    for (const double term : terms) CHECK(std::isfinite(term));
    for (const double term : terms) CHECK(term >= 0);
    if (exact.geometry == 0) {
      CHECK(terms[1] <= 1e-6 / (double(node.softening) + 1e-6));
      CHECK((i % 2 == 0 || terms[1] == 0));
      CHECK((i % 2 == 0 || terms[2] == 0));
    }
  }
}
