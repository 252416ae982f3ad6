// The closed forms on vectors: unit or the fallback, never NaN; frames that are orthonormal in every
// direction.
#include <doctest/doctest.h>

#include <coppice/core/math.hpp>
#include <coppice/core/random.hpp>
#include <limits>
#include <vector>

using namespace coppice;

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

}  // namespace

TEST_CASE("normalize_or returns unit vectors from the smallest to the largest floats") {
  Random random(1);
  for (const float size : {1e-36f, 1e-20f, 1.0f, 1e20f, 1e38f})
    for (int i = 0; i < 100; ++i) {
      const vec3 d = random.direction(), v = normalize_or(size * d, vec3(0));
      CHECK(length(v - d) < 4e-7f);
    }
}

TEST_CASE("normalize_or returns the fallback where there is no direction, and never NaN") {
  const vec3 fallback(0, 0, 1);
  for (const vec3& v : {vec3(0), vec3(-0.0f), vec3(1e-40f, 0, 0), vec3(infinity, 0, 0), vec3(1, -infinity, 1),
                        vec3(not_a_number), vec3(not_a_number, 1, 0), vec3(0, 1, not_a_number)})
    CHECK(normalize_or(v, fallback) == fallback);
}

TEST_CASE("make_frame completes any unit vector to a right-handed orthonormal frame") {
  Random random(2);
  std::vector<vec3> normals{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0},    {0, -1, 0},
                            {0, 0, 1}, {0, 0, -1}, {1, 0, -0.0f}};
  for (const float z : {-0.999999f, 0.999999f, -1e-8f}) normals.push_back(normalize(vec3(1e-4f, -1e-3f, z)));
  for (int i = 0; i < 1000; ++i) normals.push_back(random.direction());
  for (const vec3& n : normals) {
    vec3 t, b;
    make_frame(n, t, b);
    CHECK(std::abs(length(t) - 1) < 1e-6f);
    CHECK(std::abs(length(b) - 1) < 1e-6f);
    CHECK(std::abs(dot(n, t)) < 1e-6f);
    CHECK(length(cross(n, t) - b) < 1e-6f);
  }
}

TEST_CASE("luminance is that of Rec. 709, 1 for white") {
  CHECK(luminance(vec3(1)) == doctest::Approx(1).epsilon(1e-6));
  CHECK(luminance(vec3(0, 1, 0)) == 0.7152f);
  CHECK(luminance(vec3(0)) == 0);
}

TEST_CASE("is_finite looks at every component") {
  CHECK(is_finite(vec3(0, -1e38f, 1e-45f)));
  for (int axis = 0; axis < 3; ++axis)
    for (const float bad : {infinity, -infinity, not_a_number}) {
      vec3 v(1);
      v[axis] = bad;
      CHECK_FALSE(is_finite(v));
    }
}
