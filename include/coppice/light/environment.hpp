// A distant environment: an equirectangular map of radiance, and its orientation.
#pragma once

#include <algorithm>
#include <coppice/core/image.hpp>

namespace coppice {

/// Radiance from direction d (unit, world space, +Y up) is the texel at u = atan2(d.z, d.x)/2π + 1/2,
/// v = asin(d.y)/π + 1/2, v = 1 the top row. Linear RGB, unscaled, finite, >= 0.
struct Environment {
  Image map;
  float rotation = 0;  ///< radians by which the map is turned about +Y, right-handed: +X turns towards -Z
};

/// Direction of the centre of texel (x, y) of a width × height map that is not turned.
inline vec3 texel_direction(int x, int y, int width, int height) {
  const double azimuth = 2 * std::numbers::pi * ((x + 0.5) / width - 0.5);
  const double elevation = std::numbers::pi * (0.5 - (y + 0.5) / height);
  const double r = std::cos(elevation);
  return vec3(float(r * std::cos(azimuth)), float(std::sin(elevation)), float(r * std::sin(azimuth)));
}

/// Solid angle of each texel of row y, exactly.
inline double texel_solid_angle(int y, int width, int height) {
  const double top = std::numbers::pi * (0.5 - double(y) / height);
  const double bottom = std::numbers::pi * (0.5 - (y + 1.0) / height);
  return 2 * std::numbers::pi / width * (std::sin(top) - std::sin(bottom));
}

/// Nearest texel's radiance from unit direction d. Precondition: the map has texels.
inline vec3 radiance(const Environment& environment, const vec3& d) {
  const Image& map = environment.map;
  const float turns = (std::atan2(d.z, d.x) + environment.rotation) / (2 * pi) + 0.5f;
  const float v = std::asin(std::clamp(d.y, -1.0f, 1.0f)) / pi + 0.5f;
  const int x = int((turns - std::floor(turns)) * float(map.width));
  const int y = int((1 - v) * float(map.height));
  return map.at(std::clamp(x, 0, map.width - 1), std::clamp(y, 0, map.height - 1));
}

}  // namespace coppice
