// Building the light tree, and sums up it.
#include <coppice/light/directions.hpp>
#include <coppice/tree/aggregate.hpp>
#include <coppice/tree/build.hpp>
#include <limits>

#include "check.hpp"

namespace coppice::bench {
namespace {

constexpr std::uint32_t light_count = 32768;

const std::vector<LightSample>& samples() {
  static const std::vector<LightSample> all = [] {
    std::vector<LightSample> lights;
    for (const vec3& d : even_directions(light_count)) lights.push_back({d, vec3(0)});
    return lights;
  }();
  return all;
}

using Lights = std::span<std::uint32_t>;

vec3 mean_position(Lights lights) {
  glm::dvec3 sum(0);
  for (const std::uint32_t l : lights) sum += glm::dvec3(samples()[l].position);
  return vec3(sum / double(lights.size()));
}

/// The slow twin of build_tree for distant lights: every round sorts all lights of a cluster by the
/// difference of their squared distances to the two centres.
void halve_by_sorting(Lights lights) {
  if (lights.size() == 1) return;
  const Lights left = lights.first(lights.size() / 2), right = lights.subspan(lights.size() / 2);
  vec3 low(1), high(-1);
  for (const std::uint32_t l : lights)
    low = glm::min(low, samples()[l].position), high = glm::max(high, samples()[l].position);
  const vec3 size = high - low;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  std::ranges::sort(lights, {}, [&](std::uint32_t l) { return std::pair(samples()[l].position[axis], l); });
  for (int i = 0; i < TreeOptions{}.iterations; ++i) {
    const vec3 a = mean_position(left), b = mean_position(right);
    std::ranges::sort(lights, {}, [&](std::uint32_t l) {
      const vec3 p = samples()[l].position;
      return std::pair(dot(p - a, p - a) - dot(p - b, p - b), l);
    });
  }
  halve_by_sorting(left);
  halve_by_sorting(right);
}

/// Σ |position - mean|² over clusters of 32 leaves: what the tree is meant to keep small.
double spread(std::vector<std::uint32_t> light_of_leaf) {
  double sum = 0;
  for (std::size_t i = 0; i < light_of_leaf.size(); i += 32) {
    const Lights cluster = Lights(light_of_leaf).subspan(i, 32);
    const vec3 mean = mean_position(cluster);
    for (const std::uint32_t l : cluster)
      sum += double(dot(samples()[l].position - mean, samples()[l].position - mean));
  }
  return sum;
}

/// How far the spread is from the twin's; infinite where a light is missing.
double build_error() {
  const LightTree tree = build_tree(GeometricMetric(samples()));
  std::vector<std::uint32_t> lights(light_count), leaves = tree.light_of_leaf;
  std::iota(lights.begin(), lights.end(), 0u);
  std::ranges::sort(leaves);
  if (leaves != lights) return std::numeric_limits<double>::infinity();
  halve_by_sorting(lights);
  return std::fabs(spread(tree.light_of_leaf) / spread(lights) - 1);
}

void build(benchmark::State& state) {
  static const double error = build_error();
  if (!agrees(state, error, 0.01)) return;
  for (auto _ : state) benchmark::DoNotOptimize(build_tree(GeometricMetric(samples())));
}
BENCHMARK(build)->Name("tree/build")->Unit(benchmark::kMillisecond);

std::vector<float> random_values() {
  Random random(1);
  std::vector<float> values(light_count);
  for (float& v : values) v = random.uniform();
  return values;
}

/// Largest relative error of the squared deviations against two passes over the leaves of every node.
double moments_error(const LightTree& tree, std::span<const float> values) {
  const std::vector<Moments> moments = aggregate_moments(tree, values);
  double worst = 0;
  for (std::uint32_t h = 1; h < tree.leaf_count(); ++h) {
    const LeafRange leaves = leaves_below(tree.leaf_count(), h);
    long double mean = 0, squares = 0;
    for (std::uint32_t i = leaves.begin; i < leaves.end; ++i) mean += values[tree.light_of_leaf[i]];
    mean /= leaves.size();
    for (std::uint32_t i = leaves.begin; i < leaves.end; ++i)
      squares += (values[tree.light_of_leaf[i]] - mean) * (values[tree.light_of_leaf[i]] - mean);
    worst = std::max(
        worst, std::fabs(moments[h].squared_deviations - double(squares)) / std::max(double(squares), 1e-12));
  }
  return worst;
}

void aggregate_values(benchmark::State& state) {
  static const LightTree tree = build_tree(GeometricMetric(samples()));
  static const std::vector<float> values = random_values();
  static const double error = moments_error(tree, values);
  if (!agrees(state, error, 1e-9)) return;
  for (auto _ : state) benchmark::DoNotOptimize(aggregate_moments(tree, values));
}
BENCHMARK(aggregate_values)->Name("tree/aggregate_moments")->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace coppice::bench
