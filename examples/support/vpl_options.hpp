// The options of programs that gather the light of VPLs.
#pragma once

#include <coppice/gather/angle_walk.hpp>
//
#include <coppice/gather/adaptive.hpp>
#include <coppice/gather/traced_gather.hpp>
#include <coppice/light/vpls.hpp>
#include <nlohmann/json.hpp>
#include <support/program.hpp>

namespace coppice::program {

/// When a node of the VPL tree is taken whole.
enum class Criterion {
  bound,  ///< where an upper bound tells that it matters little
  angle   ///< where it covers a small solid angle: the paper's
};

/// Which pixels are gathered.
enum class Pixels { all, adaptive, paper, uniform_2, uniform_4 };

/// Exponents that materials are given, from the first to the second.
struct ExponentRange {
  float least = 5, most = 60;
};

struct VplSystemOptions {
  CommonOptions common;
  VplOptions placement;
  std::size_t emitters = 1024;   ///< surface lights at most, on shining surfaces
  std::size_t sky_lights = 256;  ///< distant lights at most, of --env
  VplTreeOptions tree;
  int bounces = 1;
  Criterion criterion = Criterion::bound;
  std::optional<float> threshold{};  ///< none: the default of the criterion
  std::optional<MinMaxCut> min_max{};
  bool is_traced = false;
  VplChoice choice = VplChoice::contribution;
  Pixels pixels = Pixels::all;
  std::optional<float> epsilon{};  ///< none: the default of the sampling
  std::optional<ExponentRange> exponents{};
  int frames = 1;
  bool animate = false;
  bool reference = false;
  std::filesystem::path compare_minus;
};

/// The threshold in force.
float threshold_of(const VplSystemOptions& options);

void add_vpl_options(CLI::App& app, VplSystemOptions& options);

/// Throws InputError for what does not go together.
void check_combinations(const VplSystemOptions& options);

nlohmann::json settings_json(const VplSystemOptions& options);

}  // namespace coppice::program
