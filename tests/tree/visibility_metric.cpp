// The data-driven metric against Cuts Eq. 12 and 13, written out, and the trees that it makes.
#include <doctest/doctest.h>

#include <coppice/light/directions.hpp>
#include <coppice/tree/build.hpp>
#include <coppice/tree/visibility_metric.hpp>
#include <support/executors.hpp>
#include <vector>

#include "support/generators.hpp"

using namespace coppice;
using namespace test_support;

namespace {

LightVisibility random_vectors(Random& random, std::size_t lights, std::size_t length) {
  LightVisibility vectors{length, std::vector<float>(lights * length)};
  for (float& share : vectors.shares) share = float(random.below(9)) / 8;
  return vectors;
}

template <LightMetric Metric>
double squared_distance(const Metric& metric, std::uint32_t a, std::uint32_t b) {
  std::vector<float> p(metric.dimension()), q(metric.dimension());
  metric.write_point(a, p);
  metric.write_point(b, q);
  double sum = 0;
  for (std::size_t k = 0; k < p.size(); ++k)
    sum += (double(p[k]) - double(q[k])) * (double(p[k]) - double(q[k]));
  return sum;
}

double squared_difference(const LightVisibility& vectors, std::uint32_t a, std::uint32_t b) {
  double sum = 0;
  for (std::size_t k = 0; k < vectors.length; ++k) {
    const double difference = double(vectors.of(a)[k]) - double(vectors.of(b)[k]);
    sum += difference * difference;
  }
  return sum;
}

/// Half the mean squared distance of all pairs: the variance, without a mean.
template <LightMetric Metric>
double variance_by_pairs(const Metric& metric) {
  double sum = 0;
  for (std::uint32_t a = 0; a < metric.size(); ++a)
    for (std::uint32_t b = 0; b < metric.size(); ++b) sum += squared_distance(metric, a, b);
  return sum / 2 / double(metric.size()) / double(metric.size());
}

std::vector<LightSample> distant(std::uint32_t count) {
  std::vector<LightSample> lights;
  for (const vec3& d : even_directions(count)) lights.push_back({d, vec3(0)});
  return lights;
}

/// Lights that are seen by all receivers or by none, by their number's last bit.
LightVisibility seen_if_odd(std::size_t lights, std::size_t length) {
  LightVisibility vectors{length, std::vector<float>(lights * length)};
  for (std::size_t i = length; i < vectors.shares.size(); ++i) vectors.shares[i] = float(i / length % 2);
  return vectors;
}

bool left_half_is_of_one_kind(const LightTree& tree) {
  for (std::uint32_t leaf = 0; leaf < tree.leaf_count() / 2; ++leaf)
    if (tree.light_of_leaf[leaf] % 2 != tree.light_of_leaf[0] % 2) return false;
  return true;
}

}  // namespace

TEST_CASE("squared distances between the points of the visibility metric are Eq. 12") {
  Random random(1);
  for (const float weight : {0.0f, 30.0f}) {
    const LightVisibility vectors = random_vectors(random, 50, 37);
    const VisibilityMetric metric(vectors, weight);
    REQUIRE(metric.size() == 50);
    REQUIRE(metric.dimension() == 37);
    const double solid_angle = 4 * std::numbers::pi / 50, k = double(weight) + 1;
    for (std::uint32_t i = 1; i < 50; ++i)
      CHECK(close(squared_distance(metric, 0, i),
                  k * k * solid_angle * solid_angle / 37 * squared_difference(vectors, 0, i), 1e-5));
  }
}

TEST_CASE("the variance is half the mean squared distance of pairs") {
  Random random(2);
  const LightVisibility vectors = random_vectors(random, 40, 20);
  const VisibilityMetric metric(vectors);
  CHECK(close(variance(metric), variance_by_pairs(metric), 1e-9));
  CHECK(variance(VisibilityMetric(LightVisibility{})) == 0);
}

