// Animations for the glTF files of the tests.
#pragma once

#include "builder.hpp"

namespace gltf_test {

inline constexpr coppice::LoadOptions moving{.separate_moving = true};

/// The JSON of one animation.
struct Clip {
  std::string samplers, channels;
  int count = 0;

  void add(int node, const std::string& path, int input, int output, const std::string& more = "") {
    const std::string comma = count > 0 ? "," : "";
    samplers += comma + R"({"input":)" + std::to_string(input) + R"(,"output":)" + std::to_string(output) +
                more + "}";
    channels += comma + R"({"sampler":)" + std::to_string(count++) + R"(,"target":{"node":)" +
                std::to_string(node) + R"(,"path":")" + path + "\"}}";
  }
  std::string json() const {
    return R"(,"animations":[{"samplers":[)" + samplers + R"(],"channels":[)" + channels + "]}]";
  }
};

inline int times(Builder& builder, const std::vector<float>& values) {
  return builder.add(values, 5126, 1, "SCALAR");
}

inline coppice::Scene load_moving_json(const std::string& json) {
  const Folder folder;
  return coppice::load_gltf(folder.write("scene.gltf", json), moving);
}

inline coppice::Scene load_moving(const Builder& builder) { return load_moving_json(builder.gltf()); }

inline std::string moving_complaint_of(const std::string& json) {
  try {
    load_moving_json(json);
    return "";
  } catch (const coppice::InputError& error) {
    return error.what();
  }
}

/// A square of the given node that slides by 4 x and turns a quarter about z in 2 seconds.
inline Builder sliding(const std::string& nodes, int node) {
  Builder builder = square();
  Clip clip;
  const int input = times(builder, {0, 2});
  clip.add(node, "translation", input, builder.vec3s({0, 0, 0, 4, 0, 0}));
  clip.add(node, "rotation", input, builder.vec4s({0, 0, 0, 1, 0, 0, 0.70710678f, 0.70710678f}));
  builder.nodes = nodes;
  builder.members = clip.json();
  return builder;
}

}  // namespace gltf_test
