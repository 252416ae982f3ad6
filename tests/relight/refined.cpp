// Filtered and refined shading: against one cluster after the other, and against all lights.
#include <doctest/doctest.h>

#include <coppice/reference/dense.hpp>
#include <coppice/reference/refined.hpp>
#include <coppice/relight/merge_face.hpp>
#include <coppice/relight/shade.hpp>
#include <limits>
#include <support/shading.hpp>

using namespace coppice;
using namespace support;

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float scale = 1.0f / 255;

/// Dim lights of random colours, and lamps that outshine them a thousand times.
LitTree lamps(std::uint32_t count, std::size_t nodes, Random& random) {
  return LitTree(count, nodes, 0, [&](const vec3&) {
    return random_colour(random) * (random.below(64) == 0 ? 1000.0f : 1.0f);
  });
}

/// A face of random cuts, or one to which everything is visible.
ClusterList merged_clusters(const LitTree& lit, Random& random) {
  MaskedCuts<std::uint8_t> cuts(lit.leaf_count(), 0);
  for (int i = 0; i < 3; ++i)
    cuts.append(random_visibility_cut<std::uint8_t>(lit.leaf_count(), 0, random),
                {random.direction(), -0.9f});
  ClusterList clusters;
  FaceMerger<std::uint8_t>(cuts, lit.frame).merge({0, 1, 2}, clusters);
  return clusters;
}
ClusterList all_visible(const LitTree& lit) {
  MaskedCuts<std::uint8_t> cuts(lit.leaf_count(), 0);
  cuts.append(Cut<std::uint8_t>{{lit.leaf_count()}, {255}});
  ClusterList clusters;
  FaceMerger<std::uint8_t>(cuts, lit.frame).merge({0, 0, 0}, clusters);
  return clusters;
}

std::vector<reference::SeenCluster> seen_from(const ShadingPoint& p, const ClusterList& clusters) {
  std::vector<reference::SeenCluster> seen;
  for (std::size_t i = 0; i < clusters.size(); ++i) {
    const double a = clusters.field(ClusterList::visible_0)[i], b = clusters.field(ClusterList::visible_1)[i],
                 c = clusters.field(ClusterList::visible_2)[i];
    const double w0 = p.weight_0, w1 = p.weight_1;
    seen.push_back({clusters.nodes()[i], (w0 * a + w1 * b + (1 - w0 - w1) * c) / 255});
  }
  return seen;
}

ShadedPoint shade(const ShadingPoint& p, const ClusterList& clusters, const LitTree& lit,
                  const LobeOptions& options) {
  RefinementScratch scratch;
  return shade_point(p, clusters, scale, options, lit.frame.nodes, scratch);
}

vec3 dense(const ShadingPoint& p, const LitTree& lit) {
  const std::vector<float> visible(lit.leaf_count(), 1);
  return reference::dense_radiance(p, lit.leaf_directions(), lit.leaf_powers(), visible);
}

std::vector<ShadingPoint> points_of_all_materials(int count, Random& random) {
  auto points = random_points(wide_materials, count, random);
  const auto narrow = random_points(narrow_materials, count, random);
  points.insert(points.end(), narrow.begin(), narrow.end());
  return points;
}

/// A point that looks along its normal, up to 20° off, and lights that shine at it within 60° of it: no
/// cluster is cut by the horizon, or by where Phong's lobe ends.
struct Frontal {
  ShadingPoint point;
  LitTree lit;
  ClusterList clusters;

  Frontal(const SetMaterial& set_material, Random& random)
      : point(random_point(random)),
        lit(2048, 64, 0,
            [&](const vec3& d) {
              const vec3 colour = random_colour(random) * (random.below(64) == 0 ? 300.0f : 1.0f);
              return dot(d, point.normal) > 0.5f ? colour : vec3(0);
            }),
        clusters(all_visible(lit)) {
    point.to_viewer = normalize(point.normal + 0.36f * random.uniform() * point.tangent);
    set_material(point);
  }
};

/// As a share of `size`.
double relative_error(const vec3& value, const glm::dvec3& expected, double size) {
  return glm::length(glm::dvec3(value) - expected) / (size + 1e-30);
}

}  // namespace

TEST_CASE("filtered is the sum of the BRDF's means over the clusters, one by one") {
  Random random(1);
  for (const std::uint32_t count : {1u, 2u, 16u, 1000u}) {
    const LitTree lit = lamps(count, 60, random);
    const ClusterList clusters = merged_clusters(lit, random);
    for (const ShadingPoint& p : points_of_all_materials(6, random)) {
      const ShadedPoint shaded = shade(p, clusters, lit, {Lobes::filtered});
      const glm::dvec3 expected = reference::Refinement(p, lit.frame.nodes).filtered(seen_from(p, clusters));
      CHECK(relative_error(shaded.radiance, expected, glm::length(expected)) < 1e-5);
      CHECK(shaded.clusters == clusters.size());
    }
  }
}

