// Random, seeded input of the kernel cut_shade, and a device to run it on.
#pragma once

#include <coppice/shared/brdf.h>

#include <algorithm>
#include <coppice/core/random.hpp>
#include <coppice/cut/masked_cuts.hpp>
#include <coppice/relight/frame_lighting.hpp>
#include <coppice/relight/shading_buffer.hpp>
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
  bool narrow = false;  ///< roughness² 0.05 and 0.1, exponent 500
  std::uint64_t seed = 1;
};

/// Owns what CutShadeInput points to. `unpacked` are the same cuts as lists of ends, for the reference.
struct RandomInput {
  RandomSettings settings;
  std::vector<Cut<std::uint8_t>> unpacked;
  MaskedCuts<std::uint8_t> cuts;
  ShadingBuffer buffer;
  FrameLighting frame;

  CutShadeInput view() const {
    CutShadeInput input;
    input.leaf_count = settings.leaf_count;
    input.granule_log2 = settings.granule_log2;
    input.visibility_masks = cuts.masks();
    input.first_value = cuts.first_value();
    input.values = cuts.values();
    input.horizons = cuts.horizons();
    input.faces = buffer.faces;
    input.points = buffer.points;
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

inline vec3 random_colour(Random& random) { return {random.uniform(), random.uniform(), random.uniform()}; }

/// A third of the receivers see all around.
inline ReceiverHorizon random_horizon(Random& random) {
  if (random.below(3) == 0) return no_horizon;
  return {random.direction(), -0.5f * random.uniform()};
}

inline void add_receiver(Random& random, RandomInput& input) {
  Cut<std::uint8_t> cut;
  split(random, 0, input.settings.leaf_count, 1u << input.settings.granule_log2, cut.ends);
  for (std::size_t i = 0; i < cut.ends.size(); ++i)
    cut.values.push_back(random.uniform() < 0.4f ? 0 : std::uint8_t(random.below(256)));
  input.cuts.append(cut, random_horizon(random));
  input.unpacked.push_back(std::move(cut));
}

inline void set_brdf(Random& random, const RandomSettings& settings, ShadingPoint& point) {
  const bool exponent = settings.brdf == BRDF_PHONG || settings.brdf == BRDF_BLINN_PHONG;
  point.brdf = settings.brdf;
  point.alpha_x = exponent ? 1 + 60 * random.uniform() : 0.1f + 0.8f * random.uniform();
  point.alpha_y = 0.1f + 0.8f * random.uniform();
  if (!settings.narrow) return;
  point.alpha_x = exponent ? 500 : random.below(2) == 0 ? 0.05f : 0.1f;
  point.alpha_y = 0.1f;
}

inline ShadingPoint random_point(Random& random, const RandomSettings& settings, std::uint32_t face) {
  ShadingPoint point{};
  vec3 bitangent;
  point.normal = random.direction();
  make_frame(point.normal, point.tangent, bitangent);
  point.to_viewer = normalize(random.direction() + 0.9f * point.normal);
  set_brdf(random, settings, point);
  point.diffuse = random_colour(random);
  point.specular = random_colour(random);
  point.fresnel = random_colour(random);
  point.weight_0 = random.uniform();
  point.weight_1 = (1 - point.weight_0) * random.uniform();
  point.face = face;
  return point;
}

inline ShadingBuffer random_buffer(Random& random, const RandomSettings& settings) {
  ShadingBuffer buffer;
  const std::uint32_t receivers = settings.receiver_count;
  for (std::uint64_t f = 0; f < settings.face_count; ++f)
    buffer.faces.push_back({{random.below(receivers), random.below(receivers), random.below(receivers)}, 0});
  for (std::uint64_t i = 0; i < settings.point_count; ++i) {
    const auto face = std::uint32_t(i * settings.face_count / settings.point_count);
    buffer.points.push_back(random_point(random, settings, face));
  }
  for (std::uint32_t f = 0; f < settings.face_count; ++f)
    buffer.faces[f].first_point = std::uint32_t(
        std::ranges::lower_bound(buffer.points, f, {}, &ShadingPoint::face) - buffer.points.begin());
  return buffer;
}

/// Nodes need not sum up their children: a kernel that took a wrong node would show it.
inline LightNode random_node(Random& random, bool is_leaf) {
  const vec3 power = random.uniform() < 0.1f ? vec3(0) : random_colour(random);
  const float spread = random.uniform();
  return {power, is_leaf ? 0 : spread, random.direction(), 1};
}

inline FrameLighting random_frame(Random& random, const RandomSettings& settings) {
  FrameLighting frame;
  for (std::uint32_t h = 0; h < 2 * settings.leaf_count; ++h)
    frame.nodes.push_back(random_node(random, h >= settings.leaf_count));
  std::vector<std::uint32_t> ends;
  split(random, 0, settings.leaf_count, settings.finest_illumination, ends);
  set_illumination_cut(frame, settings.leaf_count, std::move(ends), settings.granule_log2);
  return frame;
}

inline RandomInput random_input(const RandomSettings& settings) {
  Random random(settings.seed);
  RandomInput input{settings, {}, {settings.leaf_count, settings.granule_log2}, {}, {}};
  for (std::uint32_t i = 0; i < settings.receiver_count; ++i) add_receiver(random, input);
  input.buffer = random_buffer(random, settings);
  input.frame = random_frame(random, settings);
  return input;
}

}  // namespace coppice::test
