#include "lights.hpp"

#include <cmath>
#include <optional>

namespace coppice::gltf {
namespace {

constexpr const char* extension = "KHR_lights_punctual";

std::optional<int> light_index(const Document& document, std::size_t node) {
  const tinygltf::ExtensionMap& extensions = document.model.nodes[node].extensions;
  const auto found = extensions.find(extension);
  if (found == extensions.end()) return std::nullopt;
  const bool given = found->second.IsObject() && found->second.Get("light").IsInt();
  const int index = given ? found->second.Get("light").GetNumberAsInt() : -1;
  if (!has_item(document.model.lights, index))
    document.fail(node_name(document, node), given ? "there is no light " + std::to_string(index)
                                                   : std::string(extension) + " names no light");
  return index;
}

float positive(const Document& document, double value, const std::string& item, const char* name) {
  if (!(value >= 0) || !std::isfinite(float(value)))
    document.fail(item, std::string(name) + " is negative or not a finite float");
  return float(value);
}

PunctualLightType light_type(const Document& document, const std::string& type, const std::string& item) {
  if (type == "point") return PunctualLightType::point;
  if (type == "spot") return PunctualLightType::spot;
  if (type == "directional") return PunctualLightType::directional;
  document.fail(item, "type " + one_line(type, 20) + " is unknown");
}

void read_cones(const Document& document, const tinygltf::SpotLight& spot, PunctualLight& light,
                const std::string& item) {
  light.inner_cone = positive(document, spot.innerConeAngle, item, "innerConeAngle");
  light.outer_cone = positive(document, spot.outerConeAngle, item, "outerConeAngle");
  if (!(light.inner_cone < light.outer_cone) || light.outer_cone > pi / 2 * 1.00001f)
    document.fail(item, "its cone angles are not 0 <= inner < outer <= pi/2");
}

PunctualLight read_light(const Document& document, std::size_t index) {
  const tinygltf::Light& source = document.model.lights[index];
  const std::string item = item_name("light", index, source.name);
  PunctualLight light;
  light.type = light_type(document, source.type, item);
  if (!source.color.empty() && source.color.size() != 3) document.fail(item, "color has not 3 numbers");
  for (int c = 0; c < 3; ++c) {
    const double color = source.color.empty() ? 1 : source.color[std::size_t(c)];
    light.intensity[c] = positive(document, color * source.intensity, item, "color times intensity");
  }
  light.range = positive(document, source.range, item, "range");
  if (light.type == PunctualLightType::spot) read_cones(document, source.spot, light, item);
  return light;
}

}  // namespace

std::vector<PunctualLight> load_lights(const Document& document, const std::vector<PlacedNode>& nodes) {
  std::vector<PunctualLight> lights;
  for (const PlacedNode& placed : nodes) {
    const std::optional<int> index = light_index(document, placed.node);
    if (!index) continue;
    PunctualLight light = read_light(document, std::size_t(*index));
    const glm::dvec3 backward(placed.to_world[2]);
    const double size = length(backward);
    if (size > 0)
      light.direction = vec3(-backward / size);
    else if (light.type != PunctualLightType::point)
      document.fail(node_name(document, placed.node), "its transform leaves its light without a direction");
    light.position = vec3(placed.to_world[3]);
    lights.push_back(light);
  }
  return lights;
}

}  // namespace coppice::gltf
