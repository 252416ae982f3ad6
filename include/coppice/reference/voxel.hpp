// The slow, obvious twins of voxel/: visibility by many rays, and distances to all triangles.
#pragma once

#include <coppice/shared/sg.h>

#include <coppice/core/random.hpp>
#include <coppice/scene/mesh.hpp>
#include <coppice/scene/occluder.hpp>
#include <coppice/voxel/triangle_distance.hpp>
#include <limits>
#include <numbers>

namespace coppice::reference {

/// The direction for which a share u of the Gaussian's energy is nearer to its axis, and which has an azimuth
/// of v turns: von Mises and Fisher's distribution for u, v uniform in [0, 1).
inline vec3 gaussian_direction(const SgShape& cone, double u, double v) {
  const double sharpness = double(cone.sharpness);
  const double drop = sharpness > 1e-6 ? -std::log1p(u * std::expm1(-2 * sharpness)) / sharpness : 2 * u;
  const double radius = std::sqrt(std::fmax(drop * (2 - drop), 0.0)), angle = 2 * std::numbers::pi * v;
  vec3 x, y;
  make_frame(cone.axis, x, y);
  return normalize(float(1 - drop) * cone.axis + float(radius * std::cos(angle)) * x +
                   float(radius * std::sin(angle)) * y);
}

/// The share of a Gaussian's integral above the surface's horizon that no occluder hides, by strata² rays
/// from `origin`, which the caller has lifted off the surface. 0 where no ray is above the horizon. Standard
/// error at most 1/(2·strata).
template <Occluder O>
float cone_visibility(const O& occluder, const vec3& origin, const vec3& normal, const SgShape& cone,
                      std::uint32_t strata, Random& random) {
  std::uint32_t seen = 0, all = 0;
  for (std::uint32_t i = 0; i < strata * strata; ++i) {
    const double u = (double(i / strata) + double(random.uniform())) / strata,
                 v = (double(i % strata) + double(random.uniform())) / strata;
    const vec3 d = gaussian_direction(cone, u, v);
    if (dot(d, normal) <= 0) continue;
    ++all;
    seen += !occluder.occluded(origin, d, std::numeric_limits<float>::infinity());
  }
  return all > 0 ? float(seen) / float(all) : 0.0f;
}

/// Distance from a point to the nearest triangle of a mesh, infinity where there is none.
inline float nearest_surface(const Mesh& mesh, const vec3& p) {
  float nearest = std::numeric_limits<float>::infinity();
  for (const uvec3& t : mesh.triangles) {
    const TriangleCorners corners{mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]};
    nearest = std::fmin(nearest, length(nearest_on_triangle(corners, p) - p));
  }
  return nearest;
}

}  // namespace coppice::reference
