// How much a pixel may differ from what its parents say: the estimate by which adaptive sampling decides.
#pragma once

#include <coppice/gather/bilateral.hpp>
#include <limits>

namespace coppice::detail {

/// Calls visit(pixel) for the covered ones of the four nearby pixels on the grid of this step.
template <class Visit>
void for_each_nearby(const GBuffer& buffer, int x, int y, int step, Visit&& visit) {
  constexpr std::array<std::array<int, 2>, 4> sides{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
  for (const auto& [dx, dy] : sides)
    if (buffer.has(x + dx * step, y + dy * step))
      visit(buffer.pixels[buffer.index(x + dx * step, y + dy * step)]);
}

/// √(2 - 2 a·b), about the angle between unit normals in radians.
inline float normal_distance(const vec3& a, const vec3& b) {
  return std::sqrt(std::max(0.0f, 2 - 2 * dot(a, b)));
}

/// The first term of the coherence error (Filtering section 2.3): max |pᵢ - p| / (d/2) + √(2 - 2 n·nᵢ) over
/// the pixels nearby. `diagonal`: of the scene's bounding box, d.
inline float paper_geometry_error(const GBuffer& buffer, int x, int y, int step, float diagonal) {
  const GBufferPixel& here = buffer.pixels[buffer.index(x, y)];
  float error = 0;
  for_each_nearby(buffer, x, y, step, [&](const GBufferPixel& p) {
    error = std::max(
        error, length(p.position - here.position) / (diagonal / 2) + normal_distance(p.normal, here.normal));
  });
  return error;
}

/// Its second term over λ: Σ |L_j - L_k| over the pairs of parents; `radiance(pixel)` is a parent's.
template <class Radiance>
float paper_light_error(const Parents& parents, Radiance&& radiance) {
  float error = 0;
  for (int j = 0; j < parents.count; ++j)
    for (int k = j + 1; k < parents.count; ++k)
      error += std::fabs(luminance(radiance(parents.pixels[std::size_t(j)])) -
                         luminance(radiance(parents.pixels[std::size_t(k)])));
  return error;
}

/// Ours: a tenth of max √(2 - 2 n·nᵢ) plus a tenth of max plane distance, cut off at 1, over the pixels
/// nearby.
inline float relative_geometry_error(const GBuffer& buffer, int x, int y, int step) {
  const GBufferPixel& here = buffer.pixels[buffer.index(x, y)];
  float error = 0;
  for_each_nearby(buffer, x, y, step, [&](const GBufferPixel& p) {
    const float plane = std::min(plane_distance(buffer, here, p, step), 1.0f);
    error = std::max(error, 0.1f * (plane + normal_distance(p.normal, here.normal)));
  });
  return error;
}

/// Largest second difference of light at a pixel of the grid of this step along x and along y, each channel
/// by itself; a direction counts where both neighbours have bilateral weights of at least 0.5.
inline vec3 bend_of_light(const GBuffer& buffer, int x, int y, int step, bool use_materials,
                          std::span<const vec3> light) {
  const std::size_t i = buffer.index(x, y);
  vec3 bend(0);
  for (int axis = 0; axis < 2; ++axis) {
    const int dx = axis == 0 ? step : 0, dy = step - dx;
    if (!buffer.has(x - dx, y - dy) || !buffer.has(x + dx, y + dy)) continue;
    const std::size_t a = buffer.index(x - dx, y - dy), b = buffer.index(x + dx, y + dy);
    const auto alike = [&](std::size_t k) {
      return bilateral_weight(buffer, buffer.pixels[i], buffer.pixels[k], step, use_materials) >= 0.5f;
    };
    if (alike(a) && alike(b)) bend = glm::max(bend, glm::abs((light[a] - light[i]) + (light[b] - light[i])));
  }
  return bend;
}

/// Half of how far the parents' light spreads, channel by channel, plus how it bends there. Parents with
/// weights below 0.02 do not count.
inline vec3 change_of_light(const Parents& parents, const Interpolated& middle, std::span<const vec3> light,
                            std::span<const vec3> bends) {
  vec3 least(std::numeric_limits<float>::infinity()), most(-least), bend(0);
  for (std::size_t k = 0; k < std::size_t(parents.count); ++k) {
    if (!(middle.weights[k] > 0.02f)) continue;
    least = glm::min(least, light[parents.pixels[k]]);
    most = glm::max(most, light[parents.pixels[k]]);
    bend = glm::max(bend, bends[parents.pixels[k]]);
  }
  return 0.5f * glm::max(most - least, vec3(0)) + bend;
}

/// a / b for a, b >= 0, and 0 / 0 = 0. NaN stays.
inline float share_of(float a, float b) { return a / std::max(b, std::numeric_limits<float>::min()); }

}  // namespace coppice::detail
