// What a file's animation says about its nodes.
#pragma once

#include <coppice/scene/motion.hpp>
#include <map>
#include <optional>
#include <vector>

#include "nodes.hpp"

namespace coppice::gltf {

/// The channels of one node, each in place of the node's own value. Channels that it has not are empty.
struct NodeTracks {
  std::optional<Keyframes<vec3>> translation;
  std::optional<Keyframes<glm::quat>> rotation;  ///< keys are unit
  std::optional<Keyframes<vec3>> scale;
};

/// Counts the keyframes that are kept, which a file may share among many nodes.
class KeyBudget {
 public:
  explicit KeyBudget(const Document& document) : document_(document) {}

  /// Throws InputError beyond 2^24.
  void admit(std::size_t count, const std::string& item);

 private:
  const Document& document_;
  std::size_t count_ = 0;
};

/// Tracks of the file's first animation, by the number of the node, for nodes of the scene. Throws
/// InputError.
std::map<std::size_t, NodeTracks> read_tracks(const Document& document, const std::vector<PlacedNode>& nodes,
                                              KeyBudget& budget, Warnings& warnings);

}  // namespace coppice::gltf
