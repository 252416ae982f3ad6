// The kernel of lights in the scene against shade_faces of the CPU.
#include <doctest/doctest.h>

#include <array>
#include <coppice/relight/local_relighting.hpp>
#include <coppice/relight/shade_faces.hpp>
#include <support/occluders.hpp>

#include "random_local_input.hpp"
#include "shaded.hpp"

using namespace coppice;
using namespace coppice::test;

namespace {

constexpr LobeOptions sampled{Lobes::sampled, 0}, filtered{Lobes::filtered, 0},
    refined{Lobes::refined, 1e-3f};

Shaded by_cpu(const RandomLocalInput& input, const LobeOptions& lobes) {
  Shaded shaded(input.buffer.points.size());
  shade_faces<LocalLights>(input.buffer, input.cuts, input.scales, input.frame, lobes, 0,
                           input.buffer.faces.size(), shaded.radiance, shaded.clusters);
  return shaded;
}

Shaded by_device(VulkanDevice& device, const RandomLocalInput& input, const LobeOptions& lobes) {
  Shaded shaded(input.buffer.points.size());
  LocalCutShader shader(device, input.view());
  shaded.radiance = shader.shade(input.frame.nodes, input.frame.mask, lobes, shaded.clusters).radiance;
  return shaded;
}

void check_alike(VulkanDevice& device, const RandomLocalInput& input, const LobeOptions& lobes) {
  CAPTURE(int(lobes.lobes));
  check_alike(by_device(device, input, lobes), by_cpu(input, lobes));
}

/// Lamps in a room, a few of them bright.
std::vector<LocalLight> random_lamps(Random& random, std::uint32_t count) {
  std::vector<LocalLight> lamps;
  for (std::uint32_t i = 0; i < count; ++i)
    lamps.push_back(
        point_light(random_position(random), (i % 64 == 0 ? 100.0f : 1.0f) * random_colour(random)));
  lamps.back() = distant_light(vec3(0, 1, 0), vec3(3, 2, 1), 10);
  return lamps;
}

/// Lamps on their tree in place of random nodes, and every other point near the highlight of a bright one.
RandomLocalInput lamp_input(const RandomSettings& settings) {
  Random random(settings.seed);
  const auto lamps = random_lamps(random, settings.leaf_count);
  const LightTree tree = build_local_tree(lamps);
  LocalLighting lighting(tree, lamps);
  lighting.set_cut(100, settings.granule_log2);
  RandomLocalInput input = random_local_input(settings);
  input.frame = lighting.frame();
  for (std::size_t i = 0; i < input.buffer.points.size(); i += 2) {
    ShadingPoint& point = input.buffer.points[i];
    const vec3 to_lamp =
        normalize(lamps[64 * (i % (lamps.size() / 64))].position - input.buffer.positions[i]);
    vec3 bitangent;
    point.normal = normalize(point.to_viewer + to_lamp + 0.1f * random.direction());
    make_frame(point.normal, point.tangent, bitangent);
  }
  return input;
}

/// Receivers around a ball among the lamps, their traced cuts, and points in any three of them.
RandomLocalInput traced_input(const RandomSettings& settings) {
  RandomLocalInput input = lamp_input(settings);
  Random random(settings.seed);
  const auto lamps = random_lamps(random, settings.leaf_count);  // those of the input
  const LightTree tree = build_local_tree(lamps);
  std::vector<Receiver> receivers(settings.receiver_count);
  for (Receiver& r : receivers) {
    r.normal = random.direction();
    r.position = 0.41f * r.normal;
  }
  const support::SphereOccluder ball{{{vec3(0), 0.4f}}};
  auto [cuts, scales, rays] = precompute_local_cuts(ball, tree, LocalLightPackets(leaf_lights(tree, lamps)),
                                                    receivers, {.sigma = 1}, Serial());
  REQUIRE(cuts.granule_log2() == settings.granule_log2);
  input.cuts = std::move(cuts);
  input.scales = std::move(scales);
  return input;
}

}  // namespace

TEST_CASE("lights in the scene: the kernel agrees with the CPU for every BRDF and way to meet a cluster") {
  if (!has_device()) return;
  VulkanDevice device;
  for (const std::uint32_t brdf : {BRDF_LAMBERT, BRDF_GGX, BRDF_PHONG, BRDF_BLINN_PHONG, BRDF_WARD}) {
    CAPTURE(brdf);
    const auto input = random_local_input(
        {.leaf_count = 1024, .granule_log2 = 3, .point_count = 1000, .brdf = brdf, .seed = 7 + brdf});
    for (const LobeOptions& lobes : {sampled, filtered, refined}) check_alike(device, input, lobes);
  }
}

