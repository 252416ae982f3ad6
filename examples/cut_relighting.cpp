// Relights a scene under an environment through precomputed visibility cuts (nonlinear cut approximation).
#include <coppice/core/error.hpp>
#include <coppice/embree/threads.hpp>
#include <coppice/embree/tracer.hpp>
#include <coppice/exr/exposure.hpp>
#include <coppice/exr/write.hpp>
#include <support/knobs.hpp>
#include <support/program.hpp>
#include <support/report.hpp>
#include <support/shader.hpp>

namespace coppice::program {
namespace {

struct Options {
  CommonOptions common;
  CutOptions cut;
  std::string lights = "env";
  Knobs knobs;
  int frames = 1;
  bool reference = false;
};

void add_options(CLI::App& app, Options& o) {
  add_common_options(app, o.common);
  add_compare_options(app, o.common);
  app.add_option("--out", o.common.out,
                 "EXR file to write; a tone-mapped PNG of the same name goes beside it")
      ->required();
  app.add_option("--backend", o.common.backend, "where points are shaded")
      ->check(CLI::IsMember({"cpu", "vulkan"}))
      ->capture_default_str();
  app.add_option("--lights", o.lights, "what lights the scene")
      ->check(CLI::IsMember({"env"}))
      ->capture_default_str();
  app.add_option("--sigma", o.knobs.sigma, "error threshold of the visibility cuts (Eq. 6)")
      ->check(finite_number)
      ->check(CLI::Range(0.0, max_sigma))
      ->capture_default_str();
  app.add_option("--cut-size", o.knobs.nodes, "nodes of the illumination cut at most")
      ->check(CLI::Range(std::size_t{1}, max_nodes))
      ->capture_default_str();
  add_choice(app, "--weight", o.knobs.cuts.weight, weight_words,
             "how lights count in visibility cuts: each alike, or as much as they can light the surface");
  add_choice(
      app, "--search", o.knobs.cuts.search, search_words,
      "how visibility cuts are chosen: by the paper's threshold, or as the least error for their size");
  add_choice(
      app, "--lobes", o.knobs.lobes, lobes_words,
      "how a BRDF meets a cluster of lights: at its mean direction, averaged over it, or averaged with "
      "coarse clusters split");
  app.add_option("--frames", o.frames,
                 "frames; above 1, frame i is turned by i times --rotate-env and numbered in its name")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  app.add_flag(
      "--reference", o.reference,
      "also sum over all lights: adds the EXR layers reference and error, and both brute-force times");
  add_cut_options(app, o.cut);
}

nlohmann::json knobs_json(const Knobs& k) {
  return {{"sigma", k.sigma},
          {"cut_size", k.nodes},
          {"weight", word_of(weight_words, k.cuts.weight)},
          {"search", word_of(search_words, k.cuts.search)},
          {"lobes", word_of(lobes_words, k.lobes)}};
}

/// out.exr, or out.0007.exr.
std::filesystem::path frame_path(const Options& o, int frame) {
  std::filesystem::path path = o.common.out;
  if (o.frames == 1) return path;
  std::string number = std::to_string(frame);
  number.insert(0, number.size() < 4 ? 4 - number.size() : 0, '0');
  return path.replace_extension("." + number + path.extension().string());
}

/// Radians by which frame i turns the environment.
float turn_of_frame(const Options& o, int frame) {
  return glm::radians(o.common.rotate_environment * float(o.frames > 1 ? frame : 1));
}

std::filesystem::path preview_path(std::filesystem::path image) { return image.replace_extension(".png"); }

/// Whatever would stop the program after minutes of work.
void check_before_work(const Options& o) {
  if (o.common.out == preview_path(o.common.out))
    throw InputError(o.common.out.string(), "is the name of the preview", "let --out end in .exr");
  for (const int frame : {0, o.frames - 1}) {
    require_writable(frame_path(o, frame));
    require_writable(preview_path(frame_path(o, frame)));
  }
  if (!o.common.report.empty()) require_writable(o.common.report);
  require_backend(o.common.backend);
}

/// One frame: times, image, and what --reference and --compare add.
class FrameRenderer {
 public:
  FrameRenderer(const Options& options, CutRelighting<>& relighting, Environment environment,
                Image comparison, const Threads& threads)
      : options_(options),
        relighting_(relighting),
        environment_(std::move(environment)),
        threads_(threads),
        shader_(make_shader(options.common.backend, relighting)),
        counts_(counted_pixels(relighting.direct())),
        comparison_(std::move(comparison)) {}

  nlohmann::json render(int frame) {
    environment_.rotation = turn_of_frame(options_, frame);
    Stopwatch watch;
    const FrameLighting lighting = relighting_.light(environment_, options_.knobs.nodes);
    const double light = watch.lap();
    std::vector<std::uint32_t> clusters(relighting_.buffer().points.size());
    const std::vector<vec3> radiance = shader_->shade(lighting, threads_, clusters);
    const double shade = watch.lap();
    nlohmann::json j = {{"rotation_degrees", glm::degrees(environment_.rotation)},
                        {"milliseconds", 1e3 * (light + shade)},
                        {"milliseconds_lighting", 1e3 * light},
                        {"milliseconds_shading", 1e3 * shade},
                        {"illumination_nodes", lighting.ends.size()},
                        {"clusters", summary_json(summary_of(clusters))}};
    write(frame, radiance, clusters, lighting, j);
    return j;
  }

