#include "results.hpp"

#include <cstdio>

namespace coppice::bench {
namespace {

struct Comparison {
  const char* what;
  const char* fast;
  const char* against;
  const char* slow;
};

constexpr const char *skipping = "relight/image_by_brute_force/skipping",
                     *plain = "relight/image_by_brute_force/plain";

constexpr Comparison comparisons[] = {
    {"image, sigma 1, 256 nodes", "relight/image/sigma:1", "brute force that skips", skipping},
    {"image, sigma 2, 256 nodes", "relight/image/sigma:2", "brute force that skips", skipping},
    {"image, sigma 3, 256 nodes", "relight/image/sigma:3", "brute force that skips", skipping},
    {"image, sigma 1, 256 nodes", "relight/image/sigma:1", "brute force", plain},
    {"image, sigma 2, 256 nodes", "relight/image/sigma:2", "brute force", plain},
    {"image, sigma 3, 256 nodes", "relight/image/sigma:3", "brute force", plain},
    {"image by brute force that skips", skipping, "brute force", plain},
    {"merge of four cuts, vectorised", "cut/merge/vectorised", "the paper's merge", "cut/merge/postorder"},
    {"merge of four cuts, vectorised", "cut/merge/vectorised", "masks", "cut/merge/masks"},
    {"merge of four cuts, masks", "cut/merge/masks", "the paper's merge", "cut/merge/postorder"},
    {"merge of four cuts, ends", "cut/merge/ends", "the paper's merge", "cut/merge/postorder"},
    {"merge of four cuts, masks", "cut/merge/masks", "ends", "cut/merge/ends"},
    {"16,384 VPLs, bound 0.02", "gather/by_bound_permille/20", "all VPLs", "gather/all_vpls"},
    {"16,384 VPLs, bound 0.005", "gather/by_bound_permille/5", "all VPLs", "gather/all_vpls"},
    {"16,384 VPLs, angle 0.02", "gather/by_angle", "all VPLs", "gather/all_vpls"},
    {"256 VPLs changed: refit", "gather/refit/256", "all filtered anew", "gather/filter_16384_vpls"},
    {"visible lights up the tree", "cut/count_visible", "sums of floats", "cut/count_visible_by_floats"},
    {"visibility cut, sigma 2", "cut/select_visibility/sigma:2", "moments of all nodes",
     "cut/select_visibility_by_moments/sigma:2"},
};

struct Figure {
  const char* what;
  const char* benchmark;
  const char* counter;
  double scale;
  const char* unit;
};

constexpr Figure figures[] = {
    {"shading, Lambert", "relight/shade_point/lambert", "per_cluster", 1e9, "ns a cluster"},
    {"shading, GGX", "relight/shade_point/ggx", "per_cluster", 1e9, "ns a cluster"},
    {"shading, Phong", "relight/shade_point/phong", "per_cluster", 1e9, "ns a cluster"},
    {"shading, Blinn-Phong", "relight/shade_point/blinn_phong", "per_cluster", 1e9, "ns a cluster"},
    {"shading, Ward", "relight/shade_point/ward", "per_cluster", 1e9, "ns a cluster"},
    {"memory, sigma 1", "relight/image/sigma:1", "bytes_per_receiver", 1, "bytes a receiver"},
    {"memory, sigma 2", "relight/image/sigma:2", "bytes_per_receiver", 1, "bytes a receiver"},
    {"memory, sigma 3", "relight/image/sigma:3", "bytes_per_receiver", 1, "bytes a receiver"},
    {"precomputation", "embree/precompute_visibility/manual_time", "times_bare_rays", 1,
     "times its shadow rays alone (at most 1.5 is asked for)"},
};

std::string duration(double seconds) {
  char text[32];
  if (seconds < 1e-3)
    std::snprintf(text, sizeof text, "%.3g us", 1e6 * seconds);
  else
    std::snprintf(text, sizeof text, "%.4g ms", 1e3 * seconds);
  return text;
}

void print(const Comparison& row, const Result& fast, const Result& slow) {
  std::printf("%-32s %10s   %-22s %10s %9.2fx %9.2g%%\n", row.what, duration(fast.seconds).c_str(),
              row.against, duration(slow.seconds).c_str(), slow.seconds / fast.seconds,
              100 * fast.counters.at("error"));
}

}  // namespace

void ResultKeeper::ReportRuns(const std::vector<Run>& runs) {
  benchmark::ConsoleReporter::ReportRuns(runs);
  for (const Run& run : runs) {
    const bool is_median = run.aggregate_name == "median";
    if (run.run_type == Run::RT_Aggregate && !is_median) continue;
    Result result{run.GetAdjustedCPUTime() / benchmark::GetTimeUnitMultiplier(run.time_unit), {}};
    for (const auto& [name, counter] : run.counters) result.counters[name] = counter.value;
    if (result.counters.contains("error")) results_[run.run_name.str()] = result;
  }
}

void print_comparisons(const std::map<std::string, Result>& results) {
  std::printf("\n%-34s %13s   %-24s %13s %9s %10s\n", "what", "takes", "against", "takes", "speed-up",
              "error");
  for (const Comparison& row : comparisons) {
    const auto fast = results.find(row.fast), slow = results.find(row.slow);
    if (fast != results.end() && slow != results.end()) print(row, fast->second, slow->second);
  }
  std::printf("\n");
  for (const Figure& row : figures)
    if (const auto found = results.find(row.benchmark); found != results.end())
      std::printf("%-32s %10.4g %s\n", row.what, row.scale * found->second.counters.at(row.counter),
                  row.unit);
}

}  // namespace coppice::bench
