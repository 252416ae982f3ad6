// The kernels of VPLs against the CPU: filtering up the tree, gathering by solid angle and by lists.
#include <coppice/gather/angle_walk.hpp>
//
#include <coppice/shared/vpl_gather.h>
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <coppice/vulkan/vpl_shader.hpp>

#include "random_input.hpp"
#include "random_vpls.hpp"
#include "shaded.hpp"

using namespace coppice;
using namespace coppice::test;

namespace {

static_assert(VPL_MARK_SPLIT == std::uint32_t(WalkMark::split));
static_assert(VPL_MARK_TAKE == std::uint32_t(WalkMark::take));

std::span<const VplNode> leaves_of(const VplTree& tree) { return tree.nodes().subspan(tree.leaf_count()); }

/// The largest differences over the nodes of a tree.
struct Differences {
  float sums = 0;       ///< of colours, energy and area, relative
  float position = 0;   ///< m
  float spread = 0;     ///< of √variance, m
  float normal = 0;     ///< and softening, absolute
  float mean_lobe = 0;  ///< of the lobe's mean direction, (k + 1)/(k + 2) · lobe
  float exponent = 0;   ///< relative, of k + 2
};

/// Not a number where one of them is none.
float relative(float a, float b) {
  return a == b ? 0 : std::fabs(a - b) / std::max(std::fabs(a), std::fabs(b));
}

vec3 mean_lobe(const VplNode& n) { return (1 - lobe_shortfall(n.exponent)) * n.lobe; }

void compare(const VplNode& a, const VplNode& b, Differences& most) {
  const auto raise = [](float& value, float other) {
    if (!std::isnan(value) && !(other <= value)) value = other;
  };
  for (int c = 0; c < 3; ++c) {
    raise(most.sums, relative(a.diffuse[c], b.diffuse[c]));
    raise(most.sums, relative(a.specular[c], b.specular[c]));
  }
  raise(most.sums, relative(a.energy, b.energy));
  raise(most.sums, relative(a.area, b.area));
  raise(most.position, length(a.position - b.position));
  raise(most.spread, std::fabs(std::sqrt(a.variance) - std::sqrt(b.variance)));
  raise(most.normal, length(a.normal - b.normal));
  raise(most.normal, std::fabs(a.softening - b.softening));
  raise(most.mean_lobe, length(mean_lobe(a) - mean_lobe(b)));
  raise(most.exponent, relative(a.exponent + 2, b.exponent + 2));
}

void check_same_nodes(const std::vector<VplNode>& device, std::span<const VplNode> cpu,
                      float of_exponent = 1e-5f) {
  REQUIRE(device.size() == cpu.size());
  Differences most;
  for (std::size_t h = 1; h < cpu.size(); ++h) compare(device[h], cpu[h], most);
  CHECK(most.sums < 1e-5f);
  CHECK(most.position < 1e-5f);
  CHECK(most.spread < 1e-5f);
  CHECK(most.normal < 1e-5f);
  CHECK(most.mean_lobe < 1e-5f);
  CHECK(most.exponent < of_exponent);
}

/// One point a walk, as on the device.
VplGatherResult walk_on_cpu(const VplTree& tree, std::span<const GlossyPoint> points, float threshold,
                            std::span<const WalkMark> marks) {
  VplGatherResult result;
  for (const GlossyPoint& point : points) {
    const Gathered one = gather_by_angle(tree, std::span(&point, 1), threshold, marks, Serial());
    result.radiance.push_back(one.radiance[0]);
    result.nodes.push_back(one.nodes[0]);
  }
  return result;
}

/// Points that differ by more than a thousandth of themselves and a millionth of the mean.
std::size_t count_off(const std::vector<vec3>& a, const std::vector<vec3>& reference) {
  float mean = 0;
  for (const vec3& r : reference) mean += length(r) / float(reference.size());
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    count += !(length(a[i] - reference[i]) <= 1e-3f * length(reference[i]) + 1e-6f * mean);
  return count;
}

/// Where rounding decides, one point may take other nodes, or one in a thousand.
void check_alike(const VplGatherResult& device, const std::vector<vec3>& radiance,
                 const std::vector<std::uint32_t>& nodes) {
  const std::size_t different = count_different(device.nodes, nodes),
                    off = count_off(device.radiance, radiance);
  const std::size_t allowed = std::max<std::size_t>(1, nodes.size() / 1000);
  REQUIRE(device.nodes.size() == nodes.size());
  CHECK(relative_rms(device.radiance, radiance) < 1e-3);
  CHECK(different <= allowed);
  CHECK(off <= allowed);
}

void check_walk(const VplShader& shader, const VplTree& tree, std::span<const GlossyPoint> points,
                float threshold, std::span<const WalkMark> marks = {}) {
  CAPTURE(threshold);
  const auto cpu = walk_on_cpu(tree, points, threshold, marks);
  check_alike(shader.gather_by_angle(points, threshold, marks), cpu.radiance, cpu.nodes);
}

VplLists lists_of(const VplTree& tree, const PointGroups& groups, float threshold) {
  VplLists lists;
  GroupLists(tree, groups, threshold, Serial()).for_each(0, groups.size(), [&](auto, auto, auto ids) {
    lists.nodes.insert(lists.nodes.end(), ids.begin(), ids.end());
    lists.ends.push_back(std::uint32_t(lists.nodes.size()));
  });
  return lists;
}

}  // namespace

