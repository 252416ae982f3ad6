// A pinhole camera.
#pragma once

#include <coppice/core/math.hpp>

namespace coppice {

/// Perspective camera in world space; right, up and forward are orthonormal (glTF looks along -Z, +Y up).
struct Camera {
  vec3 position{0};
  vec3 right{1, 0, 0};
  vec3 up{0, 1, 0};
  vec3 forward{0, 0, -1};
  float vertical_fov = 0.6f;  ///< radians

  /// Unit direction through the image point (x, y) in pixels, (0, 0) the upper left corner of a width ×
  /// height image, so that (x + 0.5, y + 0.5) is a pixel's centre. Pixels are square.
  vec3 direction(float x, float y, int width, int height) const {
    const float scale = 2 * std::tan(vertical_fov / 2) / float(height);
    return normalize(forward + right * ((x - 0.5f * float(width)) * scale) +
                     up * ((0.5f * float(height) - y) * scale));
  }

  /// Width of a pixel's footprint at distance 1.
  float pixel_angle(int height) const { return 2 * std::tan(vertical_fov / 2) / float(height); }
};

}  // namespace coppice
