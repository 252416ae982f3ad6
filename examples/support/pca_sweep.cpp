#include <support/pca_sweep.hpp>
//
#include <algorithm>
#include <coppice/core/error.hpp>
#include <coppice/exr/write_file.hpp>
#include <cstdio>
#include <limits>
#include <support/pca_pictures.hpp>
#include <support/pca_study.hpp>
#include <support/plot.hpp>
#include <support/report.hpp>
#include <support/text.hpp>

namespace coppice::program {
namespace {

using nlohmann::json;

struct SweepOptions {
  PcaStudyOptions study;
  std::vector<std::size_t> samples{12000}, clusters{32};
  std::vector<std::string> visibility{
      "lattice:20",     "lattice:40", "lattice:40:bits=16", "lattice:40:points=4000", "depth:50",
      "depth:50:plain", "rays"};
  std::vector<std::string> transfer{
      "transport:20", "transport:10", "transport:20:patterns=30", "transport:20:bits=16", "uncentred:20",
      "uncentred:10", "paper:10",     "paper:10:no-mean"};

  SweepOptions() { study.base.common.raster.width = 320, study.base.common.raster.height = 180; }
};

const Words<StudyKind> kind_words{
    {"visibility", StudyKind::visibility}, {"transfer", StudyKind::transfer}, {"frame", StudyKind::frame}};

/// A cell of the CSV; empty where there is nothing.
std::string cell(const std::optional<double>& value) {
  return value ? formatted(",%.6g", *value) : std::string(",");
}

std::string cells(const std::optional<MeanErrors>& e) {
  return e ? formatted(",%.6g,%.6g", e->rel_rmse, e->mre) : std::string(",,");
}

std::optional<double> time_of(const StudyRow& r, const std::string& stage) {
  const auto found = r.milliseconds.find(stage);
  return found == r.milliseconds.end() ? std::nullopt : std::optional(found->second);
}

std::string csv(const StudyResult& result, const SweepOptions& o) {
  std::string text =
      "scene,samples,clusters,kind,setting,bytes,seconds,wrong,wrong_weighted,direct_rel_rmse,direct_mre,"
      "indirect_rel_rmse,indirect_mre,whole_rel_rmse,whole_mre,visibility_ms,projection_ms,transfer_ms,"
      "expansion_ms\n";
  for (const StudyRow& r : result.rows) {
    text += formatted("%s,%zu,%zu,%s,%s,%zu,%.4g", o.study.base.common.scene.c_str(), r.samples, r.clusters,
                      word_of(kind_words, r.kind).c_str(), r.setting.c_str(), r.bytes, r.seconds);
    text += r.decisions ? formatted(",%.6g,%.6g", r.decisions->plain, r.decisions->weighted) : ",,";
    text += cells(r.direct) + cells(r.indirect) + cells(r.whole);
    for (const char* stage : {"visibility", "projection", "transfer", "expansion"})
      text += cell(time_of(r, stage));
    text += "\n";
  }
  return text;
}

double megabytes(const StudyRow& r) { return 1e-6 * double(r.bytes); }

std::string visibility_line(const StudyRow& r) {
  return formatted("| %s | %.2f | %.1f | %.2f%% | %.2f%% | %.2f%% | %.2f%% | %.2f |\n", r.setting.c_str(),
                   megabytes(r), r.seconds, 100 * r.decisions->plain, 100 * r.decisions->weighted,
                   100 * r.direct->rel_rmse, 100 * r.direct->mre, time_of(r, "visibility").value_or(0));
}

std::string transfer_line(const StudyRow& r) {
  return formatted("| %s | %.2f | %.1f | %.2f%% | %.2f%% | %.2f | %.2f | %.2f |\n", r.setting.c_str(),
                   megabytes(r), r.seconds, 100 * r.indirect->rel_rmse, 100 * r.indirect->mre,
                   time_of(r, "projection").value_or(0), time_of(r, "transfer").value_or(0),
                   time_of(r, "expansion").value_or(0));
}

std::string frame_line(const StudyRow& r) {
  return formatted("| %s | %.2f | %.2f%% | %.2f%% | %.2f%% | %.2f%% | %.2f%% | %.2f%% |\n", r.setting.c_str(),
                   megabytes(r), 100 * r.direct->rel_rmse, 100 * r.direct->mre, 100 * r.indirect->rel_rmse,
                   100 * r.indirect->mre, 100 * r.whole->rel_rmse, 100 * r.whole->mre);
}

struct TableOf {
  StudyKind kind;
  const char* head;
  std::string (*line)(const StudyRow&);
};

const TableOf tables[] = {
    {StudyKind::visibility,
     "| Visibility | MB | s | wrong | weighted | direct relRMSE | direct mre | ms a light |\n",
     visibility_line},
    {StudyKind::transfer,
     "| Transfer | MB | s | indirect relRMSE | indirect mre | projection ms | transfer ms | expansion ms |\n",
     transfer_line},
    {StudyKind::frame,
     "| Frames | MB | direct relRMSE | direct mre | indirect relRMSE | indirect mre | whole relRMSE | whole "
     "mre |\n",
     frame_line}};

std::string room_line(const StudyRoom& room) {
  std::string text =
      formatted("%zu samples %.3g m apart, %zu clusters, transport of %.0f MB; seconds:", room.samples,
                double(room.spacing), room.clusters, 1e-6 * double(room.transport_bytes));
  for (const auto& [stage, s] : room.seconds.items())
    text += formatted(" %s %.1f,", stage.c_str(), s.get<double>());
  text.back() = '\n';
  return text;
}

std::string markdown(const StudyResult& result) {
  std::string text;
  for (const StudyRoom& room : result.rooms) {
    text += (text.empty() ? "" : "\n") + room_line(room);
    for (const TableOf& table : tables) {
      std::string lines;
      for (const StudyRow& r : result.rows)
        if (r.kind == table.kind && r.samples == room.samples && r.clusters == room.clusters)
          lines += table.line(r);
      if (!lines.empty())
        text += std::string("\n") + table.head + "|---|---|---|---|---|---|---|---|\n" + lines;
    }
  }
  return text;
}

/// The points that no other beats in both error and bytes, in order of error.
std::vector<std::pair<double, double>> best_of(std::vector<std::pair<double, double>> points) {
  std::ranges::sort(points);
  std::vector<std::pair<double, double>> best;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& p : points)
    if (p.second < least) best.push_back(p), least = p.second;
  return best;
}

/// A line a kind of visibility (wrong decisions) and a basis (relRMSE of indirect light).
std::string plot(const StudyResult& result) {
  std::vector<PlotLine> lines;
  for (const StudyRow& r : result.rows) {
    if (r.kind == StudyKind::frame || r.bytes == 0) continue;
    const bool is_visibility = r.kind == StudyKind::visibility;
    const std::string word = r.setting.substr(0, r.setting.find(':'));
    const std::string name = word + (is_visibility ? ": wrong decisions" : ": indirect relRMSE");
    auto line = std::ranges::find(lines, name, &PlotLine::name);
    if (line == lines.end()) line = lines.insert(lines.end(), {name, {}});
    const double error = is_visibility ? r.decisions->plain : r.indirect->rel_rmse;
    line->points.push_back({std::max(100 * error, 1e-4), megabytes(r)});
  }
  for (PlotLine& line : lines) line.points = best_of(std::move(line.points));
  return plot_cost_against_error("Bytes against error on unseen lights", {"error, %", "MB"}, lines, {});
}

json errors_json(const MeanErrors& e) { return {{"rel_rmse", e.rel_rmse}, {"mre", e.mre}}; }

json row_json(const StudyRow& r) {
  json j = {{"kind", word_of(kind_words, r.kind)},
            {"samples", r.samples},
            {"clusters", r.clusters},
            {"setting", r.setting},
            {"bytes", r.bytes},
            {"seconds", r.seconds},
            {"milliseconds", r.milliseconds}};
  if (r.decisions)
    j["wrong_decisions"] = {
        {"plain", r.decisions->plain}, {"weighted", r.decisions->weighted}, {"pairs", r.decisions->pairs}};
  for (const auto& [name, errors] :
       {std::pair("direct", r.direct), std::pair("indirect", r.indirect), std::pair("whole", r.whole)})
    if (errors) j[name] = errors_json(*errors);
  return j;
}

json sweep_json(const StudyResult& result, const SweepOptions& o, const Scene& scene) {
  json settings = settings_json(o.study.base);
  settings["unseen"] = o.study.unseen, settings["frame_lights"] = o.study.frame_lights;
  settings["visibility"] = o.visibility, settings["basis"] = o.transfer;
  settings["surface_samples"] = o.samples, settings["clusters"] = o.clusters;
  settings["light_size"] = o.study.base.light_size;
  for (const char* swept : {"backend", "frames", "lights", "transfer_rank", "transfer_bits",
                            "visibility_rank", "visibility_bits"})
    settings.erase(swept);
  json j = {{"program", "trade pca_transfer"}, {"settings", settings}, {"warnings", scene.warnings}};
  for (const StudyRoom& r : result.rooms)
    j["rooms"].push_back({{"samples", r.samples},
                          {"clusters", r.clusters},
                          {"spacing", r.spacing},
                          {"transport_bytes", r.transport_bytes},
                          {"seconds", r.seconds}});
  for (const StudyRow& r : result.rows) j["rows"].push_back(row_json(r));
  return j;
}

/// Options of one room that a sweep has lists of, or none.
void remove_single(CLI::App& app) {
  for (const char* single :
       {"--path", "--through", "--lights", "--intensity", "--emitters", "--light-size", "--surface-samples",
        "--clusters", "--visibility", "--visibility-rank", "--visibility-bits", "--dome", "--shadow",
        "--intervals", "--basis", "--transfer-rank", "--transfer-bits", "--store", "--backend"})
    if (app.get_option_no_throw(single)) app.remove_option(app.get_option(single));
}

void add_lists(CLI::App& app, SweepOptions& o) {
  app.add_option("--surface-samples", o.samples, "numbers of samples, separated by commas")
      ->delimiter(',')
      ->check(CLI::Range(std::size_t{1}, std::size_t{1} << 22))
      ->capture_default_str();
  app.add_option("--clusters", o.clusters, "numbers of clusters, separated by commas")
      ->delimiter(',')
      ->check(CLI::Range(std::size_t{1}, std::size_t{4096}))
      ->capture_default_str();
  app.add_option("--visibility", o.visibility,
                 "ways to know shadows, separated by commas: lattice:RANK, depth:RANK, rays; behind it "
                 ":points=N, :training=N, :smooth (lattice), :plain, :sphere, :directions=N, :intervals=N "
                 "(depth), :bits=16; none for no such rows")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--basis", o.transfer,
                 "ways to transfer light, separated by commas: transport:RANK, uncentred:RANK, paper:RANK; "
                 "behind it :patterns=N, :bits=16, :sparse=SHARE (of the matrix that is kept, in place of "
                 "patterns), :no-mean (paper); none for no such rows")
      ->delimiter(',')
      ->capture_default_str();
}

