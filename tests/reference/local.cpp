// The sum over lights of the scene, against formulas written out.
#include <doctest/doctest.h>

#include <coppice/brdf/lambert.hpp>
#include <coppice/reference/local.hpp>
#include <support/occluders.hpp>

using namespace coppice;
using namespace coppice::reference;

namespace {

const support::SphereOccluder nothing{};

ShadingPoint white_floor() {
  ShadingPoint point{};
  point.normal = point.to_viewer = vec3(0, 1, 0);
  point.tangent = vec3(1, 0, 0);
  set_lambert(point, vec3(1));
  return point;
}

vec3 radiance(const LocalLight& light, const vec3& at = vec3(0),
              const support::SphereOccluder& occluder = nothing) {
  return local_radiance(white_floor(), at, std::span(&light, 1), occluder);
}

void check_near(const vec3& value, const vec3& expected) {
  CHECK(length(value - expected) <= 1e-6f * length(expected));
}

}  // namespace

TEST_CASE("a point light falls with the squared distance and the cosine") {
  const vec3 intensity(1, 2, 3);
  check_near(radiance(point_light(vec3(0, 2, 0), intensity)), intensity / (4 * pi));
  check_near(radiance(point_light(vec3(3, 4, 0), intensity)), intensity * (0.8f / 25 / pi));
  CHECK(radiance(point_light(vec3(0, -2, 0), intensity)) == vec3(0));
  CHECK(radiance(point_light(vec3(0), intensity)) == vec3(0));
}

TEST_CASE("spots, surfaces and suns give what their profiles say") {
  check_near(radiance(spot_light(vec3(0, 2, 0), vec3(8), vec3(0, -1, 0), 0.1f, 0.2f)), vec3(2 / pi));
  CHECK(radiance(spot_light(vec3(0, 2, 0), vec3(8), vec3(0, 1, 0), 0.1f, 0.2f)) == vec3(0));
  const float area = 0.5f;
  check_near(radiance(surface_light(vec3(3, 4, 0), vec3(0, -1, 0), vec3(10), area)),
             vec3(10 * area * 0.8f * 0.8f / (25 + area / pi) / pi));
  check_near(radiance(distant_light(vec3(0.6f, 0.8f, 0), vec3(5), 100), vec3(7, 8, 9)), vec3(5 * 0.8f / pi));
}

TEST_CASE("what stands before a light hides it, what stands behind does not") {
  const LocalLight light = point_light(vec3(0, 2, 0), vec3(1));
  CHECK(radiance(light, vec3(0), {{{vec3(0, 1, 0), 0.2f}}}) == vec3(0));
  CHECK(radiance(light, vec3(0), {{{vec3(0, 3, 0), 0.2f}}}).x > 0);
  const LocalLight sun = distant_light(vec3(0, 1, 0), vec3(1), 1);
  CHECK(radiance(sun, vec3(0), {{{vec3(0, 1000, 0), 0.2f}}}) == vec3(0));
}

TEST_CASE("squares of stored values are interpolated between three receivers") {
  ShadingPoint point = white_floor();
  point.weight_0 = 0.5f, point.weight_1 = 0.25f;
  const std::vector<LocalLight> lights{point_light(vec3(0, 1, 0), vec3(1)),
                                       point_light(vec3(0, 1, 1), vec3(1))};
  MaskedCuts<std::uint16_t> cuts(2, 0);
  cuts.append(Cut<std::uint16_t>{{1, 2}, {4, 0}});
  cuts.append(Cut<std::uint16_t>{{2}, {8}});
  cuts.append(Cut<std::uint16_t>{{1, 2}, {0, 16}});
  const std::vector<float> scales{0.5f, 0.25f, 1};
  const float first = 0.5f * 16 * 0.5f + 0.25f * 64 * 0.25f, second = 0.25f * 64 * 0.25f + 0.25f * 256;
  check_near(local_radiance_from_cuts(point, vec3(0), lights, cuts, scales, uvec3(0, 1, 2)),
             vec3((first + second * std::sqrt(0.5f)) / pi));
}
