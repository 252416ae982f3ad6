// Filtered trees against direct sums over the VPLs of each node, and refits against filtering anew.
#include <doctest/doctest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <coppice/gather/group_lists.hpp>
#include <cstring>

#include "gather/vpls.hpp"
#include "support/generators.hpp"

using namespace coppice;

namespace {

constexpr VplFilter filters[] = {VplFilter::moments, VplFilter::uniform};
constexpr VplClustering clusterings[] = {VplClustering::squared, VplClustering::lengths, VplClustering::kd};

template <class T>
bool same_bits(std::span<const T> a, std::span<const T> b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

bool same_trees(const VplTree& a, const VplTree& b) {
  return same_bits(a.nodes(), b.nodes()) && same_bits(a.bounds(), b.bounds());
}

std::vector<vec3> gathered(const VplTree& tree, std::span<const GlossyPoint> points) {
  const PointGroups groups = support::in_groups(points, std::array{3u});
  return gather_by_bound(tree, groups, 0.05f, Serial()).radiance;
}

/// Weighted mean of vectors and its weighted mean squared distance.
struct MeanOfVectors {
  glm::dvec3 sum{0};
  double weight = 0;

  void add(const vec3& v, double w) { sum += w * glm::dvec3(v), weight += w; }
  glm::dvec3 mean() const { return sum / weight; }
};

double distance(const vec3& a, const glm::dvec3& b) { return glm::length(glm::dvec3(a) - b); }

/// The paper's filtering of the VPLs of a node (Filtering Eq. 3 and 4), plainly.
struct PaperLobe {
  glm::dvec3 direction{0};
  double exponent = 0, lobes = 0;

  explicit PaperLobe(std::span<const VplNode> vpls) {
    double magnitudes = 0, exponents = 0;
    for (const VplNode& n : vpls) {
      const double magnitude = support::luminance(glm::dvec3(n.specular));
      if (!(magnitude > 0)) continue;
      direction += magnitude * glm::dvec3(n.lobe), magnitudes += magnitude;
      exponents += double(n.exponent), lobes += 1;
    }
    if (lobes == 0) return;
    const double kappa = std::max(exponents / lobes, 0.0), d = glm::length(direction) / magnitudes;
    exponent = d / (d + kappa * (1 - d)) * kappa;
    direction = glm::normalize(direction);
  }
};

/// Every VPL of some is moved to the place of another.
void shuffle(std::vector<VplNode>& vpls, std::size_t count, Random& random) {
  const auto order = test_support::shuffled(random, std::uint32_t(count));
  const auto before = vpls;
  for (std::size_t i = 0; i < count; ++i)
    vpls[i].position = before[order[i]].position, vpls[i].normal = before[order[i]].normal;
}

}  // namespace

TEST_CASE("a leaf shines as Lambert and a Phong lobe lit from one direction") {
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    SurfaceSample sample{.area = support::spread(random, 1e-4f, 1), .normal = random.direction(), .side = {}};
    const PhongSurface surface{support::any_colour(random), support::any_colour(random),
                               support::spread(random, 1, 1e4f)};
    const vec3 light = normalize(sample.normal + 0.9f * random.direction());
    const VplNode leaf = vpl_leaf(sample, surface, {vec3(2, 3, 4), 0, light});
    const vec3 mirror = 2 * dot(light, sample.normal) * sample.normal - light;
    const vec3 to = normalize(mirror + support::spread(random, 1e-3f, 0.5f) * random.direction());
    const double n = double(surface.exponent), cosine = double(dot(to, normalize(mirror)));
    const glm::dvec3 radiance =
        glm::dvec3(2, 3, 4) *
        (glm::dvec3(surface.diffuse) / std::numbers::pi +
         glm::dvec3(surface.specular) * ((n + 2) / 2 / std::numbers::pi * std::pow(cosine, n)));
    const glm::dvec3 shone = glm::dvec3(leaf.diffuse) +
                             glm::dvec3(leaf.specular) *
                                 reference::lobe_radiance(double(leaf.exponent), double(dot(to, leaf.lobe)));
    CHECK(glm::length(shone - double(sample.area) * radiance) <=
          3e-6 * (10 + n) * double(sample.area) * glm::length(radiance));
    CHECK(leaf.energy == vpl_energy(leaf.diffuse, leaf.specular));
  }
}

