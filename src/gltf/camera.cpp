#include "camera.hpp"

#include <glm/gtc/constants.hpp>

namespace coppice::gltf {
namespace {

// The axes stay right-handed where the node mirrors or shears: a camera forms its image from directions
// alone.
Camera place_camera(const Document& document, const PlacedNode& placed, double vertical_fov) {
  const glm::dvec3 backward(placed.to_world[2]), upward(placed.to_world[1]);
  const glm::dvec3 sideways = cross(upward, backward);
  if (!(length(sideways) > 1e-12 * length(upward) * length(backward)))
    document.fail(node_name(document, placed.node), "its transform leaves its camera without a direction");
  Camera camera;
  const glm::dvec3 forward = -normalize(backward), right = normalize(sideways);
  camera.position = vec3(placed.to_world[3]);
  camera.forward = vec3(forward);
  camera.right = vec3(right);
  camera.up = vec3(cross(right, forward));
  camera.vertical_fov = float(vertical_fov);
  return camera;
}

}  // namespace

std::optional<Camera> find_camera(const Document& document, const std::vector<PlacedNode>& nodes,
                                  Warnings& warnings) {
  for (const PlacedNode& placed : nodes) {
    const int index = document.model.nodes[placed.node].camera;
    if (index == -1) continue;
    if (!has_item(document.model.cameras, index))
      document.fail(node_name(document, placed.node), "there is no camera " + std::to_string(index));
    const tinygltf::Camera& source = document.model.cameras[std::size_t(index)];
    if (source.type != "perspective") {
      warnings.count("orthographic cameras ignored");
      continue;
    }
    const double fov = source.perspective.yfov;
    if (!(fov > 0 && fov < glm::pi<double>()))
      document.fail(item_name("camera", std::size_t(index), source.name), "yfov is not between 0 and pi");
    return place_camera(document, placed, fov);
  }
  return std::nullopt;
}

}  // namespace coppice::gltf
