// 8-bit textures, decoded to linear values where they are sampled.
#pragma once

#include <array>
#include <cmath>
#include <coppice/core/math.hpp>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace coppice {

enum class Wrap : std::uint8_t { repeat, mirror, clamp };

/// width × height texels of 8-bit RGBA, row by row from the top; colour textures hold sRGB, others linear
/// values.
struct Texture {
  int width = 0;
  int height = 0;
  bool srgb = false;
  Wrap wrap_u = Wrap::repeat;
  Wrap wrap_v = Wrap::repeat;
  std::vector<std::uint8_t> rgba;
};

namespace detail {

inline const std::array<float, 256>& srgb_to_linear() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> t{};
    for (int i = 0; i < 256; ++i) {
      const double c = i / 255.0;
      t[std::size_t(i)] = float(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
    }
    return t;
  }();
  return table;
}

inline int wrap_texel(int i, int size, Wrap wrap) {
  if (wrap == Wrap::clamp) return i < 0 ? 0 : i >= size ? size - 1 : i;
  const int period = wrap == Wrap::repeat ? size : 2 * size;
  const int j = ((i % period) + period) % period;
  return j < size ? j : period - 1 - j;
}

inline vec4 texel(const Texture& t, int x, int y) {
  const std::size_t i = 4 * (std::size_t(wrap_texel(y, t.height, t.wrap_v)) * std::size_t(t.width) +
                             std::size_t(wrap_texel(x, t.width, t.wrap_u)));
  const std::uint8_t* p = t.rgba.data() + i;
  if (!t.srgb) return vec4(p[0], p[1], p[2], p[3]) / 255.0f;
  const auto& linear = srgb_to_linear();
  return {linear[p[0]], linear[p[1]], linear[p[2]], p[3] / 255.0f};
}

}  // namespace detail

/// Bilinear value at uv, linear RGB and alpha in [0, 1]. Precondition: the texture has texels and uv is
/// finite.
inline vec4 sample(const Texture& t, vec2 uv) {
  const float x = (uv.x - std::floor(uv.x / 2) * 2) * float(t.width) - 0.5f;  // a mirror repeats after 2
  const float y = (uv.y - std::floor(uv.y / 2) * 2) * float(t.height) - 0.5f;
  const bool clamp_u = t.wrap_u == Wrap::clamp, clamp_v = t.wrap_v == Wrap::clamp;
  const float cx = clamp_u ? glm::clamp(uv.x, 0.0f, 1.0f) * float(t.width) - 0.5f : x;
  const float cy = clamp_v ? glm::clamp(uv.y, 0.0f, 1.0f) * float(t.height) - 0.5f : y;
  const int x0 = int(std::floor(cx)), y0 = int(std::floor(cy));
  const float fx = cx - float(x0), fy = cy - float(y0);
  const vec4 top = glm::mix(detail::texel(t, x0, y0), detail::texel(t, x0 + 1, y0), fx);
  const vec4 bottom = glm::mix(detail::texel(t, x0, y0 + 1), detail::texel(t, x0 + 1, y0 + 1), fx);
  return glm::mix(top, bottom, fy);
}

}  // namespace coppice
