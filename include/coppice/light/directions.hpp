// Directions spread evenly over the sphere.
#pragma once

#include <coppice/core/math.hpp>
#include <coppice/core/random.hpp>
#include <cstdint>
#include <vector>

namespace coppice {

/// `count` unit directions on the spherical Fibonacci lattice (Swinbank and Purser 2006): neighbours of near
/// equal area and no direction of preference, in closed form and so the same everywhere. The paper scatters
/// points at random and lets them repel each other (Cuts section 4.1), which ends at the same evenness for
/// O(count²) work. A seed other than 0 turns the whole lattice at random.
inline std::vector<vec3> even_directions(std::uint32_t count, std::uint64_t seed = 0) {
  std::vector<vec3> directions(count);
  const double turn = std::numbers::pi * (3 - std::sqrt(5.0));
  for (std::uint32_t i = 0; i < count; ++i) {
    const double y = 1 - (2.0 * i + 1) / count, r = std::sqrt((1 - y) * (1 + y));
    directions[i] = vec3(float(r * std::cos(turn * i)), float(y), float(r * std::sin(turn * i)));
  }
  if (seed == 0) return directions;
  Random random(seed);
  const vec3 axis = random.direction();
  const glm::quat turned = glm::angleAxis(2 * pi * random.uniform(), axis);
  for (vec3& d : directions) d = normalize(turned * d);
  return directions;
}

}  // namespace coppice
