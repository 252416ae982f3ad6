// The solvers of principal components side by side, at the sizes of one cluster.
#include <coppice/core/simd.hpp>
//
#include <coppice/core/random.hpp>
#include <coppice/pca/basis.hpp>
#include <coppice/reference/pca.hpp>

#include "check.hpp"

namespace coppice::bench {
namespace {

/// Sums of smooth waves over random points: energies fall slowly, as those of depth do.
Rows waves(std::size_t count, std::size_t width) {
  Random random(1);
  std::vector<vec3> points(count), directions(width);
  for (auto& p : points) p = {random.uniform(), random.uniform(), random.uniform()};
  for (auto& d : directions) d = random.direction();
  Rows rows(count, width);
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t k = 0; k < width; ++k) {
      const float phase = dot(points[i], directions[k]) * 6;
      rows[i][k] = std::abs(std::sin(phase)) + 0.5f * std::abs(std::cos(3 * phase + directions[k].x));
    }
  return rows;
}

/// The largest difference of energies from the twin's, as a share of all, for fewer rows.
double error_beside_twin(PcaSolver solver) {
  const Rows rows = waves(120, 150);
  reference::DoubleRows data;
  for (std::size_t i = 0; i < rows.count(); ++i) data.emplace_back(rows[i].begin(), rows[i].end());
  const std::vector<double> mean = reference::mean_of(data);
  for (auto& row : data)
    for (std::size_t k = 0; k < mean.size(); ++k) row[k] -= mean[k];
  const auto twin = reference::singular_vectors(data);
  PcaOptions options;
  options.rank = 10, options.solver = solver;
  const PcaBasis basis = pca(rows, options);
  double worst = 0;
  for (std::size_t j = 0; j < basis.rank(); ++j)
    worst = std::max(worst, std::abs(basis.energies[j] - twin.values[j] * twin.values[j]));
  return worst / basis.total_energy;
}

void solve(benchmark::State& state, PcaSolver solver) {
  if (!agrees(state, error_beside_twin(solver), 1e-9)) return;
  const Rows rows = waves(1000, std::size_t(state.range(0)));
  PcaOptions options;
  options.rank = std::size_t(state.range(1)), options.solver = solver;
  for (auto _ : state) {
    const PcaBasis basis = pca(rows, options);
    state.counters["loss"] = basis.loss();
  }
}

void sizes(benchmark::internal::Benchmark* benchmark) {
  for (const int width : {1000, 2016, 5000})
    for (const int rank : {10, 20, 50, 100}) benchmark->Args({width, rank});
  benchmark->Unit(benchmark::kMillisecond)->ArgNames({"columns", "rank"});
}
BENCHMARK_CAPTURE(solve, pca_subspace, PcaSolver::subspace)->Apply(sizes);
BENCHMARK_CAPTURE(solve, pca_gram, PcaSolver::gram)->Apply(sizes);

}  // namespace
}  // namespace coppice::bench
