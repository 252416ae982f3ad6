// The picture of docs/ after Cuts Fig. 10: the demo scene polished, by illumination cuts of growing size, and
// by all lights. First row: the paper's cuts with sampled lobes; third: the library's, refined; below each
// how far it is off, four times as bright. Prints the errors as a table. Usage: cut_sizes OUT.png
#include <array>
#include <coppice/embree/threads.hpp>
#include <coppice/exr/exposure.hpp>
#include <coppice/exr/write.hpp>
#include <coppice/trade/errors.hpp>
#include <cstdio>

#include "demo.hpp"

namespace coppice::bench {
namespace {

const Threads threads;

constexpr std::array<std::size_t, 4> sizes{64, 128, 256, 512};
constexpr float polish = 0.16f;  // GGX α of all that the camera sees
constexpr float amplification = 4;
constexpr int shown_width = 208;  // of each image: from the lamps' reflection to the helmet

struct Way {
  const char* name;
  std::size_t cuts;  // index into the demo's sets of visibility cuts
  LobeOptions lobes;
};
constexpr Way ways[]{{"the paper's cuts, sampled lobes", usual, {Lobes::sampled}},
                     {"weighted cuts, refined lobes", weighted + usual, {}}};

/// The demo scene in its own colours, and all of it as smooth as varnish.
class PolishedDemo {
 public:
  PolishedDemo() : demo_(Demo::get()), buffer_(demo_.relighting.buffer()) {
    for (ShadingPoint& p : buffer_.points) p.alpha_x = p.alpha_y = polish;
    const DenseLights lights(leaf_count(), demo_.lighting[usual]);
    reference_ = shade([&](std::size_t begin, std::size_t end, std::span<vec3> radiance) {
      shade_faces_brute_force<Skip::unseen>(buffer_, demo_.relighting.bits(), leaf_count(), lights, begin,
                                            end, radiance);
    });
  }

  Image image(const Way& way, std::size_t nodes) const {
    const FrameLighting frame = demo_.relighting.light(demo_.environment, nodes, way.cuts);
    return shade([&](std::size_t begin, std::size_t end, std::span<vec3> radiance) {
      shade_faces(buffer_, demo_.relighting.cuts(way.cuts), frame, way.lobes, begin, end, radiance, {});
    });
  }

  const Image& reference() const { return reference_; }
  const std::vector<float>& coverage() const { return demo_.relighting.direct().coverage; }

 private:
  std::uint32_t leaf_count() const { return demo_.relighting.tree().leaf_count(); }

  template <class ShadeFaces>
  Image shade(const ShadeFaces& shade_faces) const {
    std::vector<vec3> radiance(buffer_.points.size());
    threads(buffer_.faces.size(), 64,
            [&](std::size_t begin, std::size_t end) { shade_faces(begin, end, radiance); });
    return resolve(buffer_, demo_.relighting.options().raster, radiance);
  }

  Demo& demo_;
  ShadingBuffer buffer_;
  Image reference_;
};

Image difference(const Image& a, const Image& b) {
  Image result(a.width, a.height);
  for (std::size_t i = 0; i < result.pixels.size(); ++i)
    result.pixels[i] = amplification * glm::abs(a.pixels[i] - b.pixels[i]);
  return result;
}

/// The left of images of one size, in rows of sizes.size() + 1.
Image tiled(std::span<const Image> images) {
  const std::size_t columns = sizes.size() + 1;
  const int height = images[0].height;
  Image joined(shown_width * int(columns), height * int(images.size() / columns));
  for (std::size_t i = 0; i < images.size(); ++i) {
    const int left = int(i % columns) * shown_width, top = int(i / columns) * height;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < shown_width; ++x)
        joined.pixels[joined.index(left + x, top + y)] = images[i].pixels[images[i].index(x, y)];
  }
  return joined;
}

void print_row(const Way& way, std::size_t nodes, const ImageErrors& e) {
  std::printf("| %s | %zu | %.2f%% | %.2f%% | %.1f%% |\n", way.name, nodes, 100 * e.rel_rmse, 100 * e.mre,
              100 * e.p99);
}

void write_picture(const char* path) {
  const PolishedDemo demo;
  const Image& reference = demo.reference();
  std::vector<bool> counts(demo.coverage().size());
  for (std::size_t i = 0; i < counts.size(); ++i) counts[i] = demo.coverage()[i] > 0;
  std::vector<Image> images;
  std::printf("| cuts and lobes | illumination nodes | relRMSE | mre | p99 |\n|---|---|---|---|---|\n");
  for (const Way& way : ways) {
    const std::size_t row = images.size();
    for (const std::size_t nodes : sizes) {
      images.push_back(demo.image(way, nodes));
      print_row(way, nodes, image_errors(images.back(), reference, counts));
    }
    images.push_back(reference);
    for (std::size_t i = 0; i <= sizes.size(); ++i) images.push_back(difference(images[row + i], reference));
  }
  write_png(path, tiled(images), automatic_exposure(reference, demo.coverage()));
}

}  // namespace
}  // namespace coppice::bench

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "cut_sizes: takes one file to write: OUT.png\n");
    return 2;
  }
  coppice::bench::write_picture(argv[1]);
}