void add_options(CLI::App& app, SweepOptions& o) {
  PcaStudyOptions& s = o.study;
  add_pca_options(app, s.base);
  remove_single(app);
  app.get_option("--size")->description("of the frames that are judged: 320x180 if not given");
  app.add_option("--out", s.base.common.out, "CSV file to write; an SVG plot of the same name goes beside it")
      ->required();
  add_lists(app, o);
  app.add_option("--unseen", s.unseen, "lights that judge, anywhere in the free space")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  app.add_option("--frame-lights", s.frame_lights,
                 "the first of them, by which whole frames are judged; 0 for no frames")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  app.add_option("--light-size", s.base.light_size, "metres: radius of the lights that judge")
      ->check(finite_number)
      ->check(CLI::Range(0.0f, 1e6f))
      ->capture_default_str();
  app.add_option("--pictures", s.pictures,
                 "folder for clusters.png and basis_vectors.png, of the first room and basis");
}

std::filesystem::path plot_path(const SweepOptions& o) {
  return std::filesystem::path(o.study.base.common.out).replace_extension(".svg");
}

/// Throws where anything could not be written.
void require_all_writable(const SweepOptions& o) {
  for (const auto& path : {o.study.base.common.out, plot_path(o), o.study.base.common.report})
    if (!path.empty()) require_writable(path);
  if (o.study.pictures.empty()) return;
  if (o.study.transfer.empty())
    throw InputError("--pictures", "shows vectors of the first of --basis, which is none", "name a basis");
  for (const auto& path : pca_picture_paths(o.study.pictures)) require_writable(path);
}

