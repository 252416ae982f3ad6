// The options of the program that relights with spherical Gaussians.
#pragma once

#include <coppice/sg/cone_cut.hpp>
//
#include <coppice/sg/environment_fit.hpp>
#include <coppice/sg/packed_cones.hpp>
#include <coppice/sg/sky_lights.hpp>
#include <coppice/voxel/cone_tracer.hpp>
#include <nlohmann/json.hpp>
#include <support/program.hpp>

namespace coppice::program {

/// How it is known how much of a cone is visible.
enum class ConeVisibility {
  voxels,  ///< a march through distances
  mips,    ///< the paper's: one cone through a pyramid of opacities
  rays     ///< exact
};

/// Where cones are placed.
enum class ConePlacement {
  cut,     ///< by a cut of light × BRDF
  packed,  ///< packed into the lobes of the BRDF
  paper    ///< the same, the light through each by the paper's triple product alone
};

/// How packed cones learn how much light is behind them.
enum class ConeWeights {
  lookup,  ///< in the environment that was convolved with Gaussians
  lights   ///< by a pass over all its Gaussians
};

/// One material for every surface.
struct MaterialOverride {
  std::string text;  ///< as on the command line
  std::uint32_t brdf = BRDF_LAMBERT;
  float parameter = 0;  ///< exponent or α
};

struct SgSystemOptions {
  CommonOptions common;
  std::filesystem::path environment_to;  ///< the map that frames fade to; empty: none
  SkyOptions sky;
  std::optional<float> peak_share{};  ///< PeakOptions::least_share; none: that of the placement
  ConeCutOptions cones;
  ConePlacement placement = ConePlacement::cut;
  ConeWeights weights = ConeWeights::lookup;
  LobeFit lobes = LobeFit::fitted;
  FitScheme scheme = FitScheme::one_level;
  int levels = 3;  ///< of the HEALPix grid, whose finest has 12 · 4^levels Gaussians
  ConeVisibility visibility = ConeVisibility::voxels;
  std::uint32_t voxels = 256;
  ConeTracerOptions march;  ///< through voxels
  std::uint32_t rays = 16;  ///< a cone, where rays trace them
  std::optional<MaterialOverride> material{};
  std::optional<float> roughness_to{};  ///< to which the roughness of all materials goes over the frames
  int frames = 1;
  bool animate = false;
  bool reference = false;
};

extern const Words<ConeVisibility> cone_visibility_words;
extern const Words<ConePlacement> placement_words;

/// "lambert", "phong:50" or "ggx:0.3". Throws CLI::ValidationError for anything else.
MaterialOverride parse_material(const std::string& text);

/// The sky in force: packed cones find no lamps, so that every peak is one to them.
SkyOptions sky_of(const SgSystemOptions& options);

void add_sg_options(CLI::App& app, SgSystemOptions& options);

/// Throws InputError for what does not go together.
void check_combinations(const SgSystemOptions& options);

nlohmann::json settings_json(const SgSystemOptions& options);

}  // namespace coppice::program
