// The structs of a compiled kernel: where its members lie.
#pragma once

#include <doctest/doctest.h>
#include <spirv_cross_c.h>

#include <algorithm>
#include <cstddef>
#include <fstream>
#include <map>
#include <string>
#include <vector>

namespace coppice::test {

using Offsets = std::map<std::string, std::size_t>;

struct ArrayLayout {
  std::size_t stride = 0;
  Offsets offsets;  ///< of the members of an element; empty where it is no struct
};

inline std::vector<SpvId> read_words(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::vector<char> bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  std::vector<SpvId> words(bytes.size() / sizeof(SpvId));
  std::copy_n(bytes.data(), words.size() * sizeof(SpvId), reinterpret_cast<char*>(words.data()));
  return words;
}

inline void ok(spvc_result result) { REQUIRE(result == SPVC_SUCCESS); }

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

inline Offsets with(Offsets all, const Offsets& more) {
  all.insert(more.begin(), more.end());
  return all;
}

}  // namespace coppice::test

/// A function of this name that reflects the kernel of this name.
#define KERNEL(name)                                                                        \
  const coppice::test::Reflection& name() {                                                 \
    static const coppice::test::Reflection reflection(COPPICE_SHADER_DIR "/" #name ".spv"); \
    return reflection;                                                                      \
  }

/// A member of the type `Struct`, and its offset.
#define MEMBER(name) \
  { #name, offsetof(Struct, name) }
