// Scenes from glTF 2.0 files.
#pragma once

#include <coppice/scene/scene.hpp>
#include <filesystem>

namespace coppice {

struct LoadOptions {
  /// Plays the file's first animation: meshes that it moves become Scene::objects. Otherwise everything
  /// stands still in Scene::mesh, as the nodes' own transforms say.
  bool separate_moving = false;
};

/// Loads the default scene of a .glb or .gltf file (told apart by content, not by name), with the buffers and
/// images that it refers to, flattened to world space: one mesh, its nodes in depth-first order.
///
/// * Triangles, strips and fans, indexed or not. Vertices that share an index stay shared; those that no
///   triangle uses are left out. Mirrored nodes are rewound, so that counter-clockwise stays the front.
/// * Missing normals: flat ones, by unsharing vertices. Missing tangents where a normal texture is used: from
///   the derivatives of TEXCOORD_0 (zero xyz where those are degenerate).
/// * Materials keep their indices; triangles without one use a default material behind the last.
/// * An image used both as sRGB and as linear data becomes two textures. Sampler filters are not kept.
/// * Extensions: KHR_lights_punctual, KHR_materials_emissive_strength, KHR_mesh_quantization.
///
/// What is dropped or replaced stands in Scene::warnings, a line and a count each: zero-area triangles, zero
/// normals, points and lines, blending, skins, morph targets, animations, vertex colours, texture coordinates
/// other than set 0, other extensions. Occlusion textures are left out silently.
///
/// With LoadOptions::separate_moving, each animated node with a mesh at or below it makes one object: the
/// meshes down to the next animated nodes, in the frame of the node without its scale. Objects stand in the
/// order of their first meshes. Nodes move by STEP, LINEAR and CUBICSPLINE channels of translation and
/// rotation, carried along by their parents; a channel whose values are all the same moves nothing, but its
/// value counts. What is not rigid or not a mesh stays as the node's own transform says, with a warning that
/// names the node: animated scales, rotations below an uneven scale, morph weights, cameras, lights.
///
/// Throws InputError, which names the file and the item at fault, where the file cannot be read or breaks the
/// format, where an accessor reaches beyond its data, is sparse, or holds a used value that is not finite,
/// where a world coordinate exceeds 1e9 (areas overflow in float), where the scene exceeds 2^26 triangles or
/// vertices, 2^30 texels, 2^27 in one image, or 2^24 keyframes over all objects and their parents, and where
/// the file requires an extension that is not listed above. No count in a file is trusted before the bytes
/// behind it are there.
Scene load_gltf(const std::filesystem::path& file, const LoadOptions& options = {});

}  // namespace coppice
