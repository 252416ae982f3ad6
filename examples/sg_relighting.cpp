// Objects relit by an environment while light, materials and shape all change: each becomes spherical
// Gaussians, anew for each frame.
#include <coppice/core/error.hpp>
#include <support/frames.hpp>
#include <support/report.hpp>
#include <support/sg_system.hpp>
#include <support/shader.hpp>

namespace coppice::program {
namespace {

void add_options(CLI::App& app, SgSystemOptions& o) {
  add_sg_options(app, o);
  add_compare_options(app, o.common);
  app.add_option("--out", o.common.out,
                 "EXR file to write; a tone-mapped PNG of the same name goes beside it")
      ->required();
  app.add_option("--backend", o.common.backend, "where maps are fitted and voxels are marched through")
      ->check(CLI::IsMember({"cpu", "vulkan"}))
      ->capture_default_str();
  app.add_option("--frames", o.frames,
                 "frames, numbered in their names; frame i is turned by i times --rotate-env")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  app.add_flag("--animate", o.animate, "plays the file's first animation over the frames");
  app.add_flag("--reference", o.reference,
               "also sum over all lights with a shadow ray each: adds the EXR layers reference and error");
}

void print_frame(int frame, const nlohmann::json& j) {
  std::fprintf(stderr, "frame %d: %.0f ms, %zu peaks, %.1f cones a point", frame,
               j["milliseconds"].get<double>(), j["peaks"].get<std::size_t>(),
               j["cones"]["mean"].get<double>());
  for (const auto& [what, against] : {std::pair("errors", "all lights"), std::pair("compared", "--compare")})
    if (j.contains(what))
      std::fprintf(stderr, ", relRMSE %.3f%%, mre %.3f%% against %s", 100 * j[what]["rel_rmse"].get<double>(),
                   100 * j[what]["mre"].get<double>(), against);
  std::fprintf(stderr, "\n");
}

void render(const SgSystemOptions& o) {
  check_combinations(o);
  require_frames_writable(o.common.out, o.frames, o.common.report);
  require_backend(o.common.backend);
  Comparisons compared{.reference = o.reference, .block = o.common.compare_block};
  if (!o.common.compare.empty()) compared.image = read_comparison(o.common.compare, o.common.raster);
  const Threads threads(o.common.threads);
  Inputs in = load_inputs(o.common, {.separate_moving = o.animate});
  const auto system = make_sg_system(o, in, threads);
  FrameWriter writer(*system, o.common.out, o.frames, std::move(compared));
  nlohmann::json report = {{"program", "sg_relighting"},
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
  CLI::App app("Relighting by an environment through spherical Gaussians, with nothing precomputed.",
               "sg_relighting");
  SgSystemOptions options;
  add_options(app, options);
  return run(app, argc, argv, [&] { render(options); });
}