TEST_CASE("lights in the scene: the kernel agrees with the CPU for every granule and tree size") {
  if (!has_device()) return;
  VulkanDevice device;
  for (const std::uint32_t leaf_count : {1u, 32u, 1024u, 4096u})
    for (std::uint32_t granule_log2 = 0; granule_log2 <= 3 && 1u << granule_log2 <= leaf_count;
         ++granule_log2) {
      CAPTURE(leaf_count);
      CAPTURE(granule_log2);
      const auto input = random_local_input(
          {.leaf_count = leaf_count, .granule_log2 = granule_log2, .seed = leaf_count + granule_log2});
      for (const LobeOptions& lobes : {sampled, refined}) check_alike(device, input, lobes);
    }
}

TEST_CASE("lights in the scene: the kernel refines narrow lobes as the CPU does") {
  if (!has_device()) return;
  VulkanDevice device;
  for (const std::uint32_t brdf : {BRDF_LAMBERT, BRDF_GGX, BRDF_PHONG, BRDF_BLINN_PHONG, BRDF_WARD}) {
    CAPTURE(brdf);
    const auto input = lamp_input({.leaf_count = 4096,
                                   .granule_log2 = 2,
                                   .face_count = 50,
                                   .point_count = 2000,
                                   .brdf = brdf,
                                   .narrow = true,
                                   .seed = 31 + brdf});
    for (const LobeOptions& lobes : {sampled, filtered, refined}) check_alike(device, input, lobes);
    const double merged = mean(by_cpu(input, filtered).clusters),
                 fine = mean(by_cpu(input, refined).clusters);
    if (brdf == BRDF_LAMBERT)
      CHECK(fine == merged);
    else
      CHECK(fine > merged + 20);
  }
}

TEST_CASE("lights in the scene: the kernel shades by traced cuts") {
  if (!has_device()) return;
  VulkanDevice device;
  const auto input =
      traced_input({.leaf_count = 512, .receiver_count = 40, .face_count = 20, .point_count = 1000});
  for (const LobeOptions& lobes : {sampled, filtered, refined}) check_alike(device, input, lobes);
}

TEST_CASE("a point at the place of a light takes nothing from it") {
  if (!has_device()) return;
  VulkanDevice device;
  auto input = random_local_input({.leaf_count = 1, .point_count = 10});
  for (LocalLightNode& node : input.frame.nodes) node.power = vec3(1), node.w = 1;
  input.buffer.positions[3] = input.frame.nodes[1].position;
  const auto radiance = by_device(device, input, sampled).radiance;
  CHECK(radiance[3] == vec3(0));
  CHECK(relative_rms(radiance, by_cpu(input, sampled).radiance) < 1e-4);
}

TEST_CASE("lights in the scene: no points give no radiance, and lights that are off give none") {
  if (!has_device()) return;
  VulkanDevice device;
  const auto nothing = random_local_input({.point_count = 0});
  CHECK(by_device(device, nothing, sampled).radiance.empty());
  LocalCutShader empty(device, LocalCutShadeInput{});
  CHECK(empty.shade(std::vector<LocalLightNode>(2), std::vector<std::uint32_t>{1}).radiance.empty());
  auto dark = random_local_input({});
  for (LocalLightNode& node : dark.frame.nodes) node.power = vec3(0);
  for (const LobeOptions& lobes : {sampled, refined})
    for (const vec3& v : by_device(device, dark, lobes).radiance) CHECK(v == vec3(0));
}

TEST_CASE("lights in the scene: splitting the points over dispatches changes nothing") {
  if (!has_device()) return;
  VulkanDevice device;
  const auto input = random_local_input({.leaf_count = 256, .granule_log2 = 2, .point_count = 1000});
  const Shaded whole = by_device(device, input, refined);
  check_alike(whole, by_cpu(input, refined));
  auto view = input.view();
  std::vector<std::uint32_t> clusters(1000);
  for (const std::uint32_t points : {1u, 64u, 333u}) {
    view.points_per_dispatch = points;
    LocalCutShader shader(device, view);
    CHECK(shader.shade(input.frame.nodes, input.frame.mask, refined, clusters).radiance == whole.radiance);
    CHECK(clusters == whole.clusters);
  }
}

TEST_CASE("lights in the scene: every frame has its own intensities") {
  if (!has_device()) return;
  VulkanDevice device;
  auto input = random_local_input({.leaf_count = 128, .granule_log2 = 1});
  LocalCutShader shader(device, input.view());
  const auto before = shader.shade(input.frame.nodes, input.frame.mask, sampled).radiance;
  for (LocalLightNode& node : input.frame.nodes) node.power *= vec3(1, 2, 4);
  const auto after = shader.shade(input.frame.nodes, input.frame.mask, sampled).radiance;
  CHECK(relative_rms(after, by_cpu(input, sampled).radiance) < 1e-4);
  CHECK(relative_rms(before, after) > 0.1);
}
