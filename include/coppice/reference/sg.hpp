// Integrals of spherical Gaussians by brute force: sums over the sphere in double, and sums over rings in
// long double where a test needs every digit.
#pragma once

#include <algorithm>
#include <cmath>
#include <coppice/core/config.hpp>
#include <coppice/core/math.hpp>
#include <coppice/reference/lobe.hpp>
#include <numbers>
#include <utility>
#include <vector>

namespace coppice::reference {

/// exp(-λ |d - p|²/2) over unit directions d.
struct Gaussian {
  glm::dvec3 axis;   ///< p, unit
  double sharpness;  ///< λ >= 0

  double operator()(const glm::dvec3& d) const {
    const glm::dvec3 apart = d - axis;
    return std::exp(-0.5 * sharpness * glm::dot(apart, apart));
  }
};

/// ∫ f(ω) over the sphere, by rings · turns midpoints of which most are within the width of the Gaussian.
/// Relative error for a smooth f that is as wide as that or wider: 1e-5; 1e-4 where f has a kink; where it
/// jumps, 2e-4 of its integral without the jump.
template <class Function>
double sphere_integral(const Gaussian& where, const Function& f, int rings = 400, int turns = 200) {
  double sum = 0;
  for (const SphereNode& n : sphere_nodes(where.axis, 0.7 / std::sqrt(where.sharpness + 1), rings, turns))
    sum += n.weight * f(n.direction);
  return sum;
}

/// ∫ G₁G₂G₃ (SG Eq. 4), about the sharpest of the three. Relative error 1e-5 unless all are sharp and apart.
inline double sg_triple_product(const Gaussian& a, const Gaussian& b, const Gaussian& c) {
  const Gaussian& bc = b.sharpness > c.sharpness ? b : c;
  return sphere_integral(a.sharpness > bc.sharpness ? a : bc,
                         [&](const glm::dvec3& d) { return a(d) * b(d) * c(d); });
}

/// ∫ G(ω) max(0, n·ω) dω.
inline double sg_clamped_cosine(const Gaussian& g, const glm::dvec3& normal) {
  return sphere_integral(g, [&](const glm::dvec3& d) { return g(d) * std::max(0.0, glm::dot(normal, d)); });
}

/// ∫ G over n·ω > 0.
inline double sg_hemisphere(const Gaussian& g, const glm::dvec3& normal) {
  return sphere_integral(g, [&](const glm::dvec3& d) { return glm::dot(normal, d) > 0 ? g(d) : 0.0; });
}

/// ∫ G₁(ω·p) G₂(ω·d) dω.
inline double sg_convolution(const Gaussian& g, double sharpness, const glm::dvec3& towards) {
  return sg_triple_product(g, {towards, sharpness}, {towards, 0});
}

/// Gauss's and Legendre's points and weights on [0, 1].
inline std::vector<std::pair<long double, long double>> gauss_legendre(int count) {
  std::vector<std::pair<long double, long double>> rule;
  for (int i = 0; i < count; ++i) {
    long double x = std::cos(std::numbers::pi_v<long double> * (i + 0.75L) / (count + 0.5L)), slope = 1;
    for (int step = 0; step < 20; ++step) {
      long double p = 1, before = 0;
      for (int j = 0; j < count; ++j) before = std::exchange(p, ((2 * j + 1) * x * p - j * before) / (j + 1));
      slope = count * (x * p - before) / (x * x - 1);
      x -= p / slope;
    }
    rule.push_back({0.5L * (1 + x), 1 / ((1 - x * x) * slope * slope)});
  }
  return rule;
}

/// What of a Gaussian lies above a plane through the origin.
struct AbovePlane {
  long double integral = 0;  ///< ∫ G over n·ω > 0
  long double cosine = 0;    ///< ∫ G max(0, n·ω)
};

/// For an axis at or below the plane, n·p = -below: rings about the axis, whose part above the plane is known
/// in closed form. Relative error 1e-13, however little there is. Precondition: 0 <= below <= 1, sharpness >=
/// 0.
class RingIntegral {
 public:
  RingIntegral(long double below, long double sharpness)
      : below_(below),
        level_(std::sqrt((1 - below) * (1 + below))),
        elevation_(std::asin(below)),
        sharpness_(sharpness) {
    COPPICE_ASSERT(below >= 0 && below <= 1 && sharpness >= 0);
  }

  AbovePlane operator()() const {
    const long double whole = std::numbers::pi_v<long double> - elevation_;  // rings beyond are all above
    const long double end = last_ring();
    AbovePlane sum;
    add_rings(sum, elevation_, std::min(whole, end));
    if (end > whole) add_rings(sum, whole, end);
    const long double scale = std::exp(-sharpness_ * (below_ * below_ / (1 + level_)));
    return {sum.integral * scale, sum.cosine * scale};
  }

 private:
  /// -log of G at that angle from the axis, over what it is at the plane.
  long double fall(long double angle) const {
    return 2 * sharpness_ * std::sin(0.5L * (angle + elevation_)) * std::sin(0.5L * (angle - elevation_));
  }
  long double last_ring() const {
    long double low = elevation_, high = std::numbers::pi_v<long double>;
    if (fall(high) <= 45) return high;
    for (int i = 0; i < 80; ++i) {
      const long double middle = 0.5L * (low + high);
      (fall(middle) < 45 ? low : high) = middle;
    }
    return high;
  }
  /// Panels that crowd at both ends.
  void add_rings(AbovePlane& sum, long double begin, long double end) const {
    static const auto rule = gauss_legendre(24);
    constexpr int panels = 10;
    for (int panel = 0; panel < panels; ++panel)
      for (const auto& [x, weight] : rule) {
        const long double u = (panel + x) / panels, s = u * u * (3 - 2 * u);
        add_ring(sum, begin + (end - begin) * s, weight / panels * 6 * u * (1 - u) * (end - begin));
      }
  }
  /// n·ω = along + across cos φ on a ring; it is above the plane for |φ| < turn.
  void add_ring(AbovePlane& sum, long double angle, long double width) const {
    const long double sine = std::sin(angle), along = -below_ * std::cos(angle), across = level_ * sine;
    const long double height2 = std::sin(angle - elevation_) * std::sin(angle + elevation_);
    const bool cut = across > std::abs(along);
    const long double height = cut ? std::sqrt(std::max(height2, 0.0L)) : 0;  // across · sin(turn)
    const long double turn =
        cut ? std::atan2(height, -along) : (along > 0 ? std::numbers::pi_v<long double> : 0.0L);
    const long double t2 = turn * turn;
    const long double cosine = cut && turn < 0.02L
                                   ? across * turn * t2 * (1 / 3.0L - t2 * (1 / 30.0L - t2 / 840))
                                   : along * turn + height;
    const long double weight = 2 * width * sine * std::exp(-fall(angle));
    sum.integral += weight * turn;
    sum.cosine += weight * cosine;
  }

  long double below_, level_, elevation_, sharpness_;
};

}  // namespace coppice::reference
