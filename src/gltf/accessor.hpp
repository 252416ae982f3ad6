// Typed, bounds-checked views of a glTF file's buffers.
#pragma once

#include <coppice/core/math.hpp>
#include <cstdint>
#include <span>

#include "document.hpp"

namespace coppice::gltf {

/// The bytes of a buffer view. Throws InputError (naming `item`) where they are not all there.
std::span<const unsigned char> view_bytes(const Document& document, int view, const std::string& item);

/// `count` elements of an accessor, every one of which lies inside its buffer view.
struct Elements {
  const unsigned char* data = nullptr;
  std::size_t count = 0;
  std::size_t stride = 0;
  int component_type = 0;
  bool normalized = false;

  /// Component c of element i; normalised integers map to [0, 1] or [-1, 1] (glTF 2.0, section 3.11).
  float component(std::size_t i, std::size_t c) const;
  vec2 as_vec2(std::size_t i) const { return {component(i, 0), component(i, 1)}; }
  vec3 as_vec3(std::size_t i) const { return {component(i, 0), component(i, 1), component(i, 2)}; }
  vec4 as_vec4(std::size_t i) const { return {as_vec3(i), component(i, 3)}; }
  std::uint32_t index(std::size_t i) const;
};

/// A vertex attribute of `type` (TINYGLTF_TYPE_VEC2...), any component type that glTF allows for one.
Elements attribute_elements(const Document& document, int accessor, int type, const std::string& item);

/// Vertex indices: unsigned scalars.
Elements index_elements(const Document& document, int accessor, const std::string& item);

}  // namespace coppice::gltf
