#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <coppice/core/error.hpp>
#include <coppice/exr/read.hpp>
#include <coppice/gltf/load.hpp>
#include <cstdio>
#include <iostream>
#include <support/program.hpp>
#include <system_error>

namespace coppice::program {

namespace {

/// "1280x720" as width and height.
void parse_size(const std::string& text, Raster& raster) {
  int end = 0;
  if (std::sscanf(text.c_str(), "%dx%d%n", &raster.width, &raster.height, &end) != 2 ||
      std::size_t(end) != text.size() || raster.width < 1 || raster.height < 1 || raster.width > 16384 ||
      raster.height > 16384)
    throw CLI::ValidationError("--size", "'" + text + "' is not WIDTHxHEIGHT, each 1 to 16384");
}

/// Sees the whole scene from +Z, a little from above, for files without a camera.
Camera camera_around(const Mesh& mesh) {
  Camera camera;
  if (mesh.positions.empty()) return camera;
  vec3 low = mesh.positions[0], high = low;
  for (const vec3& p : mesh.positions) low = glm::min(low, p), high = glm::max(high, p);
  const float radius = std::max(0.5f * length(high - low), 1e-6f);
  camera.forward = normalize(vec3(0, -0.35f, -1));
  camera.up = normalize(vec3(0, 1, -0.35f));
  camera.position = 0.5f * (low + high) - camera.forward * (radius / std::sin(camera.vertical_fov / 2));
  return camera;
}

}  // namespace

const CLI::Validator finite_number(
    [](const std::string& text) {
      double value = 0;
      const bool is_finite = CLI::detail::lexical_cast(text, value) && std::isfinite(value);
      return is_finite ? std::string() : "'" + text + "' is not a finite number";
    },
    "FINITE");

void add_common_options(CLI::App& app, CommonOptions& o) {
  app.add_option("--scene", o.scene, "glTF 2.0 file (.glb or .gltf); its first camera is used")->required();
  app.add_option("--env", o.environment, "environment map, equirectangular (.hdr or .exr)")->required();
  app.add_option("--rotate-env", o.rotate_environment, "degrees by which the environment is turned about +Y")
      ->check(finite_number);
  app.add_option_function<std::string>(
      "--size", [&o](const std::string& s) { parse_size(s, o.raster); },
      "WIDTHxHEIGHT of the image (1280x720)");
  app.add_option("--samples", o.raster.samples, "camera rays a pixel; 1 goes through its centre")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  app.add_option("--report", o.report, "JSON file with settings, counts, times and errors");
  app.add_option("--threads", o.threads, "threads; 0 for all")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  app.add_option("--seed", o.seed,
                 "of all that is drawn; other than 0 it also turns the lattice of lights at random")
      ->capture_default_str();
  add_choice(
      app, "--brdf", o.shading, shading_words,
      "how materials are read: as glTF means them, or as one of the classic lobes with the same colours");
  app.add_flag_callback(
      "--lambert", [&o] { o.shading = Shading::lambert; }, "short for --brdf lambert");
}

void add_compare_options(CLI::App& app, CommonOptions& o) {
  app.add_option("--compare", o.compare, "EXR file against which errors are reported");
  app.add_option("--compare-block", o.compare_block, "compare means over N x N pixels")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
}

void add_cut_options(CLI::App& app, CutOptions& o) {
  app.add_option("--max-cut-size", o.max_cut_size, "pieces of a visibility cut at most")
      ->check(CLI::Range(std::size_t{1}, std::size_t{65536}))
      ->capture_default_str();
  app.add_option("--receiver-tolerance", o.receiver_tolerance,
                 "split edges whose middle errs by more than this share of unoccluded irradiance")
      ->check(finite_number)
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  app.add_option("--max-receivers", o.max_receivers, "receivers at most after splitting")
      ->check(CLI::Range(std::size_t{0}, std::size_t{1} << 30))
      ->capture_default_str();
  add_choice(app, "--receivers", o.receivers, scope_words,
             "receivers on what the camera sees, or everywhere");
  app.add_option("--longest-edge", o.longest_edge,
                 "pixels above which edges between receivers are always split; small for moving shadows")
      ->check(finite_number)
      ->check(CLI::Range(1.0f, 1e6f))
      ->capture_default_str();
  app.add_option("--light-count", o.lights, "lights over the sphere")
      ->check(CLI::Range(1u, 1u << 20))
      ->capture_default_str();
  app.add_option(
         "--beta", o.beta,
         "how lights are clustered: 1 by their directions alone, 0 by which receivers see them, which "
         "pilot rays tell; 0.5 for smaller visibility cuts")
      ->check(finite_number)
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  app.add_option("--lobe-tolerance", o.lobe_tolerance,
                 "of refined lobes: a cluster is split where its lobe may err by more than this share of the "
                 "point's radiance")
      ->check(finite_number)
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  add_choice(app, "--instructions", o.instructions, instruction_words,
             "instructions that shade on the processor; auto: the best it has");
}

int run(CLI::App& app, int argc, char** argv, const std::function<void()>& body) {
  try {
    app.parse(argc, argv);
    body();
    return 0;
  } catch (const CLI::Success& e) {
    return app.exit(e);  // --help
  } catch (const CLI::ParseError& e) {
    std::cerr << app.get_name() << ": " << e.what() << "; --help lists the options\n";
  } catch (const InputError& e) {
    std::cerr << app.get_name() << ": " << e.what() << "\n";
  } catch (const std::system_error& e) {
    std::cerr << app.get_name() << ": a device failed: " << e.what() << "\n";
    return 1;
  } catch (const std::bad_alloc&) {
    std::cerr << app.get_name() << ": out of memory; lower --max-receivers, --size or --samples\n";
  }
  return 2;
}

void require_writable(const std::filesystem::path& path) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  if (!path.has_filename()) throw InputError(path.string(), "names no file", "name a file to write");
  if (!fs::is_directory(folder, ignored))
    throw InputError(path.string(), "its directory does not exist", "create the directory first");
  if (::access(folder.c_str(), W_OK) != 0)
    throw InputError(path.string(), "its directory cannot be written to", "name another directory");
  if (fs::exists(path, ignored) && !fs::is_regular_file(path, ignored))
    throw InputError(path.string(), "exists and is not a regular file", "name another file");
}

