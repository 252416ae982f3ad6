// The node hierarchy, flattened.
#pragma once

#include <coppice/core/math.hpp>

#include "document.hpp"

namespace coppice::gltf {

inline constexpr std::size_t no_parent = ~std::size_t{0};

/// A node of the scene and its transform to world space, in double so that deep hierarchies do not drift.
struct PlacedNode {
  std::size_t node = 0;
  std::size_t parent = no_parent;  ///< place among the placed nodes, before this one's
  glm::dmat4 to_world{1};
};

/// A node's own transform where it is given in parts: scales, then turns, then moves.
struct LocalTransform {
  glm::dvec3 translation{0};
  glm::dquat rotation{1, 0, 0, 0};  ///< unit
  glm::dvec3 scale{1};

  glm::dmat4 matrix() const;
};

/// The nodes of the default scene (the first, where none is named; all, where there is no scene), depth
/// first. Throws InputError where they do not form trees or a transform is not affine and finite.
std::vector<PlacedNode> place_nodes(const Document& document);

/// The parts of a node's transform to its parent. Throws InputError.
LocalTransform local_transform(const Document& document, std::size_t node);

/// A node's transform to its parent, given in parts or as a matrix. Throws InputError.
glm::dmat4 local_matrix(const Document& document, std::size_t node);

/// Name of a node for messages.
std::string node_name(const Document& document, std::size_t node);

}  // namespace coppice::gltf
