// Sampling that adapts to the image: its twin, what it may and may not interpolate, and extremes.
#include <doctest/doctest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <bit>
#include <coppice/gather/adaptive.hpp>
#include <coppice/reference/adaptive.hpp>
#include <cstring>
#include <limits>

#include "gather/views.hpp"
#include "support/executors.hpp"
#include "support/generators.hpp"

using namespace coppice;

namespace {

constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

/// Gathers from an image, and checks that it is asked as promised.
struct FromImage {
  const GBuffer& buffer;
  const Image& image;
  std::vector<std::size_t> batches;

  void operator()(std::span<const std::uint32_t> pixels, std::span<vec3> radiance) {
    REQUIRE(pixels.size() == radiance.size());
    CHECK(std::ranges::adjacent_find(pixels, std::greater_equal{}) == pixels.end());
    for (std::size_t k = 0; k < pixels.size(); ++k) {
      REQUIRE(buffer.pixels[pixels[k]].covered);
      radiance[k] = image.pixels[pixels[k]];
    }
    batches.push_back(pixels.size());
  }
};

template <class E = Serial>
AdaptiveImage sampled(const GBuffer& buffer, const Image& image, const AdaptiveOptions& options,
                      const E& executor = {}) {
  return sample_adaptively(buffer, options, FromImage{buffer, image, {}}, executor);
}

std::size_t covered_count(const GBuffer& buffer) {
  return std::size_t(std::ranges::count_if(buffer.pixels, [](const GBufferPixel& p) { return p.covered; }));
}

bool same_bits(const AdaptiveImage& a, const AdaptiveImage& b) {
  return a.samples == b.samples && a.steps == b.steps &&
         a.radiance.pixels.size() == b.radiance.pixels.size() &&
         std::memcmp(a.radiance.pixels.data(), b.radiance.pixels.data(),
                     a.radiance.pixels.size() * sizeof(vec3)) == 0;
}

AdaptiveOptions any_options() {
  AdaptiveOptions options;
  options.sampling = Sampling(*rc::gen::inRange(0, 3));
  options.step = 1 << *rc::gen::inRange(0, 6);
  options.epsilon = float(*rc::gen::element(0.0, 0.01, 0.07, 0.3, 2.0, 50.0));
  options.use_materials = *rc::gen::inRange(0, 2) == 1;
  options.diagonal = 10;
  return options;
}

/// A wall whose right part, from column `edge` on, is of another material.
GBuffer two_materials(int width, int height, int edge) {
  GBuffer buffer = support::wall_view(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = edge; x < width; ++x) buffer.pixels[buffer.index(x, y)].material = 1;
  return buffer;
}

std::vector<AdaptiveOptions> all_kinds() {
  return {AdaptiveOptions{}, paper_sampling(10), uniform_sampling(4)};
}

}  // namespace

TEST_CASE("sampling on grids is that of one pixel after the other, bit for bit") {
  std::size_t sampled_pixels = 0, covered = 0;
  CHECK(rc::check([&] {
    Random random = test_support::any_random();
    const GBuffer buffer = support::random_view(random, *rc::gen::inRange(1, 80), *rc::gen::inRange(1, 80));
    const Image image = support::random_radiance(random, buffer);
    const AdaptiveOptions options = any_options();
    const AdaptiveImage fast = sampled(buffer, image, options);
    const AdaptiveImage slow =
        reference::sample_adaptively(buffer, options, [&](std::uint32_t i) { return image.pixels[i]; });
    RC_ASSERT(same_bits(fast, slow));
    sampled_pixels += fast.samples, covered += covered_count(buffer);
  }));
  CHECK(sampled_pixels > covered / 10);  // neither rule was idle
  CHECK(sampled_pixels < covered / 10 * 9);
}

