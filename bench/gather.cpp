// A tree of VPLs: clustered, filtered and refitted; and its light gathered, against the sum over all of them.
#include <coppice/gather/angle_walk.hpp>
//
#include <coppice/core/random.hpp>
#include <coppice/gather/vpl_tree.hpp>
#include <coppice/reference/vpl.hpp>
#include <cstring>

#include "check.hpp"

namespace coppice::bench {
namespace {

constexpr std::uint32_t vpl_count = 16384;

/// On the six walls of a room 8 × 3 × 6 m, facing inwards, as lit by a few lamps.
VplNode random_vpl(Random& random) {
  const vec3 size(8, 3, 6), p(random.uniform(), random.uniform(), random.uniform());
  const int axis = int(random.below(3));
  const bool is_far = random.below(2) == 1;
  VplNode vpl{};
  vpl.position = size * p;
  vpl.position[axis] = is_far ? size[axis] : 0;
  vpl.normal[axis] = is_far ? -1.0f : 1.0f;
  vpl.area = 180.0f / vpl_count;
  vpl.softening = vpl.area / pi;
  vpl.diffuse = vpl.area * vec3(1, 0.9f, 0.8f) / (0.1f + p.x * p.x + p.z * p.z);
  vpl.specular = 0.5f * vpl.diffuse;
  vpl.energy = vpl_energy(vpl.diffuse, vpl.specular);
  vpl.lobe = normalize(vpl.normal + 0.8f * random.direction());
  vpl.exponent = 5 * std::pow(12.0f, random.uniform());
  return vpl;
}

const std::vector<VplNode>& vpls() {
  static const std::vector<VplNode> all = [] {
    Random random(1);
    std::vector<VplNode> made;
    for (std::uint32_t i = 0; i < vpl_count; ++i) made.push_back(random_vpl(random));
    return made;
  }();
  return all;
}

const VplTree& vpl_tree() {
  static const VplTree tree(vpls());
  return tree;
}

/// A floor as seen from a corner: 32 × 32 pixels.
const PointGroups& floor_points() {
  static const PointGroups groups = [] {
    const vec3 eye(0.5f, 1.6f, 0.5f);
    std::vector<GlossyPoint> points;
    for (std::uint32_t i = 0; i < 1024; ++i) {
      GlossyPoint p{};
      p.position = vec3(3 + float(i % 32) / 32, 0.0001f, 2 + float(i / 32) / 32);
      p.normal = vec3(0, 1, 0);
      const vec3 to_eye = normalize(eye - p.position);
      p.mirror = vec3(-to_eye.x, to_eye.y, -to_eye.z);
      p.exponent = 40;
      p.diffuse = p.specular = vec3(0.4f);
      p.pixel = i;
      points.push_back(p);
    }
    return group_points(points, 32, eye);
  }();
  return groups;
}

VplArrays all_vpls() {
  std::vector<std::uint32_t> ids(vpl_count);
  std::iota(ids.begin(), ids.end(), vpl_tree().leaf_count());
  VplArrays arrays;
  arrays.assign(vpl_tree().nodes(), ids);
  return arrays;
}

std::vector<vec3> sum_of_all() {
  const VplArrays all = all_vpls();
  std::vector<vec3> radiance;
  for (const GlossyPoint& p : floor_points().points)
    radiance.push_back(reflect_nodes<VplKind::single>(all, p));
  return radiance;
}

void cluster(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(VplTree(vpls()));
}
BENCHMARK(cluster)->Name("gather/cluster_16384_vpls")->Unit(benchmark::kMillisecond);

/// How far the energy of the root is from the sum over all VPLs.
double energy_lost(const VplTree& tree) {
  double sum = 0;
  for (const VplNode& vpl : vpls()) sum += double(vpl.energy);
  return std::abs(double(tree.nodes()[1].energy) / sum - 1);
}

void filter(benchmark::State& state) {
  VplTree tree(vpls());
  if (!agrees(state, energy_lost(tree), 1e-5)) return;
  for (auto _ : state) tree.set(vpls());
}
BENCHMARK(filter)->Name("gather/filter_16384_vpls")->Unit(benchmark::kMillisecond);

/// Whether a refit after changing some VPLs gives other bits than filtering all.
double refit_differs(VplTree& tree, std::span<const VplNode> leaves, std::span<const std::uint32_t> changed) {
  tree.refit(changed, leaves);
  VplTree anew(vpls());
  anew.set(leaves);
  return std::memcmp(tree.nodes().data(), anew.nodes().data(), tree.nodes().size_bytes()) == 0 ? 0 : 1;
}

void refit_some(benchmark::State& state) {
  std::vector<VplNode> leaves = vpls();
  std::vector<std::uint32_t> changed;
  for (std::uint32_t i = 0; i < vpl_count; i += vpl_count / std::uint32_t(state.range(0))) {
    changed.push_back(i);
    leaves[i].diffuse *= 2.0f;
  }
  VplTree tree(vpls());
  if (!agrees(state, refit_differs(tree, leaves, changed), 0)) return;
  for (auto _ : state) tree.refit(changed, leaves);
}
BENCHMARK(refit_some)->Name("gather/refit")->Arg(16)->Arg(256)->Unit(benchmark::kMicrosecond);

/// Against the sum in double at every 64th point.
double brute_force_error() {
  const std::vector<vec3> all = sum_of_all();
  std::vector<vec3> sums, expected;
  for (std::size_t i = 0; i < all.size(); i += 64) {
    sums.push_back(all[i]);
    expected.emplace_back(reference::reflected_by_all(vpls(), floor_points().points[i]));
  }
  return relative_difference(sums, expected);
}

void brute_force(benchmark::State& state) {
  if (!agrees(state, brute_force_error(), 1e-4)) return;
  for (auto _ : state) benchmark::DoNotOptimize(sum_of_all());
  state.counters["point"] = seconds_for_each(double(floor_points().points.size()));
}
BENCHMARK(brute_force)->Name("gather/all_vpls")->Unit(benchmark::kMillisecond);

void by_bound(benchmark::State& state) {
  const float threshold = 1e-3f * float(state.range(0));
  const auto gather = [&] { return gather_by_bound(vpl_tree(), floor_points(), threshold, Serial{}); };
  if (!agrees(state, relative_difference(gather().radiance, sum_of_all()), 0.03)) return;
  for (auto _ : state) benchmark::DoNotOptimize(gather());
  state.counters["point"] = seconds_for_each(double(floor_points().points.size()));
}
BENCHMARK(by_bound)->Name("gather/by_bound_permille")->Arg(20)->Arg(5)->Unit(benchmark::kMillisecond);

void by_angle(benchmark::State& state) {
  const auto gather = [&] { return gather_by_angle(vpl_tree(), floor_points().points, 0.02f, {}, Serial{}); };
  if (!agrees(state, relative_difference(gather().radiance, sum_of_all()), 0.05)) return;
  for (auto _ : state) benchmark::DoNotOptimize(gather());
  state.counters["point"] = seconds_for_each(double(floor_points().points.size()));
}
BENCHMARK(by_angle)->Name("gather/by_angle")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace coppice::bench
