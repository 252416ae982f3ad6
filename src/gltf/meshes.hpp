// The triangles of nodes, carried into the world or into the frame of an object.
#pragma once

#include <coppice/scene/scene.hpp>
#include <cstdint>

#include "nodes.hpp"

namespace coppice::gltf {

/// A node, the frame to which its mesh goes, and where its triangles are collected.
struct MeshPlacement {
  std::size_t node;
  glm::dmat4 to_frame;
  Mesh& into;
};

/// Reads the meshes of nodes for a scene whose materials stand already.
class MeshBuilder {
 public:
  MeshBuilder(const Document& document, Scene& scene, Warnings& warnings)
      : document_(document), scene_(scene), warnings_(warnings) {}

  /// Appends the node's mesh, if it has one. Throws InputError.
  void append(const MeshPlacement& placement);

 private:
  void append_primitive(const MeshPlacement& placement, const tinygltf::Primitive& primitive,
                        const std::string& item);
  std::uint32_t material_index(const tinygltf::Primitive& primitive, const std::string& item);
  void warn_of_ignored(const tinygltf::Primitive& primitive);
  void admit_triangles(std::size_t count, const std::string& item);
  void admit_vertices(std::size_t count, const std::string& item);

  const Document& document_;
  Scene& scene_;
  Warnings& warnings_;
  std::size_t triangle_count_ = 0, vertex_count_ = 0;
  std::uint32_t default_material_ = ~0u;
};

}  // namespace coppice::gltf
