// What settings of the knobs cost and how far off they are: relighting by cuts against brute force.
#pragma once

#include <coppice/relight/cut_relighting.hpp>
#include <coppice/trade/errors.hpp>
#include <optional>
#include <span>
#include <support/knobs.hpp>
#include <support/program.hpp>
#include <support/report.hpp>
#include <vector>

namespace coppice::program {

/// A setting of the knobs, and what it gave.
struct OperatingPoint {
  Knobs knobs;
  std::size_t which = 0;                      ///< index into the sets of visibility cuts
  std::size_t illumination_nodes = 0;         ///< what knobs.nodes became
  CountSummary clusters{};                    ///< evaluated a shading point
  std::vector<double> lighting{}, shading{};  ///< milliseconds, a repetition each
  ImageErrors errors{};
  std::optional<double> visibility_rel_rmse{};  ///< with all lights in the illumination cut, where asked for
  Image image{};                                ///< where asked for

  double milliseconds() const { return median(lighting) + median(shading); }
};

/// Both brute-force twins: milliseconds, a repetition each, and the image of all lights.
struct Twins {
  std::vector<double> plain, skipping;
  Image reference;

  double plain_milliseconds() const { return median(plain); }
  double skipping_milliseconds() const { return median(skipping); }
};

struct Measurements {
  std::vector<OperatingPoint> points;
  Twins twins;
};

struct MeasureOptions {
  int repeat = 3;  ///< repetitions; times are their medians
  float lobe_tolerance = LobeOptions{}.tolerance;
  bool keep_images = false;
  bool visibility_only = false;  ///< also the error of each set of visibility cuts alone
};

/// The sets of visibility cuts that these points need, a set once; tells each point its own.
std::vector<VisibilityCutOptions> share_cuts(std::vector<OperatingPoint>& points, const CutOptions& options);

/// Measures on one thread; repetitions go round all points, so that a slow spell of the machine meets them
/// all. Preconditions: the relighting keeps bits and was made with the cuts of share_cuts(points). Throws
/// std::logic_error where the twins disagree.
Measurements measure(std::vector<OperatingPoint> points, CutRelighting<>& relighting,
                     const Environment& environment, const MeasureOptions& options);

/// The point of least time with rel_rmse <= error; null where there is none.
const OperatingPoint* cheapest(std::span<const OperatingPoint> points, double error);

/// The point of least rel_rmse that takes at most that long; null where there is none.
const OperatingPoint* most_accurate(std::span<const OperatingPoint> points, double milliseconds);

}  // namespace coppice::program
