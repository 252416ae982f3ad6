// The picture of docs/tree.md, after Cuts Fig. 5: the clusters of the 9th level over the sphere of
// directions, for the demo scene. From left to right β = 0, 0.5, 1; above as seen from the front, below as
// seen from under the ground. Usage: light_clusters OUT.png
#include <coppice/core/random.hpp>
#include <coppice/exr/write.hpp>
#include <cstdio>

#include "betas.hpp"
#include "demo.hpp"

namespace coppice::bench {
namespace {

constexpr int level = 9, size = 300;
constexpr float betas[]{0, 0.5f, 1};

std::uint32_t nearest_light(std::span<const vec3> directions, const vec3& d) {
  std::uint32_t nearest = 0;
  float largest = -1;
  for (std::uint32_t l = 0; l < directions.size(); ++l)
    if (const float cosine = dot(directions[l], d); cosine > largest) largest = cosine, nearest = l;
  return nearest;
}

/// The light that each pixel of a sphere shows; none beside the sphere. `towards` the eye, unit.
std::vector<std::uint32_t> lights_of_pixels(std::span<const vec3> directions, const vec3& towards) {
  const vec3 right = normalize(cross(vec3(0, 1, 0), towards)), up = cross(towards, right);
  std::vector<std::uint32_t> lights(size * size, no_light);
  Threads()(lights.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const float x = (float(i % size) + 0.5f) / (0.48f * size) - 0.5f / 0.48f,
                  y = 0.5f / 0.48f - (float(i / size) + 0.5f) / (0.48f * size), z2 = 1 - x * x - y * y;
      if (z2 > 0) lights[i] = nearest_light(directions, x * right + y * up + std::sqrt(z2) * towards);
    }
  });
  return lights;
}

/// A colour for each light: that of its cluster.
std::vector<vec3> colours_of_lights(const LightTree& tree) {
  std::vector<vec3> colours(tree.light_count[1]);
  for (std::uint32_t leaf = 0; leaf < tree.leaf_count(); ++leaf) {
    Random random((std::uint64_t(leaf) << level) / tree.leaf_count() + 1);
    random.bits();
    const vec3 colour = vec3(0.03f) + 0.6f * vec3(random.uniform(), random.uniform(), random.uniform());
    if (tree.light_of_leaf[leaf] != no_light) colours[tree.light_of_leaf[leaf]] = colour;
  }
  return colours;
}

void write_picture(const char* path) {
  const CutRelighting<>& relighting = Demo::get().relighting;
  const PilotOptions options;
  const PilotVisibility pilot = pilot_visibility(relighting, options);
  Image picture(size * int(std::size(betas)), 2 * size, vec3(1));
  for (int row = 0; row < 2; ++row) {
    const auto lights =
        lights_of_pixels(relighting.directions(), normalize(vec3(0.3f, row == 0 ? 0.35f : -1.3f, 1)));
    for (int column = 0; column < int(std::size(betas)); ++column) {
      const auto colours = colours_of_lights(tree_for(relighting, pilot, betas[column], options));
      for (int i = 0; i < size * size; ++i)
        if (lights[std::size_t(i)] != no_light)
          picture.pixels[picture.index(column * size + i % size, row * size + i / size)] =
              colours[lights[std::size_t(i)]];
    }
  }
  write_png(path, picture, 1);
}

}  // namespace
}  // namespace coppice::bench

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "light_clusters: takes one file to write: OUT.png\n");
    return 2;
  }
  coppice::bench::write_picture(argv[1]);
}
