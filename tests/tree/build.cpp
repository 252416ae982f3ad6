// What every light tree is: a permutation of the lights with the padding spread evenly, the same each time.
#include <doctest/doctest.h>

#include <coppice/light/directions.hpp>
#include <coppice/tree/aggregate.hpp>
#include <coppice/tree/build.hpp>
#include <string>
#include <vector>

#include "support/generators.hpp"

using namespace coppice;
using namespace test_support;

namespace {

bool is_permutation_of_lights(const LightTree& tree, std::uint32_t lights) {
  std::vector<int> seen(lights, 0);
  for (const std::uint32_t light : tree.light_of_leaf) {
    if (light == no_light) continue;
    if (light >= lights) return false;
    ++seen[light];
  }
  return std::ranges::all_of(seen, [](int times) { return times == 1; });
}

bool counts_are_consistent(const LightTree& tree) {
  const std::uint32_t n = tree.leaf_count();
  for (std::uint32_t h = 1; h < 2 * n; ++h) {
    const std::uint32_t below = h >= n ? (tree.light_of_leaf[h - n] == no_light ? 0u : 1u)
                                       : tree.light_count[2 * h] + tree.light_count[2 * h + 1];
    if (tree.light_count[h] != below) return false;
  }
  return true;
}

bool padding_is_spread(const LightTree& tree) {
  for (std::uint32_t h = 1; h < tree.leaf_count(); ++h) {
    const auto left = std::int64_t(tree.light_count[2 * h]),
               right = std::int64_t(tree.light_count[2 * h + 1]);
    if (left - right < 0 || left - right > 1) return false;
  }
  return true;
}

void check_tree(const std::vector<LightSample>& lights) {
  CAPTURE(lights.size());
  const auto count = std::uint32_t(lights.size());
  const LightTree tree = build_tree(GeometricMetric(lights));
  REQUIRE(tree.leaf_count() == leaf_count_for(count));
  REQUIRE(tree.light_count.size() == 2 * std::size_t(tree.leaf_count()));
  CHECK(is_permutation_of_lights(tree, count));
  CHECK(counts_are_consistent(tree));
  CHECK(padding_is_spread(tree));
  if (count > 0) CHECK(tree.light_count[1] == count);
  const LightTree again = build_tree(GeometricMetric(lights));
  CHECK(again.light_of_leaf == tree.light_of_leaf);
  CHECK(again.light_count == tree.light_count);
}

std::vector<std::uint32_t> without_padding(const LightTree& tree) {
  std::vector<std::uint32_t> lights;
  for (const std::uint32_t l : tree.light_of_leaf)
    if (l != no_light) lights.push_back(l);
  return lights;
}

std::vector<LightSample> distant(const std::vector<vec3>& directions) {
  std::vector<LightSample> lights;
  for (const vec3& d : directions) lights.push_back({d, vec3(0)});
  return lights;
}

struct SumOfPoints {
  double count = 0;
  glm::dvec3 sum{0};
  double squares = 0;

  friend SumOfPoints operator+(const SumOfPoints& a, const SumOfPoints& b) {
    return {a.count + b.count, a.sum + b.sum, a.squares + b.squares};
  }
  double squared_deviations() const { return squares - glm::dot(sum, sum) / count; }
};

/// Mean squared distance of the lights from the mean of their cluster, over the clusters of `level`.
double mean_squared_radius(const LightTree& tree, const std::vector<LightSample>& lights, int level) {
  const auto sums = aggregate(
      tree.leaf_count(),
      [&](std::uint32_t leaf) {
        const glm::dvec3 p(lights[tree.light_of_leaf[leaf]].position);
        return SumOfPoints{1, p, glm::dot(p, p)};
      },
      [](const SumOfPoints& a, const SumOfPoints& b) { return a + b; });
  double total = 0;
  for (std::uint32_t h = 1u << level; h < 2u << level; ++h) total += sums[h].squared_deviations();
  return total / double(lights.size());
}

/// The points of a geometric metric, whose number of coordinates is not known when compiling.
struct RunTimeMetric {
  GeometricMetric metric;

  std::size_t size() const { return metric.size(); }
  std::size_t dimension() const { return GeometricMetric::dimension(); }
  void write_point(std::uint32_t light, std::span<float> point) const { metric.write_point(light, point); }
};

/// Rows of lights along x in two heaps along y that lie a little closer together than the rows are long: the
/// order along x is a fixed point of the rounds, and a poor one.
std::vector<LightSample> two_long_heaps() {
  std::vector<LightSample> lights;
  for (int i = 0; i < 1024; ++i)
    lights.push_back({vec3(float(i / 2) / 511 - 0.5f, i % 2 == 0 ? 0.45f : -0.45f, 0), vec3(0)});
  return lights;
}

bool halves_are_heaps(const LightTree& tree) {
  for (std::uint32_t leaf = 0; leaf < 1024; ++leaf)
    if (tree.light_of_leaf[leaf] % 2 != tree.light_of_leaf[leaf < 512 ? 0 : 512] % 2) return false;
  return true;
}

constexpr std::uint32_t counts[]{0, 1, 2, 3, 5, 1000, 32768};

}  // namespace

