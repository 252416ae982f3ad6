// The sum over all lights, against Lambert's law written out.
#include <doctest/doctest.h>

#include <coppice/brdf/ggx.hpp>
#include <coppice/brdf/lambert.hpp>
#include <coppice/core/random.hpp>
#include <coppice/reference/dense.hpp>
#include <vector>

using namespace coppice;
using coppice::reference::dense_radiance;

namespace {

struct Lights {
  std::vector<vec3> directions, powers;
  std::vector<float> visibility;
};

Lights random_lights(Random& random, std::size_t count) {
  Lights lights;
  for (std::size_t i = 0; i < count; ++i) {
    lights.directions.push_back(random.direction());
    lights.powers.push_back(vec3(random.uniform(), random.uniform(), random.uniform()));
    lights.visibility.push_back(random.uniform());
  }
  return lights;
}

vec3 radiance_of(const ShadingPoint& point, const Lights& lights) {
  return dense_radiance(point, lights.directions, lights.powers, lights.visibility);
}

/// A point in a random frame, seen from above its surface.
ShadingPoint random_point(Random& random) {
  ShadingPoint point{};
  point.normal = random.direction();
  vec3 bitangent;
  make_frame(point.normal, point.tangent, bitangent);
  point.to_viewer = normalize(point.normal + 0.7f * random.direction());
  return point;
}

}  // namespace

TEST_CASE("a Lambertian point sums power, albedo over pi, cosine and visibility of the lights above it") {
  Random random(1);
  for (int i = 0; i < 20; ++i) {
    ShadingPoint point = random_point(random);
    const vec3 albedo(0.2f, 0.5f, 0.9f);
    set_lambert(point, albedo);
    const Lights lights = random_lights(random, 100);
    glm::dvec3 expected(0);
    for (std::size_t l = 0; l < 100; ++l) {
      const double cosine =
          std::max(0.0, glm::dot(glm::dvec3(point.normal), glm::dvec3(lights.directions[l])));
      expected +=
          glm::dvec3(lights.powers[l] * albedo) * (cosine * double(lights.visibility[l]) / std::numbers::pi);
    }
    CHECK(length(radiance_of(point, lights) - vec3(expected)) < 1e-5f);
  }
}

TEST_CASE("radiance is linear in power and in visibility, and nothing without lights") {
  Random random(2);
  ShadingPoint point = random_point(random);
  set_metallic_roughness(point, vec3(0.5f), 0.3f, 0.4f);
  const Lights lights = random_lights(random, 50);
  const vec3 once = radiance_of(point, lights);
  CHECK(once.x > 0);
  Lights doubled = lights, hidden = lights;
  for (auto& p : doubled.powers) p *= 2.0f;
  for (auto& v : hidden.visibility) v = 0;
  CHECK(radiance_of(point, doubled) == 2.0f * once);
  CHECK(radiance_of(point, hidden) == vec3(0));
  CHECK(radiance_of(point, {}) == vec3(0));
}

TEST_CASE("turning the point with its lights about any axis changes nothing") {
  Random random(3);
  ShadingPoint point = random_point(random);
  set_metallic_roughness(point, vec3(0.8f, 0.4f, 0.1f), 1, 0.5f);
  Lights lights = random_lights(random, 50);
  const vec3 before = radiance_of(point, lights);
  const glm::quat turn = glm::angleAxis(1.1f, random.direction());
  for (vec3* v : {&point.normal, &point.tangent, &point.to_viewer}) *v = turn * *v;
  for (vec3& d : lights.directions) d = turn * d;
  CHECK(length(radiance_of(point, lights) - before) < 1e-5f * length(before));
}
