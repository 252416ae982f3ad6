// Weights between pixels and estimates of error, against their definitions written out.
#include <doctest/doctest.h>

#include <coppice/gather/coherence.hpp>

#include "gather/views.hpp"

using namespace coppice;

namespace {

GBufferPixel pixel(vec3 position, vec3 normal, std::uint32_t material = 0) {
  return {position, material, normal, true, vec3(1)};
}

}  // namespace

TEST_CASE("the bilateral weight is that of its definition") {
  Random random(1);
  const GBuffer buffer = support::empty_view(1, 1, 0.02f);
  for (int trial = 0; trial < 1000; ++trial) {
    const vec3 n = random.direction();
    const GBufferPixel a = pixel(vec3(0, 0, -3) + 0.1f * random.direction(), n);
    const GBufferPixel b = pixel(vec3(0, 0, -3) + 0.1f * random.direction(),
                                 normalize(n + 0.3f * random.uniform() * random.direction()), 1);
    const int step = 1 << random.below(5);
    const double cosine = dot(glm::dvec3(a.normal), glm::dvec3(b.normal));
    const double across = dot(glm::dvec3(n), glm::dvec3(b.position) - glm::dvec3(a.position));
    const double h = across / (0.02 * length(glm::dvec3(a.position)) * step) / 2;
    const double expected = std::pow(cosine, 64) / (1 + h * h);
    CHECK(double(bilateral_weight(buffer, a, b, step, false)) == doctest::Approx(expected).epsilon(1e-4));
    CHECK(bilateral_weight(buffer, a, b, step, true) == 0);
  }
  const GBufferPixel a = pixel(vec3(0, 0, -3), vec3(0, 0, 1)), back = pixel(vec3(0, 0, -3), vec3(0, 0, -1));
  CHECK(bilateral_weight(buffer, a, a, 1, true) == 1);
  CHECK(bilateral_weight(buffer, a, back, 1, true) == 0);
}

TEST_CASE("parents are those half way to the coarser grid, as far as they are there") {
  GBuffer buffer = support::wall_view(11, 9);
  const auto at = [&](int x, int y) { return std::uint32_t(buffer.index(x, y)); };
  const Parents amid = parents_of(buffer, 2, 6, 2);
  CHECK(amid.count == 4);
  CHECK(amid.places == 4);
  CHECK(amid.pixels == std::array<std::uint32_t, 4>{at(0, 4), at(4, 4), at(0, 8), at(4, 8)});
  const Parents between = parents_of(buffer, 4, 6, 2);
  CHECK(between.count == 2);
  CHECK(between.places == 2);
  CHECK((between.pixels[0] == at(4, 4) && between.pixels[1] == at(4, 8)));
  const Parents at_border = parents_of(buffer, 10, 6, 2);
  CHECK(at_border.count == 2);
  CHECK(at_border.places == 4);
  CHECK((at_border.pixels[0] == at(8, 4) && at_border.pixels[1] == at(8, 8)));
  buffer.pixels[at(4, 4)].covered = false;
  CHECK(parents_of(buffer, 2, 6, 2).count == 3);
}

TEST_CASE("interpolation weighs parents by their likeness, and all alike where none is") {
  GBuffer buffer = support::wall_view(3, 1);
  const std::array<vec3, 3> light{vec3(1), vec3(0), vec3(5)};
  const auto middle = [&] { return interpolate(buffer, 1, parents_of(buffer, 1, 0, 1), 1, true, light); };
  CHECK(middle().light.x == doctest::Approx(3));
  CHECK(middle().share == doctest::Approx(1));
  buffer.pixels[2].normal = vec3(std::sin(0.2f), 0, std::cos(0.2f));
  const float weight = std::pow(std::cos(0.2f), 64.0f);
  CHECK(middle().light.x == doctest::Approx((1 + 5 * weight) / (1 + weight)).epsilon(1e-4));
  CHECK(middle().share == doctest::Approx((1 + weight) / 2).epsilon(1e-4));
  buffer.pixels[2].material = 1;
  CHECK(middle().light.x == 1);
  buffer.pixels[0].material = 1;
  CHECK(middle().light.x == 3);
  CHECK(middle().share == 0);
}

