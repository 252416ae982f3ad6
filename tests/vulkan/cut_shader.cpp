#include <coppice/shared/brdf.h>
#include <doctest/doctest.h>

#include <algorithm>
#include <coppice/vulkan/cut_shader.hpp>
#include <set>

#include "random_input.hpp"

using namespace coppice;
using namespace coppice::test;
using dvec3 = glm::dvec3;

namespace {

/// The value of the piece of a receiver's cut that covers `leaf`.
double visibility_at(const RandomInput& input, std::uint32_t receiver, std::uint32_t leaf) {
  const auto& ends = input.ends[receiver];
  const auto piece = std::ranges::upper_bound(ends, leaf) - ends.begin();
  return input.values[input.first_value[receiver] + std::size_t(piece)] / 255.0;
}

/// The heap id of the node [begin, end), by descent from the root.
std::uint32_t node_by_descent(std::uint32_t leaf_count, std::uint32_t begin, std::uint32_t end) {
  std::uint32_t h = 1, first = 0, size = leaf_count;
  while (size > end - begin) {
    size /= 2;
    h = 2 * h + (begin >= first + size);
    if (begin >= first + size) first += size;
  }
  return h;
}

dvec3 reflected(const ShadingPoint& point, const LightNode& node) {
  const vec3 wi = brdf_to_local(point.normal, point.tangent, node.direction);
  const vec3 wo = brdf_viewer_to_local(point.normal, point.tangent, point.to_viewer);
  const auto terms = brdf_terms<double>(point.brdf, point.alpha_x, point.alpha_y, wi.x, wi.y, wi.z, wo);
  return dvec3(node.power) * (dvec3(point.diffuse) * terms.diffuse + dvec3(point.specular) * terms.specular +
                              dvec3(point.fresnel) * terms.fresnel);
}

/// One point by the definition: the union of all ends, leaf by leaf, in double.
dvec3 reference(const RandomInput& input, const ShadingPoint& point) {
  const uvec3 receivers = input.faces[point.face].receivers;
  std::set<std::uint32_t> ends(input.illumination_ends.begin(), input.illumination_ends.end());
  for (int i = 0; i < 3; ++i) ends.insert(input.ends[receivers[i]].begin(), input.ends[receivers[i]].end());
  const double weights[] = {point.weight_0, point.weight_1, 1.0 - point.weight_0 - point.weight_1};
  dvec3 sum(0);
  std::uint32_t begin = 0;
  for (const std::uint32_t end : ends) {
    double v = 0;
    for (int i = 0; i < 3; ++i) v += weights[i] * visibility_at(input, receivers[i], begin);
    sum += v * reflected(point, input.nodes[node_by_descent(input.settings.leaf_count, begin, end)]);
    begin = end;
  }
  return sum;
}

double relative_rms(const RandomInput& input, const std::vector<vec3>& radiance) {
  REQUIRE(radiance.size() == input.points.size());
  double difference = 0, total = 0;
  for (std::size_t i = 0; i < radiance.size(); ++i) {
    const dvec3 expected = reference(input, input.points[i]), error = dvec3(radiance[i]) - expected;
    difference += glm::dot(error, error);
    total += glm::dot(expected, expected);
  }
  REQUIRE(total > 0);
  return std::sqrt(difference / total);
}

CutShadeResult shade(VulkanDevice& device, const RandomInput& input) {
  return CutShader(device, input.view()).shade(input.nodes, input.illumination_mask);
}

constexpr double tolerance = 2e-6;  // of relative_rms: sums in float

}  // namespace

TEST_CASE("the kernel agrees with the definition for every BRDF") {
  if (!has_device()) return;
  VulkanDevice device;
  for (const std::uint32_t brdf : {BRDF_LAMBERT, BRDF_GGX, BRDF_PHONG, BRDF_BLINN_PHONG, BRDF_WARD}) {
    CAPTURE(brdf);
    const auto input = random_input({.leaf_count = 1024, .granule_log2 = 3, .brdf = brdf, .seed = 7 + brdf});
    CHECK(relative_rms(input, shade(device, input).radiance) < tolerance);
  }
}

