// The structs of the kernels of VPLs, as the compiled kernels see them.
#include <coppice/shared/vpl_gather.h>
#include <doctest/doctest.h>

#include "reflection.hpp"

using namespace coppice;
using namespace coppice::test;

namespace {

KERNEL(vpl_filter)
KERNEL(vpl_walk)
KERNEL(vpl_lists)

template <class Struct>
Offsets gather_offsets() {
  return {MEMBER(gather.nodes), MEMBER(gather.points), MEMBER(gather.radiance), MEMBER(gather.taken),
          MEMBER(gather.next),  MEMBER(range.begin),   MEMBER(range.end)};
}

}  // namespace

TEST_CASE("the parameters of the kernels of VPLs have the offsets of C++") {
  {
    using Struct = VplFilterParameters;
    const Offsets expected{MEMBER(nodes), MEMBER(first), MEMBER(levels)};
    CHECK(vpl_filter().parameter_offsets() == expected);
  }
  {
    using Struct = VplWalkParameters;
    CHECK(vpl_walk().parameter_offsets() ==
          with(gather_offsets<Struct>(),
               {MEMBER(marks), MEMBER(leaf_count), MEMBER(has_marks), MEMBER(nearest)}));
  }
  {
    using Struct = VplListsParameters;
    CHECK(vpl_lists().parameter_offsets() == with(gather_offsets<Struct>(), {MEMBER(ends), MEMBER(lists)}));
  }
}

TEST_CASE("VplNode has the offsets and the stride of C++") {
  using Struct = VplNode;
  const Offsets expected{MEMBER(diffuse),  MEMBER(energy),   MEMBER(specular), MEMBER(exponent),
                         MEMBER(position), MEMBER(variance), MEMBER(normal),   MEMBER(softening),
                         MEMBER(lobe),     MEMBER(area)};
  for (const ArrayLayout& layout :
       {vpl_filter().array("nodes"), vpl_walk().array("gather.nodes"), vpl_lists().array("gather.nodes")}) {
    CHECK(layout.offsets == expected);
    CHECK(layout.stride == sizeof(VplNode));
  }
}

TEST_CASE("GlossyPoint has the offsets and the stride of C++") {
  using Struct = GlossyPoint;
  const Offsets expected{MEMBER(position), MEMBER(exponent), MEMBER(normal),  MEMBER(pixel),
                         MEMBER(mirror),   MEMBER(group),    MEMBER(diffuse), MEMBER(padding),
                         MEMBER(specular), MEMBER(padding_2)};
  for (const auto* kernel : {&vpl_walk(), &vpl_lists()}) {
    const ArrayLayout layout = kernel->array("gather.points");
    CHECK(layout.offsets == expected);
    CHECK(layout.stride == sizeof(GlossyPoint));
  }
}

TEST_CASE("sums, counters, marks and lists lie as densely as in C++") {
  for (const auto* kernel : {&vpl_walk(), &vpl_lists()}) {
    CHECK(kernel->array("gather.radiance").stride == sizeof(vec3));
    for (const char* name : {"gather.taken", "gather.next"})
      CHECK(kernel->array(name).stride == sizeof(std::uint32_t));
  }
  CHECK(vpl_walk().array("marks").stride == sizeof(std::uint32_t));
  for (const char* name : {"ends", "lists"}) CHECK(vpl_lists().array(name).stride == sizeof(std::uint32_t));
}
