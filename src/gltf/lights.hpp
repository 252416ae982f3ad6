// KHR_lights_punctual.
#pragma once

#include <coppice/scene/scene.hpp>
#include <vector>

#include "nodes.hpp"

namespace coppice::gltf {

/// The lights of the nodes, in world space and in the nodes' order. Throws InputError.
std::vector<PunctualLight> load_lights(const Document& document, const std::vector<PlacedNode>& nodes);

}  // namespace coppice::gltf