TEST_CASE("every covered pixel is sampled at most once, on its grid, a batch a grid") {
  Random random(3);
  const GBuffer buffer = support::random_view(random, 75, 61);
  const Image image = support::random_radiance(random, buffer);
  for (const AdaptiveOptions& options : all_kinds()) {
    FromImage gather{buffer, image, {}};
    const AdaptiveImage result = sample_adaptively(buffer, options, gather, Serial{});
    CHECK(gather.batches.size() <= std::size_t(std::countr_zero(unsigned(options.step)) + 1));
    std::size_t total = 0, marked = 0;
    for (const std::size_t n : gather.batches) total += n;
    for (int y = 0; y < buffer.height; ++y)
      for (int x = 0; x < buffer.width; ++x) {
        const std::size_t i = buffer.index(x, y);
        const int step = result.steps[i];
        if (step == 0) continue;
        ++marked;
        CHECK((x % step == 0 && y % step == 0));
        CHECK((step == options.step || x % (2 * step) != 0 || y % (2 * step) != 0));
        CHECK(result.radiance.pixels[i] == image.pixels[i]);
      }
    CHECK(total == result.samples);
    CHECK(marked == result.samples);
  }
}

TEST_CASE("constant light is reconstructed exactly, and on a plane from the first grid alone") {
  const GBuffer wall = support::wall_view(49, 33);
  const Image image(49, 33, vec3(0.3f, 7, 1e-5f));
  for (const AdaptiveOptions& options : all_kinds()) {
    const AdaptiveImage result = sampled(wall, image, options);
    CHECK(result.radiance.pixels == image.pixels);
    if (options.sampling != Sampling::paper)
      CHECK(result.samples == std::size_t((48 / options.step + 1) * (32 / options.step + 1)));
  }
  Random random(4);
  GBuffer clutter = support::random_view(random, 49, 33);
  for (GBufferPixel& p : clutter.pixels) p.albedo = vec3(1);
  for (const AdaptiveOptions& options : all_kinds()) {
    const AdaptiveImage result = sampled(clutter, image, options);
    CHECK(result.samples < covered_count(clutter));
    for (std::size_t i = 0; i < clutter.pixels.size(); ++i)
      CHECK(result.radiance.pixels[i] == (clutter.pixels[i].covered ? image.pixels[i] : vec3(0)));
  }
}

TEST_CASE("where epsilon is zero every covered pixel is sampled") {
  Random random(5);
  const GBuffer wall = support::wall_view(40, 23), clutter = support::random_view(random, 40, 23);
  const Image black(40, 23), image = support::random_radiance(random, clutter);
  for (AdaptiveOptions options : {AdaptiveOptions{}, paper_sampling(10)}) {
    options.epsilon = 0;
    CHECK(sampled(wall, black, options).samples == 40 * 23);
    const AdaptiveImage result = sampled(clutter, image, options);
    CHECK(result.samples == covered_count(clutter));
    for (std::size_t i = 0; i < clutter.pixels.size(); ++i)
      if (clutter.pixels[i].covered) CHECK(result.radiance.pixels[i] == image.pixels[i]);
  }
}

TEST_CASE("a larger epsilon samples fewer pixels") {
  Random random(6);
  const GBuffer buffer = support::random_view(random, 90, 70);
  const Image image = support::random_radiance(random, buffer);
  for (AdaptiveOptions options : {AdaptiveOptions{}, paper_sampling(10)}) {
    std::size_t last = covered_count(buffer) + 1;
    for (const float factor : {0.1f, 1.0f, 3.0f}) {
      AdaptiveOptions scaled = options;
      scaled.epsilon *= factor;
      const std::size_t samples = sampled(buffer, image, scaled).samples;
      CHECK(samples < last);
      last = samples;
    }
  }
}

TEST_CASE("a plane at a grazing angle is coherent, but not to the paper's estimate") {
  const GBuffer floor = support::floor_view(81, 65);
  const Image image(81, 65, vec3(1));
  CHECK(sampled(floor, image, AdaptiveOptions{}).samples == 6 * 5);
  CHECK(sampled(floor, image, paper_sampling(300)).samples > 2 * 6 * 5);
}

