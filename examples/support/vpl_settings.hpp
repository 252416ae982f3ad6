// Ways to gather and to choose pixels, as written on a command line.
#pragma once

#include <string>
#include <support/vpl_study.hpp>

namespace coppice::program {

/// "bound:0.01", "angle:0.02", "min-max:40:9:0.02", "traced:0.002", "energy:0.002" (traced, drawn by energy),
/// with
/// ":kd", ":lengths" or ":uniform" behind them for another tree. Throws InputError.
GatherSetting parse_gather(const std::string& text);

/// "relative:0.07", "paper:0.3", "uniform:4". `diagonal`: of the scene's bounding box, for paper. Throws
/// InputError.
AdaptiveOptions parse_pixels(const std::string& text, float diagonal);

}  // namespace coppice::program
