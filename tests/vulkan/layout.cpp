// The structs that C++ and GLSL share, as the compiled kernel sees them.
#include <coppice/shared/cut_shade.h>
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

  Offsets parameter_offsets() const { return offsets(parameters_); }

  /// The array behind the address that the parameter `name` holds.
  ArrayLayout array(const std::string& name) const {
    for (unsigned i = 0; i < spvc_type_get_num_member_types(type(parameters_)); ++i) {
      if (name != spvc_compiler_get_member_name(compiler_, parameters_, i)) continue;
      const spvc_type_id block = member_type(parameters_, i);
      unsigned stride = 0;
      ok(spvc_compiler_type_struct_member_array_stride(compiler_, type(block), 0, &stride));
      return {stride, offsets(member_type(block, 0))};
    }
    FAIL("no parameter of the name " << name);
    return {};
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

  Offsets offsets(spvc_type_id parent) const {
    Offsets result;
    for (unsigned i = 0; i < spvc_type_get_num_member_types(type(parent)); ++i) {
      unsigned offset = 0;
      ok(spvc_compiler_type_struct_member_offset(compiler_, type(parent), i, &offset));
      result[spvc_compiler_get_member_name(compiler_, parent, i)] = offset;
    }
    return result;
  }

  spvc_context context_ = nullptr;
  spvc_compiler compiler_ = nullptr;
  spvc_type_id parameters_ = 0;
};

const Reflection& cut_shade() {
  static const Reflection reflection(COPPICE_SHADER_DIR "/cut_shade.spv");
  return reflection;
}

#define MEMBER(name) \
  { #name, offsetof(Struct, name) }

}  // namespace

TEST_CASE("the kernel's parameters have the offsets of C++") {
  using Struct = CutShadeParameters;
  const Offsets expected{MEMBER(visibility_masks),
                         MEMBER(first_value),
                         MEMBER(values),
                         MEMBER(horizons),
                         MEMBER(faces),
                         MEMBER(points),
                         MEMBER(nodes),
                         MEMBER(illumination_ends),
                         MEMBER(illumination_granules),
                         MEMBER(radiance),
                         MEMBER(cluster_count),
                         MEMBER(leaf_count),
                         MEMBER(granule_log2),
                         MEMBER(lobes),
                         MEMBER(tolerance),
                         MEMBER(first_point),
                         MEMBER(end_point)};
  CHECK(cut_shade().parameter_offsets() == expected);
}

TEST_CASE("LightNode has the offsets and the stride of C++") {
  using Struct = LightNode;
  const Offsets expected{MEMBER(power), MEMBER(spread), MEMBER(direction), MEMBER(solid_angle)};
  const ArrayLayout layout = cut_shade().array("nodes");
  CHECK(layout.offsets == expected);
  CHECK(layout.stride == sizeof(LightNode));
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
  const ArrayLayout layout = cut_shade().array("points");
  CHECK(layout.offsets == expected);
  CHECK(layout.stride == sizeof(ShadingPoint));
}

TEST_CASE("ShadingFace has the offsets and the stride of C++") {
  using Struct = ShadingFace;
  const Offsets expected{MEMBER(receivers), MEMBER(first_point)};
  const ArrayLayout layout = cut_shade().array("faces");
  CHECK(layout.offsets == expected);
  CHECK(layout.stride == sizeof(ShadingFace));
}

TEST_CASE("words, counts and radiance lie as densely as in C++") {
  for (const char* name : {"visibility_masks", "first_value", "values", "illumination_ends",
                           "illumination_granules", "cluster_count"})
    CHECK(cut_shade().array(name).stride == sizeof(std::uint32_t));
  CHECK(cut_shade().array("radiance").stride == sizeof(vec3));
}
