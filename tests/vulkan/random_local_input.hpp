// Random, seeded input of the kernel local_cut_shade.
#pragma once

#include <coppice/relight/local_lighting.hpp>
#include <coppice/vulkan/local_cut_shader.hpp>

#include "random_input.hpp"

namespace coppice::test {

/// Owns what LocalCutShadeInput points to.
struct RandomLocalInput {
  RandomSettings settings;
  MaskedCuts<std::uint16_t> cuts;
  std::vector<float> scales;
  ShadingBuffer buffer;
  LocalFrameLighting frame;

  LocalCutShadeInput view() const {
    LocalCutShadeInput input;
    input.leaf_count = cuts.leaf_count();
    input.granule_log2 = cuts.granule_log2();
    input.visibility_masks = cuts.masks();
    input.first_value = cuts.first_value();
    input.values = cuts.values();
    input.scales = scales;
    input.positions = buffer.positions;
    input.faces = buffer.faces;
    input.points = buffer.points;
    return input;
  }
};

/// Scales differ by a factor of 1,000; one receiver in ten has none of the light.
inline void add_receiver(Random& random, RandomLocalInput& input) {
  Cut<std::uint16_t> cut;
  split(random, 0, input.settings.leaf_count, 1u << input.settings.granule_log2, cut.ends);
  for (std::size_t i = 0; i < cut.ends.size(); ++i)
    cut.values.push_back(random.uniform() < 0.4f ? 0 : std::uint16_t(random.below(65536)));
  input.cuts.append(cut);
  input.scales.push_back(
      random.below(10) == 0 ? 0 : std::pow(10.0f, -3 * random.uniform()) / (65535.0f * 65535.0f));
}

inline vec3 random_position(Random& random) {
  return {2 * random.uniform() - 1, 2 * random.uniform() - 1, 2 * random.uniform() - 1};
}

/// A quarter of the lights is far away. Nodes need not sum up their children: a kernel that took a wrong node
/// would show it.
inline LocalLightNode random_local_node(Random& random, bool is_leaf) {
  const vec3 power = random.uniform() < 0.1f ? vec3(0) : random_colour(random);
  const float variance = random.uniform(), w = random.below(4) == 0 ? 0.0f : 1.0f;
  return {power, is_leaf ? 0 : variance, 2.0f * random_position(random), w};
}

inline RandomLocalInput random_local_input(const RandomSettings& settings) {
  Random random(settings.seed);
  RandomLocalInput input{settings, {settings.leaf_count, settings.granule_log2}, {}, {}, {}};
  for (std::uint32_t i = 0; i < settings.receiver_count; ++i) add_receiver(random, input);
  input.buffer = random_buffer(random, settings);
  for (std::uint32_t i = 0; i < settings.point_count; ++i)
    input.buffer.positions.push_back(random_position(random));
  for (std::uint32_t h = 0; h < 2 * settings.leaf_count; ++h)
    input.frame.nodes.push_back(random_local_node(random, h >= settings.leaf_count));
  std::vector<std::uint32_t> ends;
  split(random, 0, settings.leaf_count, settings.finest_illumination, ends);
  set_illumination_cut(input.frame, settings.leaf_count, std::move(ends), settings.granule_log2);
  return input;
}

}  // namespace coppice::test
