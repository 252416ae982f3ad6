// Gathering an environment into lights.
#include <coppice/light/environment_cells.hpp>

#include "check.hpp"
#include "demo.hpp"

namespace coppice::bench {
namespace {

/// The slow twin: every texel asks every direction.
std::vector<vec3> gather_by_scanning(const Image& map, std::span<const vec3> directions) {
  std::vector<glm::dvec3> sums(directions.size(), glm::dvec3(0));
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) {
      const vec3 d = texel_direction(x, y, map.width, map.height);
      const auto nearest = std::ranges::max_element(directions, {}, [&](const vec3& l) { return dot(l, d); });
      const double solid_angle = texel_solid_angle(y, map.width, map.height);
      sums[std::size_t(nearest - directions.begin())] += solid_angle * glm::dvec3(map.at(x, y));
    }
  return {sums.begin(), sums.end()};
}

/// Against the twin for few directions: all would take minutes.
double gather_error(const Environment& environment) {
  const auto directions = even_directions(128);
  const EnvironmentCells cells(directions, environment.map.width, environment.map.height);
  std::vector<vec3> powers;
  for (const CellLight& l : cells.gather(environment)) powers.push_back(l.power);
  return relative_difference(powers, gather_by_scanning(environment.map, directions));
}

void gather(benchmark::State& state) {
  const Environment& environment = Demo::get().environment;
  static const double error = gather_error(environment);
  static const EnvironmentCells cells(even_directions(32768), environment.map.width, environment.map.height);
  if (!agrees(state, error, 1e-3)) return;
  for (auto _ : state) benchmark::DoNotOptimize(cells.gather(environment));
}
BENCHMARK(gather)->Name("light/gather_environment")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace coppice::bench
