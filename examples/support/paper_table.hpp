// The table of the Cuts paper (Fig. 9) for a scene: what the geometric and the data-driven tree cost and
// give.
#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <support/paper_scene.hpp>
#include <vector>

namespace coppice::program {

/// Rows of the table: as in the paper, and as the library does by default.
inline constexpr std::array<PaperWay, 2> paper_ways{
    {{{CutWeight::uniform, CutSearch::threshold}, Lobes::sampled}, {}}};
/// The first is the table's; the others serve to compare at equal RMS.
inline constexpr std::array<double, 4> paper_sigmas{2, 1, 1.5, 3};
/// Of the illumination cuts.
inline constexpr std::array<std::size_t, 3> paper_nodes{128, 256, 512};

/// A tree, and cuts by it: for each of paper_ways one set for each of paper_sigmas.
struct PaperTree {
  double beta = 1, seconds = 0;
  std::array<std::vector<PaperCuts>, paper_ways.size()> cuts{};
};

struct PaperTable {
  PaperCounts counts;
  double receiver_seconds = 0, ray_seconds = 0;
  PaperTree geometric, driven;
};

/// Measures both trees of a scene whose tree is still the geometric one.
PaperTable measure_paper_table(PaperScene& scene, float beta, int repeat);

/// Share of the pieces of the geometric tree that the data-driven one saves.
struct PaperGain {
  double equal_sigma = 0;
  std::optional<double> equal_rms{};  ///< none where the curve of the geometric tree does not reach that RMS
};

/// Both curves have a set of cuts for each σ, the table's first. Between them log(pieces) is taken to be
/// linear in log(RMS).
PaperGain gain(std::span<const PaperCuts> geometric, std::span<const PaperCuts> driven);

/// A row for every set of cuts, with the names of the inputs, so that files of several scenes can be put
/// together.
std::string paper_csv(const PaperTable& table, const SystemOptions& options);

/// Two lines of head, then a row for each of paper_ways, as Markdown.
std::string paper_markdown(const PaperTable& table, const SystemOptions& options);

nlohmann::json paper_json(const PaperTable& table);

}  // namespace coppice::program
