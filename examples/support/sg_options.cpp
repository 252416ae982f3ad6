#include <algorithm>
#include <array>
#include <coppice/core/error.hpp>
#include <cstdio>
#include <support/sg_options.hpp>

namespace coppice::program {

const Words<ConeVisibility> cone_visibility_words{
    {"voxels", ConeVisibility::voxels}, {"mips", ConeVisibility::mips}, {"rays", ConeVisibility::rays}};
const Words<ConePlacement> placement_words{
    {"cut", ConePlacement::cut}, {"packed", ConePlacement::packed}, {"paper", ConePlacement::paper}};

MaterialOverride parse_material(const std::string& text) {
  if (text == "lambert") return {text, BRDF_LAMBERT, 0};
  const std::size_t colon = text.find(':');
  const std::string kind = text.substr(0, colon);
  float value = 0;
  int end = 0;
  const std::string number = colon == std::string::npos ? "" : text.substr(colon + 1);
  const bool is_number =
      std::sscanf(number.c_str(), "%f%n", &value, &end) == 1 && std::size_t(end) == number.size();
  if (is_number && kind == "phong" && value >= 1 && value <= BRDF_MAX_EXPONENT)
    return {text, BRDF_PHONG, value};
  if (is_number && kind == "ggx" && value >= BRDF_MIN_ALPHA && value <= 1) return {text, BRDF_GGX, value};
  throw CLI::ValidationError("--material", "'" + text +
                                               "' is none of lambert, phong:EXPONENT from 1 to 100000, "
                                               "ggx:ALPHA from 0.001 to 1");
}

namespace {

const Words<ConeWeights> weights_words{{"lookup", ConeWeights::lookup}, {"lights", ConeWeights::lights}};
const Words<LobeFit> fit_words{{"fitted", LobeFit::fitted}, {"warped", LobeFit::warped}};
const Words<FitScheme> scheme_words{{"one-level", FitScheme::one_level}, {"pyramid", FitScheme::pyramid}};

void add_light_options(CLI::App& app, SgSystemOptions& o) {
  app.add_option("--env-to", o.environment_to,
                 "map of the size of --env to which the light fades over the frames");
  app.add_option("--peaks", o.sky.peaks.most, "Gaussians at most for the lamps and the sun of the map")
      ->check(CLI::Range(0, 256))
      ->capture_default_str();
  app.add_option("--peak-threshold", o.sky.peaks.threshold, "multiple of the map's mean from which peaks are")
      ->check(finite_number)
      ->check(CLI::Range(1.01f, 1e6f))
      ->capture_default_str();
  app.add_option(
         "--peak-share", o.peak_share,
         "share of the map's energy from which a lamp is a peak (0.02, as the cut finds the others; 0 "
         "for packed cones)")
      ->check(finite_number)
      ->check(CLI::Range(0.0f, 1.0f))
      ->capture_default_str();
  app.add_option("--light-count", o.sky.lights, "cells of the sphere into which a map is gathered")
      ->check(CLI::Range(1u, 1u << 20))
      ->capture_default_str();
  app.add_option("--cut-size", o.sky.pieces, "pieces of the illumination cut")
      ->check(CLI::Range(1, 65536))
      ->capture_default_str();
}

void add_packed_options(CLI::App& app, SgSystemOptions& o) {
  add_choice(app, "--placement", o.placement, placement_words,
             "where cones are: at the pieces of a cut of light times BRDF, or packed into the BRDF's lobes; "
             "paper: packed, and the triple product alone tells their light");
  add_choice(app, "--weights", o.weights, weights_words,
             "how packed cones learn of the light behind them: by a lookup, or from every Gaussian");
  add_choice(app, "--lobes", o.lobes, fit_words, "Gaussians of the BRDF, of packed cones");
  add_choice(app, "--fit", o.scheme, scheme_words, "how the map becomes Gaussians, for packed cones");
  app.add_option("--levels", o.levels, "of --fit: the finest has 12 * 4^LEVELS Gaussians")
      ->check(CLI::Range(1, 5))
      ->capture_default_str();
}

void add_cone_options(CLI::App& app, SgSystemOptions& o) {
  app.add_option("--cones", o.cones.cones, "cones a point, besides one for each peak that matters to it")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_option("--lobe-tolerance", o.cones.lobe_tolerance,
                 "a piece of the illumination cut is split where the lobe may err by more than this share of "
                 "the point's light")
      ->check(finite_number)
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  app.add_option("--negligible", o.cones.negligible,
                 "cones that give less than this share of a point's light are not traced")
      ->check(finite_number)
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  add_choice(app, "--visibility", o.visibility, cone_visibility_words, "what cones are traced through");
  app.add_option("--voxels", o.voxels, "voxels along the longest side of the scene; a multiple of 8")
      ->check(CLI::Range(8, 2048))
      ->capture_default_str();
  app.add_option("--contact", o.march.contact, "voxels around a point that are traced exactly")
      ->check(finite_number)
      ->check(CLI::Range(0.0, 64.0))
      ->capture_default_str();
  app.add_option("--march-rays", o.march.trace.rays,
                 "rays that a cone is split into on its way through voxels; 8 at most on a device")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_option("--softness", o.march.trace.softness,
                 "of those rays, as a share of their width: more smooths the steps between them, and darkens")
      ->check(finite_number)
      ->check(CLI::Range(0.05, 2.0))
      ->capture_default_str();
  app.add_option("--rays", o.rays, "of --visibility rays: for each cone")
      ->check(CLI::Range(1, 65536))
      ->capture_default_str();
}

}  // namespace

SkyOptions sky_of(const SgSystemOptions& o) {
  SkyOptions sky = o.sky;
  if (o.placement != ConePlacement::cut) sky.peaks.least_share = 0;
  if (o.peak_share) sky.peaks.least_share = *o.peak_share;
  sky.seed = o.common.seed;
  return sky;
}

void add_sg_options(CLI::App& app, SgSystemOptions& o) {
  add_common_options(app, o.common);
  add_light_options(app, o);
  add_cone_options(app, o);
  add_packed_options(app, o);
  app.add_option_function<std::string>(
         "--material", [&o](const std::string& text) { o.material = parse_material(text); },
         "lambert, phong:EXPONENT or ggx:ALPHA: one white material for all surfaces")
      ->option_text("KIND");
  app.add_option("--roughness-to", o.roughness_to, "roughness to which all materials change over the frames")
      ->check(finite_number)
      ->check(CLI::Range(0.0, 1.0));
}

void check_combinations(const SgSystemOptions& o) {
  constexpr std::array<std::uint32_t, 5> packings{1, 3, 7, 13, 19};
  if (o.placement != ConePlacement::cut && std::ranges::find(packings, o.cones.cones) == packings.end())
    throw InputError("--cones " + std::to_string(o.cones.cones), "cannot be packed",
                     "use 1, 3, 7, 13 or 19, or --placement cut");
  if (o.voxels % 8 != 0)
    throw InputError("--voxels " + std::to_string(o.voxels), "is not a multiple of 8", "use 256 or 512");
  if (o.frames == 1 && (!o.environment_to.empty() || o.roughness_to))
    throw InputError(o.roughness_to ? "--roughness-to" : "--env-to", "changes from frame to frame",
                     "ask for several --frames");
  if (o.common.backend != "cpu" && o.visibility != ConeVisibility::voxels)
    throw InputError("--backend " + o.common.backend, "traces through voxels alone",
                     "use --visibility voxels, or --backend cpu");
  if (o.common.backend != "cpu" && o.march.trace.rays > 8)
    throw InputError("--march-rays " + std::to_string(o.march.trace.rays), "are more than 8 on a device",
                     "use --backend cpu");
  if (o.material && o.roughness_to)
    throw InputError("--roughness-to", "changes the materials of the file", "leave out --material");
}

nlohmann::json settings_json(const SgSystemOptions& o) {
  const CommonOptions& c = o.common;
  nlohmann::json j = {{"scene", c.scene.string()},
                      {"environment", c.environment.string()},
                      {"width", c.raster.width},
                      {"height", c.raster.height},
                      {"samples", c.raster.samples},
                      {"rotate_env_degrees", c.rotate_environment},
                      {"backend", c.backend},
                      {"threads", c.threads},
                      {"seed", c.seed},
                      {"brdf", word_of(shading_words, c.shading)},
                      {"peaks", o.sky.peaks.most},
                      {"peak_threshold", o.sky.peaks.threshold},
                      {"peak_share", sky_of(o).peaks.least_share},
                      {"lights", o.sky.lights},
                      {"cut_size", o.sky.pieces},
                      {"cones", o.cones.cones},
                      {"placement", word_of(placement_words, o.placement)},
                      {"lobe_tolerance", o.cones.lobe_tolerance},
                      {"negligible", o.cones.negligible},
                      {"visibility", word_of(cone_visibility_words, o.visibility)},
                      {"frames", o.frames},
                      {"animate", o.animate}};
  if (o.visibility == ConeVisibility::rays) j["rays"] = o.rays;
  if (o.visibility != ConeVisibility::rays) j["voxels"] = o.voxels;
  if (o.visibility == ConeVisibility::voxels) {
    j["contact"] = o.march.contact;
    j["march_rays"] = o.march.trace.rays;
    j["softness"] = o.march.trace.softness;
  }
  if (o.placement != ConePlacement::cut) {
    j["weights"] = word_of(weights_words, o.weights);
    j["lobes"] = word_of(fit_words, o.lobes);
    j["fit"] = word_of(scheme_words, o.scheme);
    j["levels"] = o.levels;
  }
  if (o.material) j["material"] = o.material->text;
  if (o.roughness_to) j["roughness_to"] = *o.roughness_to;
  if (!o.environment_to.empty()) j["environment_to"] = o.environment_to.string();
  return j;
}

}  // namespace coppice::program
