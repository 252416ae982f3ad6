// From a primitive's mode and indices to a list of triangles.
#pragma once

#include <coppice/core/math.hpp>
#include <vector>

#include "document.hpp"

namespace coppice::gltf {

/// Vertex indices of a primitive in drawing order: its accessor's, or 0, 1, 2... where it has none.
/// Throws InputError where one is not below vertex_count.
std::vector<std::uint32_t> read_indices(const Document& document, const tinygltf::Primitive& primitive,
                                        std::size_t vertex_count, const std::string& item);

/// Triangles of a list, strip or fan (glTF 2.0, section 3.7.2.1), wound alike. Left-over indices are dropped.
std::vector<uvec3> assemble_triangles(const std::vector<std::uint32_t>& indices, int mode);

}  // namespace coppice::gltf
