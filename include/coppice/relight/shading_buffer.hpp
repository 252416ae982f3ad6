// The points that a frame shades, sorted by the face whose clusters they share.
#pragma once

#include <coppice/shared/layout.h>

#include <cstdint>
#include <vector>

namespace coppice {

/// Points sorted by face, the faces between receivers, and the pixel that each point colours.
struct ShadingBuffer {
  std::vector<ShadingPoint> points;
  std::vector<ShadingFace> faces;
  std::vector<std::uint32_t> pixels;  ///< a point
  std::vector<vec3> positions;        ///< a point; above the surface by rounding: where shadow rays begin

  std::uint32_t end_of(std::size_t face) const {
    return face + 1 < faces.size() ? faces[face + 1].first_point : std::uint32_t(points.size());
  }
};

}  // namespace coppice
