#include <algorithm>
#include <cmath>
#include <support/plot.hpp>
#include <support/text.hpp>

namespace coppice::program {

namespace {

constexpr double left = 80, right = 700, top = 50, bottom = 420;
const char* const colours[] = {"#1b6e3c", "#c0582b", "#2c5f9e", "#8a3f8f", "#8c7a1d", "#3a8f8a",
                               "#d1495b", "#6b8e23", "#5b5ea6", "#b0763a", "#444444", "#c277b5"};

/// Maps a logarithmic range, widened to powers of 1, 2, 5 · 10ⁿ, onto pixels.
class LogAxis {
 public:
  LogAxis(double low, double high, double from, double to) : from_(from), to_(to) {
    for (int decade = -6; decade < 9; ++decade)
      for (const double step : {1.0, 2.0, 5.0}) ticks_.push_back(step * std::pow(10.0, decade));
    const auto first = std::upper_bound(ticks_.begin(), ticks_.end(), low) - 1;
    const auto last = std::lower_bound(ticks_.begin(), ticks_.end(), high);
    ticks_ = std::vector<double>(first, last + 1);
  }
  double operator()(double v) const {
    const double a = std::log(ticks_.front()), b = std::log(ticks_.back());
    return from_ + (std::log(v) - a) / std::max(b - a, 1e-9) * (to_ - from_);
  }
  const std::vector<double>& ticks() const { return ticks_; }

 private:
  double from_, to_;
  std::vector<double> ticks_;
};

void draw_axes(std::string& svg, const PlotAxes& axes, const LogAxis& x, const LogAxis& y) {
  for (const double t : x.ticks()) {
    svg +=
        formatted("<line x1='%.1f' y1='%.0f' x2='%.1f' y2='%.0f' stroke='#ddd'/>\n", x(t), top, x(t), bottom);
    svg += formatted("<text x='%.1f' y='%.0f' text-anchor='middle'>%g</text>\n", x(t), bottom + 18, t);
  }
  for (const double t : y.ticks()) {
    svg +=
        formatted("<line x1='%.0f' y1='%.1f' x2='%.0f' y2='%.1f' stroke='#ddd'/>\n", left, y(t), right, y(t));
    svg += formatted("<text x='%.0f' y='%.1f' text-anchor='end'>%g</text>\n", left - 8, y(t) + 4, t);
  }
  svg += formatted("<text x='%.0f' y='%.0f' text-anchor='middle'>%s</text>\n", (left + right) / 2,
                   bottom + 42, axes.error.c_str());
  svg += formatted("<text x='20' y='%.0f' text-anchor='middle' transform='rotate(-90 20 %.0f)'>%s</text>\n",
                   (top + bottom) / 2, (top + bottom) / 2, axes.cost.c_str());
}

void draw_line(std::string& svg, const PlotLine& line, const char* colour, const LogAxis& x, const LogAxis& y,
               double legend) {
  svg += formatted("<polyline fill='none' stroke='%s' stroke-width='2' points='", colour);
  for (const auto& [error, ms] : line.points) svg += formatted("%.1f,%.1f ", x(error), y(ms));
  svg += "'/>\n";
  for (const auto& [error, ms] : line.points)
    svg += formatted("<circle cx='%.1f' cy='%.1f' r='4' fill='%s'/>\n", x(error), y(ms), colour);
  svg += formatted("<text x='%.0f' y='%.1f' fill='%s'>%s</text>\n", right + 12, legend, colour,
                   line.name.c_str());
}

}  // namespace

std::string plot_time_against_error(const std::string& title, const std::vector<PlotLine>& lines,
                                    const std::vector<PlotLevel>& levels) {
  return plot_cost_against_error(title, {}, lines, levels);
}

std::string plot_cost_against_error(const std::string& title, const PlotAxes& axes,
                                    const std::vector<PlotLine>& lines,
                                    const std::vector<PlotLevel>& levels) {
  double x_low = 1e9, x_high = 0, y_low = 1e9, y_high = 0;
  for (const auto& line : lines)
    for (const auto& [error, ms] : line.points) {
      x_low = std::min(x_low, error), x_high = std::max(x_high, error);
      y_low = std::min(y_low, ms), y_high = std::max(y_high, ms);
    }
  for (const auto& level : levels)
    y_low = std::min(y_low, level.milliseconds), y_high = std::max(y_high, level.milliseconds);
  const LogAxis x(std::clamp(x_low, 1e-5, 1e5), std::clamp(x_high, 1e-5, 1e6), left, right);
  const LogAxis y(std::clamp(y_low, 1e-5, 1e7), std::clamp(y_high, 1e-5, 1e7), bottom, top);
  std::string svg =
      "<svg xmlns='http://www.w3.org/2000/svg' width='900' height='480' font-family='sans-serif' "
      "font-size='13'>\n"
      "<rect width='900' height='480' fill='white'/>\n";
  svg += formatted("<text x='%.0f' y='28' font-size='16'>%s</text>\n", left, title.c_str());
  draw_axes(svg, axes, x, y);
  double legend = bottom - 20 * double(lines.size() - 1);  // from below: levels are named at the top
  for (std::size_t i = 0; i < lines.size(); ++i, legend += 20)
    draw_line(svg, lines[i], colours[i % std::size(colours)], x, y, legend);
  for (const auto& level : levels) {
    svg += formatted("<line x1='%.0f' y1='%.1f' x2='%.0f' y2='%.1f' stroke='#444' stroke-dasharray='6 4'/>\n",
                     left, y(level.milliseconds), right, y(level.milliseconds));
    svg += formatted("<text x='%.0f' y='%.1f' fill='#444'>%s</text>\n", right + 12, y(level.milliseconds) + 4,
                     level.name.c_str());
  }
  return svg + "</svg>\n";
}

}  // namespace coppice::program
