// A plot of time, or of anything else, against error as SVG.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace coppice::program {

/// A line through (error in percent, milliseconds or what the plot is of), both positive.
struct PlotLine {
  std::string name;
  std::vector<std::pair<double, double>> points;
};

/// A horizontal mark at some milliseconds, for what has no error.
struct PlotLevel {
  std::string name;
  double milliseconds;
};

/// Time against relRMSE on logarithmic axes, a colour a line; an SVG document.
std::string plot_time_against_error(const std::string& title, const std::vector<PlotLine>& lines,
                                    const std::vector<PlotLevel>& levels);

/// What the axes of a plot are called.
struct PlotAxes {
  std::string error = "relRMSE against all lights, %";
  std::string cost = "milliseconds, one thread";
};

/// The same of any cost against any error.
std::string plot_cost_against_error(const std::string& title, const PlotAxes& axes,
                                    const std::vector<PlotLine>& lines, const std::vector<PlotLevel>& levels);

}  // namespace coppice::program