TEST_CASE("light does not cross the edge of a material") {
  constexpr int edge = 20;
  const GBuffer buffer = two_materials(65, 33, edge);
  Image image(65, 33, vec3(1));
  for (int y = 0; y < 33; ++y)
    for (int x = edge; x < 65; ++x) image.at(x, y) = vec3(5, 3, 2);
  AdaptiveOptions options;
  const AdaptiveImage kept = sampled(buffer, image, options);
  CHECK(kept.radiance.pixels == image.pixels);
  CHECK(kept.samples < 65 * 33 / 4);
  for (int y = 0; y < 33; y += 4)
    CHECK(kept.steps[buffer.index(edge, y)] == 4);  // half its parents are too few
  options.use_materials = false;
  options.epsilon = 10;
  CHECK(sampled(buffer, image, options).radiance.pixels != image.pixels);
  options.use_materials = true;
  CHECK(sampled(buffer, image, options).radiance.pixels == image.pixels);
}

TEST_CASE("pixels whose parents are of other surfaces are sampled, whatever epsilon is") {
  GBuffer buffer = support::wall_view(33, 33);
  const std::size_t turned = buffer.index(8, 8), before = buffer.index(24, 24), other = buffer.index(5, 20);
  buffer.pixels[turned].normal = vec3(1, 0, 0);
  buffer.pixels[before].position *= 0.5f;
  buffer.pixels[other].material = 7;
  AdaptiveOptions options;
  options.epsilon = 1e6f;
  const AdaptiveImage result = sampled(buffer, Image(33, 33, vec3(1)), options);
  CHECK(result.steps[turned] == 8);
  CHECK(result.steps[before] == 8);
  CHECK(result.steps[other] == 1);
}

TEST_CASE("pixels that nothing covers are not asked for, stay black and give nothing") {
  GBuffer buffer = support::wall_view(50, 40);
  Image image(50, 40, vec3(2));
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 50; ++x)
      if ((x / 5 + y / 7) % 3 == 0) {
        buffer.pixels[buffer.index(x, y)] = {vec3(not_a_number), 0, vec3(not_a_number), false,
                                             vec3(not_a_number)};
        image.at(x, y) = vec3(not_a_number);
      }
  for (const AdaptiveOptions& options : all_kinds()) {
    const AdaptiveImage result = sampled(buffer, image, options);
    for (std::size_t i = 0; i < buffer.pixels.size(); ++i) {
      CHECK(result.radiance.pixels[i] == (buffer.pixels[i].covered ? vec3(2) : vec3(0)));
      if (!buffer.pixels[i].covered) CHECK(result.steps[i] == 0);
    }
  }
  for (GBufferPixel& p : buffer.pixels) p.covered = false;
  for (const AdaptiveOptions& options : all_kinds()) CHECK(sampled(buffer, image, options).samples == 0);
}

TEST_CASE("images of one pixel, one row, one column and none") {
  for (const auto& [width, height] : {std::pair{1, 1}, {1, 37}, {37, 1}, {2, 2}, {15, 17}}) {
    const GBuffer wall = support::wall_view(width, height);
    const Image image(width, height, vec3(0.5f));
    for (const AdaptiveOptions& options : all_kinds()) {
      const AdaptiveImage result = sampled(wall, image, options);
      CHECK(result.steps[0] == options.step);
      CHECK(result.radiance.pixels == image.pixels);
    }
  }
  for (const AdaptiveOptions& options : all_kinds())
    CHECK(sampled(support::wall_view(0, 0), Image(), options).samples == 0);
}

TEST_CASE("exposure changes the samples of the paper's estimate, not of ours") {
  Random random(8);
  for (int trial = 0; trial < 10; ++trial) {
    const GBuffer buffer = support::random_view(random, 80, 60);
    const Image image = support::random_radiance(random, buffer);
    const auto steps = [&](float exposure, const AdaptiveOptions& options) {
      Image exposed = image;
      for (vec3& p : exposed.pixels) p *= exposure;
      return sampled(buffer, exposed, options).steps;
    };
    for (const float exposure : {0x1p-20f, 1e-6f, 1e6f, 0x1p60f}) CHECK(steps(exposure, {}) == steps(1, {}));
    CHECK(steps(1e6f, paper_sampling(10)) != steps(1, paper_sampling(10)));
    CHECK(steps(1e-6f, paper_sampling(10)) != steps(1, paper_sampling(10)));
  }
}

