#include <algorithm>
#include <limits>
#include <support/plot.hpp>
#include <support/text.hpp>
#include <support/trade_output.hpp>

namespace coppice::program {

namespace {

std::string cuts_word(const OperatingPoint& p) { return word_of(cut_kind_words, p.knobs.cuts); }
std::string lobes_word(const OperatingPoint& p) { return word_of(lobes_words, p.knobs.lobes); }

double mean_pieces(const OperatingPoint& p, const CutRelighting<>& relighting) {
  return cuts_json(relighting.cuts(p.which))["mean"].get<double>();
}

/// Quoted, where a comma or a quote is in it.
std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string csv_row(const OperatingPoint& p, const Twins& twins, const CutRelighting<>& relighting) {
  const std::string visibility =
      p.visibility_rel_rmse ? formatted("%.6f", *p.visibility_rel_rmse) : std::string();
  const double points = double(std::max<std::size_t>(1, relighting.buffer().points.size()));
  std::string row = formatted("%g,%zu,", p.knobs.sigma, p.knobs.nodes) + cuts_word(p) + "," + lobes_word(p);
  row += formatted(",%zu,%.1f,%.1f,%zu,", p.illumination_nodes, mean_pieces(p, relighting), p.clusters.mean,
                   relighting.cuts(p.which).byte_count());
  row +=
      formatted("%.3f,%.3f,%.4f,", median(p.lighting), median(p.shading), 1e3 * median(p.shading) / points);
  row += formatted("%.6f,%.6f,%.6f,", p.errors.rel_rmse, p.errors.mre, p.errors.p99) + visibility;
  return row + formatted(",%.2f,%.2f\n", twins.plain_milliseconds() / p.milliseconds(),
                         twins.skipping_milliseconds() / p.milliseconds());
}

bool has_visibility(const Measurements& measured) {
  return std::ranges::any_of(measured.points,
                             [](const auto& p) { return p.visibility_rel_rmse.has_value(); });
}

std::string table_head(bool with_visibility) {
  std::string head =
      "| σ | illumination nodes | visibility cuts | lobes | pieces a visibility cut | clusters a point | "
      "MB of cuts | ms a frame | relRMSE | × skipping SIMD | × plain SIMD |";
  std::string rule = "|---|---|---|---|---|---|---|---|---|---|---|";
  if (with_visibility) head += " relRMSE of visibility |", rule += "---|";
  return head + "\n" + rule + "\n";
}

std::string table_row(const OperatingPoint& p, const Twins& twins, const CutRelighting<>& relighting) {
  std::string row = formatted("| %g | %zu | ", p.knobs.sigma, p.illumination_nodes);
  row += cuts_word(p) + " | " + lobes_word(p);
  row += formatted(" | %.0f | %.0f | %.1f | %.1f | %.2f%% | %.1f | %.1f |", mean_pieces(p, relighting),
                   p.clusters.mean, 1e-6 * double(relighting.cuts(p.which).byte_count()), p.milliseconds(),
                   100 * p.errors.rel_rmse, twins.skipping_milliseconds() / p.milliseconds(),
                   twins.plain_milliseconds() / p.milliseconds());
  if (p.visibility_rel_rmse) row += formatted(" %.3f%% |", 100 * *p.visibility_rel_rmse);
  return row + "\n";
}

std::string twin_rows(const Twins& twins, const CutRelighting<>& relighting, const char* end) {
  const double megabytes = 8e-6 * double(relighting.bits().size());
  const double plain = twins.plain_milliseconds(), skipping = twins.skipping_milliseconds();
  return formatted("| – | all lights, skipping the unseen | – | – | | | %.1f | %.0f | 0 | 1 | %.1f |%s\n",
                   megabytes, skipping, plain / skipping, end) +
         formatted("| – | all lights | – | – | | %zu | %.1f | %.0f | 0 | %.2f | 1 |%s\n",
                   relighting.directions().size(), megabytes, plain, skipping / plain, end);
}

/// The points that no other beats in both error and time, in order of error.
std::vector<std::pair<double, double>> best_of(std::vector<std::pair<double, double>> points) {
  std::ranges::sort(points);
  std::vector<std::pair<double, double>> best;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& p : points)
    if (p.second < least) best.push_back(p), least = p.second;
  return best;
}

}  // namespace

std::string csv(const Measurements& measured, const CutRelighting<>& relighting,
                const CommonOptions& inputs) {
  std::string text =
      "scene,environment,rotate_env,sigma,cut_size,cuts,lobes,illumination_nodes,visibility_pieces,clusters,"
      "bytes,ms_lighting,ms_shading,us_per_point,rel_rmse,mre,p99,rel_rmse_visibility,times_plain,"
      "times_skipping\n";
  const std::string lighting = csv_field(inputs.scene.string()) + "," +
                               csv_field(inputs.environment.string()) +
                               formatted(",%g,", double(inputs.rotate_environment));
  for (const auto& p : measured.points) text += lighting + csv_row(p, measured.twins, relighting);
  return text;
}

std::string table(const Measurements& measured, const CutRelighting<>& relighting) {
  const auto& buffer = relighting.buffer();
  const double faces = double(std::max<std::size_t>(1, buffer.faces.size()));
  const bool with_visibility = has_visibility(measured);
  std::string text =
      formatted("%zu shading points, %.1f a face, %zu receivers, %zu lights, one thread, %s\n\n",
                buffer.points.size(), double(buffer.points.size()) / faces, relighting.receivers().size(),
                relighting.directions().size(), relighting.kernels().instructions);
  text += table_head(with_visibility);
  for (const auto& p : measured.points) text += table_row(p, measured.twins, relighting);
  return text + twin_rows(measured.twins, relighting, with_visibility ? " 0 |" : "");
}

std::string plot(const Measurements& measured) {
  std::vector<PlotLine> lines;
  for (const auto& p : measured.points) {
    const std::string name = cuts_word(p) + ", " + lobes_word(p);
    auto line = std::ranges::find(lines, name, &PlotLine::name);
    if (line == lines.end()) line = lines.insert(lines.end(), {name, {}});
    line->points.push_back({std::max(100 * p.errors.rel_rmse, 1e-4), p.milliseconds()});
  }
  for (auto& line : lines) line.points = best_of(std::move(line.points));
  return plot_time_against_error("Time against error", lines,
                                 {{"all lights, SIMD", measured.twins.plain_milliseconds()},
                                  {"skipping the unseen", measured.twins.skipping_milliseconds()}});
}

std::string description(const OperatingPoint& p) {
  return formatted("σ %g, %zu nodes, ", p.knobs.sigma, p.knobs.nodes) + cuts_word(p) + ", " + lobes_word(p) +
         formatted(": %.1f ms, relRMSE %.3g%%", p.milliseconds(), 100 * p.errors.rel_rmse);
}

nlohmann::json point_json(const OperatingPoint& p, const CutRelighting<>& relighting) {
  nlohmann::json j = {{"sigma", p.knobs.sigma},
                      {"cut_size", p.knobs.nodes},
                      {"cuts", cuts_word(p)},
                      {"lobes", lobes_word(p)},
                      {"illumination_nodes", p.illumination_nodes},
                      {"clusters", summary_json(p.clusters)},
                      {"milliseconds", p.milliseconds()},
                      {"visibility_cuts", cuts_json(relighting.cuts(p.which))},
                      {"errors", errors_json(p.errors)}};
  if (p.visibility_rel_rmse) j["rel_rmse_visibility"] = *p.visibility_rel_rmse;
  return j;
}

}  // namespace coppice::program