TEST_CASE("the more light spreads over directions the wider a leaf's lobe, and none is lost") {
  SurfaceSample sample{.area = 0.1f, .normal = vec3(0, 1, 0), .side = {}};
  const PhongSurface surface{vec3(0), vec3(0.5f), 100};
  float last = 101;
  for (const float shortfall : {0.0f, 1e-3f, 0.1f, 0.5f, 1.0f}) {
    const VplNode leaf = vpl_leaf(sample, surface, {vec3(1), shortfall, normalize(vec3(1, 1, 0))});
    CHECK(leaf.exponent < last);
    CHECK(leaf.specular.x == doctest::Approx(0.1 * 0.5 * 102 / 101));
    last = leaf.exponent;
  }
  CHECK(last == -1);
}

TEST_CASE("every VPL is at one leaf, unchanged; padding is dark") {
  Random random(2);
  for (const std::size_t count : {0u, 1u, 2u, 3u, 5u, 64u, 65u, 300u})
    for (const VplClustering clustering : clusterings) {
      const auto vpls = support::room_vpls(random, count);
      const VplTree tree(vpls, {.clustering = clustering});
      REQUIRE(tree.leaf_count() == leaf_count_for(count));
      REQUIRE(are_leaves(tree.tree().light_of_leaf, count));
      REQUIRE(tree.nodes().size() == 2 * tree.leaf_count());
      for (std::uint32_t i = 0; i < tree.leaf_count(); ++i) {
        const std::uint32_t vpl = tree.tree().light_of_leaf[i];
        const VplNode expected = vpl == no_light ? VplNode{} : vpls[vpl];
        CHECK(std::memcmp(&tree.nodes()[tree.leaf_count() + i], &expected, sizeof(VplNode)) == 0);
      }
    }
}

TEST_CASE("energy and area stay what they are up the tree, for both filters") {
  Random random(3);
  for (const VplFilter filter : filters)
    for (const std::size_t count : {1u, 2u, 3u, 100u, 1000u}) {
      const VplTree tree(support::wild_vpls(random, count), {.filter = filter});
      for (std::uint32_t h = 1; h < tree.leaf_count(); ++h) {
        const VplNode& n = tree.nodes()[h];
        glm::dvec3 diffuse(0), specular(0);
        double energy = 0, area = 0;
        for (const VplNode& leaf : support::vpls_below(tree, h)) {
          diffuse += glm::dvec3(leaf.diffuse), specular += glm::dvec3(leaf.specular);
          energy += double(leaf.energy), area += double(leaf.area);
        }
        CHECK(distance(n.diffuse, diffuse) <= 1e-5 * glm::length(diffuse));
        CHECK(distance(n.specular, specular) <= 1e-5 * glm::length(specular));
        CHECK(std::abs(double(n.energy) - energy) <= 1e-5 * energy);
        CHECK(std::abs(double(n.area) - area) <= 1e-5 * area);
        CHECK(std::abs(double(vpl_energy(n.diffuse, n.specular)) - energy) <= 1e-5 * energy);
      }
    }
}

TEST_CASE("moments are those of all VPLs of a node by their energy") {
  Random random(4);
  for (int round = 0; round < 20; ++round) {
    const VplTree tree(round % 2 == 0 ? support::wild_vpls(random, 200) : support::room_vpls(random, 200));
    for (std::uint32_t h = 1; h < tree.leaf_count(); ++h) {
      const VplNode& n = tree.nodes()[h];
      const auto vpls = support::vpls_below(tree, h);
      MeanOfVectors position, normal;
      double variance = 0, softening = 0, reach2 = 0, farthest = 0;
      for (const VplNode& v : vpls) {
        position.add(v.position, double(v.energy)), normal.add(v.normal, double(v.energy));
        softening += double(v.energy) * double(v.softening);
        farthest = std::max(farthest, double(length(v.position)));
      }
      if (position.weight == 0) continue;
      for (const VplNode& v : vpls) {
        if (!(v.energy > 0)) continue;
        const double d2 = distance(v.position, position.mean()) * distance(v.position, position.mean());
        variance += double(v.energy) / position.weight * d2, reach2 = std::max(reach2, d2);
      }
      const double rounding = 1e-6 * farthest;
      CHECK(distance(n.position, position.mean()) <= rounding);
      CHECK(distance(n.normal, normal.mean()) <= 2e-6);
      CHECK(double(n.softening) == doctest::Approx(softening / position.weight).epsilon(1e-5));
      CHECK(std::abs(double(n.variance) - variance) <= 1e-5 * variance + 1e-6 * reach2 + rounding * rounding);
    }
  }
}

