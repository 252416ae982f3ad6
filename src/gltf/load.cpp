#include <coppice/core/error.hpp>
#include <coppice/gltf/load.hpp>
#include <new>

#include "camera.hpp"
#include "document.hpp"
#include "lights.hpp"
#include "materials.hpp"
#include "meshes.hpp"
#include "nodes.hpp"

namespace coppice {
namespace {

Scene load(const std::filesystem::path& file) {
  gltf::Warnings warnings;
  const gltf::Document document = gltf::read_document(file, warnings);
  const std::vector<gltf::PlacedNode> nodes = gltf::place_nodes(document);
  Scene scene;
  gltf::load_materials(document, scene, warnings);
  gltf::MeshBuilder builder(document, scene, warnings);
  for (const gltf::PlacedNode& node : nodes) builder.append(node);
  scene.camera = gltf::find_camera(document, nodes, warnings);
  scene.lights = gltf::load_lights(document, nodes);
  if (scene.mesh.triangles.empty()) warnings.add("the scene has no triangles");
  scene.warnings = warnings.lines();
  return scene;
}

}  // namespace

Scene load_gltf(const std::filesystem::path& file) {
  const std::string name = gltf::one_line(file.string());
  try {
    return load(file);
  } catch (const InputError&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw InputError(name, "it needs more memory than there is", "split the scene");
  } catch (
      const std::exception& error) {  // tinygltf lets some of its parser's and containers' exceptions out
    throw InputError(name, "it cannot be parsed (" + gltf::one_line(error.what()) + ")",
                     "export the file again as valid glTF 2.0");
  }
}

}  // namespace coppice
