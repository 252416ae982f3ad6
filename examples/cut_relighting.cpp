// Relights a scene through cuts of a light tree (nonlinear cut approximation): by an environment, or by the
// lights in it.
#include <coppice/core/error.hpp>
#include <coppice/embree/threads.hpp>
#include <coppice/embree/tracer.hpp>
#include <support/frames.hpp>
#include <support/knobs.hpp>
#include <support/program.hpp>
#include <support/report.hpp>
#include <support/shader.hpp>
#include <support/system.hpp>

namespace coppice::program {
namespace {

void add_light_options(CLI::App& app, SystemOptions& o) {
  add_choice(app, "--lights", o.lights, light_words,
             "what lights the scene: --env, the scene's own lights, or these and one bounce");
  add_choice(app, "--visibility", o.visibility, visibility_words,
             "of the scene's lights: precomputed cuts, or a shadow ray a cluster");
  app.add_option("--emitters", o.emitters, "lights at most on shining surfaces")
      ->check(CLI::Range(std::size_t{0}, std::size_t{1} << 22))
      ->capture_default_str();
  app.add_option("--bounces", o.bounces, "lights at most on the surfaces that are lit, for --lights indirect")
      ->check(CLI::Range(std::size_t{0}, std::size_t{1} << 22))
      ->capture_default_str();
  app.add_option("--trace-tolerance", o.trace_tolerance,
                 "of traced visibility: a cluster is split while it could add more than this share of the "
                 "point's radiance")
      ->check(finite_number)
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
}

void add_options(CLI::App& app, SystemOptions& o) {
  add_common_options(app, o.common);
  app.get_option("--env")->required(false);
  add_compare_options(app, o.common);
  app.add_option("--out", o.common.out,
                 "EXR file to write; a tone-mapped PNG of the same name goes beside it")
      ->required();
  app.add_option("--backend", o.common.backend, "where points are shaded")
      ->check(CLI::IsMember({"cpu", "vulkan"}))
      ->capture_default_str();
  add_light_options(app, o);
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
  app.add_flag("--animate", o.animate, "plays the file's first animation over the frames");
  app.add_option("--store", o.store,
                 "HDF5 file that keeps the visibility: read where it fits scene and settings, else written");
  app.add_flag(
      "--reference", o.reference,
      "also sum over all lights: adds the EXR layers reference and error, and the time that it took");
  add_cut_options(app, o.cut);
}

nlohmann::json knobs_json(const Knobs& k) {
  return {{"sigma", k.sigma},
          {"cut_size", k.nodes},
          {"weight", word_of(weight_words, k.cuts.weight)},
          {"search", word_of(search_words, k.cuts.search)},
          {"lobes", word_of(lobes_words, k.lobes)}};
}

nlohmann::json all_settings_json(const SystemOptions& o) {
  nlohmann::json j = settings_json(o.common, o.cut);
  j["light_count"] = j["lights"];
  j.update(knobs_json(o.knobs));
  j.update({{"lights", word_of(light_words, o.lights)},
            {"visibility", word_of(visibility_words, o.visibility)},
            {"emitters", o.emitters},
            {"bounces", o.bounces},
            {"trace_tolerance", o.trace_tolerance},
            {"frames", o.frames},
            {"animate", o.animate}});
  return j;
}

/// What does not go together.
void check_combinations(const SystemOptions& o) {
  if (o.lights == LightKind::environment && o.common.environment.empty())
    throw InputError("--lights env", "needs a map", "name one with --env");
  if (o.lights == LightKind::environment && o.visibility == Visibility::traced)
    throw InputError("--visibility traced", "is for lights in the scene", "use --lights scene or indirect");
  if (o.lights != LightKind::environment && o.visibility == Visibility::stored && o.animate)
    throw InputError("--animate", "moves objects under --env, or where visibility is traced",
                     "use --lights env or --visibility traced");
  if (!o.store.empty() && o.visibility == Visibility::traced)
    throw InputError("--store", "has nothing to keep where visibility is traced", "use --visibility stored");
  if (o.common.backend != "cpu" && (o.animate || o.lights != LightKind::environment))
    throw InputError("--backend " + o.common.backend, "shades resting scenes under --env",
                     "use --backend cpu");
}

/// Whatever would stop the program after minutes of work.
void check_before_work(const SystemOptions& o) {
  check_combinations(o);
  require_frames_writable(o.common.out, o.frames, o.common.report);
  if (!o.store.empty()) require_writable(o.store);
  require_backend(o.common.backend);
}

void print_frame(int frame, const nlohmann::json& j) {
  std::fprintf(stderr, "frame %d: %.1f ms", frame, j["milliseconds"].get<double>());
  if (j.contains("errors"))
    std::fprintf(stderr, ", relRMSE %.3f%%, mre %.3f%% against all lights",
                 100 * j["errors"]["rel_rmse"].get<double>(), 100 * j["errors"]["mre"].get<double>());
  if (j.contains("brute_force_milliseconds"))
    std::fprintf(stderr, " (plain %.0f ms, skipping %.0f ms)",
                 j["brute_force_milliseconds"]["plain"].get<double>(),
                 j["brute_force_milliseconds"]["skipping"].get<double>());
  if (j.contains("compared"))
    std::fprintf(stderr, ", relRMSE %.3f%%, mre %.3f%% against --compare",
                 100 * j["compared"]["rel_rmse"].get<double>(), 100 * j["compared"]["mre"].get<double>());
  std::fprintf(stderr, "\n");
}

std::unique_ptr<System> make_system(const SystemOptions& o, Inputs& in, const EmbreeTracer& tracer,
                                    const Threads& threads) {
  return o.lights == LightKind::environment ? make_environment_system(o, in, tracer, threads)
                                            : make_local_system(o, in, tracer, threads);
}

void render(const SystemOptions& o) {
  check_before_work(o);
  kernels_of(o.cut);
  const Threads threads(o.common.threads);
  Inputs in = load_inputs(o.common, {.separate_moving = o.animate});
  Image comparison = o.common.compare.empty() ? Image() : read_comparison(o.common.compare, o.common.raster);
  in.environment.rotation = turn_of_frame(o, 0);
  const EmbreeTracer tracer(in.scene);
  const auto system = make_system(o, in, tracer, threads);
  FrameWriter writer(
      *system, o.common.out, o.frames,
      {.reference = o.reference, .image = std::move(comparison), .block = o.common.compare_block});
  nlohmann::json report = {{"program", "cut_relighting"},
                           {"settings", all_settings_json(o)},
                           {"preparation", system->preparation()},
                           {"warnings", in.scene.warnings}};
  report["frames"] = writer.write_all(print_frame);
  if (!o.common.report.empty()) write_report(o.common.report, report);
}

}  // namespace
}  // namespace coppice::program

int main(int argc, char** argv) {
  using namespace coppice::program;
  CLI::App app("Relights a scene through cuts of a light tree: by an environment, or by its own lights.",
               "cut_relighting");
  SystemOptions options;
  add_options(app, options);
  return run(app, argc, argv, [&] { render(options); });
}
