// How shadows are judged.
#include <coppice/transfer/decisions.hpp>
//
#include <doctest/doctest.h>

#include <support/executors.hpp>
#include <support/generators.hpp>
#include <support/occluders.hpp>

using namespace coppice;

namespace {

/// Samples of the plane y = 0 that face up.
std::vector<SurfaceSample> plane_samples(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<SurfaceSample> samples(count);
  for (SurfaceSample& s : samples) {
    const float x = 4 * random.uniform() - 2, z = 4 * random.uniform() - 2;
    s.position = {x, 0, z}, s.normal = {0, 1, 0}, s.area = 16 / float(count);
  }
  return samples;
}

const support::SphereOccluder ball{{{{0, 0.7f, 0}, 0.4f}}};

std::vector<float> exact(std::span<const SurfaceSample> samples, const SizedLight& light) {
  std::vector<float> result(samples.size(), -1);
  exact_visibility(samples, points_of(light), ball, Serial(), result);
  return result;
}

}  // namespace

TEST_CASE("exact visibility is what one shadow ray after the other says") {
  const auto samples = plane_samples(333, 1);
  for (const float radius : {0.0f, 0.3f}) {
    const SizedLight light{point_light({0.2f, 1.6f, 0.1f}, vec3(1)), radius};
    const auto visibility = exact(samples, light);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      float free = 0, above = 0;
      for (const LocalLight& point : points_of(light))
        if (const auto path = path_to(point, ray_origin(samples[i]), samples[i].normal)) {
          ++above;
          free += ball.occluded(ray_origin(samples[i]), path->direction, path->t_max) ? 0.0f : 1.0f;
        }
      CHECK(visibility[i] == free / above);
    }
  }
}

TEST_CASE("exact visibility does not depend on the executor") {
  const auto samples = plane_samples(3001, 2);
  const SizedLight light{point_light({0.2f, 1.6f, 0.1f}, vec3(1)), 0.2f};
  const auto serial = exact(samples, light);
  std::vector<float> other(samples.size());
  exact_visibility(samples, points_of(light), ball, support::Backwards{}, other);
  CHECK(other == serial);
  exact_visibility(samples, points_of(light), ball, support::TwoThreads{}, other);
  CHECK(other == serial);
}

TEST_CASE("exact decisions are never wrong, opposite ones always") {
  const auto samples = plane_samples(500, 3);
  const std::vector<SizedLight> lights{{point_light({0.2f, 1.6f, 0.1f}, vec3(1)), 0},
                                       {point_light({-1, 2, 0.5f}, vec3(3)), 0.2f}};
  std::vector<float> values;
  const auto right = wrong_decisions(samples, lights, ball, Serial(), [&](const SizedLight& light) {
    return std::span<const float>(values = exact(samples, light));
  });
  CHECK(right.plain == 0);
  CHECK(right.weighted == 0);
  CHECK(right.pairs == 1000);
  const auto wrong = wrong_decisions(samples, lights, ball, Serial(), [&](const SizedLight& light) {
    values = exact(samples, light);
    for (float& x : values) x = x >= 0.5f ? 0.0f : 1.0f;
    return std::span<const float>(values);
  });
  CHECK(wrong.plain == 1);
  CHECK(wrong.weighted == doctest::Approx(1).epsilon(1e-12));
}

TEST_CASE("wrong decisions that matter more weigh more") {
  auto samples = plane_samples(2, 4);
  samples[0].position = {0, 0, 0}, samples[1].position = {0, 0, 3};
  const std::vector<LocalLight> light{point_light({0, 1, 0}, vec3(1))};
  const float near = path_to(light[0], ray_origin(samples[0]), samples[0].normal)->irradiance.x;
  const float far = path_to(light[0], ray_origin(samples[1]), samples[1].normal)->irradiance.x;
  DecisionCount count;
  count.add(samples, light, std::vector<float>{0, 1}, std::vector<float>{1, 1});
  CHECK(count.result().plain == 0.5);
  CHECK(count.result().weighted == doctest::Approx(near / (near + far)).epsilon(1e-6));
}

TEST_CASE("a light below the horizon, no light and no samples make no pairs") {
  const auto samples = plane_samples(10, 5);
  const std::vector<SizedLight> below{{point_light({0, -1, 0}, vec3(1)), 0}}, none;
  const auto zeros = [](std::size_t count) {
    return [values = std::vector<float>(count, 0.0f)](const SizedLight&) {
      return std::span<const float>(values);
    };
  };
  CHECK(wrong_decisions(samples, below, ball, Serial(), zeros(10)).pairs == 0);
  CHECK(wrong_decisions(samples, below, ball, Serial(), zeros(10)).plain == 0);
  CHECK(wrong_decisions(samples, none, ball, Serial(), zeros(10)).pairs == 0);
  CHECK(wrong_decisions(std::span<const SurfaceSample>(), below, ball, Serial(), zeros(0)).pairs == 0);
  CHECK(exact(samples, below[0]) == std::vector<float>(10, 0.0f));
}
