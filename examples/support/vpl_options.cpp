#include <coppice/core/error.hpp>
#include <cstdio>
#include <support/vpl_options.hpp>

namespace coppice::program {

namespace {

const Words<VplDensity> density_words{{"area", VplDensity::area},
                                      {"root-irradiance", VplDensity::root_irradiance},
                                      {"irradiance", VplDensity::irradiance}};
const Words<VplSpread> spread_words{{"elimination", VplSpread::elimination},
                                    {"repulsion", VplSpread::repulsion}};
const Words<VplClustering> clustering_words{
    {"squared", VplClustering::squared}, {"lengths", VplClustering::lengths}, {"kd", VplClustering::kd}};
const Words<VplFilter> filter_words{{"moments", VplFilter::moments}, {"uniform", VplFilter::uniform}};
const Words<Criterion> criterion_words{{"bound", Criterion::bound}, {"angle", Criterion::angle}};
const Words<bool> traced_words{{"none", false}, {"traced", true}};
const Words<VplChoice> choice_words{{"energy", VplChoice::energy}, {"contribution", VplChoice::contribution}};
const Words<Pixels> pixel_words{{"off", Pixels::all},
                                {"relative", Pixels::adaptive},
                                {"paper", Pixels::paper},
                                {"uniform2", Pixels::uniform_2},
                                {"uniform4", Pixels::uniform_4}};

/// "A:B" as two finite numbers, both at least `least`.
std::pair<float, float> parse_pair(const std::string& option, const std::string& text, float least) {
  float a = 0, b = 0;
  int end = 0;
  const bool is_pair =
      std::sscanf(text.c_str(), "%f:%f%n", &a, &b, &end) == 2 && std::size_t(end) == text.size();
  if (!is_pair || !(a >= least && b >= least && std::isfinite(a) && std::isfinite(b)))
    throw CLI::ValidationError(option, "'" + text + "' is not a pair like 5:60");
  return {a, b};
}

void add_placement_options(CLI::App& app, VplSystemOptions& o) {
  app.add_option("--vpls", o.placement.count, "VPLs at most on the surfaces of the scene")
      ->check(CLI::Range(std::size_t{0}, std::size_t{1} << 22))
      ->capture_default_str();
  add_choice(app, "--density", o.placement.density, density_words,
             "what the number of VPLs on each square metre follows");
  add_choice(app, "--spread", o.placement.spread, spread_words, "how VPLs are made to lie evenly");
  app.add_option("--emitters", o.emitters, "lights at most on shining surfaces")
      ->check(CLI::Range(std::size_t{0}, std::size_t{1} << 20))
      ->capture_default_str();
  app.add_option("--sky-lights", o.sky_lights, "distant lights at most, of --env")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1} << 20))
      ->capture_default_str();
  app.add_option("--bounces", o.bounces, "bounces of light that VPLs send out")
      ->check(CLI::Range(1, 3))
      ->capture_default_str();
  app.add_option_function<std::string>(
         "--exponents",
         [&o](const std::string& text) {
           const auto [a, b] = parse_pair("--exponents", text, 1);
           o.exponents = {a, b};
         },
         "LEAST:MOST: read all materials as glossy Phong with exponents spread over this range")
      ->option_text("LEAST:MOST");
}