TEST_CASE("a node's lobe has the mean direction of its VPLs' lobes by their energy") {
  Random random(5);
  for (int round = 0; round < 20; ++round) {
    const VplTree tree(support::room_vpls(random, 200, 1e4f));
    for (std::uint32_t h = 1; h < tree.leaf_count(); ++h) {
      const VplNode& n = tree.nodes()[h];
      std::vector<reference::Lobe> lobes;
      for (const VplNode& v : support::vpls_below(tree, h))
        lobes.push_back({glm::normalize(glm::dvec3(v.lobe)), double(v.exponent),
                         support::luminance(glm::dvec3(v.specular))});
      if (std::ranges::none_of(lobes, [](const auto& l) { return l.energy > 0; })) continue;
      std::erase_if(lobes, [](const auto& l) { return !(l.energy > 0); });
      const glm::dvec3 mean = reference::mean_direction(lobes);
      const double r = (double(n.exponent) + 1) / (double(n.exponent) + 2);
      CHECK(glm::length(r * glm::dvec3(n.lobe) - mean) <= 2e-6);
      CHECK(1 - r == doctest::Approx(1 - glm::length(mean)).epsilon(1e-4));
    }
  }
}

TEST_CASE("the paper's filter is Eq. 3 and 4 over all VPLs with light of a node") {
  Random random(6);
  for (int round = 0; round < 20; ++round) {
    const VplTree tree(support::room_vpls(random, 200, 300), {.filter = VplFilter::uniform});
    for (std::uint32_t h = 1; h < tree.leaf_count(); ++h) {
      const VplNode& n = tree.nodes()[h];
      auto vpls = support::vpls_below(tree, h);
      std::erase_if(vpls, [](const VplNode& v) { return !(v.energy > 0); });
      if (vpls.empty()) continue;
      MeanOfVectors position, normal;
      for (const VplNode& v : vpls) position.add(v.position, 1), normal.add(v.normal, 1);
      CHECK(distance(n.position, position.mean()) <= 1e-5);
      CHECK(distance(n.normal, normal.mean()) <= 1e-5);
      CHECK(n.variance == 0);
      const PaperLobe lobe(vpls);
      if (lobe.lobes == 0) continue;
      CHECK(distance(n.lobe, lobe.direction) <= 1e-4);
      CHECK(std::abs(double(n.exponent) - lobe.exponent) <= (1e-5 + 2e-6 * lobe.exponent) * lobe.exponent);
    }
  }
}

TEST_CASE("bounds hold every VPL with light, and no more than those at their faces") {
  Random random(7);
  const VplTree tree(support::wild_vpls(random, 300));
  for (std::uint32_t h = 1; h < 2 * tree.leaf_count(); ++h) {
    auto vpls = support::vpls_below(tree, h);
    std::erase_if(vpls, [](const VplNode& v) { return !(v.energy > 0); });
    const VplBound& b = tree.bounds()[h];
    CHECK(b.is_dark() == vpls.empty());
    if (vpls.empty()) continue;
    vec3 low = vpls[0].position, high = low, normal_low = vpls[0].normal, lobe_low(2);
    float slowest = 1e30f, softening = 1e30f;
    double diffuse = 0, peak = 0;
    for (const VplNode& v : vpls) {
      low = glm::min(low, v.position), high = glm::max(high, v.position);
      normal_low = glm::min(normal_low, v.normal), softening = std::min(softening, v.softening);
      const double k = std::max(double(v.exponent), (double(v.exponent) + 1) / 2);
      diffuse += double(brightest(v.diffuse));
      peak += double(brightest(v.specular)) * (k + 1) / 2 / std::numbers::pi;
      if (v.specular == vec3(0)) continue;
      lobe_low = glm::min(lobe_low, v.lobe), slowest = std::min(slowest, lobe_shining(v.exponent));
    }
    CHECK((b.low == low && b.high == high && b.normal_low == normal_low && b.softening == softening));
    CHECK(std::abs(double(b.diffuse) - diffuse) <= 1e-5 * diffuse);
    CHECK(std::abs(double(b.peak) - peak) <= 1e-5 * peak);
    if (peak > 0) CHECK((b.lobe_low == lobe_low && b.slowest == slowest));
  }
}