TEST_CASE("the paper's estimate has its two terms") {
  GBuffer buffer = support::empty_view(3, 3);
  buffer.pixels[4] = pixel(vec3(0, 0, -4), vec3(0, 0, 1));
  CHECK(detail::paper_geometry_error(buffer, 1, 1, 1, 10) == 0);
  buffer.pixels[1] = pixel(vec3(0, 3, -4), vec3(0, 0, 1));
  CHECK(detail::paper_geometry_error(buffer, 1, 1, 1, 10) == doctest::Approx(3.0 / 5));
  buffer.pixels[3] = pixel(vec3(1, 0, -4), vec3(0, 1, 0));
  CHECK(detail::paper_geometry_error(buffer, 1, 1, 1, 10) == doctest::Approx(0.2 + std::sqrt(2.0)));
  const Parents parents{.pixels = {0, 1, 2, 3}, .count = 4, .places = 4};
  const std::array<float, 4> values{1, 2, 4, 8};
  const auto radiance = [&](std::size_t p) { return vec3(values[p]); };
  CHECK(detail::paper_light_error(parents, radiance) == doctest::Approx(1 + 3 + 7 + 2 + 6 + 4));
}

TEST_CASE("geometry counts by angle and by distance from the plane, not along it") {
  GBuffer buffer = support::empty_view(3, 1, 0.1f);
  buffer.pixels[1] = pixel(vec3(0, 0, -10), vec3(0, 0, 1));
  buffer.pixels[0] = pixel(vec3(-50, 0, -10), vec3(0, 0, 1));
  CHECK(detail::relative_geometry_error(buffer, 1, 0, 1) == 0);
  buffer.pixels[2] = pixel(vec3(1, 0, -10.25f), vec3(0, 0, 1));  // the footprint is 1
  CHECK(detail::relative_geometry_error(buffer, 1, 0, 1) == doctest::Approx(0.025));
  buffer.pixels[2].position.z = -200;
  CHECK(detail::relative_geometry_error(buffer, 1, 0, 1) == doctest::Approx(0.1));
  buffer.pixels[2] = pixel(vec3(1, 0, -10), vec3(0, 1, 0));
  CHECK(detail::relative_geometry_error(buffer, 1, 0, 1) == doctest::Approx(0.1 * std::sqrt(2.0)));
}

TEST_CASE("light bends where its second difference is, on one surface") {
  GBuffer buffer = support::wall_view(5, 5);
  std::vector<vec3> light(25);
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 5; ++x) light[buffer.index(x, y)] = vec3(float(x), float(x * x), float(y * y * 3));
  const auto bend = [&](int x, int y) { return detail::bend_of_light(buffer, x, y, 1, true, light); };
  CHECK(bend(2, 2) == vec3(0, 2, 6));
  CHECK(bend(0, 2) == vec3(0, 0, 6));
  CHECK(bend(0, 0) == vec3(0));
  buffer.pixels[buffer.index(2, 1)].material = 1;
  CHECK(bend(2, 2) == vec3(0, 2, 0));
  buffer.pixels[buffer.index(3, 2)].normal = vec3(1, 0, 0);
  CHECK(bend(2, 2) == vec3(0));
}

TEST_CASE("light changes by half its spread and by its bends, over parents with some weight") {
  const std::vector<vec3> light{vec3(1, 5, 2), vec3(4, 3, 2), vec3(9, 0, 2), vec3(100)};
  const std::vector<vec3> bends{vec3(0, 1, 0), vec3(0, 0, 7), vec3(0, 2, 0), vec3(100)};
  const Parents parents{.pixels = {0, 1, 2, 3}, .count = 4, .places = 4};
  Interpolated middle{.light = vec3(1), .weights = {1, 0.03f, 0.5f, 0.01f}, .share = 0.4f};
  CHECK(detail::change_of_light(parents, middle, light, bends) == vec3(4, 4.5f, 7));
  middle.weights = {0, 0, 0, 0};
  CHECK(detail::change_of_light(parents, middle, light, bends) == vec3(0));
}

TEST_CASE("shares of nothing are nothing, and NaN stays") {
  const float not_a_number = std::numeric_limits<float>::quiet_NaN();
  CHECK(detail::share_of(0, 0) == 0);
  CHECK(detail::share_of(1, 4) == 0.25f);
  CHECK(std::isnan(detail::share_of(1, not_a_number)));
  CHECK(std::isnan(detail::share_of(not_a_number, 1)));
}
