// An image is row by row from the top.
#include <doctest/doctest.h>

#include <coppice/core/image.hpp>

using namespace coppice;

TEST_CASE("pixel (x, y) is at y * width + x, and all start with the fill") {
  Image image(3, 2, vec3(0.5f));
  REQUIRE(image.pixels.size() == 6);
  CHECK(image.at(2, 1) == vec3(0.5f));
  image.at(2, 1) = vec3(1, 2, 3);
  CHECK(image.index(2, 1) == 5);
  CHECK(image.pixels[5] == vec3(1, 2, 3));
  CHECK(Image().pixels.empty());
}