TEST_CASE("the mixed metric is Eq. 13, with either scale") {
  Random random(3);
  const auto lights = scattered_lights(random, 40);
  const LightVisibility vectors = random_vectors(random, 40, 20);
  const GeometricMetric geometry(lights);
  const VisibilityMetric visibility(vectors);
  const double variance_g = variance_by_pairs(geometry), variance_v = variance_by_pairs(visibility);
  for (const float beta : {0.0f, 0.3f, 1.0f}) {
    CAPTURE(beta);
    const MixedMetric scaled(geometry, visibility, beta),
        plain(geometry, visibility, beta, MetricScale::constant);
    REQUIRE(scaled.dimension() == 26);
    for (std::uint32_t i = 1; i < 40; ++i) {
      const double g = double(beta) * squared_distance(geometry, 0, i),
                   v = (1 - double(beta)) * squared_distance(visibility, 0, i);
      CHECK(close(squared_distance(scaled, 0, i), g / variance_g + v / variance_v, 1e-4));
      CHECK(close(squared_distance(plain, 0, i), g + v, 1e-4));
    }
    CHECK(close(variance(scaled), 1.0, 1e-5));
  }
}

TEST_CASE("what does not vary counts for nothing in the mixed metric") {
  const auto lights = distant(64);
  const LightVisibility dark{8, std::vector<float>(64 * 8)};
  const VisibilityMetric visibility(dark);
  const GeometricMetric geometry(lights);
  CHECK(variance(MixedMetric(geometry, visibility, 0)) == 0);
  CHECK(close(variance(MixedMetric(geometry, visibility, 0.25f)), 0.25, 1e-5));
}

TEST_CASE("projected vectors keep squared distances as well as their length promises") {
  Random random(4);
  const LightVisibility vectors = random_vectors(random, 300, 200);
  for (const std::size_t length : {20u, 64u, 128u}) {
    CAPTURE(length);
    const LightVisibility projected = project(vectors, length, Serial());
    REQUIRE(projected.length == length);
    REQUIRE(projected.size() == 300);
    double mean = 0, mean_square = 0;
    for (std::uint32_t i = 1; i < 300; ++i) {
      const double ratio = squared_difference(projected, i, i - 1) / squared_difference(vectors, i, i - 1);
      mean += ratio / 299, mean_square += ratio * ratio / 299;
    }
    const double deviation = std::sqrt(2.0 / double(length));
    CHECK(std::fabs(mean - 1) < 0.5 * deviation);
    CHECK(std::sqrt(mean_square - mean * mean) < 1.2 * deviation);
    CHECK(std::sqrt(mean_square - mean * mean) > 0.6 * deviation);
  }
}

TEST_CASE("the projection does not depend on who runs it, only on its seed") {
  Random random(5);
  const LightVisibility vectors = random_vectors(random, 70, 33);
  const auto expected = project(vectors, 19, Serial()).shares;
  CHECK(project(vectors, 19, support::Backwards{3}).shares == expected);
  CHECK(project(vectors, 19, support::TwoThreads()).shares == expected);
  CHECK(project(vectors, 19, Serial(), 2).shares != expected);
}

TEST_CASE("the data-driven tree parts lights that lie side by side but are seen differently") {
  const auto lights = distant(1024);
  const LightVisibility vectors = seen_if_odd(1024, 16);
  const GeometricMetric geometry(lights);
  const VisibilityMetric visibility(vectors);
  CHECK(left_half_is_of_one_kind(build_tree(MixedMetric(geometry, visibility, 0))));
  CHECK(left_half_is_of_one_kind(build_tree(MixedMetric(geometry, visibility, 0.25f), {8, 4})));
  CHECK_FALSE(left_half_is_of_one_kind(build_tree(MixedMetric(geometry, visibility, 1))));
}

TEST_CASE("with the constant of Eq. 12 visibility counts for nothing beside geometry") {
  Random random(6);
  const auto lights = distant(4096);
  const LightVisibility vectors = random_vectors(random, 4096, 64);
  const VisibilityMetric visibility(vectors);
  const GeometricMetric geometry(lights);
  const double share = variance(visibility) / variance(geometry);
  CHECK(share < 1e-4);
  CHECK(share > 0);
}

TEST_CASE("lights that nobody sees are grouped by their number, the same each time") {
  const auto lights = distant(1000);
  const LightVisibility dark{8, std::vector<float>(1000 * 8)};
  const GeometricMetric geometry(lights);
  const VisibilityMetric visibility(dark);
  const LightTree tree = build_tree(MixedMetric(geometry, visibility, 0), {8, 4});
  for (std::uint32_t leaf = 0; leaf < 1024; ++leaf)
    if (tree.light_of_leaf[leaf] != no_light) CHECK((tree.light_of_leaf[leaf] < 500) == (leaf < 512));
  CHECK(tree.light_of_leaf == build_tree(MixedMetric(geometry, visibility, 0), {8, 4}).light_of_leaf);
}
