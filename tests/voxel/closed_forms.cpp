// The closed forms of the march against double, over their domains.
#include <coppice/core/simd.hpp>
//
#include <coppice/shared/voxel.h>
#include <doctest/doctest.h>

#include "support/generators.hpp"

using namespace coppice;

TEST_CASE("the angle that holds a share of a Gaussian is right to 1e-5 over the domain") {
  double worst = 0, worst_lanes = 0;
  for (float sharpness = 1e-4f; sharpness <= 1e10f; sharpness *= 1.7f)
    for (const float u : {1e-3f, 0.01f, 0.0625f, 0.3f, 0.5f, 0.77f, 0.9375f, 0.999f}) {
      const double s = double(sharpness);
      const double exact = std::min(2.0, -std::log1p(double(u) * std::expm1(-2 * s)) / s);
      float lanes[Lanes::width];
      voxel_ray_drop(Lanes(u), Lanes(sharpness)).store(lanes);
      worst = std::max(worst, std::abs(double(voxel_ray_drop(u, sharpness)) / exact - 1));
      worst_lanes = std::max(worst_lanes, std::abs(double(lanes[0]) / exact - 1));
    }
  MESSAGE("worst relative error " << worst << ", lanes " << worst_lanes);
  CHECK(worst < 1e-5);
  CHECK(worst_lanes < 1e-5);
}

TEST_CASE("a ray is wholly open over an unbounded plane, closed within the skin, and monotone between") {
  CHECK(rc::check([] {
    Random random = test_support::any_random();
    const float t = std::exp(6 * random.uniform()), slope = random.uniform(), reach = random.uniform();
    const float lift = 1, skin = 0.58f, rise = lift + t * slope;
    RC_ASSERT(voxel_opening(rise, t, rise, reach, skin, 0.8f) == 1.0f);
    RC_ASSERT(voxel_opening(skin, t, rise, reach, skin, 0.8f) == 0.0f);
    float last = 0;
    for (float d = 0; d < 10; d += 0.1f) {
      const float open = voxel_opening(d, t, rise, reach, skin, 0.8f);
      RC_ASSERT((open >= last && open <= 1));
      last = open;
    }
    RC_ASSERT(voxel_stride(0.0f, t, reach, 0.25f) >= 1);
    RC_ASSERT(voxel_stride(50.0f, t, reach, 0.25f) >= 49);
  }));
}

TEST_CASE("the width of a ray is finite, and its share runs from 0 below the horizon to 1 above") {
  CHECK(voxel_ray_width(0, 8) == 1);
  CHECK(voxel_ray_width(50, 8) == doctest::Approx(0.05));
  CHECK(voxel_ray_share(-0.2f, 0.1f) == 0);
  CHECK(voxel_ray_share(0.0f, 0.1f) == doctest::Approx(0.5));
  CHECK(voxel_ray_share(0.2f, 0.1f) == 1);
  CHECK(voxel_brick(-3, 4) == 0);
  CHECK(voxel_brick(15.9f, 4) == 1);
  CHECK(voxel_brick(1e6f, 4) == 3);
}
