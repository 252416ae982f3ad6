// Cameras of placed nodes.
#pragma once

#include <coppice/scene/camera.hpp>
#include <optional>

#include "nodes.hpp"

namespace coppice::gltf {

/// The first perspective camera in the order of the nodes, if there is one. Throws InputError.
std::optional<Camera> find_camera(const Document& document, const std::vector<PlacedNode>& nodes,
                                  Warnings& warnings);

}  // namespace coppice::gltf
