#include <coppice/shared/brdf_filtered.h>
#include <doctest/doctest.h>

#include <algorithm>
#include <coppice/vulkan/cut_shader.hpp>
#include <map>
#include <set>
#include <tuple>

#include "random_input.hpp"

using namespace coppice;
using namespace coppice::test;
using dvec3 = glm::dvec3;

namespace {

constexpr LobeOptions sampled{Lobes::sampled, 0}, filtered{Lobes::filtered, 0},
    refined{Lobes::refined, 0.02f};

/// The value of a receiver's cut at `leaf`, for a cluster in that direction.
double visibility_at(const RandomInput& input, std::uint32_t receiver, std::uint32_t leaf,
                     const vec3& direction) {
  const ReceiverHorizon horizon = input.cuts.horizons()[receiver];
  if (glm::dot(dvec3(horizon.normal), dvec3(direction)) <= double(horizon.cosine)) return 0;
  const auto& [ends, values] = input.unpacked[receiver];
  return values[std::size_t(std::ranges::upper_bound(ends, leaf) - ends.begin())] / 255.0;
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

/// One point by the definition, leaf by leaf and node by node, in double.
class Definition {
 public:
  Definition(const RandomInput& input, const ShadingPoint& point, const LobeOptions& lobes)
      : input_(input), point_(point), lobes_(lobes) {
    double brightness = 0;
    for (const auto& [node, v] : visibility_by_cluster()) {
      sum_ += v * reflected(node);
      brightness += v * brightness_of(node);
    }
    if (lobes.lobes != Lobes::refined || point.brdf == BRDF_LAMBERT) return;
    limit_ = double(lobes.tolerance) * brightness;
    sum_ = dvec3(0);
    for (const auto& [node, v] : visibility_by_cluster()) sum_ += below(node, v);
  }
  dvec3 radiance() const { return sum_; }

 private:
  static double luminance(const dvec3& c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

  std::set<std::uint32_t> all_ends() const {
    std::set<std::uint32_t> ends(input_.frame.ends.begin(), input_.frame.ends.end());
    for (int i = 0; i < 3; ++i) {
      const auto& cut = input_.unpacked[input_.buffer.faces[point_.face].receivers[i]];
      ends.insert(cut.ends.begin(), cut.ends.end());
    }
    return ends;
  }

  std::map<std::uint32_t, double> visibility_by_cluster() const {
    const double weights[] = {point_.weight_0, point_.weight_1, 1.0 - point_.weight_0 - point_.weight_1};
    const uvec3 receivers = input_.buffer.faces[point_.face].receivers;
    std::map<std::uint32_t, double> clusters;
    std::uint32_t begin = 0;
    for (const std::uint32_t end : all_ends()) {
      const std::uint32_t node = node_by_descent(input_.settings.leaf_count, begin, end);
      for (int i = 0; i < 3; ++i)
        clusters[node] +=
            weights[i] * visibility_at(input_, receivers[i], begin, input_.frame.nodes[node].direction);
      begin = end;
    }
    return clusters;
  }

  FilteredTerms<double> terms(const LightNode& node) const {
    const vec3 wi = brdf_to_local(point_.normal, point_.tangent, node.direction);
    const vec3 wo = brdf_viewer_to_local(point_.normal, point_.tangent, point_.to_viewer);
    const auto& [brdf, x, y] = std::tie(point_.brdf, point_.alpha_x, point_.alpha_y);
    if (lobes_.lobes != Lobes::sampled)
      return brdf_filtered_terms<double>(brdf, x, y, wi.x, wi.y, wi.z, light_spread<double>(node.spread), wo);
    const auto at = brdf_terms<double>(brdf, x, y, wi.x, wi.y, wi.z, wo);
    return {at.diffuse, at.specular, at.fresnel, 0};
  }

  dvec3 reflected(std::uint32_t h) const {
    const LightNode& node = input_.frame.nodes[h];
    const auto t = terms(node);
    return dvec3(node.power) * (dvec3(point_.diffuse) * t.diffuse + dvec3(point_.specular) * t.specular +
                                dvec3(point_.fresnel) * t.fresnel);
  }

  double brightness_of(std::uint32_t h) const {
    const auto t = terms(input_.frame.nodes[h]);
    return luminance(dvec3(input_.frame.nodes[h].power)) *
           (luminance(dvec3(point_.diffuse)) * t.diffuse + luminance(dvec3(point_.specular)) * t.specular +
            luminance(dvec3(point_.fresnel)) * t.fresnel);
  }

  double error(std::uint32_t h) const {
    const LightNode& node = input_.frame.nodes[h];
    const auto t = terms(node);
    const double specular =
        luminance(dvec3(point_.specular)) * t.specular + luminance(dvec3(point_.fresnel)) * t.fresnel;
    return luminance(dvec3(node.power)) * specular * t.growth;
  }

  dvec3 below(std::uint32_t h, double v) const {
    if (!(v * error(h) > limit_)) return v * reflected(h);
    const std::uint32_t count = h < input_.settings.leaf_count / 2 ? 4 : 2;
    dvec3 sum(0);
    for (std::uint32_t k = 0; k < count; ++k) sum += below(count * h + k, v);
    return sum;
  }

  const RandomInput& input_;
  const ShadingPoint& point_;
  LobeOptions lobes_;
  double limit_ = 0;
  dvec3 sum_{0};
};

double relative_rms(const RandomInput& input, const std::vector<vec3>& radiance,
                    const LobeOptions& lobes = sampled) {
  REQUIRE(radiance.size() == input.buffer.points.size());
  double difference = 0, total = 0;
  for (std::size_t i = 0; i < radiance.size(); ++i) {
    const dvec3 expected = Definition(input, input.buffer.points[i], lobes).radiance();
    const dvec3 error = dvec3(radiance[i]) - expected;
    difference += glm::dot(error, error);
    total += glm::dot(expected, expected);
  }
  REQUIRE(total > 0);
  return std::sqrt(difference / total);
}

CutShadeResult shade(VulkanDevice& device, const RandomInput& input, const LobeOptions& lobes = sampled) {
  return CutShader(device, input.view()).shade(input.frame.nodes, input.frame.mask, lobes);
}

constexpr double tolerance = 2e-6;  // of relative_rms: sums in float

}  // namespace

TEST_CASE("the kernel agrees with the definition for every BRDF and every way to meet a cluster") {
  if (!has_device()) return;
  VulkanDevice device;
  for (const std::uint32_t brdf : {BRDF_LAMBERT, BRDF_GGX, BRDF_PHONG, BRDF_BLINN_PHONG, BRDF_WARD}) {
    const auto input = random_input({.leaf_count = 1024, .granule_log2 = 3, .brdf = brdf, .seed = 7 + brdf});
    for (const LobeOptions& lobes : {sampled, filtered, refined}) {
      CAPTURE(brdf);
      CAPTURE(int(lobes.lobes));
      CHECK(relative_rms(input, shade(device, input, lobes).radiance, lobes) < tolerance);
    }
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
      CHECK(relative_rms(input, shade(device, input, refined).radiance, refined) < tolerance);
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
  const FrameLighting& frame = input.frame;
  auto view = input.view();
  std::vector<std::uint32_t> whole_count(1000), count(1000);
  const auto whole = CutShader(device, view).shade(frame.nodes, frame.mask, refined, whole_count);
  CHECK(relative_rms(input, whole.radiance, refined) < tolerance);
  for (const std::uint32_t points : {1u, 64u, 333u}) {
    view.points_per_dispatch = points;
    CHECK(CutShader(device, view).shade(frame.nodes, frame.mask, refined, count).radiance == whole.radiance);
    CHECK(count == whole_count);
  }
}

TEST_CASE("every frame has its own lighting and its own lobes") {
  if (!has_device()) return;
  VulkanDevice device;
  auto input = random_input({.leaf_count = 128, .granule_log2 = 1});
  auto& frame = input.frame;
  CutShader shader(device, input.view());
  const auto lit = shader.shade(frame.nodes, frame.mask, sampled);
  const auto dark = shader.shade(std::vector<LightNode>(256), frame.mask, sampled);
  CHECK(std::ranges::all_of(dark.radiance, [](const vec3& v) { return v == vec3(0); }));
  CHECK(shader.shade(frame.nodes, frame.mask, refined).radiance != lit.radiance);
  CHECK(shader.shade(frame.nodes, frame.mask, sampled).radiance == lit.radiance);
  set_illumination_cut(frame, 128, {128}, 1);
  CHECK(relative_rms(input, shader.shade(frame.nodes, frame.mask, sampled).radiance) < tolerance);
}

TEST_CASE("masks may exceed the largest storage buffer of a device (128 MiB)") {
  if (!has_device()) return;
  VulkanDevice device;
  const auto input = random_input({.leaf_count = 4096, .granule_log2 = 0, .point_count = 20});
  const std::uint32_t unused = 280'000;
  const auto behind_unused = [&](auto items, std::size_t each) {
    using Item = std::remove_const_t<typename decltype(items)::element_type>;
    std::vector<Item> all(unused * each, Item{});
    all.insert(all.end(), items.begin(), items.end());
    return all;
  };
  auto view = input.view();
  const auto masks = behind_unused(view.visibility_masks, 128);
  const auto first_value = behind_unused(view.first_value, 1);
  const auto horizons = behind_unused(view.horizons, 1);
  auto faces = input.buffer.faces;
  for (auto& face : faces) face.receivers += unused;
  view.visibility_masks = masks, view.first_value = first_value, view.horizons = horizons, view.faces = faces;
  REQUIRE(masks.size() * sizeof(std::uint32_t) > std::size_t(128) << 20);
  const auto result = CutShader(device, view).shade(input.frame.nodes, input.frame.mask, sampled);
  CHECK(relative_rms(input, result.radiance) < tolerance);
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
