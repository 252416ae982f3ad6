// What holds for all VPLs of a node, and from it the most that the node can bring to any of a group of
// points.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <coppice/shared/vpl.h>

#include <array>
#include <coppice/tree/light_tree.hpp>
#include <span>
#include <vector>

namespace coppice {

/// Boxes around the positions, unit normals and unit lobe directions of those VPLs of a node that shine, and
/// their brightest channels summed. A node without energy is dark: diffuse and peak are 0, the boxes a point.
struct VplBound {
  vec3 low{0};
  float slowest = 0;  ///< least exponent of a lobe with energy
  vec3 high{0};
  float peak = 0;  ///< Σ brightest channel of specular (k + 1)/2π
  vec3 normal_low{0};
  float diffuse = 0;  ///< Σ brightest channel of diffuse
  vec3 normal_high{0};
  float softening = 0;  ///< least
  vec3 lobe_low{0};
  vec3 lobe_high{0};

  bool is_dark() const { return diffuse <= 0 && peak <= 0; }
};

/// The largest channel; NaN where any channel is.
inline float brightest(const vec3& rgb) {
  return std::max(rgb.x, std::max(rgb.y, rgb.z)) + 0 * (rgb.x + rgb.y + rgb.z);
}

inline VplBound bound_of_leaf(const VplNode& n) {
  const float k = lobe_shining(n.exponent);
  VplBound b;
  b.low = b.high = n.position;
  b.normal_low = b.normal_high = n.normal;
  b.lobe_low = b.lobe_high = n.lobe;
  b.slowest = k;
  b.softening = n.softening;
  b.peak = brightest(n.specular) * (k + 1) / (2 * pi);
  b.diffuse = brightest(n.diffuse);
  return b;
}

/// What holds for the VPLs of both.
inline VplBound bound_of_both(const VplBound& a, const VplBound& b) {
  if (a.is_dark()) return b;
  if (b.is_dark()) return a;
  VplBound c = a;
  c.low = glm::min(a.low, b.low), c.high = glm::max(a.high, b.high);
  c.normal_low = glm::min(a.normal_low, b.normal_low), c.normal_high = glm::max(a.normal_high, b.normal_high);
  c.softening = std::min(a.softening, b.softening);
  c.diffuse = a.diffuse + b.diffuse;
  c.peak = a.peak + b.peak;
  if (!(b.peak > 0)) return c;
  const bool both = a.peak > 0;
  c.lobe_low = both ? glm::min(a.lobe_low, b.lobe_low) : b.lobe_low;
  c.lobe_high = both ? glm::max(a.lobe_high, b.lobe_high) : b.lobe_high;
  c.slowest = both ? std::min(a.slowest, b.slowest) : b.slowest;
  return c;
}

/// What holds for all of a group of points.
struct PointBound {
  vec3 low{0}, high{0};
  vec3 normal_low{0}, normal_high{0};
  vec3 mirror_low{0}, mirror_high{0};
  float slowest = 0;  ///< least exponent
  float peak = 0;     ///< largest brightest channel of specular (n + 2)/2π
  float diffuse = 0;  ///< largest brightest channel of diffuse / π
};

inline PointBound bound_of_points(std::span<const GlossyPoint> points) {
  PointBound b;
  if (points.empty()) return b;
  const GlossyPoint& first = points[0];
  b.low = b.high = first.position;
  b.normal_low = b.normal_high = first.normal;
  b.mirror_low = b.mirror_high = first.mirror;
  b.slowest = first.exponent;
  for (const GlossyPoint& p : points) {
    b.low = glm::min(b.low, p.position), b.high = glm::max(b.high, p.position);
    b.normal_low = glm::min(b.normal_low, p.normal), b.normal_high = glm::max(b.normal_high, p.normal);
    b.mirror_low = glm::min(b.mirror_low, p.mirror), b.mirror_high = glm::max(b.mirror_high, p.mirror);
    b.slowest = std::min(b.slowest, p.exponent);
    b.peak = std::max(b.peak, brightest(p.specular) * (p.exponent + 2) / (2 * pi));
    b.diffuse = std::max(b.diffuse, brightest(p.diffuse) / pi);
  }
  return b;
}

}  // namespace coppice

namespace coppice::inline HWY_NAMESPACE {

/// A register of bounds.
struct VplBoundLanes {
  Lanes low[3], high[3], normal_low[3], normal_high[3], lobe_low[3], lobe_high[3];
  Lanes slowest, peak, diffuse, softening;
  Lanes size;  ///< what the error of taking the node whole grows with, m; 0 for leaves
};

/// The most that nodes bring to any point of a group, in its brightest channel.
class GroupBound {
 public:
  explicit GroupBound(const PointBound& points) : points_(points) {}

