// Measures Coppice. Fails where a result is not that of its slow twin.
#include <hwy/targets.h>

#include <coppice/core/simd.hpp>
#include <cstdio>

#include "check.hpp"
#include "machine.hpp"
#include "results.hpp"

namespace coppice::bench {
namespace {

int run() {
  const std::string instructions =
      std::string(hwy::TargetName(HWY_TARGET)) + ", " + std::to_string(Lanes::width) + " floats a register";
  benchmark::AddCustomContext("processor", processor());
  benchmark::AddCustomContext("instructions", instructions);
  ResultKeeper keeper;
  benchmark::RunSpecifiedBenchmarks(&keeper);
  if (check_failed()) {
    std::fprintf(stderr, "bench_coppice: a result is not that of its slow twin; the runs above tell which\n");
    return 1;
  }
  if (keeper.results().empty()) return 0;
  std::printf("\n%s, %s, processor time of one thread\n", processor().c_str(), instructions.c_str());
  print_comparisons(keeper.results());
  return 0;
}

}  // namespace
}  // namespace coppice::bench

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  return coppice::bench::run();
}
