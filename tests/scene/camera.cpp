// Rays through the image, against the pinhole's geometry.
#include <doctest/doctest.h>

#include <cmath>
#include <coppice/scene/camera.hpp>
#include <initializer_list>

using namespace coppice;

namespace {

double angle_between(const vec3& a, const vec3& b) {
  return std::atan2(glm::length(glm::cross(glm::dvec3(a), glm::dvec3(b))),
                    glm::dot(glm::dvec3(a), glm::dvec3(b)));
}

}  // namespace

TEST_CASE("the middle of the image looks forward, its edges by half the field of view") {
  Camera camera;
  camera.vertical_fov = 1.0f;
  CHECK(length(camera.direction(320, 180, 640, 360) - camera.forward) < 1e-6f);
  const vec3 top = camera.direction(320, 0, 640, 360), bottom = camera.direction(320, 360, 640, 360);
  CHECK(angle_between(top, bottom) == doctest::Approx(1.0).epsilon(1e-5));
  CHECK(top.y > 0);  // rows run downwards
  CHECK(bottom.y < 0);
  const vec3 right = camera.direction(640, 180, 640, 360);
  CHECK(right.x > 0);
  CHECK(std::tan(angle_between(camera.forward, right)) ==
        doctest::Approx(std::tan(0.5) * 640 / 360).epsilon(1e-5));  // square pixels
}

TEST_CASE("directions are unit and follow the camera's own axes") {
  Camera camera;
  camera.right = {0, 0, -1};
  camera.up = {0, 1, 0};
  camera.forward = {-1, 0, 0};
  for (const float x : {0.5f, 10.0f, 63.5f})
    for (const float y : {0.5f, 31.5f}) {
      const vec3 d = camera.direction(x, y, 64, 32);
      CHECK(std::abs(length(d) - 1) < 3e-7f);
      CHECK((d.z < 0) == (x > 32));
      CHECK((d.y > 0) == (y < 16));
      CHECK(d.x < 0);
    }
}

TEST_CASE("a pixel's angle is what the image plane at distance 1 spans, per row") {
  const Camera camera;
  CHECK(100 * camera.pixel_angle(100) == doctest::Approx(2 * std::tan(0.3)));
  const vec3 a = camera.direction(50, 50, 100, 100), b = camera.direction(51, 50, 100, 100);
  CHECK(angle_between(a, b) == doctest::Approx(camera.pixel_angle(100)).epsilon(1e-3));
}
