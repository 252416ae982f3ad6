// Triangles, one set of flat arrays.
#pragma once

#include <coppice/core/math.hpp>
#include <cstdint>
#include <vector>

namespace coppice {

/// Vertices and triangles in world space, or in the frame of an object that moves; units of the file (metres
/// in glTF).
struct Mesh {
  std::vector<vec3> positions;   ///< a vertex
  std::vector<vec3> normals;     ///< a vertex; unit shading normals
  std::vector<vec4> tangents;    ///< a vertex; xyz unit or zero (none), w = ±1: bitangent = w·(n × t)
  std::vector<vec2> uvs;         ///< a vertex; glTF TEXCOORD_0, (0, 0) is the upper left; zero where absent
  std::vector<uvec3> triangles;  ///< vertex indices, counter-clockwise seen from the front
  std::vector<std::uint32_t> materials;  ///< a triangle; index into Scene::materials
};

}  // namespace coppice
