// The orientation of environment maps, against directions worked out by hand, and the sizes of their texels.
#include <doctest/doctest.h>

#include <coppice/core/random.hpp>
#include <coppice/light/environment.hpp>
#include <numbers>

using namespace coppice;

namespace {

/// A map whose texel (x, y) has the radiance (x, y, 1).
Image numbered(int width, int height) {
  Image map(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) map.at(x, y) = vec3(x, y, 1);
  return map;
}

vec3 at_degrees(double azimuth, double elevation) {
  const double a = azimuth * std::numbers::pi / 180, e = elevation * std::numbers::pi / 180;
  return vec3(glm::dvec3(std::cos(e) * std::cos(a), std::sin(e), std::cos(e) * std::sin(a)));
}

constexpr float quarter_turn = pi / 2;

}  // namespace

TEST_CASE("+X is the centre of the image, +Z a quarter to its right, +Y the top row") {
  const Environment environment{numbered(8, 4), 0};
  CHECK(radiance(environment, at_degrees(1, -1)) == vec3(4, 2, 1));    // just right of and below the centre
  CHECK(radiance(environment, at_degrees(-1, 1)) == vec3(3, 1, 1));    // just left of and above it
  CHECK(radiance(environment, at_degrees(91, 1)) == vec3(6, 1, 1));    // u = 3/4
  CHECK(radiance(environment, at_degrees(-91, 1)) == vec3(1, 1, 1));   // u = 1/4
  CHECK(radiance(environment, at_degrees(179, 1)) == vec3(7, 1, 1));   // the right edge
  CHECK(radiance(environment, at_degrees(-179, 1)) == vec3(0, 1, 1));  // the left edge
  CHECK(radiance(environment, vec3(0, 1, 0)).y == 0);
  CHECK(radiance(environment, vec3(0, -1, 0)).y == 3);
  CHECK(radiance(environment, at_degrees(10, 46)) == vec3(4, 0, 1));
  CHECK(radiance(environment, at_degrees(10, 44)) == vec3(4, 1, 1));
}

TEST_CASE("texel directions follow the same convention") {
  CHECK(length(texel_direction(4, 2, 8, 4) - at_degrees(22.5, -22.5)) < 1e-6f);
  CHECK(length(texel_direction(0, 0, 8, 4) - at_degrees(-157.5, 67.5)) < 1e-6f);
  CHECK(length(texel_direction(7, 3, 8, 4) - at_degrees(157.5, -67.5)) < 1e-6f);
  CHECK(length(texel_direction(0, 0, 1, 1) - vec3(1, 0, 0)) < 1e-6f);
}

TEST_CASE("a texel's direction looks up that texel") {
  for (const auto& [width, height] :
       {std::pair(1, 1), std::pair(3, 2), std::pair(64, 32), std::pair(7, 301)}) {
    const Environment environment{numbered(width, height), 0};
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const vec3 d = texel_direction(x, y, width, height);
        REQUIRE(std::abs(length(d) - 1) < 3e-7f);
        REQUIRE(radiance(environment, d) == vec3(x, y, 1));
      }
  }
}

TEST_CASE("turning the map by a quarter takes what was at +X to -Z, and leaves the poles") {
  const Environment environment{numbered(8, 4), quarter_turn};
  CHECK(radiance(environment, at_degrees(-89, 1)) == vec3(4, 1, 1));  // -Z sees the centre of the image
  CHECK(radiance(environment, at_degrees(1, 1)) == vec3(6, 1, 1));    // +X sees what was at +Z
  CHECK(radiance(environment, vec3(0, 1, 0)).y == 0);
}

TEST_CASE("whole turns change nothing, negative turns are the inverse") {
  Random random(1);
  const Image map = numbered(16, 8);
  for (int i = 0; i < 500; ++i) {
    const float azimuth = 360 * random.uniform() - 180, elevation = 170 * random.uniform() - 85;
    const vec3 d = at_degrees(double(azimuth), double(elevation));
    // Away from the texels' edges, where rounding decides.
    const float column = (azimuth + 180) / 22.5f;
    if (std::abs(column - std::round(column)) < 0.01f) continue;
    CHECK(radiance({map, 4 * quarter_turn}, d) == radiance({map, 0}, d));
    CHECK(radiance({map, -8 * quarter_turn}, d) == radiance({map, 0}, d));
    CHECK(radiance({map, -quarter_turn}, d) == radiance({map, 3 * quarter_turn}, d));
  }
}

TEST_CASE("every direction looks up some texel, on the seam and at the poles too") {
  const Environment environment{numbered(5, 3), 0.1f};
  Random random(2);
  for (int i = 0; i < 10000; ++i) REQUIRE(radiance(environment, random.direction()).z == 1);
  for (const vec3& d :
       {vec3(-1, 0, 0.0f), vec3(-1, 0, -0.0f), vec3(0, 1, 0), vec3(0, -1, 0), vec3(0, 1.0000001f, 0)})
    CHECK(radiance(environment, d).z == 1);
}

TEST_CASE("texels' solid angles add up to the sphere and have their closed form") {
  for (const auto& [width, height] :
       {std::pair(1, 1), std::pair(3, 2), std::pair(64, 32), std::pair(1024, 512)}) {
    double sum = 0;
    for (int y = 0; y < height; ++y) sum += width * texel_solid_angle(y, width, height);
    CHECK(std::abs(sum - 4 * std::numbers::pi) < 1e-11);
  }
  CHECK(texel_solid_angle(0, 4, 2) == doctest::Approx(std::numbers::pi / 2));
  CHECK(texel_solid_angle(1, 4, 4) == doctest::Approx(std::numbers::pi / 2 * std::sqrt(0.5)));
}
