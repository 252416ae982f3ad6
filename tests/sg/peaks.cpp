// Peaks: regions on the sphere against flooding, and Gaussians of the right place, width and energy.
#include <doctest/doctest.h>

#include <coppice/light/directions.hpp>
#include <coppice/reference/environment_fit.hpp>
#include <coppice/sg/peaks.hpp>

#include "support/generators.hpp"

using namespace coppice;
using namespace test_support;

namespace {

double mean_luminance(const Image& map) {
  double sum = 0;
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x)
      sum += texel_solid_angle(y, map.width, map.height) * double(luminance(map.at(x, y)));
  return sum / (4 * std::numbers::pi);
}

std::vector<SgLight> peaks_of(const Image& map, const PeakOptions& options = {}) {
  return find_peaks(map, mean_luminance(map), options);
}

/// 1 in the texels within `radius` radians of a direction, `background` elsewhere.
Image disc(int width, int height, const vec3& centre, float radius, float background = 0) {
  Image map(width, height, vec3(background));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (dot(texel_direction(x, y, width, height), centre) > std::cos(radius)) map.at(x, y) = vec3(1);
  return map;
}

double angle_between(const vec3& a, const vec3& b) {
  const glm::dvec3 u(a), v(b);
  return std::atan2(glm::length(glm::cross(u, v)), glm::dot(u, v));
}

}  // namespace

TEST_CASE("bright regions are those that flooding finds, on the seam and at the poles too") {
  rc::check([] {
    Random random = any_random();
    const int width = *rc::gen::inRange(1, 30), height = *rc::gen::inRange(1, 20);
    const float share = random.uniform();
    Image map(width, height);
    for (vec3& pixel : map.pixels) pixel = vec3(random.uniform() < share ? 2.0f : 0.5f);
    const std::vector<std::uint32_t> expected = reference::flood_regions(map, 1);
    const BrightRegions regions = bright_regions(map, 1);
    std::vector<std::uint32_t> labels(map.pixels.size(), 0);
    for (const BrightRun& run : regions.runs)
      for (int x = run.begin; x < run.end; ++x) labels[map.index(x, run.row)] = run.region + 1;
    RC_ASSERT(labels == expected);
    RC_ASSERT(regions.count == *std::max_element(expected.begin(), expected.end()));
  });
}

TEST_CASE("a spot across the seam, or about a pole, is one region") {
  const Image seam = disc(64, 32, vec3(-1, 0, 0), 0.3f), pole = disc(64, 32, vec3(0, 1, 0), 0.3f);
  CHECK(bright_regions(seam, 0.5f).count == 1);
  CHECK(bright_regions(pole, 0.5f).count == 1);
  Image opposite(64, 32);
  opposite.at(0, 31) = opposite.at(32, 31) = vec3(1);  // half a turn apart, and next to each other
  CHECK(bright_regions(opposite, 0.5f).count == 1);
  opposite.at(0, 31) = vec3(0);
  opposite.at(0, 10) = opposite.at(63, 11) = vec3(1);  // across a corner of the seam
  CHECK(bright_regions(opposite, 0.5f).count == 2);
}

TEST_CASE("an even disc gives one Gaussian of its place, energy and second moment, wherever it lies") {
  for (const vec3& centre : {vec3(1, 0, 0), vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, -1, 0),
                             normalize(vec3(-1, 0.5f, 0.01f)), normalize(vec3(0.1f, 1, 0.1f))}) {
    const Image map = disc(512, 256, centre, 0.2f);
    const auto peaks = peaks_of(map);
    REQUIRE(peaks.size() == 1);
    CHECK(angle_between(peaks[0].axis, centre) < 2e-3);
    CHECK(close(sg_energy(peaks).x, 4 * std::numbers::pi * mean_luminance(map), 1e-6));
    CHECK(peaks[0].sharpness == doctest::Approx(4 / (0.2 * 0.2)).epsilon(0.06));  // 1/λ = radius²/4
  }
}

TEST_CASE("a sun of one texel has that texel's place, energy and width") {
  for (const int y : {0, 3, 63, 127}) {
    Image map(256, 128, vec3(1));
    map.at(255, y) = vec3(1e5f, 9e4f, 8e4f);
    const auto peaks = peaks_of(map, {8, 32, 1});
    REQUIRE(peaks.size() == 1);
    const double area = texel_solid_angle(y, 256, 128);
    CHECK(angle_between(peaks[0].axis, texel_direction(255, y, 256, 128)) < 1e-6);
    CHECK(close(sg_energy(peaks).y, 9e4 * area, 1e-6));
    CHECK(1 / double(peaks[0].sharpness) < std::numbers::pi * std::numbers::pi / (128 * 128 * 12.0) * 1.01);
    CHECK(1 / double(peaks[0].sharpness) > std::numbers::pi * std::numbers::pi / (128 * 128 * 24.0));
  }
}

TEST_CASE("a long light gets two or three Gaussians along it, which keep its energy") {
  const auto bar = [](int half_length) {
    Image map(512, 256);
    for (int x = 256 - half_length; x < 256 + half_length; ++x)
      for (int y = 124; y < 132; ++y) map.at(x, y) = vec3(1, 2, 3);
    return map;
  };
  CHECK(peaks_of(bar(4)).size() == 1);
  CHECK(peaks_of(bar(8)).size() == 2);
  const auto three = peaks_of(bar(40));
  REQUIRE(three.size() == 3);
  CHECK(three[0].axis.z < -0.2f);
  CHECK(std::abs(three[1].axis.z) < 0.02f);
  CHECK(three[2].axis.z > 0.2f);
  CHECK(close(sg_energy(three).z, 3 * 4 * std::numbers::pi * mean_luminance(bar(40)) / 1.8596, 1e-4));
  CHECK(peaks_of(bar(40), {8, 32, 2}).size() == 2);
  CHECK(peaks_of(bar(40), {8, 32, 1}).size() == 1);
}

TEST_CASE("there are never more Gaussians than asked for, and the strongest come first") {
  rc::check([] {
    Random random = any_random();
    const Image map = random_map(random, 40, 20);
    const std::size_t most = *rc::gen::inRange<std::size_t>(0, 12);
    const auto all = peaks_of(map, {2, 1000, 1}), some = peaks_of(map, {2, most, 1});
    RC_ASSERT(some.size() == std::min(most, all.size()));
    for (std::size_t i = 0; i < some.size(); ++i) RC_ASSERT(some[i].amplitude == all[i].amplitude);
    for (std::size_t i = 1; i < all.size(); ++i)
      RC_ASSERT(all[i].luminance <= all[i - 1].luminance * 1.00001f);
    RC_ASSERT(peaks_of(map, {2, most, 3}).size() <= most);
  });
}

TEST_CASE("black and even maps have no peaks, and one of 1e30 has finite ones") {
  CHECK(peaks_of(Image(1, 1)).empty());
  CHECK(peaks_of(Image(1, 1, vec3(3))).empty());
  CHECK(peaks_of(Image(64, 32)).empty());
  CHECK(peaks_of(Image(64, 32, vec3(1e30f))).empty());
  Image map(64, 32, vec3(1e-30f));
  map.at(5, 5) = vec3(1e30f);
  const auto peaks = peaks_of(map);
  REQUIRE(peaks.size() == 1);
  CHECK(is_finite(peaks[0].amplitude));
  CHECK(close(sg_energy(peaks).x, 1e30 * texel_solid_angle(5, 64, 32), 1e-6));
}
