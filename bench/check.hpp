// A benchmark counts only where its result is that of its slow twin.
#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <coppice/core/math.hpp>
#include <cstdint>
#include <span>
#include <vector>

namespace coppice::bench {

/// Whether any check has failed so far.
inline bool& check_failed() {
  static bool failed = false;
  return failed;
}

/// Shows the deviation from the slow twin as the counter "error". Beyond the limit the benchmark is not
/// measured and the program will fail.
inline bool agrees(benchmark::State& state, double error, double limit) {
  state.counters["error"] = error;
  if (error <= limit) return true;
  check_failed() = true;
  state.SkipWithError("the result is not that of its slow twin");
  return false;
}

/// Σ |a - b| / Σ |b| over all channels. Precondition: equal sizes; b is not black.
inline double relative_difference(std::span<const vec3> a, std::span<const vec3> b) {
  double difference = 0, size = 0;
  for (std::size_t i = 0; i < b.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      difference += std::fabs(double(a[i][c]) - double(b[i][c]));
      size += std::fabs(double(b[i][c]));
    }
  return difference / size;
}

/// The counter that shows a time as seconds for each of `count` things that an iteration does.
inline benchmark::Counter seconds_for_each(double count) {
  return {count, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert};
}

/// `count` of the indices below `total`, evenly spread. Precondition: total > 0.
inline std::vector<std::uint32_t> spread_indices(std::size_t count, std::size_t total) {
  std::vector<std::uint32_t> indices;
  for (std::size_t i = 0; i < std::min(count, total); ++i)
    indices.push_back(std::uint32_t((2 * i + 1) * total / (2 * std::min(count, total))));
  return indices;
}

}  // namespace coppice::bench
