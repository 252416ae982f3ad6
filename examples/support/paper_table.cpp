#include <algorithm>
#include <cmath>
#include <cstdio>
#include <support/paper_table.hpp>
#include <support/report.hpp>
#include <support/text.hpp>

namespace coppice::program {
namespace {

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

PaperTree measure_tree(PaperScene& scene, double beta, int repeat) {
  PaperTree tree{beta, scene.tree_seconds(), {}};
  for (std::size_t way = 0; way < paper_ways.size(); ++way)
    for (const double sigma : paper_sigmas) {
      std::fprintf(stderr, "beta %g, %s, sigma %g\n", beta,
                   word_of(cut_kind_words, paper_ways[way].cuts).c_str(), sigma);
      PaperRequest request{sigma, paper_ways[way], {}, repeat};
      if (sigma == paper_sigmas[0]) request.nodes.assign(paper_nodes.begin(), paper_nodes.end());
      tree.cuts[way].push_back(scene.measure(request));
    }
  return tree;
}

/// Pieces that a curve takes for an RMS.
std::optional<double> pieces_at(std::span<const PaperCuts> cuts, double rms) {
  std::vector<std::pair<double, double>> curve;  // RMS and pieces, both as logarithms
  for (const PaperCuts& c : cuts)
    if (c.rms > 0 && c.pieces > 0) curve.emplace_back(std::log(c.rms), std::log(c.pieces));
  std::ranges::sort(curve);
  const double x = std::log(rms);
  for (std::size_t i = 1; i < curve.size(); ++i) {
    const auto [left, low] = curve[i - 1];
    const auto [right, high] = curve[i];
    if (x < left || x > right || left == right) continue;
    return std::exp(low + (high - low) * (x - left) / (right - left));
  }
  return std::nullopt;
}

double total_seconds(const PaperTable& table, const PaperTree& tree, const PaperCuts& cuts) {
  return tree.seconds + table.receiver_seconds + table.ray_seconds + cuts.seconds;
}

std::string csv_row(const PaperTable& table, const PaperTree& tree, std::size_t way, const PaperCuts& c) {
  std::string row = formatted("%zu,%zu,%zu,%zu,%g,", table.counts.triangles, table.counts.points,
                              table.counts.receivers, table.counts.lights, tree.beta);
  row += word_of(cut_kind_words, paper_ways[way].cuts) + "," + word_of(lobes_words, paper_ways[way].lobes);
  row += formatted(",%g,%.2f,%.2f,%.2f,%.2f,%.3f,%.6f,%zu,", c.sigma, table.receiver_seconds, tree.seconds,
                   table.ray_seconds, c.seconds, c.pieces, c.rms, c.bytes);
  if (c.file_bytes > 0) row += std::to_string(c.file_bytes);
  for (std::size_t i = 0; i < paper_nodes.size(); ++i)
    row += c.frames.empty() ? ",,"
                            : formatted(",%.3f,%.6f", median(c.frames[i].milliseconds), c.frames[i].rel_rmse);
  return row + "\n";
}

std::string percent(std::optional<double> share) { return share ? formatted("%.0f%%", 100 * *share) : "–"; }

std::string tree_cells(const PaperTable& table, const PaperTree& tree, const PaperCuts& c) {
  return formatted(" %.0f s | %.1f MB | %.0f | %.3f |", total_seconds(table, tree, c),
                   1e-6 * double(c.file_bytes), c.pieces, c.rms);
}

/// "12 / 15 / 21"
template <class Text>
std::string slashed(const std::vector<PaperFrame>& frames, const Text& text) {
  std::string all;
  for (const PaperFrame& f : frames) all += (all.empty() ? "" : " / ") + text(f);
  return all;
}

std::string markdown_row(const PaperTable& table, const SystemOptions& options, std::size_t way) {
  const auto &geometric = table.geometric.cuts[way], &driven = table.driven.cuts[way];
  const PaperGain saved = gain(geometric, driven);
  std::string row =
      "| " + options.common.scene.stem().string() + " | " + word_of(light_words, options.lights);
  row += formatted(" | %zuK | %zu | ", (table.counts.receivers + 500) / 1000, table.counts.lights) +
         word_of(cut_kind_words, paper_ways[way].cuts) + " |";
  row += tree_cells(table, table.geometric, geometric[0]) + tree_cells(table, table.driven, driven[0]);
  row += " " + percent(saved.equal_sigma) + " | " + percent(saved.equal_rms) + " | ";
  row += slashed(driven[0].frames,
                 [](const PaperFrame& f) { return formatted("%.0f", median(f.milliseconds)); });
  return row + " | " +
         slashed(driven[0].frames,
                 [](const PaperFrame& f) { return formatted("%.2f%%", 100 * f.rel_rmse); }) +
         " |\n";
}

nlohmann::json cuts_json(const PaperCuts& c, std::size_t way) {
  nlohmann::json j = {{"cuts", word_of(cut_kind_words, paper_ways[way].cuts)},
                      {"lobes", word_of(lobes_words, paper_ways[way].lobes)},
                      {"sigma", c.sigma},
                      {"pieces", c.pieces},
                      {"rms", c.rms},
                      {"seconds", c.seconds},
                      {"bytes", c.bytes}};
  if (c.frames.empty()) return j;
  j["file_bytes"] = c.file_bytes;
  for (const PaperFrame& f : c.frames)
    j["frames"].push_back(
        {{"nodes", f.nodes}, {"milliseconds", median(f.milliseconds)}, {"rel_rmse", f.rel_rmse}});
  return j;
}

nlohmann::json tree_json(const PaperTree& tree) {
  nlohmann::json j = {{"beta", tree.beta}, {"seconds", tree.seconds}};
  for (std::size_t way = 0; way < paper_ways.size(); ++way)
    for (const PaperCuts& c : tree.cuts[way]) j["cuts"].push_back(cuts_json(c, way));
  return j;
}

}  // namespace

PaperTable measure_paper_table(PaperScene& scene, float beta, int repeat) {
  PaperTable table{scene.counts(), scene.receiver_seconds(), scene.ray_seconds(), {}, {}};
  table.geometric = measure_tree(scene, 1, repeat);
  scene.drive_tree_by_data(beta);
  table.driven = measure_tree(scene, double(beta), repeat);
  return table;
}

PaperGain gain(std::span<const PaperCuts> geometric, std::span<const PaperCuts> driven) {
  const PaperCuts& cuts = driven[0];
  PaperGain result{1 - cuts.pieces / geometric[0].pieces, {}};
  if (const auto pieces = pieces_at(geometric, cuts.rms)) result.equal_rms = 1 - cuts.pieces / *pieces;
  return result;
}

std::string paper_csv(const PaperTable& table, const SystemOptions& options) {
  std::string text =
      "scene,environment,lights,triangles,points,receivers,light_count,beta,cuts,lobes,sigma,"
      "seconds_receivers,seconds_tree,seconds_rays,seconds_cuts,visibility_pieces,rms,bytes,file_bytes";
  for (const std::size_t nodes : paper_nodes) text += formatted(",ms_%zu,rel_rmse_%zu", nodes, nodes);
  text += "\n";
  const std::string lighting = csv_field(options.common.scene.string()) + "," +
                               csv_field(options.common.environment.string()) + "," +
                               word_of(light_words, options.lights) + ",";
  for (const PaperTree* tree : {&table.geometric, &table.driven})
    for (std::size_t way = 0; way < paper_ways.size(); ++way)
      for (const PaperCuts& c : tree->cuts[way]) text += lighting + csv_row(table, *tree, way, c);
  return text;
}

std::string paper_markdown(const PaperTable& table, const SystemOptions& options) {
  std::string text = "| scene | light | receivers | lights | cuts |";
  for (const PaperTree* tree : {&table.geometric, &table.driven})
    text += formatted(" β = %g: precomputation | storage | mean cut size | RMS |", tree->beta);
  text += " gain at equal σ | at equal RMS | ms a frame at 128 / 256 / 512 nodes | relRMSE |\n";
  text += "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (std::size_t way = 0; way < paper_ways.size(); ++way) text += markdown_row(table, options, way);
  return text;
}

nlohmann::json paper_json(const PaperTable& table) {
  return {{"triangles", table.counts.triangles},
          {"points", table.counts.points},
          {"receivers", table.counts.receivers},
          {"lights", table.counts.lights},
          {"seconds", {{"receivers", table.receiver_seconds}, {"rays", table.ray_seconds}}},
          {"geometric", tree_json(table.geometric)},
          {"data_driven", tree_json(table.driven)}};
}

}  // namespace coppice::program
