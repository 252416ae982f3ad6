// Which frame the mesh of a node belongs to: the world's, or that of a node that moves.
#pragma once

#include <coppice/scene/motion.hpp>
#include <vector>

#include "animation.hpp"
#include "nodes.hpp"

namespace coppice::gltf {

inline constexpr std::size_t world_frame = ~std::size_t{0};

/// Where a placed node stands.
struct NodeFrame {
  std::size_t frame = world_frame;  ///< index into Frames::moving, or world_frame
  glm::dmat4 to_frame{1};           ///< does not change with time
};

/// The frame of an animated node without its scale; it moves rigidly in its parent's.
struct MovingFrame {
  std::size_t node = 0;
  std::size_t parent = world_frame;
  std::size_t key_count = 0;  ///< of its joint and of all those above
  double reach = 0;           ///< how far its origin may get from the world's
  Joint joint;
};

struct Frames {
  std::vector<NodeFrame> of_nodes;  ///< a placed node
  std::vector<MovingFrame> moving;  ///< parents first

  /// The joints from the world to a moving frame.
  Motion motion(std::size_t frame) const;
};

/// All nodes in the world, where they are placed.
Frames resting_frames(const std::vector<PlacedNode>& nodes);

/// The nodes as the file's first animation moves them. Nodes whose animation is not rigid stay at rest in
/// their parents' frames, and a warning says so. Throws InputError.
Frames moving_frames(const Document& document, const std::vector<PlacedNode>& nodes, KeyBudget& budget,
                     Warnings& warnings);

}  // namespace coppice::gltf
