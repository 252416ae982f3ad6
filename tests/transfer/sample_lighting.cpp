// Direct light at samples against one light and one ray at a time.
#include <coppice/core/simd.hpp>
//
#include <doctest/doctest.h>
#include <rapidcheck.h>

#include <coppice/light/thin_samples.hpp>
#include <coppice/transfer/sample_lighting.hpp>
#include <support/executors.hpp>
#include <support/generators.hpp>
#include <support/local_lights.hpp>
#include <support/occluders.hpp>
#include <support/scenes.hpp>

using namespace coppice;

namespace {

std::vector<SurfaceSample> ground_samples(std::size_t count) {
  Scene scene;
  scene.materials.resize(1);
  support::add_ground(scene.mesh, 1, -1);
  const std::vector<TriangleSide> sides = {{0, true}, {1, true}};
  return scatter_samples(scene.mesh, sides, count, Shares::by_area, 1);
}

Mesh small_box() {
  Mesh mesh;
  support::add_box(mesh, vec3(-0.3f, -0.9f, -0.3f), vec3(0.2f, -0.5f, 0.4f));
  return mesh;
}

}  // namespace

TEST_CASE("Direct light at samples is the sum over lights, one shadow ray each, for any threads") {
  const support::TriangleTracer occluder(small_box());
  CHECK(rc::check([&] {
    Random random = test_support::any_random();
    const auto samples = ground_samples(*rc::gen::inRange<std::size_t>(0, 60));
    const auto lights = support::random_local_lights(random, *rc::gen::inRange<std::size_t>(0, 20));
    std::vector<vec3> out(samples.size()), again(samples.size());
    light_directly(samples, lights, occluder, Serial(), 0, out);
    light_directly(samples, lights, occluder, support::Backwards(), 0, again);
    RC_ASSERT(out == again);
    light_directly(samples, lights, occluder, support::TwoThreads(), 0, again);
    RC_ASSERT(out == again);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      vec3 expected(0);
      const vec3 origin = ray_origin(samples[i]);
      for (const LocalLight& light : lights)
        if (const auto path = path_to(light, origin, samples[i].normal))
          if (!occluder.occluded(origin, path->direction, path->t_max)) expected += path->irradiance;
      for (int c = 0; c < 3; ++c)
        RC_ASSERT(test_support::close(double(out[i][c]), double(expected[c]), 1e-5));
    }
  }));
}

TEST_CASE("Softening dims near lights smoothly and leaves far ones alone") {
  std::vector<SurfaceSample> samples(2);
  samples[0] = {.position = vec3(0), .area = 1, .normal = vec3(0, 1, 0), .side = {}};
  samples[1] = {.position = vec3(0, -3, 0), .area = 1, .normal = vec3(0, 1, 0), .side = {}};
  const std::vector<LocalLight> lights = {point_light(vec3(0, 0.5f, 0), vec3(1))};
  std::vector<vec3> sharp(2), soft(2);
  const support::TriangleTracer nothing{Mesh()};
  light_directly(samples, lights, nothing, Serial(), 0, sharp);
  light_directly(samples, lights, nothing, Serial(), 0.5f, soft);
  CHECK(sharp[0].x == doctest::Approx(4).epsilon(1e-4));
  CHECK(soft[0].x == doctest::Approx(4 / std::sqrt(2.0)).epsilon(1e-4));
  CHECK(soft[1].x == doctest::Approx(sharp[1].x).epsilon(3e-4));
  CHECK(soft[1].x < sharp[1].x);
  light_directly(samples, lights, nothing, Serial(), 1e-20f, soft);  // squares that vanish in float
  CHECK(soft[0].x == sharp[0].x);
  light_directly(samples, lights, nothing, Serial(), 1e10f, soft);
  CHECK(soft[0].x < 1e-19f);
}

TEST_CASE("A ball of light shines like the point at its centre, and its shadows are soft") {
  const auto samples = ground_samples(400);
  const support::TriangleTracer occluder(small_box()), nothing{Mesh()};
  SizedLight light{point_light(vec3(0.1f, 1, 0), vec3(1, 2, 3)), 0.2f};
  const auto ball = direct_irradiance(samples, light, nothing, Serial(), {});
  const auto shadowed = direct_irradiance(samples, light, occluder, Serial(), {});
  light.radius = 0;
  const auto point = direct_irradiance(samples, light, nothing, Serial(), {});
  std::size_t partly = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    CHECK(ball[i].y == doctest::Approx(point[i].y).epsilon(0.02));
    partly += shadowed[i].y > 0.05f * ball[i].y && shadowed[i].y < 0.95f * ball[i].y;
  }
  CHECK(partly > 10);
}

TEST_CASE("The softening distance is four sample spacings") {
  const auto samples = ground_samples(100);
  CHECK(softening_distance(samples) == doctest::Approx(0.8f));
  CHECK(softening_distance({}) == 0);
}
