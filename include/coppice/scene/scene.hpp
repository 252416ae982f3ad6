// A scene as a file describes it: triangles, materials, textures, camera, lights, and objects that move.
#pragma once

#include <coppice/core/math.hpp>
#include <coppice/scene/camera.hpp>
#include <coppice/scene/mesh.hpp>
#include <coppice/scene/motion.hpp>
#include <coppice/scene/texture.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace coppice {

/// glTF 2.0 metallic-roughness. A texture is an index into Scene::textures, or -1; factors multiply it.
struct Material {
  std::string name;
  vec3 base_color{1};
  float alpha = 1;
  float metallic = 1;
  float roughness = 1;
  vec3 emission{0};  ///< radiance: emissiveFactor × KHR_materials_emissive_strength
  int base_color_texture = -1;
  int metallic_roughness_texture = -1;  ///< green is roughness, blue is metallic
  int normal_texture = -1;
  float normal_scale = 1;
  int emission_texture = -1;
  bool alpha_mask = false;  ///< texels with alpha below the cutoff are holes, for camera and shadow rays
  float alpha_cutoff = 0.5f;
  bool double_sided = false;
};

enum class PunctualLightType : std::uint8_t { point, spot, directional };

/// KHR_lights_punctual, in world space. Intensity is candela (point, spot) or lux (directional), times
/// colour.
struct PunctualLight {
  PunctualLightType type = PunctualLightType::point;
  vec3 position{0};
  vec3 direction{0, 0, -1};  ///< along which spot and directional lights shine; unit
  vec3 intensity{1};
  float range = 0;  ///< metres; 0: unlimited
  float inner_cone = 0;
  float outer_cone = pi / 4;  ///< radians from the axis
};

/// A rigid object that moves.
struct MovingObject {
  std::string name;
  Mesh mesh;      ///< in the object's own frame, in units of the world; materials index Scene::materials
  Motion motion;  ///< from that frame to the world
};

/// Everything that a program needs of a scene file.
struct Scene {
  Mesh mesh;  ///< what rests
  std::vector<Material> materials;
  std::vector<Texture> textures;
  std::optional<Camera> camera;  ///< the first of the file
  std::vector<PunctualLight> lights;
  std::vector<MovingObject> objects;  ///< none, unless loading was asked to keep them apart
  std::vector<std::string> warnings;  ///< what was dropped or replaced on loading, one line each, with counts
};

/// Seconds until the last object comes to rest; 0 where nothing moves.
inline float animation_duration(const Scene& scene) {
  float last = 0;
  for (const MovingObject& object : scene.objects) last = std::fmax(last, object.motion.duration());
  return last;
}

}  // namespace coppice