Inputs load_inputs(const CommonOptions& options, const LoadOptions& load) {
  Inputs in{load_gltf(options.scene, load), {}, {}};
  if (!options.environment.empty()) in.environment = read_environment(options.environment);
  for (const auto& warning : in.scene.warnings) std::cerr << "warning: " << warning << "\n";
  if (!in.scene.camera)
    std::cerr << "warning: " << options.scene.string() << ": no camera; looking at the whole scene from +Z\n";
  in.camera = in.scene.camera.value_or(camera_around(in.scene.mesh));
  return in;
}

CutRelightingOptions relighting_options(const CommonOptions& common, const CutOptions& cut) {
  CutRelightingOptions o;
  o.raster = common.raster;
  o.shading = common.shading;
  o.light_count = cut.lights;
  o.seed = common.seed;
  o.refine = {cut.receiver_tolerance, cut.max_receivers};
  o.scope = cut.receivers;
  o.longest_edge = cut.longest_edge;
  o.beta = cut.beta;
  return o;
}

namespace {

InstructionSet instructions_of(const CutOptions& cut) {
  const auto supported = supported_instruction_sets();
  const InstructionSet set = cut.instructions.value_or(supported.back());
  if (std::ranges::find(supported, set) == supported.end())
    throw InputError(std::string("--instructions ") + name(set), "is not had by this processor",
                     "use --instructions auto");
  return set;
}

}  // namespace

const ShadingKernels<std::uint8_t>& kernels_of(const CutOptions& cut) {
  return kernels_for<std::uint8_t>(instructions_of(cut));
}

const ShadingKernels<std::uint16_t>& local_kernels_of(const CutOptions& cut) {
  return kernels_for<std::uint16_t>(instructions_of(cut));
}

VisibilityCutOptions visibility_options(const CutOptions& cut, double sigma, const CutKind& kind) {
  return {sigma, cut.max_cut_size, kind.weight, kind.search};
}

Progress visibility_progress() {
  return [watch = Stopwatch(), last = -1.0](std::size_t done, std::size_t total) mutable {
    if (last < 0) watch = Stopwatch(), last = 0;
    const double seconds = watch.seconds();
    const bool finished = done == total;
    if (!finished && seconds - last < 0.5) return;
    last = seconds;
    const double left = seconds / double(done) * double(total - done);
    std::fprintf(stderr, "visibility %zu/%zu receivers, %.0f s left  %s", done, total, left,
                 finished ? "\n" : "\r");
  };
}

}  // namespace coppice::program
