// An environment convolved with Gaussians beforehand, over direction and sharpness: a cone costs one lookup.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <coppice/shared/sg.h>

#include <algorithm>
#include <coppice/core/config.hpp>
#include <coppice/core/parallel.hpp>
#include <coppice/sg/environment_grid.hpp>
#include <coppice/sg/octahedron.hpp>
#include <coppice/sg/peaks.hpp>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace coppice {

/// How fine the table is. Its texels grow with both of the first two.
struct PreconvolvedOptions {
  float levels_per_octave = 2;  ///< of 1 + λ. 0.5 to 4
  float texels_per_width = 3;   ///< a Gaussian's 1/√λ over the distance of texels. 1 to 8
  /// Greatest λ with a level of its own; then follows the radiance itself. Lights that are sharper still are
  /// seen as through this Gaussian's texels.
  float sharpest = 511;
};

/// The lights of a grid's cells less some peaks: what is left of a map, without a fit. Each cell is a
/// Gaussian of its own variance, about where its light lies. Directions are those of the map, not turned.
inline std::vector<SgLight> cell_lights(const EnvironmentGrid& grid, std::span<const EnvironmentCell> cells,
                                        std::span<const SgLight> peaks) {
  const float sharpness = float(12 / grid.healpix().pixel_area());
  std::vector<SgLight> lights;
  for (const EnvironmentCell& cell : cells)
    if (cell.energy != vec3(0))
      lights.push_back(sg_light_of_energy({cell.centre, sharpness}, glm::dvec3(cell.energy)));
  for (const SgLight& peak : peaks) lights.push_back(sg_light({peak.axis, peak.sharpness}, -peak.amplitude));
  return lights;
}

}  // namespace coppice

namespace coppice::detail::inline HWY_NAMESPACE {

/// Lights in columns, padded to whole registers with black ones.
class LightColumns {
 public:
  void clear() {
    for (auto& column : columns_) column.clear();
  }
  std::size_t size() const { return columns_[0].size(); }
  void append(const SgLight& light) {
    const float values[columns] = {light.axis.x,      light.axis.y,      light.axis.z,     light.sharpness,
                                   light.amplitude.x, light.amplitude.y, light.amplitude.z};
    for (std::size_t c = 0; c < columns; ++c) columns_[c].push_back(values[c]);
  }
  void pad() {
    while (size() % Lanes::width != 0) append({vec3(0, 1, 0), 1, vec3(0), 0});
  }

  /// Σ amplitude ∫ G_light G / ∫ G, for the Gaussian of this axis and sharpness. Registers of lights whose
  /// products with it have all fallen below a tenth of the tolerance are left out: ∫ G_light G is at most
  /// e^-x of what it is where the axes agree, x = λλ'd²/(2 (λ + λ')), which no division tells (SgLightBound).
  vec3 mean(const vec3& axis, float sharpness, float tolerance = 0) const {
    const Lanes most = tolerance > 0 ? 2 * std::log(10 / tolerance) : 1e30f;
    Lanes red = 0.0f, green = 0.0f, blue = 0.0f;
    const Lanes own = sharpness, scale = sg_normalisation(sharpness);
    for (std::size_t i = 0; i < size(); i += Lanes::width) {
      const Lanes x = at(0, i) - axis.x, y = at(1, i) - axis.y, z = at(2, i) - axis.z, other = at(3, i);
      const Lanes squared = mul_add(x, x, mul_add(y, y, z * z));
      const Lanes both = own + other, product = own * other * squared;
      if (all(product > most * both)) continue;
      const Lanes length = sqrt(max(both * both - product, Lanes(0.0f)));
      const Lanes value = exp(-(product / max(length + both, Lanes(1e-30f)))) * sg_integral(length) * scale;
      red = mul_add(value, at(4, i), red);
      green = mul_add(value, at(5, i), green);
      blue = mul_add(value, at(6, i), blue);
    }
    return {sum_of_lanes(red), sum_of_lanes(green), sum_of_lanes(blue)};
  }

