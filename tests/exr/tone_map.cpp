#include <doctest/doctest.h>

#include <bit>
#include <coppice/exr/exposure.hpp>
#include <coppice/exr/tone_map.hpp>
#include <cstdint>
#include <limits>
#include <vector>

using namespace coppice;

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();
constexpr float largest = std::numeric_limits<float>::max();

bool in_unit_range(float x) { return x >= 0 && x <= 1; }

}  // namespace

TEST_CASE("the tone curve rises from 0 to 1 over all floats") {
  float before = 0;
  for (std::uint32_t bits = 0; bits <= std::bit_cast<std::uint32_t>(infinity); bits += 4099) {
    const float shown = filmic(std::bit_cast<float>(bits));
    REQUIRE(in_unit_range(shown));
    REQUIRE(in_unit_range(srgb_encode(shown)));
    REQUIRE(shown >= before - 1.2e-7f);
    before = shown;
  }
  CHECK(filmic(0) == 0);
  CHECK(filmic(7.2f) < 1);
  CHECK(filmic(7.25f) == 1);
  CHECK(filmic(0.18f) == doctest::Approx(0.18 * (2.51 * 0.18 + 0.03) / (0.18 * (2.43 * 0.18 + 0.59) + 0.14)));
}

TEST_CASE("the tone map is total") {
  CHECK(tone_map(vec3(1e30f, infinity, largest), 1) == vec3(1));
  CHECK(tone_map(vec3(1e30f, infinity, largest), 1e30f) == vec3(1));
  CHECK(tone_map(vec3(not_a_number, -1, -infinity), 1) == vec3(0));
  const float values[] = {not_a_number, infinity, -infinity, 0,       -0.0f, 1e-45f, 1,
                          -1,           1e30f,    largest,   -largest};
  for (const float value : values)
    for (const float exposure : values) {
      CAPTURE(value);
      CAPTURE(exposure);
      CHECK(in_unit_range(tone_map(vec3(value), exposure).x));
    }
}

TEST_CASE("the sRGB encoding passes through the standard's values and is continuous") {
  CHECK(srgb_encode(0) == 0);
  CHECK(srgb_encode(1) == doctest::Approx(1));
  CHECK(srgb_encode(0.2140411f) == doctest::Approx(0.5));
  CHECK(srgb_encode(0.0031308f) == doctest::Approx(srgb_encode(0.00313081f)).epsilon(1e-4));
}

TEST_CASE("the automatic exposure brings the geometric mean of covered pixels to middle grey") {
  Image image(2, 2);
  image.pixels = {vec3(0.5f), vec3(8), vec3(0), vec3(1e30f)};
  CHECK(automatic_exposure(image, std::vector<float>{1, 1, 1, 0}) == doctest::Approx(0.18 / 2));
  CHECK(automatic_exposure(image, std::vector<float>{1, 0.5f, 0, 0}, 0.5f) == doctest::Approx(0.25));
  image.pixels[3] = vec3(2);
  CHECK(automatic_exposure(image) == doctest::Approx(0.18 / 2));
}

TEST_CASE("the automatic exposure is positive and finite whatever the image holds") {
  CHECK(automatic_exposure(Image()) == 1);
  for (const float value : {0.0f, -1.0f, not_a_number, infinity})
    CHECK(automatic_exposure(Image(3, 3, vec3(value))) == 1);
  for (const float value : {1e-45f, 1e-38f, 1e30f, 3e38f, largest}) {
    const float exposure = automatic_exposure(Image(3, 3, vec3(value)));
    CHECK(exposure > 0);
    CHECK(std::isfinite(exposure));
  }
}
