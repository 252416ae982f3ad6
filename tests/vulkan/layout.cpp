// The structs that C++ and GLSL share, as the compiled kernels see them.
#include <coppice/shared/cut_product.h>
#include <doctest/doctest.h>

#include "reflection.hpp"

using namespace coppice;
using namespace coppice::test;

namespace {

KERNEL(cut_shade)
KERNEL(local_cut_shade)
KERNEL(cut_ranks)
KERNEL(cut_product_masks)
KERNEL(cut_product_values)

template <class Struct>
Offsets shading_offsets() {
  return {MEMBER(shading.cuts.masks),
          MEMBER(shading.cuts.first_value),
          MEMBER(shading.cuts.values),
          MEMBER(shading.faces),
          MEMBER(shading.points),
          MEMBER(shading.illumination_ends),
          MEMBER(shading.illumination_granules),
          MEMBER(shading.radiance),
          MEMBER(shading.cluster_count),
          MEMBER(shading.leaf_count),
          MEMBER(shading.granule_log2),
          MEMBER(shading.lobes),
          MEMBER(shading.tolerance),
          MEMBER(range.begin),
          MEMBER(range.end),
          MEMBER(nodes)};
}

template <class Struct>
Offsets product_offsets() {
  return {MEMBER(product.base.masks),
          MEMBER(product.base.first_value),
          MEMBER(product.base.values),
          MEMBER(product.factors.masks),
          MEMBER(product.factors.first_value),
          MEMBER(product.factors.values),
          MEMBER(product.factor_ranks),
          MEMBER(product.first_factor),
          MEMBER(product.blends),
          MEMBER(masks),
          MEMBER(range.begin),
          MEMBER(range.end),
          MEMBER(words)};
}

}  // namespace

TEST_CASE("the parameters of the shading kernels have the offsets of C++") {
  {
    using Struct = CutShadeParameters;
    CHECK(cut_shade().parameter_offsets() == with(shading_offsets<Struct>(), {MEMBER(horizons)}));
  }
  {
    using Struct = LocalCutShadeParameters;
    CHECK(local_cut_shade().parameter_offsets() ==
          with(shading_offsets<Struct>(), {MEMBER(scales), MEMBER(positions)}));
  }
}

TEST_CASE("the parameters of the kernels of products have the offsets of C++") {
  {
    using Struct = CutRanksParameters;
    const Offsets expected{MEMBER(masks),       MEMBER(first_value), MEMBER(ranks),
                           MEMBER(range.begin), MEMBER(range.end),   MEMBER(words)};
    CHECK(cut_ranks().parameter_offsets() == expected);
  }
  {
    using Struct = ProductMasksParameters;
    CHECK(cut_product_masks().parameter_offsets() == with(product_offsets<Struct>(), {MEMBER(counts)}));
  }
  {
    using Struct = ProductValuesParameters;
    CHECK(cut_product_values().parameter_offsets() ==
          with(product_offsets<Struct>(), {MEMBER(base_ranks), MEMBER(ranks), MEMBER(values)}));
  }
}

TEST_CASE("LightNode has the offsets and the stride of C++") {
  using Struct = LightNode;
  const Offsets expected{MEMBER(power), MEMBER(spread), MEMBER(direction), MEMBER(solid_angle)};
  const ArrayLayout layout = cut_shade().array("nodes");
  CHECK(layout.offsets == expected);
  CHECK(layout.stride == sizeof(LightNode));
}

TEST_CASE("LocalLightNode has the offsets and the stride of C++") {
  using Struct = LocalLightNode;
  const Offsets expected{MEMBER(power), MEMBER(variance), MEMBER(position), MEMBER(w)};
  const ArrayLayout layout = local_cut_shade().array("nodes");
  CHECK(layout.offsets == expected);
  CHECK(layout.stride == sizeof(LocalLightNode));
}

TEST_CASE("ReceiverHorizon has the offsets and the stride of C++") {
  using Struct = ReceiverHorizon;
  const Offsets expected{MEMBER(normal), MEMBER(cosine)};
  const ArrayLayout layout = cut_shade().array("horizons");
  CHECK(layout.offsets == expected);
  CHECK(layout.stride == sizeof(ReceiverHorizon));
}

TEST_CASE("ShadingPoint has the offsets and the stride of C++") {
  using Struct = ShadingPoint;
  const Offsets expected{MEMBER(normal),    MEMBER(alpha_x),  MEMBER(tangent), MEMBER(alpha_y),
                         MEMBER(to_viewer), MEMBER(brdf),     MEMBER(diffuse), MEMBER(weight_0),
                         MEMBER(specular),  MEMBER(weight_1), MEMBER(fresnel), MEMBER(face)};
  for (const auto* kernel : {&cut_shade(), &local_cut_shade()}) {
    const ArrayLayout layout = kernel->array("shading.points");
    CHECK(layout.offsets == expected);
    CHECK(layout.stride == sizeof(ShadingPoint));
  }
}

TEST_CASE("ShadingFace has the offsets and the stride of C++") {
  using Struct = ShadingFace;
  const Offsets expected{MEMBER(receivers), MEMBER(first_point)};
  for (const auto* kernel : {&cut_shade(), &local_cut_shade()}) {
    const ArrayLayout layout = kernel->array("shading.faces");
    CHECK(layout.offsets == expected);
    CHECK(layout.stride == sizeof(ShadingFace));
  }
}

TEST_CASE("ProductFactor has the offsets and the stride of C++") {
  using Struct = ProductFactor;
  const Offsets expected{MEMBER(cuts), MEMBER(weights), MEMBER(count)};
  for (const auto* kernel : {&cut_product_masks(), &cut_product_values()}) {
    const ArrayLayout layout = kernel->array("product.blends");
    CHECK(layout.offsets == expected);
    CHECK(layout.stride == sizeof(ProductFactor));
  }
}

TEST_CASE("words, counts, positions and radiance lie as densely as in C++") {
  for (const auto* kernel : {&cut_shade(), &local_cut_shade()}) {
    for (const char* name :
         {"shading.cuts.masks", "shading.cuts.first_value", "shading.cuts.values",
          "shading.illumination_ends", "shading.illumination_granules", "shading.cluster_count"})
      CHECK(kernel->array(name).stride == sizeof(std::uint32_t));
    CHECK(kernel->array("shading.radiance").stride == sizeof(vec3));
  }
  CHECK(local_cut_shade().array("scales").stride == sizeof(float));
  CHECK(local_cut_shade().array("positions").stride == sizeof(vec3));
  for (const char* name : {"masks", "first_value", "ranks"})
    CHECK(cut_ranks().array(name).stride == sizeof(std::uint32_t));
  for (const char* name :
       {"masks", "ranks", "base_ranks", "values", "product.first_factor", "product.factor_ranks"})
    CHECK(cut_product_values().array(name).stride == sizeof(std::uint32_t));
}
