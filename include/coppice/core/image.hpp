// An image in memory: linear RGB, row by row from the top.
#pragma once

#include <coppice/core/math.hpp>
#include <cstddef>
#include <vector>

namespace coppice {

/// width × height pixels, linear RGB; pixel (x, y) is at y·width + x, y = 0 is the top row.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<vec3> pixels;

  Image() = default;
  Image(int w, int h, vec3 fill = vec3(0))
      : width(w), height(h), pixels(std::size_t(w) * std::size_t(h), fill) {}

  std::size_t index(int x, int y) const { return std::size_t(y) * std::size_t(width) + std::size_t(x); }
  vec3& at(int x, int y) { return pixels[index(x, y)]; }
  const vec3& at(int x, int y) const { return pixels[index(x, y)]; }
};

}  // namespace coppice
