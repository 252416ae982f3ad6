// Interpolation between the pixels of a coarser grid that lie on the same surface.
#pragma once

#include <array>
#include <coppice/gather/g_buffer.hpp>
#include <span>

namespace coppice {

/// Covered pixels of the grid of twice the step around a pixel, at most four. The bilinear weights of all are
/// equal, because the pixel is half way between them: one over `places`.
struct Parents {
  std::array<std::uint32_t, 4> pixels{};
  int count = 0;
  int places = 0;  ///< 2 between neighbours of the coarser grid, 4 amid them; also where some lie outside
};

/// Light that a pixel takes from its parents.
struct Interpolated {
  vec3 light{0};
  std::array<float, 4> weights{};  ///< bilateral, a parent each, in [0, 1]
  float share = 0;                 ///< sum of bilateral weights over that of bilinear ones, in [0, 1]
};

/// True where (x, y), which is on the grid of this step, is also on that of twice the step.
inline bool is_on_coarser_grid(int x, int y, int step) { return ((x | y) & step) == 0; }

/// The parents of (x, y), which is on the grid of this step and not on the coarser one; upper ones first,
/// left before right.
inline Parents parents_of(const GBuffer& buffer, int x, int y, int step) {
  const int dx = x & step, dy = y & step;
  Parents parents{.places = dx > 0 && dy > 0 ? 4 : 2};
  for (int j = -dy; j <= dy; j += 2 * step)
    for (int i = -dx; i <= dx; i += 2 * step)
      if (buffer.has(x + i, y + j))
        parents.pixels[std::size_t(parents.count++)] = std::uint32_t(buffer.index(x + i, y + j));
  return parents;
}

/// How far b is from the tangent plane of a, in the width of a's footprint times the step: 0 for neighbours
/// on a plane, however grazing the view.
inline float plane_distance(const GBuffer& buffer, const GBufferPixel& a, const GBufferPixel& b, int step) {
  return std::fabs(dot(a.normal, b.position - a.position)) / (buffer.footprint(a) * float(step));
}

/// The bilateral weight of b for a in [0, 1], without the bilinear one: cos⁶⁴ between their normals, which
/// halves at 8.4°, over 1 + (plane distance / 2)²; 0 across materials where these count. Same form as Sloan
/// et al., "Image-Based Proxy Accumulation", 2007; the exponent is ours.
inline float bilateral_weight(const GBuffer& buffer, const GBufferPixel& a, const GBufferPixel& b, int step,
                              bool use_materials) {
  if (use_materials && a.material != b.material) return 0;
  const float h = 0.5f * plane_distance(buffer, a, b, step);
  float weight = std::clamp(dot(a.normal, b.normal), 0.0f, 1.0f);
  for (int k = 0; k < 6; ++k) weight *= weight;
  return weight / (1 + h * h);
}

/// The mean of the parents' light by their weights, exact where they agree. Where all weights are below 1e-6
/// of the bilinear ones, the mean of the covered parents; where there is none, black.
inline Interpolated interpolate(const GBuffer& buffer, std::size_t pixel, const Parents& parents, int step,
                                bool use_materials, std::span<const vec3> light) {
  Interpolated result;
  float sum = 0;
  for (std::size_t k = 0; k < std::size_t(parents.count); ++k) {
    result.weights[k] =
        bilateral_weight(buffer, buffer.pixels[pixel], buffer.pixels[parents.pixels[k]], step, use_materials);
    sum += result.weights[k];
  }
  result.share = sum / float(parents.places);
  const bool any = result.share > 1e-6f;
  float before = 0;
  for (std::size_t k = 0; k < std::size_t(parents.count); ++k) {
    const float weight = any ? result.weights[k] : 1.0f;
    if (!(weight > 0)) continue;
    before += weight;
    result.light += (light[parents.pixels[k]] - result.light) * (weight / before);
  }
  return result;
}

}  // namespace coppice
