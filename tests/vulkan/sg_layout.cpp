// The structs of the kernels of spherical Gaussians, as the compiled kernels see them.
#include <coppice/shared/sg_kernels.h>
#include <doctest/doctest.h>

#include "reflection.hpp"

using namespace coppice;
using namespace coppice::test;

namespace {

KERNEL(sg_fit_means)
KERNEL(sg_fit_pass)
KERNEL(sg_cones)
KERNEL(sg_products)

template <class Struct>
void check_array(const Reflection& kernel, const char* name, const Offsets& expected) {
  CAPTURE(name);
  const ArrayLayout layout = kernel.array(name);
  CHECK(layout.offsets == expected);
  CHECK(layout.stride == sizeof(Struct));
}

}  // namespace

TEST_CASE("the parameters of the kernels of a fit have the offsets of C++") {
  {
    using Struct = FitMeansParameters;
    const Offsets expected{MEMBER(windows.begins), MEMBER(windows.columns), MEMBER(windows.values),
                           MEMBER(cells),          MEMBER(centres),         MEMBER(axes),
                           MEMBER(peaks),          MEMBER(means),           MEMBER(sharpness),
                           MEMBER(peak_count)};
    CHECK(sg_fit_means().parameter_offsets() == expected);
  }
  {
    using Struct = FitPassParameters;
    const Offsets expected{MEMBER(model.begins), MEMBER(model.columns), MEMBER(model.values),
                           MEMBER(means),        MEMBER(from),          MEMBER(to),
                           MEMBER(step),         MEMBER(first_gaussian)};
    CHECK(sg_fit_pass().parameter_offsets() == expected);
  }
}

TEST_CASE("the parameters of the kernels of cones and products have the offsets of C++") {
  {
    using Struct = ConesParameters;
    const Offsets expected{MEMBER(settings),  MEMBER(slots),          MEMBER(distances),  MEMBER(receivers),
                           MEMBER(cones),     MEMBER(closed),         MEMBER(visibility), MEMBER(range.begin),
                           MEMBER(range.end), MEMBER(receiver_count), MEMBER(before),     MEMBER(has_closed)};
    CHECK(sg_cones().parameter_offsets() == expected);
  }
  {
    using Struct = ProductsParameters;
    const Offsets expected{MEMBER(lights),    MEMBER(pairs),       MEMBER(means),    MEMBER(range.begin),
                           MEMBER(range.end), MEMBER(first_light), MEMBER(end_light)};
    CHECK(sg_products().parameter_offsets() == expected);
  }
}

TEST_CASE("Gaussians, lights and pairs have the offsets and the stride of C++") {
  {
    using Struct = SgShape;
    check_array<Struct>(sg_cones(), "cones", {MEMBER(axis), MEMBER(sharpness)});
  }
  {
    using Struct = SgLight;
    const Offsets expected{MEMBER(axis), MEMBER(sharpness), MEMBER(amplitude), MEMBER(luminance)};
    check_array<Struct>(sg_products(), "lights", expected);
    check_array<Struct>(sg_fit_means(), "peaks", expected);
  }
  {
    using Struct = SgPair;
    check_array<Struct>(
        sg_products(), "pairs",
        {MEMBER(lobe.axis), MEMBER(lobe.sharpness), MEMBER(cone.axis), MEMBER(cone.sharpness)});
  }
  {
    using Struct = SgPairMean;
    check_array<Struct>(sg_products(), "means", {MEMBER(mean), MEMBER(scale)});
  }
  {
    using Struct = FitCell;
    check_array<Struct>(sg_fit_means(), "cells", {MEMBER(energy), MEMBER(centre)});
  }
}

TEST_CASE("ConeReceiver and ConeSettings have the offsets and the stride of C++") {
  {
    using Struct = ConeReceiver;
    check_array<Struct>(
        sg_cones(), "receivers",
        {MEMBER(position), MEMBER(cones_end), MEMBER(normal), MEMBER(index), MEMBER(shading_normal)});
  }
  {
    using Struct = ConeSettings;
    check_array<Struct>(sg_cones(), "settings",
                        {MEMBER(grid.low), MEMBER(grid.voxels_per_unit), MEMBER(grid.bricks),
                         MEMBER(grid.voxel), MEMBER(grid.first_brick), MEMBER(trace.rays),
                         MEMBER(trace.steps), MEMBER(trace.lift), MEMBER(trace.start), MEMBER(trace.skin),
                         MEMBER(trace.softness), MEMBER(trace.slack), MEMBER(trace.growth)});
  }
}

TEST_CASE("matrices, vectors, bytes and visibilities of Gaussians lie as densely as in C++") {
  for (const char* name : {"windows.begins", "windows.columns", "windows.values"})
    CHECK(sg_fit_means().array(name).stride == 4);
  for (const char* name : {"model.begins", "model.columns", "model.values"})
    CHECK(sg_fit_pass().array(name).stride == 4);
  for (const char* name : {"centres", "axes", "means"})
    CHECK(sg_fit_means().array(name).stride == sizeof(vec3));
  for (const char* name : {"means", "from", "to"}) CHECK(sg_fit_pass().array(name).stride == sizeof(vec3));
  for (const char* name : {"slots", "distances", "closed", "visibility"})
    CHECK(sg_cones().array(name).stride == 4);
}
