// The triangles of placed nodes, in world space.
#pragma once

#include <coppice/scene/scene.hpp>
#include <cstdint>

#include "nodes.hpp"

namespace coppice::gltf {

/// Appends the meshes of nodes to a scene whose materials stand already.
class MeshBuilder {
 public:
  MeshBuilder(const Document& document, Scene& scene, Warnings& warnings)
      : document_(document), scene_(scene), warnings_(warnings) {}

  /// The node's mesh, if it has one. Throws InputError.
  void append(const PlacedNode& placed);

 private:
  void append_primitive(const PlacedNode& placed, const tinygltf::Primitive& primitive,
                        const std::string& item);
  std::uint32_t material_index(const tinygltf::Primitive& primitive, const std::string& item);
  void warn_of_ignored(const tinygltf::Primitive& primitive);
  void admit(std::size_t triangles, const std::string& item);

  const Document& document_;
  Scene& scene_;
  Warnings& warnings_;
  std::size_t admitted_triangles_ = 0;
  std::uint32_t default_material_ = ~0u;
};

}  // namespace coppice::gltf
