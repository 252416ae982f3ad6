// Random, seeded input of the kernel cut_shade, and a device to run it on.
#pragma once

#include <coppice/shared/brdf.h>

#include <coppice/core/random.hpp>
#include <coppice/vulkan/cut_shader.hpp>
#include <iostream>
#include <vector>

namespace coppice::test {

/// True where a device of these options is there; else says why the test is skipped.
inline bool has_device(const VulkanOptions& options = {}) {
  const auto missing = VulkanDevice::unavailable(options);
  if (missing) std::cout << "SKIPPED: " << missing->what() << std::endl;
  return !missing;
}

struct RandomSettings {
  std::uint32_t leaf_count = 64;
  std::uint32_t granule_log2 = 0;
  std::uint32_t finest_illumination = 1;  ///< leaves; the illumination cut has no smaller range
  std::uint32_t receiver_count = 12;
  std::uint32_t face_count = 8;
  std::uint32_t point_count = 100;
  std::uint32_t brdf = BRDF_GGX;
  std::uint64_t seed = 1;
};

/// Owns what CutShadeInput points to. `ends` repeats the masks as lists, for the reference.
struct RandomInput {
  RandomSettings settings;
  std::vector<std::vector<std::uint32_t>> ends;
  std::vector<std::uint32_t> illumination_ends;
  std::vector<std::uint32_t> visibility_masks, first_value, illumination_mask;
  std::vector<std::uint8_t> values;
  std::vector<ShadingFace> faces;
  std::vector<ShadingPoint> points;
  std::vector<LightNode> nodes;

  CutShadeInput view() const {
    CutShadeInput input;
    input.leaf_count = settings.leaf_count;
    input.granule_log2 = settings.granule_log2;
    input.visibility_masks = visibility_masks;
    input.first_value = first_value;
    input.values = values;
    input.faces = faces;
    input.points = points;
    return input;
  }
};

/// Ends of a random cut of the node [begin, end), none of its ranges below `finest` leaves.
inline void split(Random& random, std::uint32_t begin, std::uint32_t end, std::uint32_t finest,
                  std::vector<std::uint32_t>& ends) {
  if (end - begin <= finest || random.uniform() < 0.2f) return ends.push_back(end);
  const std::uint32_t middle = (begin + end) / 2;
  split(random, begin, middle, finest, ends);
  split(random, middle, end, finest, ends);
}

inline std::vector<std::uint32_t> mask_of(const std::vector<std::uint32_t>& ends, std::uint32_t leaf_count,
                                          std::uint32_t unit) {
  std::vector<std::uint32_t> mask((leaf_count / unit + 31) / 32, 0);
  for (const std::uint32_t end : ends) mask[(end / unit - 1) / 32] |= 1u << ((end / unit - 1) % 32);
  return mask;
}

inline vec3 random_colour(Random& random) { return {random.uniform(), random.uniform(), random.uniform()}; }

inline void add_receiver(Random& random, RandomInput& input) {
  const std::uint32_t granule = 1u << input.settings.granule_log2;
  std::vector<std::uint32_t> ends;
  split(random, 0, input.settings.leaf_count, granule, ends);
  const auto mask = mask_of(ends, input.settings.leaf_count, granule);
  input.visibility_masks.insert(input.visibility_masks.end(), mask.begin(), mask.end());
  input.first_value.push_back(std::uint32_t(input.values.size()));
  for (std::size_t i = 0; i < ends.size(); ++i)
    input.values.push_back(random.uniform() < 0.4f ? 0 : std::uint8_t(random.below(256)));
  input.ends.push_back(std::move(ends));
}

inline ShadingPoint random_point(Random& random, const RandomSettings& settings, std::uint32_t face) {
  const bool exponent = settings.brdf == BRDF_PHONG || settings.brdf == BRDF_BLINN_PHONG;
  ShadingPoint point{};
  vec3 bitangent;
  point.normal = random.direction();
  make_frame(point.normal, point.tangent, bitangent);
  point.to_viewer = normalize(random.direction() + 0.9f * point.normal);
  point.brdf = settings.brdf;
  point.alpha_x = exponent ? 1 + 60 * random.uniform() : 0.1f + 0.8f * random.uniform();
  point.alpha_y = 0.1f + 0.8f * random.uniform();
  point.diffuse = random_colour(random);
  point.specular = random_colour(random);
  point.fresnel = random_colour(random);
  point.weight_0 = random.uniform();
  point.weight_1 = (1 - point.weight_0) * random.uniform();
  point.face = face;
  return point;
}

/// Nodes need not sum up their children: a kernel that took a wrong node would show it.
inline LightNode random_node(Random& random) {
  const vec3 power = random.uniform() < 0.1f ? vec3(0) : random_colour(random);
  return {.power = power, .spread = random.uniform(), .direction = random.direction(), .solid_angle = 1};
}

inline RandomInput random_input(const RandomSettings& settings) {
  Random random(settings.seed);
  RandomInput input;
  input.settings = settings;
  const std::uint32_t receivers = settings.receiver_count;
  for (std::uint32_t i = 0; i < receivers; ++i) add_receiver(random, input);
  for (std::uint32_t f = 0; f < settings.face_count; ++f) {
    const std::uint32_t first = std::uint32_t(std::uint64_t(f) * settings.point_count / settings.face_count);
    input.faces.push_back(
        {{random.below(receivers), random.below(receivers), random.below(receivers)}, first});
  }
  for (std::uint32_t i = 0; i < settings.point_count; ++i) {
    const auto face = std::uint32_t((std::uint64_t(i) * settings.face_count) / settings.point_count);
    input.points.push_back(random_point(random, settings, face));
  }
  for (std::uint32_t h = 0; h < 2 * settings.leaf_count; ++h) input.nodes.push_back(random_node(random));
  split(random, 0, settings.leaf_count, settings.finest_illumination, input.illumination_ends);
  input.illumination_mask = mask_of(input.illumination_ends, settings.leaf_count, 1);
  return input;
}

}  // namespace coppice::test