TEST_CASE("refined equals refining one cluster after the other") {
  Random random(2);
  RefinementScratch scratch;  // reused: nothing of an earlier point may stay
  int points = 0, different_counts = 0, split = 0;
  double worst = 0;
  for (const std::uint32_t count : {1u, 2u, 16u, 1000u, 1024u})
    for (const float tolerance : {0.1f, 1e-2f, 1e-3f, 5e-4f, 1e-5f}) {
      const LitTree lit = lamps(count, 40, random);
      const ClusterList clusters = merged_clusters(lit, random);
      for (const ShadingPoint& p : points_of_all_materials(10, random)) {
        const ShadedPoint shaded =
            shade_point(p, clusters, scale, {Lobes::refined, tolerance}, lit.frame.nodes, scratch);
        const auto seen = seen_from(p, clusters);
        const reference::Refinement slow(p, lit.frame.nodes);
        const auto expected = slow.refined(seen, tolerance);
        const double size = std::max(glm::length(slow.filtered(seen)), glm::length(expected.radiance));
        ++points, split += shaded.clusters > clusters.size();
        if (shaded.clusters != expected.clusters) {
          ++different_counts;
          continue;
        }
        const double error = relative_error(shaded.radiance, expected.radiance, size);
        worst = std::max(worst, error);
      }
    }
  CHECK(worst < 1e-5);
  CHECK(different_counts <= points / 1000);
  CHECK(split > points / 5);
}

TEST_CASE("refined at tolerance 0 is the sum over all lights") {
  Random random(3);
  for (int i = 0; i < 4; ++i)
    for (const SetMaterial& set_material : narrow_materials) {
      const Frontal f(set_material, random);
      const vec3 expected = dense(f.point, f.lit);
      const ShadedPoint shaded = shade(f.point, f.clusters, f.lit, {Lobes::refined, 0});
      CHECK(relative_error(shaded.radiance, expected, length(expected)) < 1e-5);
      CHECK(shaded.clusters > 256);
    }
}

TEST_CASE("refined at a huge tolerance is filtered") {
  Random random(4);
  const LitTree lit = lamps(1000, 40, random);
  const ClusterList clusters = merged_clusters(lit, random);
  for (const ShadingPoint& p : points_of_all_materials(4, random))
    for (const float tolerance : {1e30f, infinity}) {
      const ShadedPoint shaded = shade(p, clusters, lit, {Lobes::refined, tolerance});
      CHECK(shaded.radiance == shade(p, clusters, lit, {Lobes::filtered}).radiance);
      CHECK(shaded.clusters == clusters.size());
    }
}

TEST_CASE("Lambert is never refined") {
  Random random(5);
  const LitTree lit = lamps(1000, 40, random);
  const ClusterList clusters = merged_clusters(lit, random);
  ShadingPoint p = random_point(random);
  set_lambert(p, vec3(1));
  CHECK(shade(p, clusters, lit, {Lobes::refined, 0}).clusters == clusters.size());
}

TEST_CASE("a smaller tolerance means less error and more clusters") {
  Random random(6);
  std::vector<Frontal> points;
  for (int i = 0; i < 8; ++i)
    for (const SetMaterial& set_material : narrow_materials) points.emplace_back(set_material, random);
  double last_error = infinity, first_error = 0;
  std::size_t last_count = 0;
  for (const float tolerance : {infinity, 1e-1f, 1e-2f, 1e-3f, 1e-4f, 1e-5f, 0.0f}) {
    double error = 0;
    std::size_t count = 0;
    for (const Frontal& f : points) {
      const ShadedPoint shaded = shade(f.point, f.clusters, f.lit, {Lobes::refined, tolerance});
      const vec3 expected = dense(f.point, f.lit);
      const double e = relative_error(shaded.radiance, expected, length(expected));
      error += e * e / double(points.size()), count += shaded.clusters;
    }
    CAPTURE(tolerance);
    CHECK(error < 1.2 * last_error);
    CHECK(count >= last_count);
    if (tolerance == infinity) first_error = error;
    last_error = error, last_count = count;
  }
  CHECK(std::sqrt(first_error) > 0.05);
  CHECK(std::sqrt(last_error) < 1e-4);
}

TEST_CASE("black points, dark skies and light from 1e-30 to 1e30 end, and give finite radiance") {
  Random random(7);
  for (const float power : {0.0f, 1e-30f, 1.0f, 1e30f}) {
    const LitTree lit(512, 20, 0,
                      [&](const vec3&) { return vec3(random.below(50) == 0 ? power : 1e-6f * power); });
    const ClusterList clusters = all_visible(lit);
    for (ShadingPoint p : points_of_all_materials(10, random))
      for (const float tolerance : {0.0f, 1e-4f, infinity})
        for (const bool is_black : {false, true}) {
          if (is_black) p.diffuse = p.specular = p.fresnel = vec3(0);
          const ShadedPoint shaded = shade(p, clusters, lit, {Lobes::refined, tolerance});
          CAPTURE(power);
          CAPTURE(tolerance);
          CHECK(is_finite(shaded.radiance));
          CHECK(shaded.clusters <= clusters.size() + 2 * lit.leaf_count());
          if (is_black || power == 0) CHECK(shaded.radiance == vec3(0));
          if (is_black) CHECK(shaded.clusters == clusters.size());
        }
  }
}

TEST_CASE(
    "radiance is never negative, also where bright clusters are replaced by parts that shine elsewhere") {
  Random random(8);
  std::size_t refined_points = 0;
  for (int i = 0; i < 20; ++i) {
    const LitTree lit(512, 20, 0, [&](const vec3&) { return vec3(random.below(50) == 0 ? 1000 : i % 2); });
    const ClusterList clusters = all_visible(lit);
    for (int k = 0; k < 100; ++k) {
      ShadingPoint p = random_point(random);
      if (k % 2)
        set_phong(p, vec3(0), vec3(1), 1e4f);
      else
        set_ward(p, vec3(0), vec3(1), 0.01f, 0.01f);
      const ShadedPoint shaded = shade(p, clusters, lit, {});
      CHECK(std::min({shaded.radiance.x, shaded.radiance.y, shaded.radiance.z}) >= 0);
      refined_points += shaded.clusters > clusters.size();
    }
  }
  CHECK(refined_points > 1000);
}
