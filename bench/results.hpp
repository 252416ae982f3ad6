// What the benchmarks have measured, and what follows from comparing them.
#pragma once

#include <benchmark/benchmark.h>

#include <map>
#include <string>

namespace coppice::bench {

struct Result {
  double seconds = 0;  ///< of processor time, an iteration: what other programs do counts for little
  std::map<std::string, double> counters;
};

/// Shows what it is told and keeps it: medians where benchmarks are repeated, otherwise the only run.
class ResultKeeper : public benchmark::ConsoleReporter {
 public:
  void ReportRuns(const std::vector<Run>& runs) override;

  const std::map<std::string, Result>& results() const { return results_; }

 private:
  std::map<std::string, Result> results_;
};

/// Prints speed-ups with their errors beside, then single figures. Rows whose benchmarks did not run are left
/// out.
void print_comparisons(const std::map<std::string, Result>& results);

}  // namespace coppice::bench