  struct Bounded {
    Lanes radiance;  ///< at least what the node brings
    Lanes angle;     ///< the most that its size covers, √sr; at most √4π
  };

  Bounded operator()(const VplBoundLanes& n) const {
    Lanes c[3], nearest2 = 0.0f, centre2 = 0.0f, reach2 = 0.0f, above = 0.0f, before = 0.0f;
    for (int k = 0; k < 3; ++k) {
      const Lanes from = n.low[k] - points_.high[k], to = n.high[k] - points_.low[k];
      const Lanes gap = max(max(from, -to), 0.0f), extent = 0.5f * (to - from);
      c[k] = 0.5f * (from + to);
      nearest2 = mul_add(gap, gap, nearest2);
      centre2 = mul_add(c[k], c[k], centre2);
      reach2 = mul_add(extent, extent, reach2);
      above += most_product(points_.normal_low[k], points_.normal_high[k], from, to);
      before += most_product(n.normal_low[k], n.normal_high[k], -to, -from);
    }
    const Lanes nearest = sqrt(nearest2), reach = sqrt(reach2);
    const Lanes rounding = 5e-7f * mul_add(2.0f, reach, nearest);  // of heights: they cancel
    const Lanes inverse = 1.0f / sqrt(max(centre2, 1e-24f)), sine = reach * inverse;
    for (Lanes& x : c) x = x * inverse;
    const Cone cone{sine, sqrt(max(1.0f - sine * sine, 0.0f)), sine >= 1.0f};
    const Lanes here =
        min(turned(most(points_.normal_low, points_.normal_high, c), cone), share(above + rounding, nearest));
    const Lanes there = min(turned(most(n.normal_low, n.normal_high, -c[0], -c[1], -c[2]), cone),
                            share(before + rounding, nearest));
    const Lanes lobe = turned(most(n.lobe_low, n.lobe_high, -c[0], -c[1], -c[2]), cone);
    const Lanes mirror = turned(most(points_.mirror_low, points_.mirror_high, c), cone);
    const Lanes sent = mul_add(n.peak, power(lobe, n.slowest), n.diffuse);
    const Lanes reflected = mul_add(Lanes(points_.peak), power(mirror, points_.slowest), points_.diffuse);
    const Lanes geometry = 1.0f / max(nearest2 + n.softening, 1e-30f);
    return {sent * there * here * reflected * geometry, min(n.size * sqrt(geometry), 3.5449077f)};
  }

 private:
  /// Directions from the points to the VPLs lie within this angle of the one from centre to centre.
  struct Cone {
    Lanes sine, cosine;
    LaneMask is_everything;
  };

  /// The largest dot product of a vector in a box with a direction.
  static Lanes most(const Lanes* low, const Lanes* high, Lanes x, Lanes y, Lanes z) {
    return max(low[0] * x, high[0] * x) + max(low[1] * y, high[1] * y) + max(low[2] * z, high[2] * z);
  }
  static Lanes most(const vec3& low, const vec3& high, const Lanes* d) {
    return max(low.x * d[0], high.x * d[0]) + max(low.y * d[1], high.y * d[1]) +
           max(low.z * d[2], high.z * d[2]);
  }

  /// The largest cosine to any direction of the cone, if that to its axis is at most `cosine`; at least 0.
  /// Rounded up, by more than a lobe of exponent 1e5 forgives rounding.
  static Lanes turned(Lanes cosine, const Cone& cone) {
    const Lanes sine = sqrt(max(1.0f - cosine * cosine, 0.0f));
    const Lanes nearer = mul_add(cosine, cone.cosine, sine * cone.sine) + 2e-6f;
    const LaneMask is_one = (cosine >= cone.cosine) | cone.is_everything;
    return select(is_one, 1.0f, min(max(nearer, 0.0f), 1.0f));
  }

  /// The largest product of two numbers from two intervals.
  static Lanes most_product(Lanes low, Lanes high, Lanes from, Lanes to) {
    return max(max(low * from, low * to), max(high * from, high * to));
  }
  /// A cosine is at most height over distance.
  static Lanes share(Lanes height, Lanes nearest) {
    return select(height > 0.0f, min(height / max(nearest, 1e-30f), 1.0f), 0.0f);
  }

  /// At least x^k: x^k <= e^-y with y = k (1 - x), and e^(y/8) >= 1 + y/8 + (y/8)²/2.
  static Lanes power(Lanes x, Lanes k) {
    const Lanes y = 0.125f * k * (1.0f - x), e = mul_add(y, mul_add(0.5f, y, 1.0f), 1.0f);
    const Lanes e2 = e * e, e4 = e2 * e2;
    return 1.0f / (e4 * e4);
  }

  PointBound points_;
};

}  // namespace coppice::inline HWY_NAMESPACE
