// The knobs that trade sweeps.
#pragma once

#include <cstddef>
#include <string>
#include <support/words.hpp>
#include <vector>

namespace coppice::program {

inline constexpr double max_sigma = 1000;
/// Nodes of the illumination cut: where none are asked for, and at most.
inline constexpr std::size_t default_nodes = 64, max_nodes = std::size_t{1} << 20;

/// One setting of all knobs.
struct Knobs {
  double sigma = VisibilityCutOptions{}.sigma;
  std::size_t nodes = default_nodes;  ///< of the illumination cut at most
  CutKind cuts;
  Lobes lobes = LobeOptions{}.lobes;
};

/// The values of each knob.
struct KnobRanges {
  std::vector<double> sigmas{1, 2, 3};
  std::vector<std::size_t> sizes{32, 64, 128};
  std::vector<CutKind> cuts{CutKind{}};
  std::vector<Lobes> lobes{LobeOptions{}.lobes};
};

/// Every combination: in order of kind of cuts, then σ, nodes and lobes.
std::vector<Knobs> combinations(const KnobRanges& ranges);

/// SIGMA:SIZE[:CUTS[:LOBES]], as in "2:64:cosine-optimal:refined"; what is left out is the default. Throws
/// InputError.
Knobs parse_knobs(const std::string& text);

/// "sigma2_64_cosine-optimal_refined": part of a file's name.
std::string file_suffix(const Knobs& knobs);

}  // namespace coppice::program
