// What all programs share: command line, input files, exit codes.
#pragma once

#include <CLI/CLI.hpp>
#include <coppice/gltf/load.hpp>
#include <coppice/light/environment.hpp>
#include <coppice/relight/cut_relighting.hpp>
#include <coppice/scene/scene.hpp>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <support/words.hpp>
#include <vector>

namespace coppice::program {

/// The options of DESIGN section 6 that every program reads.
struct CommonOptions {
  std::filesystem::path scene, environment, out, report, compare;
  Raster raster;
  float rotate_environment = 0;  ///< degrees
  std::string backend = "cpu";
  int threads = 0;
  std::uint64_t seed = 0;
  int compare_block = 1;
  Shading shading = Shading::metallic_roughness;
};

/// The options of the precomputation by cuts.
struct CutOptions {
  std::size_t max_cut_size = VisibilityCutOptions{}.max_size;
  double receiver_tolerance = RefineOptions{}.tolerance;
  std::size_t max_receivers = RefineOptions{}.max_receivers;
  ReceiverScope receivers = ReceiverScope::seen;
  float longest_edge = ViewOptions{}.longest_edge;  ///< pixels
  std::uint32_t lights = CutRelightingOptions{}.light_count;
  float beta = CutRelightingOptions{}.beta;
  float lobe_tolerance = LobeOptions{}.tolerance;
  std::optional<InstructionSet> instructions{};  ///< none: the best of the processor
};

/// Accepts numbers but NaN and infinity; CLI::Range lets NaN pass.
extern const CLI::Validator finite_number;

void add_common_options(CLI::App& app, CommonOptions& options);
void add_compare_options(CLI::App& app, CommonOptions& options);
void add_cut_options(CLI::App& app, CutOptions& options);

/// Parses, then runs the body. Bad input, on the command line or from files, is one line on stderr and exit
/// code 2.
int run(CLI::App& app, int argc, char** argv, const std::function<void()>& body);

/// Throws InputError where a file of that name could not be written: asked before the work begins, not after
/// it.
void require_writable(const std::filesystem::path& path);

/// Scene and, where one is named, environment of the command line; their warnings go to stderr.
struct Inputs {
  Scene scene;
  Camera camera;
  Environment environment;
};
Inputs load_inputs(const CommonOptions& options, const LoadOptions& load = {});

/// Settings of the library from those of the command line; `cuts` and `lobes` are left to the program.
CutRelightingOptions relighting_options(const CommonOptions& common, const CutOptions& cut);

/// The shading kernels of --instructions. Throws InputError where this processor or build lacks them.
const ShadingKernels<std::uint8_t>& kernels_of(const CutOptions& cut);

/// The same for lights in the scene.
const ShadingKernels<std::uint16_t>& local_kernels_of(const CutOptions& cut);

/// Visibility cuts of one threshold and kind.
VisibilityCutOptions visibility_options(const CutOptions& cut, double sigma, const CutKind& kind);

/// A line on stderr that tells how far the visibility is and how long it will take.
Progress visibility_progress();

}  // namespace coppice::program