  /// Σ amplitude G(axis).
  vec3 radiance(const vec3& axis) const {
    Lanes red = 0.0f, green = 0.0f, blue = 0.0f;
    for (std::size_t i = 0; i < size(); i += Lanes::width) {
      const Lanes x = at(0, i) - axis.x, y = at(1, i) - axis.y, z = at(2, i) - axis.z;
      const Lanes value = exp(Lanes(-0.5f) * at(3, i) * mul_add(x, x, mul_add(y, y, z * z)));
      red = mul_add(value, at(4, i), red);
      green = mul_add(value, at(5, i), green);
      blue = mul_add(value, at(6, i), blue);
    }
    return {sum_of_lanes(red), sum_of_lanes(green), sum_of_lanes(blue)};
  }

 private:
  static constexpr std::size_t columns = 7;
  Lanes at(std::size_t column, std::size_t i) const { return Lanes::load(&columns_[column][i]); }

  std::vector<float> columns_[columns];
};

}  // namespace coppice::detail::inline HWY_NAMESPACE

namespace coppice::inline HWY_NAMESPACE {

/// Tables of ∫ L G_λ / ∫ G_λ over the direction p, one for each of a row of sharpnesses from 0 on, each an
/// octahedral square as fine as its sharpness asks for; between them, and between texels, linear.
class PreconvolvedEnvironment {
 public:
  /// Of the light that these Gaussians send: the rest of a fit, or cell_lights. Peaks are better left out and
  /// added one by one: they would ask for a far finer table. Cost: docs/sg.md.
  template <Executor E = Serial>
  explicit PreconvolvedEnvironment(std::span<const SgLight> lights, const PreconvolvedOptions& options = {},
                                   const E& executor = {})
      : levels_per_octave_(options.levels_per_octave) {
    COPPICE_ASSERT(options.levels_per_octave > 0 && options.texels_per_width > 0 && options.sharpest >= 0);
    float finest = 1;
    for (const SgLight& light : lights)
      finest = std::max(finest, std::min(light.sharpness, options.sharpest));
    const int count = 1 + int(std::ceil(levels_per_octave_ * std::log2(1 + options.sharpest)));
    for (int k = 0; k < count; ++k)
      add_level(std::exp2(float(k) / levels_per_octave_) - 1, finest, options.texels_per_width);
    add_level(std::numeric_limits<float>::infinity(), finest, options.texels_per_width);
    texels_.resize(levels_.back().first + square(levels_.back().size + 1));
    for (const Level& level : levels_) fill(level, lights, executor);
  }

  /// Turns the environment about +Y, by Environment::rotation on top of the lights' own: exact, for queries
  /// are turned instead.
  void turn(float rotation) { cosine_ = std::cos(rotation), sine_ = std::sin(rotation); }

  /// ∫ L G. Any λ >= 0. Errors and cost: docs/sg.md.
  vec3 lookup(const SgShape& shape) const { return sg_integral(shape.sharpness) * mean(shape); }

  /// ∫ L G / ∫ G, the mean radiance under the Gaussian; the radiance from its axis for an infinite λ.
  vec3 mean(const SgShape& shape) const {
    const vec3& p = shape.axis;
    const vec2 point = octahedral_point({cosine_ * p.x - sine_ * p.z, p.y, sine_ * p.x + cosine_ * p.z});
    const std::size_t last = levels_.size() - 2;  // of those with a sharpness
    if (shape.sharpness >= levels_[last].sharpness) {
      const float share = levels_[last].sharpness / shape.sharpness;  // to first order in 1/λ
      return share * at(levels_[last], point) + (1 - share) * at(levels_[last + 1], point);
    }
    const float place = levels_per_octave_ * std::log2(1 + shape.sharpness);
    const std::size_t k = std::min(std::size_t(place), last - 1);
    const float t = place - float(k);
    return (1 - t) * at(levels_[k], point) + t * at(levels_[k + 1], point);
  }

  std::size_t level_count() const { return levels_.size(); }
  /// Texels of all levels, 12 bytes each.
  std::size_t texel_count() const { return texels_.size(); }

