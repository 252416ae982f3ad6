// The structs of the kernels of moving lights, as the compiled kernels see them.
#include <coppice/shared/transfer.h>
#include <doctest/doctest.h>

#include "reflection.hpp"

using namespace coppice;
using namespace coppice::test;

namespace {

KERNEL(lattice_features)
KERNEL(lattice_visibility)
KERNEL(sample_light)
KERNEL(light_project)
KERNEL(light_mix)
KERNEL(light_expand)

template <class Struct>
void check_array(const Reflection& kernel, const char* name, const Offsets& expected) {
  CAPTURE(name);
  const ArrayLayout layout = kernel.array(name);
  CHECK(layout.offsets == expected);
  CHECK(layout.stride == sizeof(Struct));
}

}  // namespace

TEST_CASE("the parameters of the kernels of visibility and direct light have the offsets of C++") {
  {
    using Struct = LatticeFeaturesParameters;
    const Offsets expected{MEMBER(clusters),  MEMBER(bits),   MEMBER(before),      MEMBER(rows),
                           MEMBER(scales),    MEMBER(points), MEMBER(features),    MEMBER(range.begin),
                           MEMBER(range.end), MEMBER(rank),   MEMBER(block_count), MEMBER(first_point),
                           MEMBER(end_point), MEMBER(known)};
    CHECK(lattice_features().parameter_offsets() == expected);
  }
  {
    using Struct = LatticeVisibilityParameters;
    const Offsets expected{MEMBER(clusters),      MEMBER(coefficients), MEMBER(features),
                           MEMBER(visibility),    MEMBER(range.begin),  MEMBER(range.end),
                           MEMBER(cluster_count), MEMBER(rank),         MEMBER(block_count),
                           MEMBER(smooth_edges),  MEMBER(share),        MEMBER(continues)};
    CHECK(lattice_visibility().parameter_offsets() == expected);
  }
  {
    using Struct = SampleLightParameters;
    const Offsets expected{MEMBER(positions), MEMBER(normals), MEMBER(visibility),
                           MEMBER(lights),    MEMBER(direct),  MEMBER(range.begin),
                           MEMBER(range.end), MEMBER(light),   MEMBER(continues)};
    CHECK(sample_light().parameter_offsets() == expected);
  }
}

TEST_CASE("the parameters of the kernels of transfer have the offsets of C++") {
  {
    using Struct = LightProjectParameters;
    const Offsets expected{MEMBER(clusters),  MEMBER(values),        MEMBER(scales),
                           MEMBER(offsets),   MEMBER(direct),        MEMBER(coefficients),
                           MEMBER(intensity), MEMBER(cluster_count), MEMBER(range.begin),
                           MEMBER(range.end), MEMBER(field_count),   MEMBER(stride),
                           MEMBER(is_centred)};
    CHECK(light_project().parameter_offsets() == expected);
  }
  {
    using Struct = LightMixParameters;
    const Offsets expected{MEMBER(values),      MEMBER(scales),    MEMBER(coefficients),  MEMBER(weights),
                           MEMBER(range.begin), MEMBER(range.end), MEMBER(pattern_count), MEMBER(row_words)};
    CHECK(light_mix().parameter_offsets() == expected);
  }
  {
    using Struct = LightExpandParameters;
    const Offsets expected{MEMBER(clusters), MEMBER(values),      MEMBER(scales),    MEMBER(weights),
                           MEMBER(indirect), MEMBER(range.begin), MEMBER(range.end), MEMBER(cluster_count)};
    CHECK(light_expand().parameter_offsets() == expected);
  }
}

TEST_CASE("clusters, corners and lights of samples have the offsets and the stride of C++") {
  {
    using Struct = FieldCluster;
    const Offsets expected{MEMBER(first_sample), MEMBER(end_sample), MEMBER(first_quad),
                           MEMBER(first_field),  MEMBER(end_field),  MEMBER(first_word)};
    check_array<Struct>(lattice_visibility(), "clusters", expected);
    check_array<Struct>(light_project(), "clusters", expected);
    check_array<Struct>(light_expand(), "clusters", expected);
  }
  {
    using Struct = LatticeClusterRows;
    check_array<Struct>(lattice_features(), "clusters", {MEMBER(first_word), MEMBER(first_byte)});
  }
  {
    using Struct = LatticeCornerList;
    check_array<Struct>(lattice_features(), "points", {MEMBER(points), MEMBER(weights), MEMBER(count)});
  }
  {
    using Struct = SampleLight;
    check_array<Struct>(sample_light(), "lights",
                        {MEMBER(position), MEMBER(w), MEMBER(axis), MEMBER(offset), MEMBER(intensity),
                         MEMBER(square), MEMBER(softness), MEMBER(softening)});
  }
}

TEST_CASE("words, features, values and colours of samples lie as densely as in C++") {
  for (const char* name : {"bits", "before", "rows", "scales"})
    CHECK(lattice_features().array(name).stride == 4);
  CHECK(lattice_features().array("features").stride == LATTICE_BLOCK * sizeof(float));
  CHECK(lattice_visibility().array("features").stride == LATTICE_BLOCK * sizeof(float));
  for (const char* name : {"coefficients", "visibility"}) CHECK(lattice_visibility().array(name).stride == 4);
  for (const char* name : {"positions", "normals", "direct"})
    CHECK(sample_light().array(name).stride == sizeof(vec3));
  for (const char* name : {"values", "scales", "offsets", "coefficients"})
    CHECK(light_project().array(name).stride == 4);
  CHECK(light_project().array("direct").stride == sizeof(vec3));
  for (const char* name : {"values", "scales", "coefficients"}) CHECK(light_mix().array(name).stride == 4);
  CHECK(light_mix().array("weights").stride == sizeof(vec3));
  for (const char* name : {"values", "scales"}) CHECK(light_expand().array(name).stride == 4);
  for (const char* name : {"weights", "indirect"}) CHECK(light_expand().array(name).stride == sizeof(vec3));
}
