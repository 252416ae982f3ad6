// Where the samples of a shadow field stand, and which of them surround a point.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <coppice/core/config.hpp>
#include <coppice/core/math.hpp>
#include <cstdint>
#include <variant>
#include <vector>

namespace coppice {

/// Samples and their weights, which sum to 1. Without samples: beyond the field.
struct SampleBlend {
  std::array<std::uint32_t, 8> samples{};
  std::array<float, 8> weights{};
  std::uint32_t count = 0;

  void add(std::uint32_t sample, float weight) {
    if (!(weight > 0)) return;
    samples[count] = sample;
    weights[count++] = weight;
  }
};

namespace detail {

/// Between which of `count` nodes a coordinate in node spacings lies: the lower one, and the share of the
/// upper.
struct Interval {
  std::uint32_t lower;
  float share;

  Interval(float x, std::uint32_t count) {
    const float clamped = std::clamp(x, 0.0f, float(count - 1));
    lower = std::min(std::uint32_t(clamped), count < 2 ? 0u : count - 2);
    share = clamped - float(lower);
  }
  float weight(int upper) const { return upper ? share : 1 - share; }
};

}  // namespace detail

/// Samples on spheres around an object whose radii grow by a constant factor, in the directions of an
/// octahedral map: as fine as the object is near (shadow fields, Zhou et al. 2005).
class ShellSamples {
 public:
  /// Radii from `innermost` to at least `outermost`, `shells` to an octave; (resolution + 1)² directions a
  /// shell. Precondition: 0 < innermost < outermost; shells and resolution >= 1.
  ShellSamples(const vec3& centre, float innermost, float outermost, int shells, int resolution)
      : centre_(centre),
        innermost_(innermost),
        outermost_(outermost),
        shells_(float(shells)),
        nodes_(std::uint32_t(resolution) + 1),
        shell_count_(std::uint32_t(std::ceil(std::log2(outermost / innermost) * float(shells))) + 1) {
    COPPICE_ASSERT(innermost > 0 && innermost < outermost && shells > 0 && resolution > 0);
  }

  std::uint32_t count() const { return shell_count_ * nodes_ * nodes_; }

  std::vector<vec3> positions() const {
    std::vector<vec3> all;
    all.reserve(count());
    for (std::uint32_t s = 0; s < shell_count_; ++s)
      for (std::uint32_t y = 0; y < nodes_; ++y)
        for (std::uint32_t x = 0; x < nodes_; ++x)
          all.push_back(centre_ + innermost_ * std::exp2(float(s) / shells_) * direction(x, y));
    return all;
  }

  /// Trilinear in the logarithm of the radius and in the map. Points within the innermost shell are taken to
  /// be on it; beyond the outermost there are no samples.
  SampleBlend locate(const vec3& point) const {
    SampleBlend blend;
    const vec3 from_centre = point - centre_;
    const float radius = length(from_centre);
    if (!(radius <= outermost_)) return blend;
    const vec2 map = octahedral(from_centre);
    const float scale = 0.5f * float(nodes_ - 1);
    const detail::Interval s(std::log2(std::max(radius, innermost_) / innermost_) * shells_, shell_count_),
        x((map.x + 1) * scale, nodes_), y((map.y + 1) * scale, nodes_);
    for (int corner = 0; corner < 8; ++corner) {
      const int ds = corner >> 2, dy = corner >> 1 & 1, dx = corner & 1;
      const std::uint32_t row = (s.lower + std::uint32_t(ds)) * nodes_ + y.lower + std::uint32_t(dy);
      blend.add(row * nodes_ + x.lower + std::uint32_t(dx), s.weight(ds) * y.weight(dy) * x.weight(dx));
    }
    return blend;
  }

 private:
  static float sign(float x) { return x < 0 ? -1.0f : 1.0f; }

  /// The octahedron's lower half folded out to the corners of [-1, 1]².
  static vec2 octahedral(const vec3& d) {
    const float sum = std::fabs(d.x) + std::fabs(d.y) + std::fabs(d.z);
    if (!(sum > 0)) return {0, 0};
    const vec2 p(d.x / sum, d.y / sum);
    if (d.z >= 0) return p;
    return {(1 - std::fabs(p.y)) * sign(p.x), (1 - std::fabs(p.x)) * sign(p.y)};
  }

  vec3 direction(std::uint32_t x, std::uint32_t y) const {
    const vec2 p(2 * float(x) / float(nodes_ - 1) - 1, 2 * float(y) / float(nodes_ - 1) - 1);
    const float z = 1 - std::fabs(p.x) - std::fabs(p.y);
    if (z >= 0) return normalize(vec3(p, z));
    return normalize(vec3((1 - std::fabs(p.y)) * sign(p.x), (1 - std::fabs(p.x)) * sign(p.y), z));
  }

  vec3 centre_;
  float innermost_, outermost_, shells_;
  std::uint32_t nodes_, shell_count_;
};

/// Samples on a regular grid in a box.
class GridSamples {
 public:
  /// Spacings of at most `spacing`. Precondition: low <= high; spacing > 0.
  GridSamples(const vec3& low, const vec3& high, float spacing) : low_(low) {
    COPPICE_ASSERT(spacing > 0);
    for (int k = 0; k < 3; ++k) {
      COPPICE_ASSERT(low[k] <= high[k]);
      nodes_[k] = std::uint32_t(std::ceil((high[k] - low[k]) / spacing)) + 1;
      step_[k] = nodes_[k] > 1 ? (high[k] - low[k]) / float(nodes_[k] - 1) : spacing;
    }
  }

  std::uint32_t count() const { return nodes_.x * nodes_.y * nodes_.z; }

  std::vector<vec3> positions() const {
    std::vector<vec3> all;
    all.reserve(count());
    for (std::uint32_t z = 0; z < nodes_.z; ++z)
      for (std::uint32_t y = 0; y < nodes_.y; ++y)
        for (std::uint32_t x = 0; x < nodes_.x; ++x) all.push_back(low_ + step_ * vec3(uvec3(x, y, z)));
    return all;
  }

  /// Trilinear. Points beyond the box are taken to be on its surface.
  SampleBlend locate(const vec3& point) const {
    SampleBlend blend;
    const vec3 at = (point - low_) / step_;
    const detail::Interval x(at.x, nodes_.x), y(at.y, nodes_.y), z(at.z, nodes_.z);
    for (int corner = 0; corner < 8; ++corner) {
      const int dz = corner >> 2, dy = corner >> 1 & 1, dx = corner & 1;
      const std::uint32_t row = (z.lower + std::uint32_t(dz)) * nodes_.y + y.lower + std::uint32_t(dy);
      blend.add(row * nodes_.x + x.lower + std::uint32_t(dx), z.weight(dz) * y.weight(dy) * x.weight(dx));
    }
    return blend;
  }

 private:
  vec3 low_, step_{1};
  uvec3 nodes_{1};
};

using FieldSamples = std::variant<ShellSamples, GridSamples>;

inline SampleBlend locate(const FieldSamples& samples, const vec3& point) {
  return std::visit([&](const auto& s) { return s.locate(point); }, samples);
}
inline std::vector<vec3> positions_of(const FieldSamples& samples) {
  return std::visit([](const auto& s) { return s.positions(); }, samples);
}

}  // namespace coppice
