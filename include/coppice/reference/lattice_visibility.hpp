// The obvious twin of lattice visibility: every shadow ray kept, no compression.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <coppice/light/bounce.hpp>
#include <coppice/transfer/light_lattice.hpp>

namespace coppice::reference {

/// Whether each sample sees each lattice point.
struct LatticeVisibility {
  LightLattice lattice;
  std::vector<std::int8_t> seen;  ///< sample i, point p at i · points + p: 1 seen, -1 hidden, 0 below horizon
};

/// By one shadow ray a sample and point.
template <Occluder O>
LatticeVisibility lattice_visibility(std::span<const SurfaceSample> samples, LightLattice lattice,
                                     const O& occluder) {
  LatticeVisibility result{std::move(lattice), {}};
  for (const SurfaceSample& sample : samples)
    for (const vec3& p : result.lattice.positions) {
      const auto path = path_to(point_light(p, vec3(1)), ray_origin(sample), sample.normal);
      const bool hidden = path && occluder.occluded(ray_origin(sample), path->direction, path->t_max);
      result.seen.push_back(!path ? std::int8_t{0} : hidden ? std::int8_t{-1} : std::int8_t{1});
    }
  return result;
}

/// Interpolated decision of a sample for a light: seen where above 0. Precondition: sample < samples.
inline float margin(const LatticeVisibility& visibility, std::size_t sample, const LatticeCorners& light) {
  float sum = 0;
  for (std::uint32_t c = 0; c < light.count; ++c)
    sum += light.weights[c] * float(visibility.seen[sample * visibility.lattice.count() + light.points[c]]);
  return sum;
}

}  // namespace coppice::reference
