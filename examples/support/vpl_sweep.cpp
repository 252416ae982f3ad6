#include <coppice/core/error.hpp>
#include <coppice/exr/write_file.hpp>
#include <cstdio>
#include <support/report.hpp>
#include <support/text.hpp>
#include <support/vpl_pixel_study.hpp>
#include <support/vpl_settings.hpp>
#include <support/vpl_surfaces.hpp>
#include <support/vpl_sweep.hpp>

namespace coppice::program {
namespace {

struct SweepOptions {
  VplSystemOptions base;
  std::vector<std::size_t> counts{16384};
  std::vector<int> bounces{1};
  std::vector<std::string> gather_texts{"bound:0.02", "bound:0.01", "bound:0.005", "angle:0.05",
                                        "angle:0.02"};
  std::vector<std::string> pixel_texts;
  std::size_t points = 4096;
  int repeat = 3;
};

/// A row of the table.
struct Row {
  std::size_t vpls = 0, shining = 0;
  int bounces = 1;
  GatherMeasurement gather{};
  BruteForce brute{};          // its radiance left empty
  std::string pixels{};        // of a whole image: which were gathered
  double share = 0, psnr = 0;  // of the covered pixels; against all of them gathered
};

/// The scene as its camera sees it; VPLs come later.
VplSubject seen_scene(Inputs& in, const VplSystemOptions& o, const EmbreeTracer& tracer,
                      const Threads& threads) {
  VplSubject s;
  s.scene = in.scene, s.camera = in.camera, s.raster = o.common.raster;
  for (const CameraHit& h : trace_camera(tracer, s.camera, s.raster, threads))
    if (emission_at(s.scene, h.hit) == vec3(0)) s.hits.push_back(h);
  s.points = glossy_points(s.scene, s.hits, ProgramSurfaces{s.scene, o.common.shading, o.exponents}, threads);
  return s;
}

void place_and_light(VplSubject& s, const VplSystemOptions& o, std::span<const LocalLight> lights,
                     std::size_t count, int bounces, const EmbreeTracer& tracer, const Threads& threads) {
  VplOptions placement = o.placement;
  placement.count = count, placement.seed = o.common.seed;
  const auto vpls = place_vpls(s.scene, lights, tracer, threads, placement);
  std::vector<VplLight> light(vpls.size());
  light_vpls(vpls, lights, tracer, threads, light);
  const ProgramSurfaces surfaces{s.scene, o.common.shading, o.exponents};
  const auto leaves_of = [&](std::span<const VplLight> l) { return vpl_leaves(vpls, l, surfaces, threads); };
  const BounceGather gather{bounces, 0.02f, o.is_traced, o.common.seed, {}};
  light = with_bounces(vpls, light, leaves_of, gather, tracer, threads);
  s.leaves = shining(leaves_of(light));
  s.placed = vpls.size();
}

class Sweep {
 public:
  Sweep(const SweepOptions& o, Inputs& in, const Threads& threads)
      : o_(o),
        threads_(threads),
        tracer_(in.scene),
        subject_(seen_scene(in, o.base, tracer_, threads)),
        lights_(primary_lights(o.base, in.scene, in.environment)) {
    const std::string file = o.base.common.scene.string();
    if (subject_.points.empty())
      throw InputError(file, "shows its camera no surface", "name a scene that is in view");
    if (lights_.empty()) throw InputError(file, "has no lights and no shining surfaces", "name an --env");
  }

  std::vector<Row> run() {
    for (const std::size_t count : o_.counts)
      for (const int bounces : o_.bounces) {
        place_and_light(subject_, o_.base, lights_, count, bounces, tracer_, threads_);
        all_.clear();
        std::fprintf(stderr, "%zu VPLs, %zu shine, %d bounce(s)\n", subject_.placed, subject_.leaves.size(),
                     bounces);
        measure_settings(bounces);
      }
    return std::move(rows_);
  }
  const VplSubject& subject() const { return subject_; }

 private:
  void measure_settings(int bounces) {
    const auto points = spread_points(subject_, o_.points);
    const BruteForce brute = sum_all(subject_, points, o_.repeat);
    std::vector<vec3> seen;
    for (const std::string& text : o_.gather_texts) {
      const GatherSetting setting = parse_gather(text);
      if (setting.traced && seen.empty()) seen = sum_all_traced(subject_, points, tracer_, threads_);
      const VplTree tree(subject_.leaves, setting.tree);
      Row row{.gather = measure_gather(subject_, tree, points, setting.traced ? seen : brute.radiance,
                                       setting, tracer_, o_.repeat)};
      add(std::move(row), brute, bounces);
      if (!setting.traced) measure_images(tree, setting, brute, bounces);
    }
  }

