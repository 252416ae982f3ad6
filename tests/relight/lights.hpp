// Light trees over even directions, visibility that may be seen from somewhere, and receivers anywhere.
#pragma once

#include <coppice/core/random.hpp>
#include <coppice/light/directions.hpp>
#include <coppice/relight/visibility.hpp>
#include <coppice/tree/build.hpp>
#include <span>
#include <vector>

namespace relight_test {

using coppice::DirectionPackets;
using coppice::LightTree;
using coppice::Random;
using coppice::Receiver;
using coppice::vec3;

inline LightTree tree_over(std::span<const vec3> directions) {
  std::vector<coppice::LightSample> samples;
  for (const vec3& d : directions) samples.push_back({d, vec3(0)});
  return coppice::build_tree(coppice::GeometricMetric(samples));
}

struct Lights {
  std::vector<vec3> directions;
  LightTree tree;
  DirectionPackets packets;  ///< by leaf

  explicit Lights(std::uint32_t count)
      : directions(coppice::even_directions(count, 9)),
        tree(tree_over(directions)),
        packets(coppice::leaf_directions(tree, directions)) {}
};

/// Visibility by light: a half space, with some lights flipped at random.
inline std::vector<float> random_visibility(const Lights& lights, Random& random, float noise) {
  const vec3 axis = random.direction();
  const float level = random.uniform() - 0.5f;
  std::vector<float> values;
  for (const vec3& d : lights.directions)
    values.push_back((dot(d, axis) > level) != (random.uniform() < noise) ? 1.0f : 0.0f);
  return values;
}

inline std::vector<std::uint64_t> bits_of(const LightTree& tree, std::span<const float> visibility) {
  std::vector<std::uint64_t> bits(coppice::words_for_bits(tree.leaf_count()), 0);
  for (std::uint32_t i = 0; i < tree.leaf_count(); ++i)
    if (tree.light_of_leaf[i] != coppice::no_light && visibility[tree.light_of_leaf[i]] > 0)
      bits[i / 64] |= std::uint64_t{1} << (i % 64);
  return bits;
}

inline std::vector<Receiver> random_receivers(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<Receiver> receivers(count);
  for (Receiver& r : receivers) {
    r.position = 2 * random.uniform() * random.direction();
    r.normal = random.direction();
    r.horizon = -0.3f * random.uniform();
  }
  return receivers;
}

}  // namespace relight_test