TEST_CASE("refitting along what has changed is filtering anew, bit for bit") {
  CHECK(rc::check([] {
    Random random = test_support::any_random();
    const auto count = std::size_t(*rc::gen::inRange(1, 300));
    const VplTreeOptions options{.clustering = clusterings[random.below(3)],
                                 .filter = filters[random.below(2)]};
    auto vpls = support::wild_vpls(random, count);
    VplTree refitted(vpls, options);
    VplTree anew = refitted;
    const auto points = support::room_points(random, 12);
    for (int frame = 0; frame < 4; ++frame) {
      std::vector<std::uint32_t> changed;
      for (std::uint32_t i = random.below(3); i < count; i += 1 + random.below(30)) changed.push_back(i);
      for (const std::uint32_t i : changed) vpls[i] = support::wild_vpls(random, 1)[0];
      refitted.refit(changed, vpls);
      anew.set(vpls);
      RC_ASSERT(same_trees(refitted, anew));
      const auto a = gathered(refitted, points), b = gathered(anew, points);
      RC_ASSERT(same_bits(std::span<const vec3>(a), std::span<const vec3>(b)));
    }
  }));
}

TEST_CASE("setting the VPLs that a tree was built over changes nothing") {
  Random random(8);
  for (const VplFilter filter : filters) {
    const auto vpls = support::room_vpls(random, 77);
    const VplTree built(vpls, {.filter = filter});
    VplTree set = built;
    set.set(support::room_vpls(random, 77));
    CHECK(!same_trees(set, built));
    set.set(vpls);
    CHECK(same_trees(set, built));
  }
}

TEST_CASE("no VPL, one, coincident ones and dark ones make trees of finite nodes") {
  Random random(9);
  auto dark = support::room_vpls(random, 33);
  for (VplNode& n : dark) n.diffuse = n.specular = vec3(0), n.energy = 0;
  auto coincident = std::vector<VplNode>(21, support::any_vpl(random, vec3(1), vec3(0, 1, 0)));
  auto opposite = coincident;
  for (std::size_t i = 0; i < opposite.size(); i += 2) opposite[i].lobe = -opposite[i].lobe;
  const auto points = support::room_points(random, 9);
  for (const auto& vpls : {std::vector<VplNode>{}, support::room_vpls(random, 1), dark, coincident, opposite})
    for (const VplFilter filter : filters)
      for (const VplClustering clustering : clusterings) {
        const VplTree tree(vpls, {.clustering = clustering, .filter = filter});
        const double looseness = tree.looseness();
        CHECK((looseness >= 0 && looseness <= 1));
        for (const VplNode& n : tree.nodes())
          for (std::size_t k = 0; k < sizeof(VplNode) / sizeof(float); ++k) {
            float x;
            std::memcpy(&x, reinterpret_cast<const char*>(&n) + k * sizeof(float), sizeof x);
            CHECK(std::isfinite(x));
          }
        for (const vec3& r : gathered(tree, points)) CHECK(is_finite(r));
      }
}

TEST_CASE("looseness is a share that grows as VPLs change places") {
  Random random(10);
  for (const VplClustering clustering : clusterings) {
    auto vpls = support::room_vpls(random, 500);
    VplTree tree(vpls, {.clustering = clustering});
    const double built = tree.looseness();
    CHECK((built > 0.3 && built < 0.7));
    double last = built;
    for (const std::size_t moved : {50u, 200u, 500u}) {
      shuffle(vpls, moved, random);
      tree.set(vpls);
      CHECK(tree.looseness() > last);
      last = tree.looseness();
    }
    CHECK((last > 0.65 && last <= 1));
    CHECK(VplTree(vpls, {.clustering = clustering, .filter = VplFilter::uniform}).looseness() == 0);
  }
}