  void measure_images(const VplTree& tree, const GatherSetting& setting, const BruteForce& brute,
                      int bounces) {
    if (o_.pixel_texts.empty()) return;
    if (all_.empty()) sum_everywhere();
    std::vector<AdaptiveOptions> ways;
    for (const std::string& text : o_.pixel_texts)
      ways.push_back(parse_pixels(text, scene_size(subject_.scene.mesh)));
    const auto measured = measure_pixels(subject_, tree, setting, tracer_, ways, all_, o_.repeat);
    for (std::size_t i = 0; i < measured.size(); ++i)
      add({.gather = measured[i].gather,
           .pixels = o_.pixel_texts[i],
           .share = measured[i].share,
           .psnr = measured[i].psnr},
          brute, bounces);
  }

  void sum_everywhere() {
    std::vector<std::uint32_t> ids(subject_.leaves.size());
    std::iota(ids.begin(), ids.end(), 0u);
    VplArrays arrays;
    arrays.assign(subject_.leaves, ids);
    all_.assign(subject_.points.size(), vec3(0));
    threads_(all_.size(), 256, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        all_[i] = reflect_nodes<VplKind::single>(arrays, subject_.points[i]);
    });
  }

  void add(Row row, const BruteForce& brute, int bounces) {
    row.vpls = subject_.placed, row.shining = subject_.leaves.size(), row.bounces = bounces;
    row.brute.microseconds = brute.microseconds, row.brute.microseconds_all = brute.microseconds_all;
    rows_.push_back(std::move(row));
  }

  const SweepOptions& o_;
  const Threads& threads_;
  EmbreeTracer tracer_;
  VplSubject subject_;
  std::vector<LocalLight> lights_;
  std::vector<Row> rows_;
  std::vector<vec3> all_;  ///< at every point, of all VPLs; empty until it is asked for
};

std::string csv(std::span<const Row> rows, const SweepOptions& o) {
  std::string text =
      "scene,vpls,shining,bounces,gather,pixels,nodes_min,nodes_mean,nodes_max,tests,rel_rmse,mre,p95,bias,"
      "microseconds,times_brute_shining,times_brute_all,pixel_share,psnr_db\n";
  for (const Row& r : rows) {
    const GatherMeasurement& g = r.gather;
    text += formatted("%s,%zu,%zu,%d,%s,%s,%zu,%.1f,%zu,%.1f,%.6f,%.6f,%.6f,%.6f,%.4f,%.2f,%.2f,%.4f,%.2f\n",
                      o.base.common.scene.filename().c_str(), r.vpls, r.shining, r.bounces,
                      g.setting.name.c_str(), r.pixels.c_str(), g.least, g.mean, g.most, g.tests,
                      g.errors.rel_rmse, g.errors.mre, g.errors.p95, g.bias, g.microseconds,
                      r.brute.microseconds / g.microseconds, r.brute.microseconds_all / g.microseconds,
                      r.share, r.psnr);
  }
  return text;
}

std::string table(std::span<const Row> rows) {
  std::string text =
      "| VPLs (shining), bounces | gathered | nodes min / mean / max | relRMSE | mre | p95 | bias | µs a "
      "point | × shining | × "
      "all | pixels | PSNR |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const Row& r : rows) {
    const GatherMeasurement& g = r.gather;
    text += formatted(
        "| %zu (%zu), %d | %s | %zu / %.0f / %zu | %.2f%% | %.2f%% | %.2f%% | %.2f%% | %.2f | %.1f | %.1f | ",
        r.vpls, r.shining, r.bounces, g.setting.name.c_str(), g.least, g.mean, g.most,
        100 * g.errors.rel_rmse, 100 * g.errors.mre, 100 * g.errors.p95, 100 * g.bias, g.microseconds,
        r.brute.microseconds / g.microseconds, r.brute.microseconds_all / g.microseconds);
    text += r.pixels.empty() ? std::string(" | |\n")
                             : formatted("%s: %.1f%% | %.1f dB |\n", r.pixels.c_str(), 100 * r.share, r.psnr);
  }
  return text;
}