void add_gather_options(CLI::App& app, VplSystemOptions& o) {
  add_choice(app, "--criterion", o.criterion, criterion_words,
             "when a cluster is taken whole: by an upper bound of what it brings, or by its solid angle");
  app.add_option("--threshold", o.threshold,
                 "of the criterion: share of a point's light (0.01; 0.02 with shadows), or steradians (0.02)")
      ->check(finite_number)
      ->check(CLI::Range(0.0, 6.0));
  add_choice(app, "--clustering", o.tree.clustering, clustering_words, "how VPLs are put into clusters");
  add_choice(app, "--filter", o.tree.filter, filter_words, "how a cluster stands for its VPLs");
  app.add_option_function<std::string>(
         "--min-max",
         [&o](const std::string& text) {
           const auto [a, b] = parse_pair("--min-max", text, 0);
           o.min_max = {a, b};
         },
         "MIN:MAX: normal variances of min-max cuts, for --criterion angle; alone the paper's, 40:9")
      ->option_text("MIN:MAX")
      ->expected(0, 1)
      ->default_str("40:9");
  add_choice(app, "--visibility", o.is_traced, traced_words,
             "of VPLs: none hides one, or a shadow ray to one VPL of each cluster");
  add_choice(app, "--ray-choice", o.choice, choice_words, "of traced visibility: to which VPL of a cluster");
  add_choice(app, "--adaptive", o.pixels, pixel_words,
             "which pixels are gathered, the others being interpolated; alone relative");
  app.get_option("--adaptive")->expected(0, 1)->default_str("relative");
  app.add_option("--epsilon", o.epsilon, "threshold of --adaptive (0.07; 0.3 for paper)")
      ->check(finite_number)
      ->check(CLI::NonNegativeNumber);
}

}  // namespace

float threshold_of(const VplSystemOptions& o) {
  if (o.threshold) return *o.threshold;
  if (o.criterion == Criterion::angle) return 0.02f;
  return o.is_traced ? 0.02f : 0.01f;
}

void add_vpl_options(CLI::App& app, VplSystemOptions& o) {
  add_common_options(app, o.common);
  app.get_option("--env")->required(false);
  add_placement_options(app, o);
  add_gather_options(app, o);
}

void check_combinations(const VplSystemOptions& o) {
  if (o.common.raster.samples != 1)
    throw InputError("--samples", "is 1 here: pixels are points of an image that adapts", "leave it out");
  if (o.min_max && o.criterion != Criterion::angle)
    throw InputError("--min-max", "cuts what a walk by solid angle visits", "use --criterion angle");
  if (o.is_traced && o.criterion == Criterion::angle)
    throw InputError("--visibility traced", "sends its rays to clusters of bounds", "use --criterion bound");
  if (o.criterion == Criterion::angle && !(threshold_of(o) > 0))
    throw InputError("--threshold", "is a solid angle above 0", "use --criterion bound for all VPLs");
  if (o.is_traced && o.common.backend != "cpu")
    throw InputError("--backend " + o.common.backend, "traces no rays", "use --backend cpu");
}

nlohmann::json settings_json(const VplSystemOptions& o) {
  const CommonOptions& c = o.common;
  nlohmann::json j = {{"scene", c.scene.string()},
                      {"environment", c.environment.string()},
                      {"width", c.raster.width},
                      {"height", c.raster.height},
                      {"rotate_env_degrees", c.rotate_environment},
                      {"backend", c.backend},
                      {"threads", c.threads},
                      {"seed", c.seed},
                      {"brdf", word_of(shading_words, c.shading)},
                      {"vpls", o.placement.count},
                      {"density", word_of(density_words, o.placement.density)},
                      {"spread", word_of(spread_words, o.placement.spread)},
                      {"emitters", o.emitters},
                      {"sky_lights", o.sky_lights},
                      {"bounces", o.bounces},
                      {"criterion", word_of(criterion_words, o.criterion)},
                      {"threshold", threshold_of(o)},
                      {"clustering", word_of(clustering_words, o.tree.clustering)},
                      {"filter", word_of(filter_words, o.tree.filter)},
                      {"visibility", word_of(traced_words, o.is_traced)},
                      {"ray_choice", word_of(choice_words, o.choice)},
                      {"adaptive", word_of(pixel_words, o.pixels)},
                      {"frames", o.frames},
                      {"animate", o.animate}};
  if (o.min_max) j["min_max"] = {o.min_max->min, o.min_max->max};
  if (o.exponents) j["exponents"] = {o.exponents->least, o.exponents->most};
  if (o.epsilon) j["epsilon"] = *o.epsilon;
  return j;
}

}  // namespace coppice::program
