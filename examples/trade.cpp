// Sweeps the threshold of the visibility cuts and the size of the illumination cut, and measures time against
// error.
#include <algorithm>
#include <coppice/core/error.hpp>
#include <coppice/embree/threads.hpp>
#include <coppice/embree/tracer.hpp>
#include <coppice/exr/exposure.hpp>
#include <coppice/exr/write.hpp>
#include <coppice/exr/write_file.hpp>
#include <cstdio>
#include <numeric>
#include <set>
#include <support/plot.hpp>
#include <support/program.hpp>
#include <support/report.hpp>

namespace coppice::program {
namespace {

struct Options {
  CommonOptions common;
  CutOptions cut;
  std::vector<double> sigmas{1, 2, 3};
  std::vector<std::size_t> sizes{128, 256, 512};
  std::vector<std::string> point_texts;
  std::filesystem::path images;
  int repeat = 3;
};

/// A setting of both knobs, and what it gave.
struct OperatingPoint {
  double sigma = 0;
  std::size_t nodes = 0, which = 0;       ///< which: index into the sets of visibility cuts
  std::size_t pieces = 0;                 ///< of the illumination cut
  double clusters = 0;                    ///< mean a shading point
  std::vector<double> lighting, shading;  ///< milliseconds, a repetition each
  std::vector<vec3> radiance;
  ImageErrors errors;