nlohmann::json row_json(const Row& r) {
  const GatherMeasurement& g = r.gather;
  nlohmann::json j = {{"vpls", r.vpls},
                      {"shining", r.shining},
                      {"bounces", r.bounces},
                      {"gather", g.setting.name},
                      {"nodes", summary_json({g.least, g.most, g.mean})},
                      {"tests", g.tests},
                      {"errors", errors_json(g.errors)},
                      {"bias", g.bias},
                      {"microseconds", g.microseconds},
                      {"microseconds_brute_shining", r.brute.microseconds},
                      {"microseconds_brute_all", r.brute.microseconds_all}};
  if (!r.pixels.empty()) j["pixels"] = {{"chosen", r.pixels}, {"share", r.share}, {"psnr_db", r.psnr}};
  return j;
}

nlohmann::json sweep_json(std::span<const Row> rows, const SweepOptions& o, const Scene& scene) {
  nlohmann::json settings = settings_json(o.base);
  for (const char* single : {"criterion", "threshold", "clustering", "filter", "ray_choice", "adaptive",
                             "backend", "frames", "animate"})
    settings.erase(single);
  settings["vpls"] = o.counts, settings["bounces"] = o.bounces, settings["gather"] = o.gather_texts;
  settings["pixels"] = o.pixel_texts, settings["points"] = o.points, settings["repeat"] = o.repeat;
  nlohmann::json j = {{"program", "trade glossy_vpls"}, {"settings", settings}, {"warnings", scene.warnings}};
  for (const Row& r : rows) j["rows"].push_back(row_json(r));
  return j;
}

void add_options(CLI::App& app, SweepOptions& o) {
  add_vpl_options(app, o.base);
  for (const char* single : {"--vpls", "--bounces", "--criterion", "--threshold", "--clustering", "--filter",
                             "--min-max", "--ray-choice", "--adaptive", "--epsilon", "--backend"})
    if (app.get_option_no_throw(single)) app.remove_option(app.get_option(single));
  app.add_option("--out", o.base.common.out, "CSV file to write")->required();
  app.add_option("--vpls", o.counts, "numbers of VPLs, separated by commas")
      ->delimiter(',')
      ->check(CLI::Range(1, 1 << 22))
      ->capture_default_str();
  app.add_option("--bounces", o.bounces, "numbers of bounces, separated by commas")
      ->delimiter(',')
      ->check(CLI::Range(1, 3))
      ->capture_default_str();
  app.add_option(
         "--gather", o.gather_texts,
         "ways to gather, separated by commas: bound:τ, angle:STERADIANS, min-max:MIN:MAX:STERADIANS, "
         "traced:τ, energy:τ; each with :kd or :lengths (clustering) or :uniform (filter) behind it")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option(
         "--pixels", o.pixel_texts,
         "also measure images of which only some pixels are gathered: relative:ε, paper:ε, uniform:4, ...")
      ->delimiter(',');
  app.add_option("--points", o.points, "points at which ways to gather are compared, about")
      ->check(CLI::Range(std::size_t{16}, std::size_t{1} << 24))
      ->capture_default_str();
  app.add_option("--repeat", o.repeat, "repetitions; times are their medians")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
}

void run_sweep(const SweepOptions& o) {
  check_combinations(o.base);
  for (const std::string& text : o.gather_texts) parse_gather(text);
  for (const std::string& text : o.pixel_texts) parse_pixels(text, 1);
  for (const auto& path : {o.base.common.out, o.base.common.report})
    if (!path.empty()) require_writable(path);
  const Threads threads(o.base.common.threads);
  Inputs in = load_inputs(o.base.common);
  in.environment.rotation = glm::radians(o.base.common.rotate_environment);
  Sweep sweep(o, in, threads);
  const std::vector<Row> rows = sweep.run();
  write_file(o.base.common.out, csv(rows, o));
  std::printf("%zu pixels covered; times of one thread, over %zu points\n\n%s", sweep.subject().points.size(),
              spread_points(sweep.subject(), o.points).size(), table(rows).c_str());
  if (!o.base.common.report.empty()) write_report(o.base.common.report, sweep_json(rows, o, in.scene));
}

}  // namespace

int sweep_vpls(int argc, char** argv) {
  CLI::App app("Measures nodes, time and error of gathering the light of VPLs, over its knobs.",
               "trade glossy_vpls");
  SweepOptions options;
  add_options(app, options);
  return run(app, argc, argv, [&] { run_sweep(options); });
}

}  // namespace coppice::program
