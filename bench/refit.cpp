// Some of 65,536 lights that move: the sums above them, against all sums made anew.
#include <coppice/core/random.hpp>
#include <coppice/relight/local_lighting.hpp>
#include <coppice/tree/build.hpp>
#include <cstring>

#include "check.hpp"

namespace coppice::bench {
namespace {

constexpr std::uint32_t light_count = 65536;

LocalLight random_light(Random& random) {
  const float x = random.uniform(), y = random.uniform(), z = random.uniform();
  return point_light(10.0f * vec3(x, y, z), vec3(random.uniform(), random.uniform(), random.uniform()));
}

/// The lights on their tree.
struct Lamps {
  std::vector<LocalLight> lights;
  LightTree tree;

  Lamps() {
    Random random(1);
    for (std::uint32_t i = 0; i < light_count; ++i) lights.push_back(random_light(random));
    const auto samples = metric_samples(lights);
    tree = build_tree(GeometricMetric(samples));
  }
};

const Lamps& lamps() {
  static const Lamps all;
  return all;
}

/// Lights far from each other in the tree, and two places for each, to go to and fro.
struct Moves {
  std::vector<std::uint32_t> lights;
  std::vector<LocalLight> there, back;

  explicit Moves(std::size_t count) : lights(spread_indices(count, light_count)) {
    Random random(2);
    for (const std::uint32_t l : lights) {
      there.push_back(random_light(random));
      back.push_back(lamps().lights[l]);
    }
  }
};

template <class T>
bool same_bits(std::span<const T> a, std::span<const T> b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

/// How many of the arrays are not those of new sums over all lights: bit for bit.
double arrays_that_differ(const LocalLighting& updated, const Moves& moves) {
  std::vector<LocalLight> lights = lamps().lights;
  for (std::size_t i = 0; i < moves.lights.size(); ++i) lights[moves.lights[i]] = moves.there[i];
  const LocalLighting anew(lamps().tree, lights);
  return !same_bits<LocalLightNode>(updated.frame().nodes, anew.frame().nodes) +
         !same_bits<LocalEmission>(updated.emissions(), anew.emissions());
}

/// With `nodes` > 0 the illumination cut is chosen anew after every update.
void update(benchmark::State& state, std::size_t nodes) {
  const Moves moves(std::size_t(state.range(0)));
  LocalLighting lighting(lamps().tree, lamps().lights);
  lighting.update(moves.lights, moves.there);
  if (!agrees(state, arrays_that_differ(lighting, moves), 0)) return;
  bool is_there = true;
  for (auto _ : state) {
    is_there = !is_there;
    lighting.update(moves.lights, is_there ? moves.there : moves.back);
    if (nodes > 0) lighting.set_cut(nodes, 0);
    benchmark::ClobberMemory();
  }
}
BENCHMARK_CAPTURE(update, alone, 0)
    ->Name("relight/update_lights")
    ->ArgName("moved")
    ->Arg(1)
    ->Arg(16)
    ->Arg(256)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(update, with_cut, 64)
    ->Name("relight/update_lights_and_cut")
    ->ArgName("moved")
    ->Arg(1)
    ->Arg(16)
    ->Arg(256)
    ->Unit(benchmark::kMicrosecond);

/// The slow twin: all sums anew.
void sum_all(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(LocalLighting(lamps().tree, lamps().lights));
}
BENCHMARK(sum_all)->Name("relight/sum_all_lights")->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace coppice::bench
