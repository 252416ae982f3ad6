// The scene that the benchmarks measure: the demo scene under its first environment, small enough to be
// prepared in seconds.
#pragma once

#include <array>
#include <coppice/embree/tracer.hpp>
#include <coppice/relight/cut_relighting.hpp>
#include <coppice/scene/scene.hpp>
#include <span>

namespace coppice::bench {

/// Thresholds of the visibility cuts, and nodes of the illumination cut.
inline constexpr std::array<double, 3> sigmas{1, 2, 3};
inline constexpr std::size_t illumination_nodes = 256;
/// The index of σ = 2 in `sigmas`, which stands for all where one is enough. Sets of visibility cuts: the
/// first are by threshold and unweighted, as in the paper, one for each σ; from `weighted` on they are as the
/// library makes them.
inline constexpr std::size_t usual = 1, weighted = sigmas.size();

/// Made once, at the first benchmark that needs it. Visibility keeps its bits for the brute-force twins.
class Demo {
 public:
  static Demo& get();

  /// The visibility of all leaves from a receiver, a bit each.
  std::span<const std::uint64_t> bits(std::uint32_t receiver) const;

  Scene scene;
  Environment environment;
  EmbreeTracer tracer;
  CutRelighting<> relighting;
  std::array<FrameLighting, sigmas.size()> lighting;  ///< for the cuts of each σ

 private:
  Demo();
};

}  // namespace coppice::bench
