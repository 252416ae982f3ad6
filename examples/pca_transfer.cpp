// A room relit by lights that move through it: shadows and indirect light from bases that were computed once.
#include <coppice/core/error.hpp>
#include <support/frames.hpp>
#include <support/pca_system.hpp>
#include <support/report.hpp>
#include <support/shader.hpp>

namespace coppice::program {
namespace {

void add_options(CLI::App& app, PcaSystemOptions& o) {
  add_pca_options(app, o);
  add_compare_options(app, o.common);
  app.add_option("--out", o.common.out,
                 "EXR file to write; a tone-mapped PNG of the same name goes beside it")
      ->required();
  app.add_option("--backend", o.common.backend, "where bases are evaluated")
      ->check(CLI::IsMember({"cpu", "vulkan"}))
      ->capture_default_str();
  app.add_option("--frames", o.frames,
                 "frames, numbered in their names, spread over the time of the lights' keys")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  app.add_option(
      "--store", o.store,
      "HDF5 file that keeps the precomputation: read where it fits scene and settings, else written");
  app.add_flag("--reference", o.reference,
               "also a shadow ray from each pixel, and light that is solved for without any basis: adds the "
               "EXR layers reference and error");
}

void print_frame(int frame, const nlohmann::json& j) {
  std::fprintf(stderr, "frame %d: %.1f ms at the samples, %.0f ms at the pixels", frame,
               j["samples_milliseconds"].get<double>(), j["pixels_milliseconds"].get<double>());
  for (const auto& [what, against] :
       {std::pair("errors", "rays and solver"), std::pair("compared", "--compare")})
    if (j.contains(what))
      std::fprintf(stderr, ", relRMSE %.3f%%, mre %.3f%% against %s", 100 * j[what]["rel_rmse"].get<double>(),
                   100 * j[what]["mre"].get<double>(), against);
  std::fprintf(stderr, "\n");
}

void render(const PcaSystemOptions& o) {
  check_combinations(o);
  require_frames_writable(o.common.out, o.frames, o.common.report);
  if (!o.store.empty()) require_writable(o.store);
  require_backend(o.common.backend);
  Comparisons compared{.reference = o.reference, .block = o.common.compare_block};
  if (!o.common.compare.empty()) compared.image = read_comparison(o.common.compare, o.common.raster);
  const Threads threads(o.common.threads);
  Inputs in = load_inputs(o.common);
  const std::size_t told = in.scene.warnings.size();
  const auto system = make_pca_system(o, in, threads);
  for (std::size_t i = told; i < in.scene.warnings.size(); ++i)
    std::fprintf(stderr, "warning: %s\n", in.scene.warnings[i].c_str());
  FrameWriter writer(*system, o.common.out, o.frames, std::move(compared));
  nlohmann::json report = {{"program", "pca_transfer"},
                           {"settings", settings_json(o)},
                           {"preparation", system->preparation()},
                           {"warnings", in.scene.warnings}};
  report["frames"] = writer.write_all(print_frame);
  if (!o.common.report.empty()) write_report(o.common.report, report);
}

}  // namespace
}  // namespace coppice::program

int main(int argc, char** argv) {
  using namespace coppice::program;
  CLI::App app("Lights that move through a room, with soft shadows and indirect light from PCA bases.",
               "pca_transfer");
  PcaSystemOptions options;
  add_options(app, options);
  return run(app, argc, argv, [&] { render(options); });
}
