// Sweeps the knobs of relighting by cuts, measures time against error, and picks settings for a target.
#include <coppice/core/error.hpp>
#include <coppice/embree/threads.hpp>
#include <coppice/embree/tracer.hpp>
#include <coppice/exr/exposure.hpp>
#include <coppice/exr/write.hpp>
#include <coppice/exr/write_file.hpp>
#include <cstdio>
#include <support/measure.hpp>
#include <support/paper_table.hpp>
#include <support/pca_sweep.hpp>
#include <support/program.hpp>
#include <support/report.hpp>
#include <support/sg_sweep.hpp>
#include <support/text.hpp>
#include <support/trade_output.hpp>
#include <support/vpl_sweep.hpp>

namespace coppice::program {
namespace {

struct Options {
  CommonOptions common;
  CutOptions cut;
  KnobRanges ranges;
  std::vector<std::string> point_texts;
  std::filesystem::path images;
  int repeat = MeasureOptions{}.repeat;
  bool visibility_only = false;
  std::optional<double> target_error, target_milliseconds;
  bool paper_table = false;
  LightKind lights = LightKind::environment;
  std::size_t emitters = SystemOptions{}.emitters, bounces = SystemOptions{}.bounces;
};

void add_knob_options(CLI::App& app, Options& o) {
  app.add_option("--sigma", o.ranges.sigmas, "thresholds of the visibility cuts, separated by commas (1,2,3)")
      ->delimiter(',')
      ->check(finite_number)
      ->check(CLI::Range(0.0, max_sigma));
  app.add_option("--cut-size", o.ranges.sizes,
                 "sizes of the illumination cut, separated by commas (32,64,128)")
      ->delimiter(',')
      ->check(CLI::Range(std::size_t{1}, max_nodes));
  add_choices(app, "--cuts", o.ranges.cuts, cut_kind_words,
              "how lights count in visibility cuts, and how the cuts are chosen");
  add_choices(app, "--lobes", o.ranges.lobes, lobes_words, "how a BRDF meets a cluster of lights");
  app.add_option("--points", o.point_texts,
                 "SIGMA:SIZE[:CUTS[:LOBES]],... to measure instead of every combination")
      ->delimiter(',');
}

/// After those of sweeps, which it excludes.
void add_table_options(CLI::App& app, Options& o) {
  CLI::Option* table =
      app.add_flag("--paper-table", o.paper_table,
                   "instead of a sweep: --out gets the table of the Cuts paper (Fig. 9), for the geometric "
                   "tree and for that of --beta (0.5)");
  for (const char* knob : {"--sigma", "--cut-size", "--cuts", "--lobes", "--points", "--visibility-only",
                           "--target-error", "--target-ms", "--images"})
    table->excludes(app.get_option(knob));
  add_choice(app, "--lights", o.lights, light_words,
             "of the table: --env, the scene's own lights, or one bounce of these");
  app.add_option("--emitters", o.emitters, "of the table: lights at most on shining surfaces")
      ->check(CLI::Range(std::size_t{0}, std::size_t{1} << 22))
      ->capture_default_str();
  app.add_option("--bounces", o.bounces,
                 "of the table: lights at most on lit surfaces, for --lights indirect")
      ->check(CLI::Range(std::size_t{0}, std::size_t{1} << 22))
      ->capture_default_str();
  for (const char* option : {"--lights", "--emitters", "--bounces"}) app.get_option(option)->needs(table);
}

void add_options(CLI::App& app, Options& o) {
  add_common_options(app, o.common);
  app.get_option("--env")->required(false);
  app.add_option("--out", o.common.out,
                 "CSV file to write; an SVG plot of the same name goes beside that of a sweep")
      ->required();
  add_knob_options(app, o);
  app.add_flag("--visibility-only", o.visibility_only,
               "also measure the error of the visibility cuts alone, with all lights in the illumination cut "
               "(slow)");
  app.add_option("--target-error", o.target_error,
                 "name the fastest point of at most this relRMSE (0.01: 1%)")
      ->check(finite_number)
      ->check(CLI::NonNegativeNumber);
  app.add_option("--target-ms", o.target_milliseconds,
                 "name the most accurate point of at most so many milliseconds a frame")
      ->check(finite_number)
      ->check(CLI::NonNegativeNumber);
  app.add_option("--images", o.images,
                 "also write the image of each point and of the reference, as PREFIX_...exr and .png");
  app.add_option("--repeat", o.repeat, "repetitions; times are their medians")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  add_cut_options(app, o.cut);
  add_table_options(app, o);
}

std::filesystem::path plot_path(const Options& o) {
  return std::filesystem::path(o.common.out).replace_extension(".svg");
}

/// PREFIX_NAME.exr; empty where no images are asked for.
std::filesystem::path image_path(const Options& o, const std::string& name) {
  return o.images.empty() ? std::filesystem::path()
                          : std::filesystem::path(o.images.string() + "_" + name + ".exr");
}

std::vector<OperatingPoint> operating_points(const Options& o) {
  std::vector<OperatingPoint> points;
  for (const std::string& text : o.point_texts) points.push_back({parse_knobs(text)});
  if (!o.point_texts.empty()) return points;
  for (const Knobs& knobs : combinations(o.ranges)) points.push_back({knobs});
  return points;
}

void write_images(const Options& o, const Measurements& measured, const CutRelighting<>& relighting) {
  const Image& reference = measured.twins.reference;
  const float exposure = automatic_exposure(reference, relighting.direct().coverage);
  const auto write = [&](const std::string& suffix, const Image& image) {
    std::filesystem::path path = image_path(o, suffix);
    write_exr(path, image.width, image.height,
              {{"", image}, {"A", relighting.direct().coverage}, {"reference", reference}});
    write_png(path.replace_extension(".png"), image, exposure);
  };
  write("reference", reference);
  for (const auto& p : measured.points) write(file_suffix(p.knobs), p.image);
}

/// A point for each target that was named; none where no point reaches it.
struct Pick {
  std::string target, unreached;
  const OperatingPoint* point;
};

std::vector<Pick> pick(const Options& o, std::span<const OperatingPoint> points) {
  std::vector<Pick> picks;
  if (o.target_error)
    picks.push_back({formatted("relRMSE of at most %g%%", 100 * *o.target_error),
                     "add a smaller --sigma or a larger --cut-size", cheapest(points, *o.target_error)});
  if (o.target_milliseconds)
    picks.push_back({formatted("a frame of at most %g ms", *o.target_milliseconds),
                     "add a larger --sigma or a smaller --cut-size",
                     most_accurate(points, *o.target_milliseconds)});
  return picks;
}

void print_picks(const std::vector<Pick>& picks) {
  for (const Pick& p : picks)
    std::printf(
        "\n%s: %s\n", p.target.c_str(),
        p.point ? description(*p.point).c_str() : ("no point measured reaches it; " + p.unreached).c_str());
}

nlohmann::json report(const Options& o, const Measurements& measured, const std::vector<Pick>& picks,
                      const CutRelighting<>& relighting, const Scene& scene) {
  nlohmann::json j = {{"program", "trade"},
                      {"settings", settings_json(o.common, o.cut)},
                      {"preparation", preparation_json(relighting, scene)},
                      {"brute_force_milliseconds",
                       {{"plain", measured.twins.plain_milliseconds()},
                        {"skipping", measured.twins.skipping_milliseconds()}}}};
  for (const auto& p : measured.points) j["points"].push_back(point_json(p, relighting));
  for (const Pick& p : picks)
    j["picks"].push_back(
        {{"target", p.target}, {"point", p.point ? point_json(*p.point, relighting) : nlohmann::json()}});
  return j;
}

void sweep(const Options& o) {
  std::vector<OperatingPoint> points = operating_points(o);
  for (const auto& path : {o.common.out, plot_path(o), o.common.report, image_path(o, "reference")})
    if (!path.empty()) require_writable(path);
  const auto& kernels = kernels_of(o.cut);
  const Threads threads(o.common.threads);
  Inputs in = load_inputs(o.common);
  in.environment.rotation = glm::radians(o.common.rotate_environment);
  const EmbreeTracer tracer(in.scene);
  CutRelightingOptions settings = relighting_options(o.common, o.cut);
  settings.cuts = share_cuts(points, o.cut);
  settings.keep_bits = true;
  CutRelighting<> relighting(in.scene, tracer, in.camera, in.environment, settings, threads,
                             visibility_progress());
  relighting.use(kernels);
  const Measurements measured =
      measure(std::move(points), relighting, in.environment,
              {o.repeat, o.cut.lobe_tolerance, !o.images.empty(), o.visibility_only});
  const std::vector<Pick> picks = pick(o, measured.points);
  write_file(o.common.out, csv(measured, relighting, o.common));
  write_file(plot_path(o), plot(measured));
  if (!o.images.empty()) write_images(o, measured, relighting);
  std::fputs(table(measured, relighting).c_str(), stdout);
  print_picks(picks);
  if (!o.common.report.empty())
    write_report(o.common.report, report(o, measured, picks, relighting, in.scene));
}

SystemOptions system_options(const Options& o) {
  SystemOptions options;
  options.common = o.common;
  options.cut = o.cut;
  options.lights = o.lights;
  options.emitters = o.emitters, options.bounces = o.bounces;
  return options;
}

void write_paper_table(const Options& o) {
  for (const auto& path : {o.common.out, o.common.report})
    if (!path.empty()) require_writable(path);
  kernels_of(o.cut);
  const Threads threads(o.common.threads);
  Inputs in = load_inputs(o.common);
  in.environment.rotation = glm::radians(o.common.rotate_environment);
  const EmbreeTracer tracer(in.scene);
  const SystemOptions options = system_options(o);
  const float beta = o.cut.beta < 1 ? o.cut.beta : 0.5f;
  const PaperTable table =
      measure_paper_table(*make_paper_scene(options, in, tracer, threads), beta, o.repeat);
  write_file(o.common.out, paper_csv(table, options));
  std::fputs(paper_markdown(table, options).c_str(), stdout);
  if (!o.common.report.empty())
    write_report(o.common.report, {{"program", "trade"},
                                   {"settings", settings_json(o.common, o.cut)},
                                   {"paper_table", paper_json(table)},
                                   {"warnings", in.scene.warnings}});
}

void measure_as_asked(const Options& o) {
  if (o.lights == LightKind::environment && o.common.environment.empty())
    throw InputError("--env", "is required for an environment", "name an environment map");
  if (o.paper_table)
    write_paper_table(o);
  else
    sweep(o);
}

}  // namespace
}  // namespace coppice::program

int main(int argc, char** argv) {
  using namespace coppice::program;
  const std::string program = argc > 1 ? argv[1] : "";
  if (program == "glossy_vpls") return sweep_vpls(argc - 1, argv + 1);
  if (program == "sg_relighting") return sweep_gaussians(argc - 1, argv + 1);
  if (program == "pca_transfer") return sweep_pca(argc - 1, argv + 1);
  CLI::App app(
      "Measures time against error of relighting through cuts, over their knobs. `trade glossy_vpls` "
      "measures gathering from VPLs, `trade sg_relighting` spherical Gaussians, `trade pca_transfer` PCA "
      "bases "
      "of a room; they have a --help of their own.",
      "trade");
  Options options;
  add_options(app, options);
  return run(app, argc, argv, [&] { measure_as_asked(options); });
}