  double milliseconds() const { return median(lighting) + median(shading); }
};

/// Both brute-force twins: milliseconds, a repetition each.
struct Twins {
  std::vector<double> plain, skipping;
  std::vector<vec3> radiance;
};

void add_options(CLI::App& app, Options& o) {
  add_common_options(app, o.common);
  app.add_option("--out", o.common.out, "CSV file to write; an SVG plot of the same name goes beside it")
      ->required();
  app.add_option("--sigma", o.sigmas, "thresholds of the visibility cuts, separated by commas")
      ->delimiter(',')
      ->check(finite_number)
      ->check(CLI::Range(0.0, 1000.0));
  app.add_option("--cut-size", o.sizes, "sizes of the illumination cut, separated by commas")
      ->delimiter(',')
      ->check(CLI::Range(std::size_t{1}, std::size_t{1} << 20));
  app.add_option("--points", o.point_texts, "SIGMA:SIZE,... to measure instead of every pair of the two")
      ->delimiter(',');
  app.add_option("--images", o.images,
                 "also write the image of each point and of the reference, as PREFIX_...exr and .png");
  app.add_option("--repeat", o.repeat, "repetitions; times are their medians")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  add_cut_options(app, o.cut);
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
  const auto add = [&](double sigma, std::size_t nodes) {
    OperatingPoint p;
    p.sigma = sigma, p.nodes = nodes;
    points.push_back(p);
  };
  for (const std::string& text : o.point_texts) {
    double sigma = 0;
    unsigned nodes = 0;
    int end = 0;
    if (std::sscanf(text.c_str(), "%lf:%u%n", &sigma, &nodes, &end) != 2 || std::size_t(end) != text.size() ||
        !(sigma >= 0 && sigma <= 1000) || nodes < 1)
      throw InputError("--points " + text, "is not SIGMA:SIZE", "write for example 2:256");
    add(sigma, nodes);
  }
  for (const double sigma : o.sigmas)
    for (const std::size_t nodes : o.sizes)
      if (o.point_texts.empty()) add(sigma, nodes);
  return points;
}

/// The thresholds that occur, and each point's index among them.
std::vector<double> distinct_sigmas(std::vector<OperatingPoint>& points) {
  std::set<double> set;
  for (const auto& p : points) set.insert(p.sigma);
  const std::vector<double> sigmas(set.begin(), set.end());
  for (auto& p : points) p.which = std::size_t(std::ranges::find(sigmas, p.sigma) - sigmas.begin());
  return sigmas;
}

void measure_point(OperatingPoint& p, CutRelighting<>& relighting, const Environment& environment) {
  std::vector<std::uint32_t> clusters(relighting.buffer().points.size());
  Stopwatch watch;
  const FrameLighting frame = relighting.light(environment, p.nodes, p.which);
  p.lighting.push_back(1e3 * watch.lap());
  p.radiance = relighting.shade(frame, Serial{}, p.which, clusters);
  p.shading.push_back(1e3 * watch.lap());
  p.pieces = frame.ends.size();
  p.clusters =
      clusters.empty() ? 0 : std::accumulate(clusters.begin(), clusters.end(), 0.0) / double(clusters.size());
}

void measure_twins(Twins& twins, CutRelighting<>& relighting, const Environment& environment) {
  const FrameLighting frame = relighting.light(environment, 1);
  Stopwatch watch;
  const auto skipping = relighting.shade_by_brute_force<Skip::unseen>(frame, Serial{});
  twins.skipping.push_back(1e3 * watch.lap());
  twins.radiance = relighting.shade_by_brute_force<Skip::nothing>(frame, Serial{});
  twins.plain.push_back(1e3 * watch.lap());
  const auto differs = [](const vec3& a, const vec3& b) {
    return length(a - b) > 1e-4f * (length(a) + length(b)) + 1e-12f;
  };
  if (!std::ranges::equal(skipping, twins.radiance, std::not_fn(differs)))
    throw std::logic_error("the two brute-force twins disagree");
}

/// One thread throughout; repetitions go round all variants, so that a slow spell of the machine meets them
/// all.
void measure(std::vector<OperatingPoint>& points, Twins& twins, CutRelighting<>& relighting,
             const Environment& environment, int repeat) {
  for (int r = 0; r < repeat; ++r) {
    std::fprintf(stderr, "measuring, round %d of %d\n", r + 1, repeat);
    measure_twins(twins, relighting, environment);
    for (auto& p : points) measure_point(p, relighting, environment);
  }
  const auto counts = counted_pixels(relighting.direct());
  const Image reference = relighting.image(twins.radiance);
  for (auto& p : points) p.errors = image_errors(relighting.image(p.radiance), reference, counts);
}

std::string csv(const std::vector<OperatingPoint>& points, const Twins& twins,
                const CutRelighting<>& relighting) {
  std::string text =
      "sigma,cut_size,illumination_nodes,visibility_pieces,clusters,bytes,ms_lighting,ms_shading,us_per_"
      "point,"
      "rel_rmse,mre,p99,times_plain,times_skipping\n";
  for (const auto& p : points) {
    char line[512];
    const auto cuts = cuts_json(relighting.cuts(p.which));
    std::snprintf(line, sizeof line, "%g,%zu,%zu,%.1f,%.1f,%zu,%.3f,%.3f,%.4f,%.6f,%.6f,%.6f,%.2f,%.2f\n",
                  p.sigma, p.nodes, p.pieces, cuts["mean"].get<double>(), p.clusters,
                  cuts["bytes"].get<std::size_t>(), median(p.lighting), median(p.shading),
                  1e3 * median(p.shading) / double(std::max<std::size_t>(1, p.radiance.size())),
                  p.errors.rel_rmse, p.errors.mre, p.errors.p99, median(twins.plain) / p.milliseconds(),
                  median(twins.skipping) / p.milliseconds());
    text += line;
  }
  return text;
}

void print_table(const std::vector<OperatingPoint>& points, const Twins& twins,
                 const CutRelighting<>& relighting) {
  const auto& buffer = relighting.buffer();
  std::printf("%zu shading points, %.1f a face, %zu receivers, %zu lights, one thread\n\n",
              buffer.points.size(),
              buffer.faces.empty() ? 0.0 : double(buffer.points.size()) / double(buffer.faces.size()),
              relighting.receivers().size(), relighting.directions().size());
  std::printf(
      "| σ | illumination nodes | pieces a visibility cut | clusters a point | MB of cuts | ms a frame | "
      "relRMSE | × skipping SIMD | × plain SIMD |\n");
  std::printf("|---|---|---|---|---|---|---|---|---|\n");
  for (const auto& p : points) {
    const auto cuts = cuts_json(relighting.cuts(p.which));
    std::printf("| %g | %zu | %.0f | %.0f | %.1f | %.0f | %.2f%% | %.1f | %.1f |\n", p.sigma, p.pieces,
                cuts["mean"].get<double>(), p.clusters, 1e-6 * cuts["bytes"].get<double>(), p.milliseconds(),
                100 * p.errors.rel_rmse, median(twins.skipping) / p.milliseconds(),
                median(twins.plain) / p.milliseconds());
  }
  std::printf("| – | all lights, skipping the unseen | | | %.1f | %.0f | 0 | 1 | %.1f |\n",
              8e-6 * double(relighting.bits().size()), median(twins.skipping),
              median(twins.plain) / median(twins.skipping));
  std::printf("| – | all lights | | %zu | %.1f | %.0f | 0 | %.2f | 1 |\n", relighting.directions().size(),
              8e-6 * double(relighting.bits().size()), median(twins.plain),
              median(twins.skipping) / median(twins.plain));
}

std::string plot(const std::vector<OperatingPoint>& points, const Twins& twins) {
  std::vector<PlotLine> lines;
  for (const auto& p : points) {
    char name[64];
    std::snprintf(name, sizeof name, "sigma %g", p.sigma);
    auto line = std::ranges::find(lines, name, &PlotLine::name);
    if (line == lines.end()) line = lines.insert(lines.end(), {name, {}});
    line->points.push_back({std::max(100 * p.errors.rel_rmse, 1e-4), p.milliseconds()});
  }
  for (auto& line : lines) std::ranges::sort(line.points);
  return plot_time_against_error(
      "Time against error", lines,
      {{"all lights, SIMD", median(twins.plain)}, {"skipping the unseen", median(twins.skipping)}});
}

void write_images(const Options& o, const std::vector<OperatingPoint>& points, const Twins& twins,
                  const CutRelighting<>& relighting) {
  const Image reference = relighting.image(twins.radiance);
  const float exposure = automatic_exposure(reference, relighting.direct().coverage);
  const auto write = [&](const std::string& suffix, const Image& image) {
    std::filesystem::path path = image_path(o, suffix);
    write_exr(path, image.width, image.height,
              {{"", image}, {"A", relighting.direct().coverage}, {"reference", reference}});
    write_png(path.replace_extension(".png"), image, exposure);
  };
  write("reference", reference);
  for (const auto& p : points) {
    char suffix[64];
    std::snprintf(suffix, sizeof suffix, "sigma%g_%zu", p.sigma, p.nodes);
    write(suffix, relighting.image(p.radiance));
  }
}

void sweep(const Options& o) {
  std::vector<OperatingPoint> points = operating_points(o);
  for (const auto& path : {o.common.out, plot_path(o), o.common.report, image_path(o, "reference")})
    if (!path.empty()) require_writable(path);
  const Threads threads(o.common.threads);
  Inputs in = load_inputs(o.common);
  in.environment.rotation = glm::radians(o.common.rotate_environment);
  const EmbreeTracer tracer(in.scene);
  CutRelightingOptions settings = relighting_options(o.common, o.cut, distinct_sigmas(points));
  settings.keep_bits = true;
  CutRelighting<> relighting(in.scene, tracer, in.camera, in.environment, settings, threads,
                             visibility_progress());
  Twins twins;
  measure(points, twins, relighting, in.environment, o.repeat);
  write_file(o.common.out, csv(points, twins, relighting));
  write_file(plot_path(o), plot(points, twins));
  if (!o.images.empty()) write_images(o, points, twins, relighting);
  print_table(points, twins, relighting);
  if (o.common.report.empty()) return;
  nlohmann::json report = {
      {"program", "trade"},
      {"settings", settings_json(o.common, o.cut)},
      {"preparation", preparation_json(relighting, in.scene)},
      {"brute_force_milliseconds", {{"plain", median(twins.plain)}, {"skipping", median(twins.skipping)}}}};
  for (const auto& p : points)
    report["points"].push_back({{"sigma", p.sigma},
                                {"cut_size", p.nodes},
                                {"clusters", p.clusters},
                                {"milliseconds", p.milliseconds()},
                                {"visibility_cuts", cuts_json(relighting.cuts(p.which))},
                                {"errors", errors_json(p.errors)}});
  write_report(o.common.report, report);
}

}  // namespace
}  // namespace coppice::program

int main(int argc, char** argv) {
  using namespace coppice::program;
  CLI::App app("Measures time against error of relighting through cuts, over their two knobs.", "trade");
  Options options;
  add_options(app, options);
  return run(app, argc, argv, [&] { sweep(options); });
}
