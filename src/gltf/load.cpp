#include <coppice/core/error.hpp>
#include <coppice/gltf/load.hpp>
#include <new>

#include "camera.hpp"
#include "document.hpp"
#include "frames.hpp"
#include "lights.hpp"
#include "materials.hpp"
#include "meshes.hpp"
#include "nodes.hpp"

namespace coppice {
namespace {

std::string object_name(const gltf::Document& document, std::size_t node) {
  const std::string& name = document.model.nodes[node].name;
  return name.empty() ? gltf::item_name("node", node) : gltf::one_line(name, 60);
}

// Finds the object of a moving frame, and makes it where it has none so far.
class Objects {
 public:
  Objects(const gltf::Document& document, const gltf::Frames& frames, gltf::KeyBudget& budget,
          std::vector<MovingObject>& objects)
      : document_(document), frames_(frames), budget_(budget), objects_(objects) {
    places_.resize(frames.moving.size(), none);
  }

  Mesh& mesh_of(std::size_t frame) {
    if (places_[frame] == none) {
      const gltf::MovingFrame& moving = frames_.moving[frame];
      budget_.admit(moving.key_count, gltf::node_name(document_, moving.node));
      places_[frame] = objects_.size();
      objects_.push_back({object_name(document_, moving.node), {}, frames_.motion(frame)});
    }
    return objects_[places_[frame]].mesh;
  }

 private:
  static constexpr std::size_t none = ~std::size_t{0};
  const gltf::Document& document_;
  const gltf::Frames& frames_;
  gltf::KeyBudget& budget_;
  std::vector<MovingObject>& objects_;
  std::vector<std::size_t> places_;
};

void load_meshes(const gltf::Document& document, const std::vector<gltf::PlacedNode>& nodes, Scene& scene,
                 const LoadOptions& options, gltf::Warnings& warnings) {
  gltf::KeyBudget budget(document);
  const gltf::Frames frames = options.separate_moving ? gltf::moving_frames(document, nodes, budget, warnings)
                                                      : gltf::resting_frames(nodes);
  gltf::MeshBuilder builder(document, scene, warnings);
  Objects objects(document, frames, budget, scene.objects);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (document.model.nodes[nodes[i].node].mesh == -1) continue;
    const auto& [frame, to_frame] = frames.of_nodes[i];
    Mesh& into = frame == gltf::world_frame ? scene.mesh : objects.mesh_of(frame);
    builder.append({nodes[i].node, to_frame, into});
  }
  std::erase_if(scene.objects, [](const MovingObject& object) { return object.mesh.triangles.empty(); });
}

Scene load(const std::filesystem::path& file, const LoadOptions& options) {
  gltf::Warnings warnings;
  const gltf::Document document = gltf::read_document(file, warnings);
  if (!options.separate_moving) warnings.count("animations ignored", document.model.animations.size());
  const std::vector<gltf::PlacedNode> nodes = gltf::place_nodes(document);
  Scene scene;
  gltf::load_materials(document, scene, warnings);
  load_meshes(document, nodes, scene, options, warnings);
  scene.camera = gltf::find_camera(document, nodes, warnings);
  scene.lights = gltf::load_lights(document, nodes);
  if (scene.mesh.triangles.empty() && scene.objects.empty()) warnings.add("the scene has no triangles");
  scene.warnings = warnings.lines();
  return scene;
}

}  // namespace

Scene load_gltf(const std::filesystem::path& file, const LoadOptions& options) {
  const std::string name = gltf::one_line(file.string());
  try {
    return load(file, options);
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