 private:
  struct Level {
    float sharpness;
    std::uint32_t size;  ///< squares along an edge, between size + 1 texels
    std::size_t first;   ///< texel
  };

  static std::size_t square(std::uint32_t x) { return std::size_t(x) * x; }

  /// The light is no sharper than 1/λ + 1/λ_light. An edge of n squares has 3.5/n radians each, on average.
  void add_level(float sharpness, float finest, float texels_per_width) {
    const float width = std::sqrt(std::min(1 / std::max(sharpness, 0.25f) + 1 / finest, 1.0f));
    const float squares = 3.5f * texels_per_width / width;
    const std::size_t first = levels_.empty() ? 0 : levels_.back().first + square(levels_.back().size + 1);
    levels_.push_back({sharpness, std::max(8u, (std::uint32_t(squares) + 7) / 8 * 8), first});
  }

  /// Bilinear. Texels lie on the square's edges too, so no filter reaches across a fold.
  vec3 at(const Level& level, const vec2& point) const {
    const vec2 place = point * float(level.size);
    const std::uint32_t x = std::min(std::uint32_t(place.x), level.size - 1);
    const std::uint32_t y = std::min(std::uint32_t(place.y), level.size - 1);
    const float s = place.x - float(x), t = place.y - float(y);
    const vec3* row = &texels_[level.first + std::size_t(y) * (level.size + 1) + x];
    const vec3* next = row + level.size + 1;
    return (1 - t) * ((1 - s) * row[0] + s * row[1]) + t * ((1 - s) * next[0] + s * next[1]);
  }

  /// Blocks of texels, each of which looks at the lights that reach it.
  template <Executor E>
  void fill(const Level& level, std::span<const SgLight> lights, const E& executor) {
    const std::uint32_t blocks = level.size / block + 1;
    executor(square(blocks), 4, [&](std::size_t begin, std::size_t end) {
      detail::LightColumns near;
      for (std::size_t i = begin; i < end; ++i)
        fill_block(level, std::uint32_t(i % blocks) * block, std::uint32_t(i / blocks) * block, lights, near);
    });
  }

  vec3 direction(const Level& level, std::uint32_t x, std::uint32_t y) const {
    return octahedral_direction(vec2(float(x), float(y)) / float(level.size));
  }

  void fill_block(const Level& level, std::uint32_t x0, std::uint32_t y0, std::span<const SgLight> lights,
                  detail::LightColumns& near) {
    const std::uint32_t x1 = std::min(x0 + block, level.size + 1), y1 = std::min(y0 + block, level.size + 1);
    const vec3 middle = direction(level, (x0 + x1 - 1) / 2, (y0 + y1 - 1) / 2);
    float radius = 0;
    for (std::uint32_t y = y0; y < y1; ++y)
      for (std::uint32_t x = x0; x < x1; ++x)
        radius = std::max(radius, length(direction(level, x, y) - middle));
    near.clear();
    for (const SgLight& light : lights)
      if (length(light.axis - middle) - radius < reach(level.sharpness, light.sharpness)) near.append(light);
    near.pad();
    for (std::uint32_t y = y0; y < y1; ++y)
      for (std::uint32_t x = x0; x < x1; ++x) {
        const vec3 p = direction(level, x, y);
        texels_[level.first + std::size_t(y) * (level.size + 1) + x] =
            std::isinf(level.sharpness) ? near.radiance(p) : near.mean(p, level.sharpness);
      }
  }

  /// The distance of axes beyond which the product has fallen to e^-10: λ₁λ₂d²/2(λ₁ + λ₂) = 10.
  static float reach(float a, float b) {
    return std::sqrt(20 * (1 / std::max(a, 1e-6f) + 1 / std::max(b, 1e-6f)));
  }

  static constexpr std::uint32_t block = 8;

  float levels_per_octave_;
  float cosine_ = 1, sine_ = 0;  ///< of the turn
  std::vector<Level> levels_;
  std::vector<vec3> texels_;  ///< level by level, row by row
};

}  // namespace coppice::inline HWY_NAMESPACE
