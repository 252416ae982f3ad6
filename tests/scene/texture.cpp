// Texture values: where texels lie, how they blend, how they wrap, and how sRGB is decoded.
#include <doctest/doctest.h>

#include <cmath>
#include <coppice/scene/texture.hpp>
#include <vector>

#include "support/generators.hpp"

using namespace coppice;
using namespace test_support;

namespace {

Texture random_texture(Random& random, int width, int height) {
  Texture t{width, height, false, Wrap::repeat, Wrap::repeat, {}};
  t.rgba.resize(std::size_t(4 * width * height));
  for (auto& byte : t.rgba) byte = std::uint8_t(random.bits());
  return t;
}

vec4 texel_of(const Texture& t, int x, int y) {
  const std::uint8_t* p = &t.rgba[std::size_t(4 * (y * t.width + x))];
  return vec4(p[0], p[1], p[2], p[3]) / 255.0f;
}

vec2 centre_of(const Texture& t, int x, int y) {
  return {(float(x) + 0.5f) / float(t.width), (float(y) + 0.5f) / float(t.height)};
}

bool close_to(const vec4& a, const vec4& b) { return glm::length(a - b) < 2e-4f; }

/// One row of two texels, black and white, wrapped as said.
float black_and_white(Wrap wrap, float u) {
  const Texture t{2, 1, false, wrap, wrap, {0, 0, 0, 255, 255, 255, 255, 255}};
  return sample(t, {u, 0.5f}).x;
}

}  // namespace

TEST_CASE("at a texel's centre the value is the texel's, (0, 0) is the upper left") {
  Random random(1);
  for (const auto& [width, height] : {std::pair(1, 1), std::pair(2, 3), std::pair(16, 5)}) {
    const Texture t = random_texture(random, width, height);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) CHECK(close_to(sample(t, centre_of(t, x, y)), texel_of(t, x, y)));
  }
}

TEST_CASE("between four texels the value is their mean") {
  Random random(2);
  const Texture t = random_texture(random, 4, 4);
  const vec4 mean = (texel_of(t, 1, 1) + texel_of(t, 2, 1) + texel_of(t, 1, 2) + texel_of(t, 2, 2)) / 4.0f;
  CHECK(close_to(sample(t, {0.5f, 0.5f}), mean));
}

TEST_CASE("textures that repeat have period 1, mirrored ones are even and have period 2") {
  Random random(3);
  Texture t = random_texture(random, 5, 3);
  for (int i = 0; i < 200; ++i) {
    const vec2 uv(random.uniform(), random.uniform());
    t.wrap_u = t.wrap_v = Wrap::repeat;
    for (const vec2 period : {vec2(1, 0), vec2(0, -1), vec2(-3, 7)})
      CHECK(close_to(sample(t, uv), sample(t, uv + period)));
    t.wrap_u = t.wrap_v = Wrap::mirror;
    for (const vec2 period : {vec2(2, 0), vec2(0, -2), vec2(-4, 6)})
      CHECK(close_to(sample(t, uv), sample(t, uv + period)));
    CHECK(close_to(sample(t, uv), sample(t, {-uv.x, uv.y})));
    CHECK(close_to(sample(t, uv), sample(t, {uv.x, 2 - uv.y})));
  }
}

TEST_CASE("clamped textures go on as their edge") {
  Random random(4);
  Texture t = random_texture(random, 3, 3);
  t.wrap_u = t.wrap_v = Wrap::clamp;
  for (const float far : {0.0f, -0.01f, -5.0f, -1e30f}) {
    CHECK(close_to(sample(t, {far, 0.5f}), texel_of(t, 0, 1)));
    CHECK(close_to(sample(t, {0.5f, 1 - far}), texel_of(t, 1, 2)));
  }
}

TEST_CASE("at the edge a repeated texture blends with its other side, a mirrored or clamped one does not") {
  CHECK(black_and_white(Wrap::repeat, 0) == doctest::Approx(0.5));
  CHECK(black_and_white(Wrap::mirror, 0) == doctest::Approx(0));
  CHECK(black_and_white(Wrap::clamp, 0) == doctest::Approx(0));
  CHECK(black_and_white(Wrap::repeat, 1) == doctest::Approx(0.5));
  CHECK(black_and_white(Wrap::mirror, 1) == doctest::Approx(1));
  CHECK(black_and_white(Wrap::mirror, 1.25f) == doctest::Approx(1));
  CHECK(black_and_white(Wrap::mirror, 1.75f) == doctest::Approx(0));
  CHECK(black_and_white(Wrap::clamp, 1) == doctest::Approx(1));
}

TEST_CASE("each direction wraps in its own way") {
  Random random(5);
  Texture t = random_texture(random, 4, 4);
  t.wrap_v = Wrap::clamp;
  CHECK(close_to(sample(t, centre_of(t, 1, 0) + vec2(1, -3)), texel_of(t, 1, 0)));
}

TEST_CASE("sRGB is decoded before it is blended, alpha never is") {
  Texture t{2, 1, true, Wrap::clamp, Wrap::clamp, {0, 55, 188, 55, 255, 10, 188, 155}};
  const auto linear = [](double c) { return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4); };
  const vec4 left = sample(t, {0, 0.5f}), middle = sample(t, {0.5f, 0.5f}), right = sample(t, {1, 0.5f});
  CHECK(left.y == doctest::Approx(linear(55 / 255.0)));
  CHECK(left.z == doctest::Approx(linear(188 / 255.0)));
  CHECK(right.x == doctest::Approx(1));
  CHECK(right.y == doctest::Approx(linear(10 / 255.0)));
  CHECK(left.w == doctest::Approx(55 / 255.0));
  CHECK(middle.x == doctest::Approx(0.5));
  CHECK(middle.w == doctest::Approx(105 / 255.0));
}
