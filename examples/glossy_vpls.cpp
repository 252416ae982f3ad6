// Glossy global illumination from virtual point lights whose directional radiance is filtered up a tree
// (reflectance filtering). Nothing is precomputed: lights, materials and objects may change with each frame.
#include <coppice/core/error.hpp>
#include <support/frames.hpp>
#include <support/report.hpp>
#include <support/shader.hpp>
#include <support/vpl_system.hpp>

namespace coppice::program {
namespace {

void add_options(CLI::App& app, VplSystemOptions& o) {
  add_vpl_options(app, o);
  add_compare_options(app, o.common);
  app.add_option(
         "--compare-minus", o.compare_minus,
         "EXR file that is taken from that of --compare before the light of the VPLs alone is compared "
         "with it: a reference of direct light")
      ->needs(app.get_option("--compare"));
  app.add_option("--out", o.common.out,
                 "EXR file to write; a tone-mapped PNG of the same name goes beside it")
      ->required();
  app.add_option("--backend", o.common.backend, "where VPLs are filtered and gathered")
      ->check(CLI::IsMember({"cpu", "vulkan"}))
      ->capture_default_str();
  app.add_option("--frames", o.frames,
                 "frames, numbered in their names; frame i is turned by i times --rotate-env")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  app.add_flag("--animate", o.animate, "plays the file's first animation over the frames");
  app.add_flag("--reference", o.reference,
               "also sum over every VPL at every pixel: adds the EXR layers reference and error");
}

/// The light of the VPLs alone has a reference; so it is compared, if direct light is taken off.
Comparisons comparisons(const VplSystemOptions& o) {
  Comparisons c{.reference = o.reference, .referenced = "indirect", .block = o.common.compare_block};
  if (o.common.compare.empty()) return c;
  c.image = read_comparison(o.common.compare, o.common.raster);
  if (o.compare_minus.empty()) return c;
  c.compared = "indirect";
  const Image less = read_comparison(o.compare_minus, o.common.raster);
  for (std::size_t i = 0; i < c.image.pixels.size(); ++i) c.image.pixels[i] -= less.pixels[i];
  return c;
}

void print_frame(int frame, const nlohmann::json& j) {
  std::fprintf(stderr, "frame %d: %.0f ms, %zu of %zu VPLs shine", frame, j["milliseconds"].get<double>(),
               j["vpls"]["shining"].get<std::size_t>(), j["vpls"]["placed"].get<std::size_t>());
  for (const char* what : {"nodes", "shadow_rays"})
    if (j.contains(what)) std::fprintf(stderr, ", %.0f %s a pixel", j[what]["mean"].get<double>(), what);
  for (const auto& [what, against] : {std::pair("errors", "all VPLs"), std::pair("compared", "--compare")})
    if (j.contains(what))
      std::fprintf(stderr, ", relRMSE %.3f%%, mre %.3f%% against %s", 100 * j[what]["rel_rmse"].get<double>(),
                   100 * j[what]["mre"].get<double>(), against);
  std::fprintf(stderr, "\n");
}

void render(const VplSystemOptions& o) {
  check_combinations(o);
  require_frames_writable(o.common.out, o.frames, o.common.report);
  require_backend(o.common.backend);
  Comparisons compared = comparisons(o);
  const Threads threads(o.common.threads);
  Inputs in = load_inputs(o.common, {.separate_moving = o.animate});
  const std::size_t told = in.scene.warnings.size();
  const auto system = make_vpl_system(o, in, threads);
  for (std::size_t i = told; i < in.scene.warnings.size(); ++i)
    std::fprintf(stderr, "warning: %s\n", in.scene.warnings[i].c_str());
  FrameWriter writer(*system, o.common.out, o.frames, std::move(compared));
  nlohmann::json report = {{"program", "glossy_vpls"},
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
  CLI::App app("Glossy global illumination from virtual point lights, with nothing precomputed.",
               "glossy_vpls");
  VplSystemOptions options;
  add_options(app, options);
  return run(app, argc, argv, [&] { render(options); });
}
