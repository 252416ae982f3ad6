// Random, seeded VPLs and points that reflect them.
#pragma once

#include <coppice/gather/angle_walk.hpp>
//
#include <cmath>
#include <coppice/core/random.hpp>
#include <vector>

namespace coppice::test {

inline vec3 random_rgb(Random& random) { return {random.uniform(), random.uniform(), random.uniform()}; }

inline vec3 random_place(Random& random) { return 6.0f * random_rgb(random) - vec3(3); }

inline float power_of_ten(Random& random, float low, float high) {
  return std::pow(10.0f, low + (high - low) * random.uniform());
}

/// In a box of 6 m. One in five is dark, one in five has no lobe, one in five nothing but its lobe; one in
/// five shines all over, with an exponent from -1 to 1.
inline VplNode random_vpl(Random& random) {
  VplNode node{};
  const std::uint32_t kind = random.below(5);
  const float scale = kind == 0 ? 0 : power_of_ten(random, -2, 1);
  if (kind != 1) node.diffuse = scale * random_rgb(random);
  if (kind != 2) node.specular = scale * random_rgb(random);
  node.energy = vpl_energy(node.diffuse, node.specular);
  node.exponent = kind == 3 ? 2 * random.uniform() - 1 : power_of_ten(random, 0, 5);
  node.position = random_place(random);
  node.normal = random.direction();
  node.lobe = normalize(node.normal + 0.7f * random.direction());
  node.area = power_of_ten(random, -4, -2);
  node.softening = node.area / pi;
  return node;
}

/// One in eight at the place of the one before, one in eight a copy of it.
inline std::vector<VplNode> random_vpls(Random& random, std::size_t count) {
  std::vector<VplNode> vpls;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t kind = i == 0 ? 7 : random.below(8);
    vpls.push_back(kind == 0 ? vpls.back() : random_vpl(random));
    if (kind == 1) vpls.back().position = vpls[i - 1].position;
  }
  return vpls;
}

/// VPLs of a mirror that bends slowly: lobes of exponent 1e4 to 1e5, all within a degree or so.
inline std::vector<VplNode> mirror_vpls(Random& random, std::size_t count) {
  std::vector<VplNode> vpls;
  for (std::size_t i = 0; i < count; ++i) {
    VplNode node = random_vpl(random);
    node.specular = random_rgb(random);
    node.energy = vpl_energy(node.diffuse, node.specular);
    node.exponent = power_of_ten(random, 4, 5);
    node.position.y = -3;
    node.normal = vec3(0, 1, 0);
    node.lobe = normalize(vec3(0.6f, 0.8f, 0) + 0.01f * random.direction());
    vpls.push_back(node);
  }
  return vpls;
}

inline GlossyPoint random_glossy_point(Random& random) {
  GlossyPoint point{};
  point.position = random_place(random);
  point.exponent = power_of_ten(random, 0, 5);
  point.normal = random.direction();
  point.mirror = normalize(point.normal + 0.9f * random.direction());
  point.diffuse = random_rgb(random);
  point.specular = random_rgb(random);
  return point;
}

inline std::vector<GlossyPoint> random_glossy_points(Random& random, std::size_t count) {
  std::vector<GlossyPoint> points;
  for (std::size_t i = 0; i < count; ++i) points.push_back(random_glossy_point(random));
  return points;
}

/// Groups of 1 to 40 points that lie close together and look alike.
inline PointGroups random_groups(Random& random, std::size_t count) {
  PointGroups groups;
  for (std::size_t g = 0; g < count; ++g) {
    const GlossyPoint first = random_glossy_point(random);
    const std::uint32_t size = 1 + random.below(40);
    for (std::uint32_t i = 0; i < size; ++i) {
      GlossyPoint point = first;
      point.position += 0.05f * random.direction();
      point.normal = normalize(first.normal + 0.05f * random.direction());
      point.mirror = normalize(first.mirror + 0.05f * random.direction());
      point.group = std::uint32_t(g);
      groups.points.push_back(point);
    }
    groups.ends.push_back(std::uint32_t(groups.points.size()));
  }
  return groups;
}

}  // namespace coppice::test
