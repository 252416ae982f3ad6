// Measures Coppice. Fails where a result is not that of its slow twin.
#include <hwy/targets.h>

#include <coppice/core/simd.hpp>
#include <cstdio>
#include <fstream>

#include "check.hpp"
#include "results.hpp"

namespace coppice::bench {
namespace {

/// The name that Linux gives to the processor.
std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown processor";
}

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