 private:
  void write(int frame, const std::vector<vec3>& radiance, const std::vector<std::uint32_t>& clusters,
             const FrameLighting& lighting, nlohmann::json& j) {
    const Image image = relighting_.image(radiance),
                cut_size = resolve(relighting_.buffer(), options_.common.raster, as_vectors(clusters));
    std::vector<float> cut_sizes;
    for (const vec3& c : cut_size.pixels) cut_sizes.push_back(c.x);
    std::vector<Layer> layers{{"", image}, {"A", relighting_.direct().coverage}, {"cut_size.Y", cut_sizes}};
    Image reference, error(image.width, image.height);
    if (options_.reference) {
      reference = add_reference(lighting, image, j);
      for (std::size_t i = 0; i < error.pixels.size(); ++i)
        error.pixels[i] = image.pixels[i] - reference.pixels[i];
      layers.push_back({"reference", reference});
      layers.push_back({"error", error});
    }
    if (!comparison_.pixels.empty())
      j["compared"] = errors_json(compare(image, comparison_, counts_, options_.common.compare_block));
    const std::filesystem::path path = frame_path(options_, frame);
    write_exr(path, image.width, image.height, layers);
    write_png(preview_path(path), image, automatic_exposure(image, relighting_.direct().coverage));
  }

  Image add_reference(const FrameLighting& lighting, const Image& image, nlohmann::json& j) {
    Stopwatch watch;
    const auto skipping = relighting_.shade_by_brute_force<Skip::unseen>(lighting, threads_);
    const double skip_seconds = watch.lap();
    const auto plain = relighting_.shade_by_brute_force<Skip::nothing>(lighting, threads_);
    const double plain_seconds = watch.lap();
    const Image reference = relighting_.image(plain);
    j["brute_force_milliseconds"] = {{"plain", 1e3 * plain_seconds}, {"skipping", 1e3 * skip_seconds}};
    j["errors"] = errors_json(compare(image, reference, counts_, 1));
    return reference;
  }

  static std::vector<vec3> as_vectors(const std::vector<std::uint32_t>& values) {
    std::vector<vec3> vectors;
    for (const auto v : values) vectors.emplace_back(float(v));
    return vectors;
  }

  const Options& options_;
  CutRelighting<>& relighting_;
  Environment environment_;
  const Threads& threads_;
  std::unique_ptr<Shader> shader_;
  std::vector<bool> counts_;
  Image comparison_;
};

void print_frame(int frame, const nlohmann::json& j) {
  std::fprintf(stderr, "frame %d: %.1f ms", frame, j["milliseconds"].get<double>());
  if (j.contains("errors"))
    std::fprintf(stderr, ", relRMSE %.3f%% against all lights (plain %.0f ms, skipping %.0f ms)",
                 100 * j["errors"]["rel_rmse"].get<double>(),
                 j["brute_force_milliseconds"]["plain"].get<double>(),
                 j["brute_force_milliseconds"]["skipping"].get<double>());
  if (j.contains("compared"))
    std::fprintf(stderr, ", relRMSE %.3f%%, mre %.3f%% against --compare",
                 100 * j["compared"]["rel_rmse"].get<double>(), 100 * j["compared"]["mre"].get<double>());
  std::fprintf(stderr, "\n");
}

void render(const Options& o) {
  check_before_work(o);
  const auto& kernels = kernels_of(o.cut);
  const Threads threads(o.common.threads);
  Inputs in = load_inputs(o.common);
  Image comparison = o.common.compare.empty() ? Image() : read_comparison(o.common.compare, o.common.raster);
  in.environment.rotation = turn_of_frame(o, 0);
  const EmbreeTracer tracer(in.scene);
  CutRelightingOptions settings = relighting_options(o.common, o.cut);
  settings.cuts = {visibility_options(o.cut, o.knobs.sigma, o.knobs.cuts)};
  settings.lobes = {o.knobs.lobes, o.cut.lobe_tolerance};
  settings.keep_bits = o.reference;
  CutRelighting<> relighting(in.scene, tracer, in.camera, in.environment, settings, threads,
                             visibility_progress());
  relighting.use(kernels);
  FrameRenderer renderer(o, relighting, std::move(in.environment), std::move(comparison), threads);
  nlohmann::json report = {{"program", "cut_relighting"},
                           {"settings", settings_json(o.common, o.cut)},
                           {"preparation", preparation_json(relighting, in.scene)},
                           {"visibility_cuts", cuts_json(relighting.cuts())},
                           {"warnings", in.scene.warnings}};
  report["settings"].update(knobs_json(o.knobs));
  for (int frame = 0; frame < o.frames; ++frame) {
    report["frames"].push_back(renderer.render(frame));
    print_frame(frame, report["frames"].back());
  }
  if (!o.common.report.empty()) write_report(o.common.report, report);
}

}  // namespace
}  // namespace coppice::program

int main(int argc, char** argv) {
  using namespace coppice::program;
  CLI::App app("Relights a scene under an environment through precomputed visibility cuts.",
               "cut_relighting");
  Options options;
  add_options(app, options);
  return run(app, argc, argv, [&] { render(options); });
}