TEST_CASE("nodes filtered on the device are those of the CPU, for every size of tree") {
  if (!has_device()) return;
  VulkanDevice device;
  VplShader shader(device);
  for (const std::size_t count : {1u, 2u, 3u, 64u, 100u, 128u, 129u, 5000u}) {
    CAPTURE(count);
    Random random(count);
    const VplTree tree(random_vpls(random, count));
    shader.filter(leaves_of(tree));
    check_same_nodes(shader.nodes(), tree.nodes());
    // Lobes a hundredth apart, which is what rounds: 1e-7 of it is 1e-5 of their exponent.
    const VplTree mirror(mirror_vpls(random, count));
    shader.filter(leaves_of(mirror));
    check_same_nodes(shader.nodes(), mirror.nodes(), 5e-5f);
  }
}

TEST_CASE("VPLs that are all dark, or all in one place, are filtered to numbers") {
  if (!has_device()) return;
  VulkanDevice device;
  VplShader shader(device);
  Random random(2);
  std::vector<VplNode> same(256, random_vpls(random, 10).back());
  std::vector<VplNode> dark = random_vpls(random, 256);
  for (VplNode& vpl : dark) vpl.diffuse = vpl.specular = vec3(0), vpl.energy = 0;
  for (const auto& vpls : {same, dark}) {
    const VplTree tree(vpls);
    shader.filter(leaves_of(tree));
    check_same_nodes(shader.nodes(), tree.nodes());
  }
  const auto points = random_glossy_points(random, 100);
  const auto gathered = shader.gather_by_angle(points, 0.01f);
  CHECK(gathered.radiance == std::vector<vec3>(100, vec3(0)));
  CHECK(gathered.nodes == std::vector<std::uint32_t>(100, 0));
}

TEST_CASE("points gather by solid angle what they gather on the CPU one by one") {
  if (!has_device()) return;
  VulkanDevice device;
  VplShader shader(device);
  for (const std::size_t count : {1u, 2u, 3u, 100u, 5000u}) {
    CAPTURE(count);
    Random random(100 + count);
    const VplTree tree(random_vpls(random, count));
    const auto points = random_glossy_points(random, 1000);
    shader.filter(leaves_of(tree));
    for (const float threshold : {1.0f, 0.03f, 0.001f, 1e-6f}) check_walk(shader, tree, points, threshold);
  }
}

TEST_CASE("narrow lobes that agree are gathered as on the CPU") {
  if (!has_device()) return;
  VulkanDevice device;
  VplShader shader(device);
  Random random(7);
  const VplTree tree(mirror_vpls(random, 2000));
  auto points = random_glossy_points(random, 1000);
  for (GlossyPoint& point : points) {
    point.mirror = normalize(vec3(-0.6f, -0.8f, 0) + 0.01f * random.direction());
    point.normal = vec3(0, -1, 0);
  }
  shader.filter(leaves_of(tree));
  check_walk(shader, tree, points, 0.001f);
}

TEST_CASE("marks split and take nodes as on the CPU") {
  if (!has_device()) return;
  VulkanDevice device;
  VplShader shader(device);
  Random random(8);
  const VplTree tree(random_vpls(random, 3000));
  const auto points = random_glossy_points(random, 500);
  shader.set_nodes(tree.nodes());
  for (const MinMaxCut& cut : {MinMaxCut{}, MinMaxCut{400, 0}, MinMaxCut{1e9f, 30}}) {
    const auto marks = min_max_marks(tree, cut);
    check_walk(shader, tree, points, 0.1f, marks);
    CHECK(shader.gather_by_angle(points, 0.1f, marks).nodes != shader.gather_by_angle(points, 0.1f).nodes);
  }
}

TEST_CASE("groups gather their lists as on the CPU") {
  if (!has_device()) return;
  VulkanDevice device;
  VplShader shader(device);
  for (const std::size_t count : {1u, 3u, 100u, 5000u}) {
    CAPTURE(count);
    Random random(200 + count);
    const VplTree tree(random_vpls(random, count));
    const PointGroups groups = random_groups(random, 60);
    shader.filter(leaves_of(tree));
    for (const float threshold : {0.0f, 0.003f}) {
      CAPTURE(threshold);
      const Gathered cpu = gather_by_bound(tree, groups, threshold, Serial());
      check_alike(shader.gather_lists(groups.points, lists_of(tree, groups, threshold)), cpu.radiance,
                  cpu.nodes);
    }
  }
}

