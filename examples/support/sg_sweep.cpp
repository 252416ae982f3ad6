#include <algorithm>
#include <coppice/core/error.hpp>
#include <coppice/exr/write_file.hpp>
#include <cstdio>
#include <map>
#include <support/report.hpp>
#include <support/sg_sweep.hpp>
#include <support/sg_system.hpp>
#include <support/text.hpp>

namespace coppice::program {
namespace {

struct SweepOptions {
  SgSystemOptions base;
  std::vector<std::string> materials{"file"};
  std::vector<std::string> settings{"cut:7:voxels", "cut:19:voxels", "cut:7:rays",
                                    "cut:19:rays",  "packed:7:rays", "packed:19:rays"};
  int repeat = 1;
};

struct Row {
  std::string material, setting;
  double cones = 0, clusters = 0;
  std::map<std::string, double> milliseconds{};  ///< by stage: medians
  ImageErrors errors{};
};

[[noreturn]] void refuse(const std::string& text) {
  throw InputError("--settings", "'" + text + "' is no way to relight",
                   "write PLACEMENT:CONES:VISIBILITY, as in cut:7:voxels");
}

std::uint32_t number(const std::string& setting, const std::string& text, unsigned long most) {
  if (text.empty() || text.size() > 6 || text.find_first_not_of("0123456789") != std::string::npos)
    refuse(setting);
  const unsigned long value = std::stoul(text);
  if (value > most) refuse(setting);
  return std::uint32_t(value);
}

/// A word behind the first three: KEY=NUMBER, or the name of a choice.
void apply(const std::string& setting, const std::string& word, SgSystemOptions& o) {
  const std::size_t equals = word.find('=');
  const std::string key = word.substr(0, equals);
  const auto value = [&](unsigned long most) { return number(setting, word.substr(equals + 1), most); };
  if (equals == std::string::npos) {
    if (word == "lights")
      o.weights = ConeWeights::lights;
    else if (word == "warped")
      o.lobes = LobeFit::warped;
    else if (word == "pyramid")
      o.scheme = FitScheme::pyramid;
    else
      refuse(setting);
  } else if (key == "peaks") {
    o.sky.peaks.most = value(256);
  } else if (key == "voxels") {
    o.voxels = value(2048);
  } else if (key == "contact") {
    o.march.contact = float(value(64));
  } else if (key == "rays") {
    o.rays = value(65536);
  } else if (key == "march") {
    o.march.trace.rays = std::clamp(value(64), 1u, 64u);
  } else if (key == "cut") {
    o.sky.pieces = std::max(1u, value(65536));
  } else {
    refuse(setting);
  }
}

SgSystemOptions options_of(const SgSystemOptions& base, const std::string& setting) {
  SgSystemOptions o = base;
  const std::vector<std::string> parts = split_at_colons(setting);
  if (parts.size() < 3) refuse(setting);
  const auto placement = choice_of(placement_words, parts[0]);
  const auto visibility = choice_of(cone_visibility_words, parts[2]);
  if (!placement || !visibility) refuse(setting);
  o.placement = *placement, o.visibility = *visibility;
  o.cones.cones = std::max(1u, number(setting, parts[1], 64));
  for (std::size_t i = 3; i < parts.size(); ++i) apply(setting, parts[i], o);
  check_combinations(o);
  return o;
}

class Sweep {
 public:
  Sweep(const SweepOptions& o, Inputs& in, const Threads& threads) : o_(o), in_(in), threads_(threads) {}

  std::vector<Row> run() {
    std::vector<Row> rows;
    for (const std::string& material : o_.materials) {
      SgSystemOptions base = o_.base;
      if (material != "file") base.material = parse_material(material);
      const auto exact = make_sg_system(options_of(base, "cut:1:rays"), in_, threads_);
      const RenderedFrame frame = exact->render(0);
      nlohmann::json ignored;
      const Image reference = exact->reference(ignored);
      for (const std::string& setting : o_.settings) {
        rows.push_back(measure(options_of(base, setting), setting, reference));
        rows.back().material = material;
        std::fprintf(stderr, "%s %s: relRMSE %.2f%%\n", material.c_str(), setting.c_str(),
                     100 * rows.back().errors.rel_rmse);
      }
    }
    return rows;
  }

 private:
  Row measure(const SgSystemOptions& options, const std::string& setting, const Image& reference) {
    const auto system = make_sg_system(options, in_, threads_);
    Row row{.material = {}, .setting = setting};
    std::map<std::string, std::vector<double>> times;
    for (int i = 0; i < o_.repeat; ++i) {
      const RenderedFrame frame = system->render(0);
      for (const auto& [stage, ms] : frame.report["stages"].items()) times[stage].push_back(ms);
      times["frame"].push_back(frame.report["milliseconds"]);
      row.cones = frame.report["cones"]["mean"], row.clusters = frame.report["clusters"];
      row.errors = compare(frame.image, reference, counted_pixels(frame.direct), 1);
    }
    for (const auto& [stage, all] : times) row.milliseconds[stage] = median(all);
    return row;
  }

