// The node hierarchy, flattened.
#pragma once

#include <coppice/core/math.hpp>

#include "document.hpp"

namespace coppice::gltf {

/// A node of the scene and its transform to world space, in double so that deep hierarchies do not drift.
struct PlacedNode {
  std::size_t node = 0;
  glm::dmat4 to_world{1};
};

/// The nodes of the default scene (the first, where none is named; all, where there is no scene), depth
/// first. Throws InputError where they do not form trees or a transform is not affine and finite.
std::vector<PlacedNode> place_nodes(const Document& document);

/// Name of a node for messages.
std::string node_name(const Document& document, std::size_t node);

}  // namespace coppice::gltf
