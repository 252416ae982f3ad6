// HEALPix: pixels of equal area about their centres, at the seam and the poles too.
#include <doctest/doctest.h>

#include <coppice/core/random.hpp>
#include <coppice/sg/healpix.hpp>
#include <set>
#include <tuple>

using namespace coppice;

namespace {

constexpr int sides[] = {1, 2, 3, 4, 5, 7, 8, 9, 16, 31};

}  // namespace

TEST_CASE("each centre lies in its own pixel, is unit, and no two are one") {
  for (const int nside : sides) {
    const Healpix grid(nside);
    std::set<std::tuple<float, float, float>> seen;
    for (std::uint32_t i = 0; i < grid.pixel_count(); ++i) {
      const vec3 c = grid.centre(i);
      REQUIRE(std::abs(length(c) - 1) < 3e-7f);
      REQUIRE(grid.pixel(c) == i);
      seen.insert({c.x, c.y, c.z});
    }
    CHECK(seen.size() == grid.pixel_count());
  }
}

TEST_CASE("heights and azimuths of the first, a middle and the last ring are those of the definition") {
  const Healpix grid(4);  // rings of 4, 8, 12, then 16 pixels
  const auto azimuth = [&](std::uint32_t i) { return std::atan2(grid.centre(i).z, grid.centre(i).x); };
  CHECK(grid.centre(0).y == doctest::Approx(1 - 1.0 / 48));
  CHECK(azimuth(0) == doctest::Approx(pi / 4));
  CHECK(grid.centre(4).y == doctest::Approx(1 - 4.0 / 48));
  CHECK(grid.centre(24).y == doctest::Approx(2.0 / 3));  // the first ring of the belt, shifted by half
  CHECK(azimuth(24) == doctest::Approx(pi / 16));
  CHECK(azimuth(40) == doctest::Approx(0));  // the second, not shifted
  CHECK(grid.centre(88).y == doctest::Approx(0));
  CHECK(grid.centre(191).y == doctest::Approx(-1 + 1.0 / 48));
  CHECK(azimuth(191) == doctest::Approx(-pi / 4));
}

TEST_CASE("pixels have equal areas") {
  for (const int nside : {1, 2, 3, 5, 8}) {
    const Healpix grid(nside);
    const int rows = 2000, columns = 2003;  // even in height and azimuth: points of equal area
    std::vector<int> counts(grid.pixel_count());
    for (int y = 0; y < rows; ++y) {
      const double height = 1 - (2 * y + 1.0) / rows;
      for (int x = 0; x < columns; ++x)
        ++counts[grid.pixel(height, 1 - std::abs(height), (x + 0.5) / columns)];
    }
    const double expected = double(rows) * columns / grid.pixel_count();
    for (const int count : counts) REQUIRE(std::abs(count - expected) < 0.02 * expected);
  }
}

TEST_CASE("no direction lies further from its pixel's centre than 1.2 roots of its area") {
  Random random(1);
  for (const int nside : sides) {
    const Healpix grid(nside);
    const double widest = 1.2 * std::sqrt(grid.pixel_area());
    for (int i = 0; i < 20000; ++i) {
      const vec3 d = random.direction();
      const std::uint32_t pixel = grid.pixel(d);
      REQUIRE(pixel < grid.pixel_count());
      REQUIRE(length(grid.centre(pixel) - d) < widest);
    }
  }
}

TEST_CASE("the poles and both sides of the seam have pixels next to them") {
  for (const int nside : sides) {
    const Healpix grid(nside);
    CHECK(grid.pixel(vec3(0, 1, 0)) < 4);
    CHECK(grid.pixel(vec3(0, -1, 0)) >= grid.pixel_count() - 4);
    for (const float y : {-0.9f, -0.3f, 0.0f, 0.3f, 0.9f})
      for (const float z : {-1e-7f, -0.0f, 0.0f, 1e-7f}) {
        const vec3 d(-std::sqrt(1 - y * y), y, z);
        CHECK(length(grid.centre(grid.pixel(d)) - d) < 1.2 * std::sqrt(grid.pixel_area()));
      }
  }
}

TEST_CASE("directions a millionth from a pole keep their quadrant") {
  const Healpix grid(1024);
  for (int i = 0; i < 4; ++i) {
    const float azimuth = (float(i) + 0.5f) * pi / 2, r = 1e-6f;
    const vec3 d(r * std::cos(azimuth), 1, r * std::sin(azimuth));
    CHECK(grid.pixel(d) == std::uint32_t(i));
    CHECK(grid.pixel(vec3(d.x, -1, d.z)) == grid.pixel_count() - 4 + std::uint32_t(i));
  }
}