TEST_CASE("walks and lists beyond what one kernel may loop go on in the next dispatch") {
  if (!has_device()) return;
  VulkanDevice device;
  VplShader shader(device);
  Random random(9);
  const VplTree tree(random_vpls(random, 50'000));
  auto points = random_glossy_points(random, 30);
  shader.set_nodes(tree.nodes());
  check_walk(shader, tree, points, 1e-9f);
  CHECK(shader.gather_by_angle(points, 1e-9f).nodes[0] > 33'000);
  VplLists lists;
  for (const std::uint32_t count : {70'000u, 0u, 32'768u, 32'769u}) {
    for (std::uint32_t i = 0; i < count; ++i)
      lists.nodes.push_back(1 + random.below(2 * tree.leaf_count() - 1));
    lists.ends.push_back(std::uint32_t(lists.nodes.size()));
  }
  VplGatherResult cpu;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::uint32_t group = points[i].group = random.below(4);
    const std::uint32_t first = group == 0 ? 0 : lists.ends[group - 1];
    const auto ids = std::span(lists.nodes).subspan(first, lists.ends[group] - first);
    VplArrays nodes;
    nodes.assign(tree.nodes(), ids);
    cpu.radiance.push_back(reflect_nodes<VplKind::cluster>(nodes, points[i]));
    cpu.nodes.push_back(std::uint32_t(ids.size()));
  }
  check_alike(shader.gather_lists(points, lists), cpu.radiance, cpu.nodes);
}

TEST_CASE("the paper's filtering is gathered from nodes of the CPU") {
  if (!has_device()) return;
  VulkanDevice device;
  VplShader shader(device);
  Random random(10);
  const auto vpls = random_vpls(random, 1000);
  const VplTree moments(vpls), uniform(vpls, {.filter = VplFilter::uniform});
  const auto points = random_glossy_points(random, 500);
  shader.filter(leaves_of(moments));
  const auto filtered = shader.gather_by_angle(points, 0.1f).radiance;
  shader.set_nodes(uniform.nodes());
  check_walk(shader, uniform, points, 0.1f);
  CHECK(relative_rms(shader.gather_by_angle(points, 0.1f).radiance, filtered) > 1e-3);
}

TEST_CASE("without VPLs points are dark, and without points nothing is gathered") {
  if (!has_device()) return;
  VulkanDevice device;
  VplShader shader(device);
  Random random(11);
  auto points = random_glossy_points(random, 70);
  const std::vector<vec3> black(70, vec3(0));
  CHECK(shader.nodes().empty());
  CHECK(shader.gather_by_angle(points, 0.1f).radiance == black);
  const VplTree tree(random_vpls(random, 20));
  shader.filter(leaves_of(tree));
  CHECK(shader.gather_by_angle({}, 0.1f).radiance.empty());
  CHECK(shader.gather_lists({}, {}).radiance.empty());
  CHECK(shader.gather_lists(points, {{0}, {}}).radiance == black);
  CHECK(shader.gather_by_angle(points, 0.1f).radiance != black);
  shader.filter({});
  CHECK(shader.nodes().empty());
  CHECK(shader.gather_by_angle(points, 0.1f).radiance == black);
}

TEST_CASE("a shader that has moved gathers the same bits") {
  if (!has_device()) return;
  VulkanDevice device;
  VplShader shader(device);
  Random random(12);
  const VplTree tree(random_vpls(random, 500));
  const auto points = random_glossy_points(random, 200);
  shader.filter(leaves_of(tree));
  const auto before = shader.gather_by_angle(points, 0.01f).radiance;
  const VplShader moved(std::move(shader));
  CHECK(moved.gather_by_angle(points, 0.01f).radiance == before);
}

TEST_CASE("the device's clock tells that more VPLs take longer, where it has one") {
  if (!has_device()) return;
  VulkanDevice device;
  VplShader shader(device);
  Random random(14);
  const auto points = random_glossy_points(random, 1000);
  const VplTree small(random_vpls(random, 2)), large(random_vpls(random, 4000));
  if (!shader.filter(leaves_of(small))) return;
  const auto few = shader.gather_by_angle(points, 1e-5f).milliseconds;
  CHECK(shader.filter(leaves_of(large)).value() > 0);
  const auto many = shader.gather_by_angle(points, 1e-5f).milliseconds;
  CHECK(few.value() >= 0);
  CHECK(many.value() > few.value());
}

TEST_CASE("the validation layer has nothing to say of VPLs") {
  if (!has_device({.validation = true})) return;
  VulkanDevice device({.validation = true});
  VplShader shader(device);
  Random random(13);
  const VplTree tree(random_vpls(random, 300));
  const PointGroups groups = random_groups(random, 10);
  shader.filter(leaves_of(tree));
  check_walk(shader, tree, groups.points, 0.1f, min_max_marks(tree, {}));
  const Gathered cpu = gather_by_bound(tree, groups, 0.01f, Serial());
  check_alike(shader.gather_lists(groups.points, lists_of(tree, groups, 0.01f)), cpu.radiance, cpu.nodes);
  for (const std::string& message : device.validation_messages()) FAIL_CHECK(message);
}