TEST_CASE("any executor gives the same bits") {
  Random random(9);
  const GBuffer buffer = support::random_view(random, 130, 90);
  const Image image = support::random_radiance(random, buffer);
  for (const AdaptiveOptions& options : all_kinds()) {
    const AdaptiveImage serial = sampled(buffer, image, options);
    CHECK(same_bits(serial, sampled(buffer, image, options, support::Backwards{1})));
    CHECK(same_bits(serial, sampled(buffer, image, options, support::Backwards{5})));
    CHECK(same_bits(serial, sampled(buffer, image, options, support::TwoThreads{})));
  }
}

TEST_CASE("albedo is divided out, and albedo near zero does no harm") {
  GBuffer buffer = support::wall_view(65, 49);
  Random random(10);
  Image image(65, 49);
  const std::array<float, 5> values{0, 1e-42f, 1e-5f, 0.2f, 1};
  for (std::size_t i = 0; i < buffer.pixels.size(); ++i) {
    for (int c = 0; c < 3; ++c) buffer.pixels[i].albedo[c] = values[random.below(5)];
    image.pixels[i] = buffer.pixels[i].albedo * vec3(2, 3, 4);
  }
  for (const AdaptiveOptions& options : {AdaptiveOptions{}, uniform_sampling(4)}) {
    const AdaptiveImage result = sampled(buffer, image, options);
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
      for (int c = 0; c < 3; ++c) {
        const float floored = std::max(buffer.pixels[i].albedo[c], 1e-3f);
        CHECK(result.radiance.pixels[i][c] >= 0);
        CHECK(result.radiance.pixels[i][c] <= 4.001f * floored);
      }
  }
  for (std::size_t i = 0; i < buffer.pixels.size(); ++i) {
    buffer.pixels[i].albedo = glm::max(buffer.pixels[i].albedo, vec3(0.01f));
    image.pixels[i] = buffer.pixels[i].albedo * vec3(2, 3, 4);
  }
  const AdaptiveImage result = sampled(buffer, image, AdaptiveOptions{});
  CHECK(result.samples == 5 * 4);
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    for (int c = 0; c < 3; ++c)
      CHECK(result.radiance.pixels[i][c] == doctest::Approx(image.pixels[i][c]).epsilon(1e-5));
}

TEST_CASE("NaN and infinity that are gathered stay, and are not interpolated from unless told to be") {
  const GBuffer buffer = support::wall_view(49, 49);
  for (const float bad : {not_a_number, std::numeric_limits<float>::infinity()}) {
    Image image(49, 49, vec3(1));
    image.at(16, 16) = vec3(1, bad, 1);
    for (const AdaptiveOptions& options : {AdaptiveOptions{}, paper_sampling(10)}) {
      const AdaptiveImage result = sampled(buffer, image, options);
      for (int y = 0; y < 49; ++y)
        for (int x = 0; x < 49; ++x) CHECK(is_finite(result.radiance.at(x, y)) == (x != 16 || y != 16));
      for (const int k : {8, 24}) CHECK(result.steps[buffer.index(k, 16)] == 8);
      CHECK(result.samples < 49 * 49 / 4);  // only its neighbours are
    }
    const AdaptiveImage uniform = sampled(buffer, image, uniform_sampling(16));
    CHECK(!is_finite(uniform.radiance.at(16, 16)));
    CHECK(!is_finite(uniform.radiance.at(20, 12)));
    CHECK(is_finite(uniform.radiance.at(40, 40)));
  }
}

TEST_CASE("uniform sampling takes every so many pixels, and is exact for linear light on a plane") {
  const GBuffer buffer = support::wall_view(45, 29);
  Image image(45, 29);
  for (int y = 0; y < 29; ++y)
    for (int x = 0; x < 45; ++x) image.at(x, y) = vec3(float(x), float(y), float(2 * x + y + 1));
  for (const int step : {1, 2, 4}) {
    const AdaptiveImage result = sampled(buffer, image, uniform_sampling(step));
    CHECK(result.samples == std::size_t((44 / step + 1) * (28 / step + 1)));
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
      for (int c = 0; c < 3; ++c)
        CHECK(result.radiance.pixels[i][c] == doctest::Approx(image.pixels[i][c]).epsilon(1e-4));
  }
}
