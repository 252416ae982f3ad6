// The structs that C++ and GLSL share, as the compiled kernels see them.
#include <coppice/shared/cut_product.h>
#include <doctest/doctest.h>
#include <spirv_cross_c.h>

#include <algorithm>
#include <cstddef>
#include <fstream>
#include <map>
#include <string>
#include <vector>

namespace {

using namespace coppice;
using Offsets = std::map<std::string, std::size_t>;

struct ArrayLayout {
  std::size_t stride = 0;
  Offsets offsets;  ///< of the members of an element; empty where it is no struct
};

std::vector<SpvId> read_words(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::vector<char> bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  std::vector<SpvId> words(bytes.size() / sizeof(SpvId));
  std::copy_n(bytes.data(), words.size() * sizeof(SpvId), reinterpret_cast<char*>(words.data()));
  return words;
}

void ok(spvc_result result) { REQUIRE(result == SPVC_SUCCESS); }

/// What SPIRV-Cross says of a module with one block of push constants, a struct of buffer addresses and
/// numbers.
class Reflection {
 public:
  explicit Reflection(const std::string& path) {
    const auto words = read_words(path);
    REQUIRE(!words.empty());
    ok(spvc_context_create(&context_));
    spvc_parsed_ir module;
    ok(spvc_context_parse_spirv(context_, words.data(), words.size(), &module));
    ok(spvc_context_create_compiler(context_, SPVC_BACKEND_NONE, module, SPVC_CAPTURE_MODE_TAKE_OWNERSHIP,
                                    &compiler_));
    parameters_ = member_type(push_constants(), 0);
  }
  ~Reflection() { spvc_context_destroy(context_); }
  Reflection(const Reflection&) = delete;
  Reflection& operator=(const Reflection&) = delete;

  /// Members of members are named as in C++: "outer.inner".
  Offsets parameter_offsets() const { return offsets(parameters_); }

  /// The array behind the address that the parameter `name` holds.
  ArrayLayout array(const std::string& name) const {
    const spvc_type_id block = blocks(parameters_).at(name);
    unsigned stride = 0;
    ok(spvc_compiler_type_struct_member_array_stride(compiler_, type(block), 0, &stride));
    return {stride, offsets(member_type(block, 0))};
  }

 private:
  spvc_type type(spvc_type_id id) const { return spvc_compiler_get_type_handle(compiler_, id); }

  /// Without the pointer or the array around it.
  spvc_type_id member_type(spvc_type_id parent, unsigned index) const {
    return spvc_type_get_base_type_id(type(spvc_type_get_member_type(type(parent), index)));
  }

  spvc_type_id push_constants() const {
    spvc_resources resources;
    ok(spvc_compiler_create_shader_resources(compiler_, &resources));
    const spvc_reflected_resource* list;
    std::size_t count = 0;
    ok(spvc_resources_get_resource_list_for_type(resources, SPVC_RESOURCE_TYPE_PUSH_CONSTANT, &list, &count));
    REQUIRE(count == 1);
    return list[0].base_type_id;
  }

  std::string member_name(spvc_type_id parent, unsigned index) const {
    return spvc_compiler_get_member_name(compiler_, parent, index);
  }

  bool is_address(spvc_type_id parent, unsigned index) const {
    return spvc_type_get_storage_class(type(spvc_type_get_member_type(type(parent), index))) ==
           SpvStorageClassPhysicalStorageBuffer;
  }

  /// Calls visit(name, offset, type) for each member of `parent`, and of the structs in it.
  template <class Visit>
  void for_each_member(spvc_type_id parent, Visit&& visit, const std::string& prefix = "",
                       std::size_t first = 0) const {
    for (unsigned i = 0; i < spvc_type_get_num_member_types(type(parent)); ++i) {
      const std::string name = prefix + member_name(parent, i);
      unsigned offset = 0;
      ok(spvc_compiler_type_struct_member_offset(compiler_, type(parent), i, &offset));
      const spvc_type_id member = member_type(parent, i);
      if (!is_address(parent, i) && spvc_type_get_basetype(type(member)) == SPVC_BASETYPE_STRUCT)
        for_each_member(member, visit, name + ".", first + offset);
      else
        visit(name, first + offset, member);
    }
  }

  Offsets offsets(spvc_type_id parent) const {
    Offsets result;
    for_each_member(parent,
                    [&](const auto& name, std::size_t offset, spvc_type_id) { result[name] = offset; });
    return result;
  }

  /// What addresses point to, by the name of the member that holds them.
  std::map<std::string, spvc_type_id> blocks(spvc_type_id parent) const {
    std::map<std::string, spvc_type_id> result;
    for_each_member(parent, [&](const auto& name, std::size_t, spvc_type_id id) { result[name] = id; });
    return result;
  }

  spvc_context context_ = nullptr;
  spvc_compiler compiler_ = nullptr;
  spvc_type_id parameters_ = 0;
};

#define KERNEL(name)                                                         \
  const Reflection& name() {                                                 \
    static const Reflection reflection(COPPICE_SHADER_DIR "/" #name ".spv"); \
    return reflection;                                                       \
  }
KERNEL(cut_shade)
KERNEL(local_cut_shade)
KERNEL(cut_ranks)
KERNEL(cut_product_masks)
KERNEL(cut_product_values)

#define MEMBER(name) \
  { #name, offsetof(Struct, name) }

Offsets with(Offsets all, const Offsets& more) {
  all.insert(more.begin(), more.end());
  return all;
}

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
