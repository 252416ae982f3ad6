// What the camera sees at each pixel: the input of sampling that adapts to the image.
#pragma once

#include <algorithm>
#include <coppice/core/config.hpp>
#include <coppice/core/math.hpp>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace coppice {

/// The surface at a pixel's centre.
struct GBufferPixel {
  vec3 position{0};            ///< world space, metres
  std::uint32_t material = 0;  ///< surfaces of different materials do not share light
  vec3 normal{0};              ///< unit; the shading normal, on the viewer's side
  bool covered = false;        ///< false: the ray met nothing, and the rest has no meaning
  vec3 albedo{1};              ///< what light is divided by before it is interpolated
};

/// width × height pixels, one camera ray each; pixel (x, y) is at y·width + x, y = 0 is the top row.
struct GBuffer {
  int width = 0;
  int height = 0;
  vec3 eye{0};            ///< where the camera is, world space
  float pixel_angle = 0;  ///< width of a pixel's footprint at distance 1 (Camera::pixel_angle)
  std::vector<GBufferPixel> pixels;

  std::size_t index(int x, int y) const { return std::size_t(y) * std::size_t(width) + std::size_t(x); }
  bool has(int x, int y) const {
    return x >= 0 && y >= 0 && x < width && y < height && pixels[index(x, y)].covered;
  }
  /// Width of the pixel's footprint across the ray, metres; above zero.
  float footprint(const GBufferPixel& p) const {
    return std::max(pixel_angle * length(p.position - eye), 1e-30f);
  }
};

}  // namespace coppice
