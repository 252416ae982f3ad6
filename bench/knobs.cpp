// Errors, not times: what the choices that are no knob of the programs cost, on the benchmarks' demo scene.
// Prints the tables of docs/: relRMSE against the sum over all lights.
#include <coppice/embree/threads.hpp>
#include <coppice/trade/errors.hpp>
#include <cstdio>

#include "demo.hpp"

namespace coppice::bench {
namespace {

const Threads threads;

double error_of(const std::vector<vec3>& radiance, const std::vector<vec3>& reference) {
  Image x(int(radiance.size()), 1), r(int(radiance.size()), 1);
  x.pixels = radiance, r.pixels = reference;
  return 100 * image_errors(x, r, std::vector<bool>(radiance.size(), true)).rel_rmse;
}

template <Quantised Value>
std::vector<vec3> through_cuts(const ShadingBuffer& buffer, const MaskedCuts<Value>& cuts,
                               const FrameLighting& frame, const LobeOptions& lobes = {Lobes::sampled}) {
  std::vector<vec3> radiance(buffer.points.size());
  threads(buffer.faces.size(), 64, [&](std::size_t begin, std::size_t end) {
    shade_faces(buffer, cuts, frame, lobes, begin, end, radiance, {});
  });
  return radiance;
}

std::vector<vec3> all_lights(const ShadingBuffer& buffer, const CutRelighting<>& relighting,
                             const FrameLighting& frame) {
  std::vector<vec3> radiance(buffer.points.size());
  const DenseLights lights(relighting.tree().leaf_count(), frame);
  threads(buffer.faces.size(), 64, [&](std::size_t begin, std::size_t end) {
    shade_faces_brute_force<Skip::nothing>(buffer, relighting.bits(), relighting.tree().leaf_count(), lights,
                                           begin, end, radiance);
  });
  return radiance;
}

/// Those of `values` whose points are at least as rough as 0.4.
std::vector<vec3> of_rough_points(const ShadingBuffer& buffer, const std::vector<vec3>& values) {
  std::vector<vec3> rough;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (buffer.points[i].alpha_x >= 0.4f * 0.4f) rough.push_back(values[i]);
  return rough;
}

/// The illumination cut that splits by mean radiance instead of the cluster's sum.
FrameLighting split_by_mean(const FrameLighting& frame, std::uint32_t leaf_count,
                            std::uint32_t granule_log2) {
  FrameLighting other = frame;
  const auto mean = [&](std::uint32_t h) {
    return luminance(frame.nodes[h].power) / std::max(frame.nodes[h].solid_angle, 1e-30f);
  };
  set_illumination_cut(other, leaf_count, select_by_budget(leaf_count, mean, illumination_nodes),
                       granule_log2);
  return other;
}

MaskedCuts<std::uint8_t> without_horizons(const MaskedCuts<std::uint8_t>& cuts) {
  MaskedCuts<std::uint8_t> blind(cuts.leaf_count(), cuts.granule_log2());
  for (std::size_t i = 0; i < cuts.size(); ++i) blind.append(cuts.unpack(i));
  return blind;
}

void error_by_choice() {
  Demo& demo = Demo::get();
  const auto& r = demo.relighting;
  const FrameLighting& frame = demo.lighting[usual];
  const auto reference = all_lights(r.buffer(), r, frame);
  const auto print = [&](const char* name, const std::vector<vec3>& x) {
    std::printf("| %s | %.3f%% |\n", name, error_of(x, reference));
  };
  const auto usual_way = through_cuts(r.buffer(), r.cuts(usual), frame);
  print("unweighted cuts by threshold, 256 nodes, lobes sampled: the paper's way", usual_way);
  const auto rough = of_rough_points(r.buffer(), usual_way);
  std::printf("| the same, of the %.0f%% of points with roughness >= 0.4 | %.3f%% |\n",
              100.0 * double(rough.size()) / double(usual_way.size()),
              error_of(rough, of_rough_points(r.buffer(), reference)));
  print("illumination cut by mean radiance, not by sum",
        through_cuts(r.buffer(), r.cuts(usual),
                     split_by_mean(frame, r.tree().leaf_count(), r.cuts(usual).granule_log2())));
  CutRelightingOptions options = r.options();
  options.keep_bits = false;
  CutRelighting<std::uint16_t> wide(demo.scene, demo.tracer, demo.scene.camera.value(), demo.environment,
                                    options, threads);
  print("visibility in 16 bits, not 8", through_cuts(wide.buffer(), wide.cuts(usual), frame));
  const FrameLighting small = demo.relighting.light(demo.environment, 64, weighted + usual);
  print("the library's defaults: weighted cuts, 64 nodes, lobes refined",
        through_cuts(r.buffer(), r.cuts(weighted + usual), small, {}));
  print("the same, receivers blind to their horizon",
        through_cuts(r.buffer(), without_horizons(r.cuts(weighted + usual)), small, {}));
  for (const float tolerance : {1e-4f, 3e-4f, 3e-3f, 1e-2f}) {
    char name[80];
    std::snprintf(name, sizeof name, "the defaults, lobe tolerance %g", double(tolerance));
    print(name, through_cuts(r.buffer(), r.cuts(weighted + usual), small, {Lobes::refined, tolerance}));
  }
}

}  // namespace
}  // namespace coppice::bench

int main() {
  using namespace coppice;
  using namespace coppice::bench;
  std::printf(
      "\n## Single choices: relRMSE of the scene's own materials, σ = 2\n\n| choice | relRMSE "
      "|\n|---|---|\n");
  error_by_choice();
}
