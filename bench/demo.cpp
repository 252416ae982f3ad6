#include "demo.hpp"

#include <coppice/embree/threads.hpp>
#include <coppice/exr/read.hpp>
#include <coppice/gltf/load.hpp>
#include <cstdio>
#include <filesystem>

namespace coppice::bench {
namespace {

const std::filesystem::path assets = std::filesystem::path(COPPICE_SOURCE_DIR) / "assets";

CutRelightingOptions settings() {
  CutRelightingOptions o;
  o.raster = {320, 180, 1};
  o.cuts.clear();
  for (const double sigma : sigmas)
    o.cuts.push_back({sigma, VisibilityCutOptions{}.max_size, CutWeight::uniform, CutSearch::threshold});
  for (const double sigma : sigmas) o.cuts.push_back({sigma});
  o.refine.max_receivers = 8000;  // a third of what the tolerance asks for: seconds, not a minute
  o.keep_bits = true;
  return o;
}

}  // namespace

Demo::Demo()
    : scene(load_gltf(assets / "flight_helmet" / "flight_helmet.gltf")),
      environment(read_environment(assets / "hdri" / "workshop.hdr")),
      tracer(scene),
      relighting(scene, tracer, scene.camera.value(), environment, settings(), Threads()) {
  for (std::size_t i = 0; i < sigmas.size(); ++i)
    lighting[i] = relighting.light(environment, illumination_nodes, i);
  const PreparationReport& report = relighting.report();
  std::fprintf(stderr, "demo scene: %zu triangles, %zu receivers, %zu points, %.1f s of visibility\n",
               scene.mesh.triangles.size(), report.receivers, relighting.buffer().points.size(),
               report.visibility);
}

Demo& Demo::get() {
  static Demo demo;
  return demo;
}

std::span<const std::uint64_t> Demo::bits(std::uint32_t receiver) const {
  const std::size_t words = words_for_bits(relighting.tree().leaf_count());
  return relighting.bits().subspan(receiver * words, words);
}

}  // namespace coppice::bench
