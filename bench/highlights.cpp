// The picture of docs/: the demo scene as if all of it were one metal, GGX α 0.1. From left to right: lobes
// sampled at the clusters of 256 illumination nodes, refined from 64, all lights. Usage: highlights OUT.png
#include <coppice/embree/threads.hpp>
#include <coppice/exr/exposure.hpp>
#include <coppice/exr/write.hpp>
#include <cstdio>

#include "demo.hpp"

namespace coppice::bench {
namespace {

const Threads threads;

std::vector<vec3> shade(const ShadingBuffer& buffer, std::size_t cuts, const FrameLighting& frame,
                        const LobeOptions& lobes) {
  std::vector<vec3> radiance(buffer.points.size());
  threads(buffer.faces.size(), 64, [&](std::size_t begin, std::size_t end) {
    shade_faces(buffer, Demo::get().relighting.cuts(cuts), frame, lobes, begin, end, radiance, {});
  });
  return radiance;
}

std::vector<vec3> shade_all_lights(const ShadingBuffer& buffer, const FrameLighting& frame) {
  const auto& relighting = Demo::get().relighting;
  const std::uint32_t leaf_count = relighting.tree().leaf_count();
  std::vector<vec3> radiance(buffer.points.size());
  const DenseLights lights(leaf_count, frame);
  threads(buffer.faces.size(), 64, [&](std::size_t begin, std::size_t end) {
    shade_faces_brute_force<Skip::unseen>(buffer, relighting.bits(), leaf_count, lights, begin, end,
                                          radiance);
  });
  return radiance;
}

Image side_by_side(std::span<const Image> images) {
  const Image& first = images[0];
  Image joined(first.width * int(images.size()), first.height);
  for (std::size_t i = 0; i < images.size(); ++i)
    for (int y = 0; y < first.height; ++y)
      for (int x = 0; x < first.width; ++x)
        joined.pixels[joined.index(int(i) * first.width + x, y)] = images[i].pixels[first.index(x, y)];
  return joined;
}

void write_picture(const char* path) {
  Demo& demo = Demo::get();
  ShadingBuffer buffer = demo.relighting.buffer();
  for (ShadingPoint& p : buffer.points) set_metallic_roughness(p, vec3(1), 1, std::sqrt(0.1f));
  const FrameLighting small = demo.relighting.light(demo.environment, 64, weighted + usual);
  const Image images[] = {
      resolve(buffer, demo.relighting.options().raster,
              shade(buffer, usual, demo.lighting[usual], {Lobes::sampled})),
      resolve(buffer, demo.relighting.options().raster, shade(buffer, weighted + usual, small, {})),
      resolve(buffer, demo.relighting.options().raster, shade_all_lights(buffer, small))};
  write_png(path, side_by_side(images), automatic_exposure(images[2], demo.relighting.direct().coverage));
}

}  // namespace
}  // namespace coppice::bench

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "highlights: takes one file to write: OUT.png\n");
    return 2;
  }
  coppice::bench::write_picture(argv[1]);
}
