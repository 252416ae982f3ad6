// Metallic-roughness materials.
#pragma once

#include <coppice/scene/scene.hpp>

#include "document.hpp"

namespace coppice::gltf {

/// Fills the scene's materials, in the order of the file, and the textures that they use. Throws InputError.
void load_materials(const Document& document, Scene& scene, Warnings& warnings);

}  // namespace coppice::gltf
