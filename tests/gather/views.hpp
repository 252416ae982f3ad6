// G-buffers without a scene: what a camera at the origin would see.
#pragma once

#include <coppice/core/image.hpp>
#include <coppice/core/random.hpp>
#include <coppice/gather/g_buffer.hpp>
#include <vector>

namespace support {

using coppice::GBuffer;
using coppice::GBufferPixel;
using coppice::Image;
using coppice::Random;
using coppice::vec3;

inline GBuffer empty_view(int width, int height, float pixel_angle = 0.01f) {
  GBuffer buffer{width, height, vec3(0), pixel_angle, {}};
  buffer.pixels.resize(std::size_t(width) * std::size_t(height));
  return buffer;
}

/// Towards the centre of a pixel; not unit. The camera looks along -Z.
inline vec3 direction_of(const GBuffer& buffer, int x, int y) {
  return {(float(x) + 0.5f - 0.5f * float(buffer.width)) * buffer.pixel_angle,
          (0.5f * float(buffer.height) - float(y) - 0.5f) * buffer.pixel_angle, -1};
}

/// A wall at distance 5 that faces the camera.
inline GBuffer wall_view(int width, int height) {
  GBuffer buffer = empty_view(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      buffer.pixels[buffer.index(x, y)] = {5.0f * direction_of(buffer, x, y), 0, vec3(0, 0, 1), true,
                                           vec3(1)};
  return buffer;
}

/// A floor 1.5 below the camera; the top row looks down by 0.6 degrees: towards 150.
inline GBuffer floor_view(int width, int height) {
  GBuffer buffer = empty_view(width, height, 0.005f);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      vec3 d = direction_of(buffer, x, y);
      d.y = -0.01f - float(y) * buffer.pixel_angle;
      buffer.pixels[buffer.index(x, y)] = {d * (1.5f / -d.y), 0, vec3(0, 1, 0), true, vec3(1)};
    }
  return buffer;
}

/// Rectangles of random planes, materials and bumps over each other, with holes.
inline GBuffer random_view(Random& random, int width, int height) {
  GBuffer buffer = empty_view(width, height);
  for (std::uint32_t k = 0; k < 6; ++k) {
    const int left = k == 0 ? 0 : int(random.below(std::uint32_t(width)));
    const int top = k == 0 ? 0 : int(random.below(std::uint32_t(height)));
    const bool covered = k == 0 || random.uniform() < 0.8f;
    const vec3 normal = normalize(random.direction() + vec3(0, 0, 1.5f));
    const float distance = 3 + 4 * random.uniform(), bumps = 0.15f * float(random.below(3));
    const std::uint32_t material = random.below(3);
    for (int y = top; y < std::min(height, top + 40); ++y)
      for (int x = left; x < std::min(width, left + 40); ++x) {
        const vec3 d = direction_of(buffer, x, y);
        const vec3 bent = normalize(normal + bumps * random.direction());
        const float t = distance * normal.z / std::max(-dot(d, normal), 0.05f);
        const vec3 albedo(random.uniform(), 0.5f, random.uniform() < 0.1f ? 0.0f : 1.0f);
        buffer.pixels[buffer.index(x, y)] = {t * d, material, bent, covered, albedo};
      }
  }
  return buffer;
}

/// Light that varies slowly over positions, with a few spots, times albedo.
inline Image random_radiance(Random& random, const GBuffer& buffer) {
  Image image(buffer.width, buffer.height);
  const vec3 a = 2.0f * random.direction(), centre = 5.0f * random.direction();
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    const GBufferPixel& p = buffer.pixels[i];
    const vec3 from = p.position - centre;
    const float spot = std::exp(-4 * dot(from, from));
    image.pixels[i] = p.albedo * (vec3(1.5f) + glm::sin(a * p.position.x + p.position) + vec3(3 * spot));
  }
  return image;
}

}  // namespace support