void parse_settings(SweepOptions& o) {
  if (o.visibility != std::vector<std::string>{"none"})
    for (const std::string& text : o.visibility)
      o.study.visibility.push_back(parse_visibility(text, room_options(o.study.base).shadows));
  if (o.transfer != std::vector<std::string>{"none"})
    for (const std::string& text : o.transfer)
      o.study.transfer.push_back(parse_transfer(text, room_options(o.study.base).transfer));
}

void run_sweep(SweepOptions& o) {
  check_combinations(o.study.base);
  parse_settings(o);
  require_all_writable(o);
  const Threads threads(o.study.base.common.threads);
  const Inputs in = load_inputs(o.study.base.common);
  PcaStudy study(o.study, in, threads);
  for (const std::size_t samples : o.samples)
    for (const std::size_t clusters : o.clusters) {
      study.add_room(samples, clusters);
      std::fprintf(stderr, "%zu samples in %zu clusters: measured\n", samples, clusters);
    }
  write_file(o.study.base.common.out, csv(study.result(), o));
  write_file(plot_path(o), plot(study.result()));
  std::fputs(markdown(study.result()).c_str(), stdout);
  if (!o.study.base.common.report.empty())
    write_report(o.study.base.common.report, sweep_json(study.result(), o, in.scene));
}

}  // namespace

int sweep_pca(int argc, char** argv) {
  CLI::App app(
      "Measures bytes, time and error of the shadows and the indirect light of PCA bases, on lights that "
      "they were not made for.",
      "trade pca_transfer");
  SweepOptions options;
  add_options(app, options);
  return run(app, argc, argv, [&] { run_sweep(options); });
}

}  // namespace coppice::program
