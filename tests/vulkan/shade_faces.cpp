// The kernel against shade_faces of the CPU, under lighting whose highlights ask for refinement.
#include <doctest/doctest.h>

#include <array>
#include <coppice/light/directions.hpp>
#include <coppice/relight/shade_faces.hpp>
#include <coppice/tree/build.hpp>

#include "random_input.hpp"
#include "shaded.hpp"

using namespace coppice;
using namespace coppice::test;

namespace {

/// A sky with small lamps, and a light tree over it.
class LampSky {
 public:
  explicit LampSky(std::uint32_t light_count) : directions_(even_directions(light_count, 3)) {
    Random random(17);
    for (vec3& lamp : lamps) lamp = random.direction();
    std::vector<LightSample> samples;
    for (const vec3& d : directions_) samples.push_back({d, vec3(0)});
    tree_ = build_tree(GeometricMetric(samples));
  }

  FrameLighting frame(std::size_t max_nodes, std::uint32_t granule_log2) const {
    std::vector<CellLight> lights;
    for (const vec3& d : directions_) lights.push_back({radiance(d) * solid_angle(), solid_angle()});
    return light_frame(tree_, lights, directions_, max_nodes, granule_log2);
  }

  std::array<vec3, 6> lamps;

 private:
  float solid_angle() const { return 4 * pi / float(directions_.size()); }
  vec3 radiance(const vec3& d) const {
    for (const vec3& lamp : lamps)
      if (dot(lamp, d) > 0.999f) return {2000, 1500, 1000};
    return vec3(1.0f, 1.5f, 2.0f) * (1.2f + d.y);
  }

  std::vector<vec3> directions_;
  LightTree tree_;
};

/// Points under the sky, every other one near the highlight of a lamp.
RandomInput lamp_input(const RandomSettings& settings) {
  const LampSky sky(settings.leaf_count);
  RandomInput input = random_input(settings);
  input.frame = sky.frame(100, settings.granule_log2);
  Random random(settings.seed);
  for (std::size_t i = 0; i < input.buffer.points.size(); i += 2) {
    ShadingPoint& point = input.buffer.points[i];
    vec3 bitangent;
    point.normal = normalize(point.to_viewer + sky.lamps[i % sky.lamps.size()] + 0.1f * random.direction());
    make_frame(point.normal, point.tangent, bitangent);
  }
  return input;
}

Shaded by_cpu(const RandomInput& input, const LobeOptions& lobes) {
  Shaded shaded(input.buffer.points.size());
  shade_faces(input.buffer, input.cuts, input.frame, lobes, 0, input.buffer.faces.size(), shaded.radiance,
              shaded.clusters);
  return shaded;
}

Shaded by_device(VulkanDevice& device, const RandomInput& input, const LobeOptions& lobes) {
  Shaded shaded(input.buffer.points.size());
  CutShader shader(device, input.view());
  shaded.radiance = shader.shade(input.frame.nodes, input.frame.mask, lobes, shaded.clusters).radiance;
  return shaded;
}

void check_alike(VulkanDevice& device, const RandomInput& input, const LobeOptions& lobes) {
  check_alike(by_device(device, input, lobes), by_cpu(input, lobes));
}

}  // namespace

TEST_CASE("the kernel chooses the clusters that the CPU chooses, for every BRDF with a narrow lobe") {
  if (!has_device()) return;
  VulkanDevice device;
  for (const std::uint32_t brdf : {BRDF_LAMBERT, BRDF_GGX, BRDF_PHONG, BRDF_BLINN_PHONG, BRDF_WARD}) {
    CAPTURE(brdf);
    const auto input = lamp_input({.leaf_count = 4096,
                                   .granule_log2 = 3,
                                   .face_count = 50,
                                   .point_count = 2000,
                                   .brdf = brdf,
                                   .narrow = true,
                                   .seed = 31 + brdf});
    for (const Lobes lobes : {Lobes::sampled, Lobes::filtered, Lobes::refined}) {
      CAPTURE(int(lobes));
      check_alike(device, input, {.lobes = lobes, .tolerance = 5e-4f});
    }
    const auto merged = by_cpu(input, {.lobes = Lobes::filtered}).clusters,
               refined = by_cpu(input, {.lobes = Lobes::refined, .tolerance = 5e-4f}).clusters;
    if (brdf == BRDF_LAMBERT)
      CHECK(refined == merged);
    else
      CHECK(mean(refined) > mean(merged) + 20);
  }
}

TEST_CASE("the kernel refines as the CPU does in every granule, tree and tolerance") {
  if (!has_device()) return;
  VulkanDevice device;
  for (const std::uint32_t leaf_count : {2u, 128u, 2048u})
    for (const std::uint32_t granule_log2 : {0u, 1u, 4u}) {
      if (leaf_count >> granule_log2 == 0) continue;
      const auto input = lamp_input({.leaf_count = leaf_count,
                                     .granule_log2 = granule_log2,
                                     .point_count = 1000,
                                     .narrow = true,
                                     .seed = leaf_count + granule_log2});
      for (const float tolerance : {0.0f, 1e-4f, 1e-2f}) {
        CAPTURE(leaf_count);
        CAPTURE(granule_log2);
        CAPTURE(tolerance);
        check_alike(device, input, {.lobes = Lobes::refined, .tolerance = tolerance});
      }
    }
}