TEST_CASE("scattered lights of any number make a tree") {
  Random random(1);
  for (const std::uint32_t count : counts) check_tree(scattered_lights(random, count));
}

TEST_CASE("coincident lights make a tree") {
  for (const std::uint32_t count : counts) {
    check_tree(std::vector<LightSample>(count, {vec3(1, 2, 3), vec3(0, 1, 0)}));
    check_tree(std::vector<LightSample>(count, {vec3(0), vec3(0)}));
  }
}

TEST_CASE("a few places with many lights each make a tree") {
  Random random(2);
  const auto places = scattered_lights(random, 3);
  std::vector<LightSample> lights;
  for (int i = 0; i < 1000; ++i) lights.push_back(places[random.below(3)]);
  check_tree(lights);
}

TEST_CASE("collinear lights make a tree in the order of the line, however they are numbered") {
  Random random(3);
  for (const std::uint32_t count : counts) {
    const auto place = shuffled(random, count);
    std::vector<LightSample> lights(count);
    for (std::uint32_t i = 0; i < count; ++i) lights[i].position = vec3(0, 10 + float(place[i]) / 64, 0);
    check_tree(lights);
    std::vector<std::uint32_t> places;
    for (const std::uint32_t l : without_padding(build_tree(GeometricMetric(lights))))
      places.push_back(place[l]);
    CHECK(std::ranges::is_sorted(places));
  }
}

TEST_CASE("any number of lights, in any scale, makes a tree") {
  CHECK(rc::check([] {
    Random random = any_random();
    auto lights = scattered_lights(random, *rc::gen::inRange(0u, 300u));
    const float scale = std::pow(10.0f, float(*rc::gen::inRange(-40, 37)));
    for (auto& l : lights) l.position *= scale;
    const LightTree tree = build_tree(GeometricMetric(lights));
    RC_ASSERT(tree.leaf_count() == leaf_count_for(lights.size()));
    RC_ASSERT(is_permutation_of_lights(tree, std::uint32_t(lights.size())));
    RC_ASSERT(counts_are_consistent(tree));
    RC_ASSERT(padding_is_spread(tree));
  }));
}

TEST_CASE("two groups are the two halves, by position or by normal") {
  Random random(4);
  std::vector<LightSample> by_position, by_normal;
  for (int i = 0; i < 64; ++i) {
    const float side = i % 2 == 0 ? 1.0f : -1.0f;
    by_position.push_back({vec3(side * 5, 0, 0) + 0.5f * random.direction(), random.direction()});
    by_normal.push_back({vec3(1, 2, 3), normalize(vec3(0, side, 0) + 0.2f * random.direction())});
  }
  for (const auto& lights : {by_position, by_normal}) {
    const LightTree tree = build_tree(GeometricMetric(lights));
    for (std::uint32_t leaf = 0; leaf < 64; ++leaf)
      CHECK(tree.light_of_leaf[leaf] % 2 == tree.light_of_leaf[leaf < 32 ? 0 : 32] % 2);
  }
}

TEST_CASE("clusters of even directions are about as compact as squares") {
  const auto lights = distant(even_directions(4096));
  const LightTree tree = build_tree(GeometricMetric(lights));
  for (const int level : {4, 6, 8}) {
    CAPTURE(level);
    const double square = 4 * std::numbers::pi / (1 << level) / 6;
    CHECK(mean_squared_radius(tree, lights, level) < 1.25 * square);
  }
}

TEST_CASE("other iterations make other trees, all of them whole") {
  Random random(5);
  const auto lights = scattered_lights(random, 500);
  for (const int iterations : {0, 1, 8, 20})
    CHECK(is_permutation_of_lights(build_tree(GeometricMetric(lights), {iterations}), 500));
  CHECK(build_tree(GeometricMetric(lights), {0}).light_of_leaf !=
        build_tree(GeometricMetric(lights)).light_of_leaf);
}

TEST_CASE("the tree is the same where the number of coordinates is known only at run time") {
  Random random(6);
  for (const std::uint32_t count : counts) {
    const auto lights = scattered_lights(random, count);
    const GeometricMetric metric(lights);
    for (const TreeOptions options : {TreeOptions{}, TreeOptions{8, 3}})
      CHECK(build_tree(RunTimeMetric{metric}, options).light_of_leaf ==
            build_tree(metric, options).light_of_leaf);
  }
}

TEST_CASE("several first guesses find the split that one misses") {
  const auto lights = two_long_heaps();
  const GeometricMetric metric(lights);
  CHECK_FALSE(halves_are_heaps(build_tree(metric)));
  for (const std::size_t starts : {2u, 6u, 100u}) {
    const LightTree tree = build_tree(metric, {8, starts});
    CHECK(halves_are_heaps(tree));
    CHECK(is_permutation_of_lights(tree, 1024));
    CHECK(counts_are_consistent(tree));
  }
}