TEST_CASE("the kernel agrees with the definition for every granule and tree size") {
  if (!has_device()) return;
  VulkanDevice device;
  for (const std::uint32_t leaf_count : {1u, 2u, 32u, 64u, 4096u}) {
    for (std::uint32_t granule_log2 = 0; granule_log2 <= 5 && 1u << granule_log2 <= leaf_count;
         ++granule_log2) {
      CAPTURE(leaf_count);
      CAPTURE(granule_log2);
      const auto input = random_input(
          {.leaf_count = leaf_count, .granule_log2 = granule_log2, .seed = leaf_count + granule_log2});
      CHECK(relative_rms(input, shade(device, input).radiance) < tolerance);
    }
  }
}

TEST_CASE("an illumination cut may be the root, as coarse as a granule, or all leaves") {
  if (!has_device()) return;
  VulkanDevice device;
  for (const std::uint32_t finest : {1024u, 16u, 4u, 1u}) {
    CAPTURE(finest);
    const auto input = random_input(
        {.leaf_count = 1024, .granule_log2 = 4, .finest_illumination = finest, .seed = 100 + finest});
    CHECK(relative_rms(input, shade(device, input).radiance) < tolerance);
  }
}

TEST_CASE("no points give no radiance") {
  if (!has_device()) return;
  VulkanDevice device;
  const auto input = random_input({.point_count = 0});
  CHECK(shade(device, input).radiance.empty());
  CutShader nothing(device, CutShadeInput{});
  CHECK(nothing.shade(std::vector<LightNode>(2), std::vector<std::uint32_t>{1}).radiance.empty());
}

TEST_CASE("splitting the points over dispatches changes nothing") {
  if (!has_device()) return;
  VulkanDevice device;
  const auto input = random_input({.leaf_count = 256, .granule_log2 = 2, .point_count = 1000});
  auto view = input.view();
  const auto whole = CutShader(device, view).shade(input.nodes, input.illumination_mask);
  CHECK(relative_rms(input, whole.radiance) < tolerance);
  for (const std::uint32_t count : {1u, 64u, 333u}) {
    view.points_per_dispatch = count;
    CHECK(CutShader(device, view).shade(input.nodes, input.illumination_mask).radiance == whole.radiance);
  }
}

TEST_CASE("every frame has its own lighting") {
  if (!has_device()) return;
  VulkanDevice device;
  auto input = random_input({.leaf_count = 128, .granule_log2 = 1});
  CutShader shader(device, input.view());
  const auto lit = shader.shade(input.nodes, input.illumination_mask);
  const auto dark = shader.shade(std::vector<LightNode>(256), input.illumination_mask);
  CHECK(std::ranges::all_of(dark.radiance, [](const vec3& v) { return v == vec3(0); }));
  CHECK(shader.shade(input.nodes, input.illumination_mask).radiance == lit.radiance);
  input.illumination_ends = {128};
  CHECK(relative_rms(input, shader.shade(input.nodes, {{0, 0, 0, 1u << 31}}).radiance) < tolerance);
}

TEST_CASE("masks may exceed the largest storage buffer of a device (128 MiB)") {
  if (!has_device()) return;
  VulkanDevice device;
  auto input = random_input({.leaf_count = 4096, .granule_log2 = 0, .point_count = 20});
  const std::uint32_t unused = 280'000;
  input.visibility_masks.insert(input.visibility_masks.begin(), std::size_t(unused) * 128, 0);
  input.first_value.insert(input.first_value.begin(), unused, 0);
  input.ends.insert(input.ends.begin(), unused, {});
  for (auto& face : input.faces) face.receivers += unused;
  REQUIRE(input.visibility_masks.size() * sizeof(std::uint32_t) > std::size_t(128) << 20);
  CHECK(relative_rms(input, shade(device, input).radiance) < tolerance);
}

TEST_CASE("the device's clock gives the kernel's time") {
  if (!has_device()) return;
  VulkanDevice device;
  const auto small = shade(device, random_input({.leaf_count = 64, .point_count = 1}));
  const auto large = shade(device, random_input({.leaf_count = 4096, .point_count = 4000}));
  if (!small.milliseconds) return;
  REQUIRE(large.milliseconds);
  CHECK(*small.milliseconds >= 0);
  CHECK(*large.milliseconds > *small.milliseconds);
  CHECK(*large.milliseconds < 600e3);
}

TEST_CASE("input that does not fit into the device's memory is refused by name") {
  if (!has_device()) return;
  VulkanDevice device;
  CutShadeInput input;
  input.leaf_count = 1u << 31;  // 128 GiB of nodes
  CHECK_THROWS_WITH_AS(CutShader(device, input), doctest::Contains(device.name().c_str()), InputError);
}