  const SweepOptions& o_;
  Inputs& in_;
  const Threads& threads_;
};

double time_of(const Row& r, const std::string& stage) {
  const auto found = r.milliseconds.find(stage);
  return found == r.milliseconds.end() ? 0 : found->second;
}

std::string csv(std::span<const Row> rows, const SweepOptions& o) {
  std::string text =
      "scene,environment,material,setting,cones,clusters,rel_rmse,mre,p95,p99,light_ms,placement_ms,"
      "visibility_ms,frame_ms\n";
  for (const Row& r : rows)
    text += formatted("%s,%s,%s,%s,%.2f,%.1f,%.6g,%.6g,%.6g,%.6g,%.4g,%.4g,%.4g,%.4g\n",
                      o.base.common.scene.c_str(), o.base.common.environment.c_str(), r.material.c_str(),
                      r.setting.c_str(), r.cones, r.clusters, r.errors.rel_rmse, r.errors.mre, r.errors.p95,
                      r.errors.p99, time_of(r, "environment"), time_of(r, "placement"),
                      time_of(r, "visibility"), time_of(r, "frame"));
  return text;
}

std::string table(std::span<const Row> rows) {
  std::string text =
      "| Material | Setting | Cones a point | relRMSE | mre | p95 | light ms | placement ms | visibility ms "
      "| "
      "frame ms |\n|---|---|---|---|---|---|---|---|---|---|\n";
  for (const Row& r : rows)
    text += formatted("| %s | %s | %.1f | %.2f%% | %.2f%% | %.2f%% | %.0f | %.0f | %.0f | %.0f |\n",
                      r.material.c_str(), r.setting.c_str(), r.cones, 100 * r.errors.rel_rmse,
                      100 * r.errors.mre, 100 * r.errors.p95, time_of(r, "environment"),
                      time_of(r, "placement"), time_of(r, "visibility"), time_of(r, "frame"));
  return text;
}

nlohmann::json sweep_json(std::span<const Row> rows, const SweepOptions& o, const Scene& scene) {
  nlohmann::json j = {
      {"program", "trade sg_relighting"}, {"settings", settings_json(o.base)}, {"warnings", scene.warnings}};
  for (const Row& r : rows)
    j["rows"].push_back({{"material", r.material},
                         {"setting", r.setting},
                         {"cones", r.cones},
                         {"clusters", r.clusters},
                         {"milliseconds", r.milliseconds},
                         {"errors", errors_json(r.errors)}});
  return j;
}

void add_options(CLI::App& app, SweepOptions& o) {
  add_sg_options(app, o.base);
  for (const char* single :
       {"--placement", "--cones", "--visibility", "--material", "--env-to", "--roughness-to"})
    app.remove_option(app.get_option(single));
  app.add_option("--out", o.base.common.out, "CSV file to write")->required();
  app.add_option("--materials", o.materials,
                 "file (those of the scene), lambert, phong:EXPONENT, ggx:ALPHA, separated by commas")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--settings", o.settings,
                 "ways to relight, separated by commas: PLACEMENT:CONES:VISIBILITY, and behind it :lights "
                 "(weights), :warped (lobes), :pyramid (fit), :peaks=N, :voxels=N, :contact=N, :rays=N, "
                 ":march=N (rays through voxels), :cut=N")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--repeat", o.repeat, "repetitions; times are their medians")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
}

void run_sweep(const SweepOptions& o) {
  for (const std::string& setting : o.settings) options_of(o.base, setting);
  for (const std::string& material : o.materials)
    if (material != "file") parse_material(material);
  for (const auto& path : {o.base.common.out, o.base.common.report})
    if (!path.empty()) require_writable(path);
  const Threads threads(o.base.common.threads);
  Inputs in = load_inputs(o.base.common);
  const std::vector<Row> rows = Sweep(o, in, threads).run();
  write_file(o.base.common.out, csv(rows, o));
  std::fputs(table(rows).c_str(), stdout);
  if (!o.base.common.report.empty()) write_report(o.base.common.report, sweep_json(rows, o, in.scene));
}

}  // namespace

int sweep_gaussians(int argc, char** argv) {
  CLI::App app("Measures cones, time and error of relighting by spherical Gaussians, over its knobs.",
               "trade sg_relighting");
  SweepOptions options;
  add_options(app, options);
  return run(app, argc, argv, [&] { run_sweep(options); });
}

}  // namespace coppice::program
