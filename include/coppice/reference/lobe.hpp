// Lobes of radiance by brute force: sums over every lobe, and convolutions by quadrature, in double.
#pragma once

#include <algorithm>
#include <cmath>
#include <coppice/core/config.hpp>
#include <coppice/core/math.hpp>
#include <numbers>
#include <span>
#include <vector>

namespace coppice::reference {

/// A direction of a quadrature over the sphere and the solid angle that it stands for.
struct SphereNode {
  glm::dvec3 direction;
  double weight;
};

/// rings · turns midpoints over the whole sphere, most of them within a few `width` radians of the axis.
inline std::vector<SphereNode> sphere_nodes(const glm::dvec3& axis, double width, int rings, int turns) {
  const glm::dvec3 other = std::abs(axis.x) < 0.7 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 u = glm::normalize(glm::cross(axis, other)), v = glm::cross(axis, u);
  const double most = std::asinh(std::numbers::pi / width);
  std::vector<SphereNode> nodes;
  for (int i = 0; i < rings; ++i)
    for (int j = 0; j < turns; ++j) {
      const double t = most * (i + 0.5) / rings, angle = width * std::sinh(t);
      const double turn = 2 * std::numbers::pi * (j + 0.5) / turns;
      const double ring = std::sin(angle) * width * std::cosh(t) * most / rings;
      const glm::dvec3 across = u * std::cos(turn) + v * std::sin(turn);
      nodes.push_back(
          {axis * std::cos(angle) + across * std::sin(angle), ring * 2 * std::numbers::pi / turns});
    }
  return nodes;
}

/// Filtering Eq. 1 for energy 1: (k + 1)/2π max(0, cosine)^k, 1/sr; k < 0 shines as 0 does.
inline double lobe_radiance(double exponent, double cosine) {
  const double k = std::max(exponent, 0.0);
  return cosine > 0 ? (k + 1) / (2 * std::numbers::pi) * std::pow(cosine, k) : 0;
}

struct Lobe {
  glm::dvec3 direction;  ///< unit
  double exponent;
  double energy;
};

/// The radiance of all lobes towards a unit direction, one after the other.
inline double radiance(std::span<const Lobe> lobes, const glm::dvec3& towards) {
  double sum = 0;
  for (const Lobe& lobe : lobes)
    sum += lobe.energy * lobe_radiance(lobe.exponent, glm::dot(lobe.direction, towards));
  return sum;
}

/// The mean of the directions in which the lobes shine, by energy: Σ energy R d / Σ energy.
/// Precondition: some energy.
inline glm::dvec3 mean_direction(std::span<const Lobe> lobes) {
  glm::dvec3 sum(0);
  double energy = 0;
  for (const Lobe& lobe : lobes) {
    sum += lobe.energy * ((lobe.exponent + 1) / (lobe.exponent + 2)) * lobe.direction;
    energy += lobe.energy;
  }
  return sum / energy;
}

/// The spherical Gaussian exp(s cosine) (von Mises-Fisher) whose directions have a mean of a given length:
/// coth(s) - 1/s.
class SphericalGaussian {
 public:
  /// Precondition: 0 <= mean_length < 1.
  explicit SphericalGaussian(double mean_length) {
    COPPICE_ASSERT(mean_length >= 0 && mean_length < 1);
    double low = 0, high = 1 / (1 - mean_length) + 4;
    for (int i = 0; i < 100; ++i) {
      sharpness_ = 0.5 * (low + high);
      (mean_of(sharpness_) < mean_length ? low : high) = sharpness_;
    }
  }

  double sharpness() const { return sharpness_; }
  /// 1/sr.
  double density(double cosine) const {
    if (sharpness_ < 1e-8) return 0.25 * std::numbers::inv_pi;
    const double peak = sharpness_ / (-2 * std::numbers::pi * std::expm1(-2 * sharpness_));
    return peak * std::exp(sharpness_ * (cosine - 1));
  }

 private:
  static double mean_of(double s) { return s < 1e-3 ? s / 3 : 1 / std::tanh(s) - 1 / s; }

  double sharpness_ = 0;
};

/// A Phong lobe of energy 1 whose direction is spread by a spherical Gaussian: their convolution, by
/// quadrature over the narrower of the two. Relative error below 1e-3 at the peak of any, 1e-4 of its energy.
class SpreadLobe {
 public:
  /// Precondition: exponent >= 0, 0 <= mean_length <= 1.
  SpreadLobe(double exponent, double mean_length)
      : exponent_(exponent), delta_(mean_length >= 1), gaussian_(delta_ ? 0 : mean_length) {
    const double sharpest = std::max(exponent, gaussian_.sharpness());
    lobe_inside_ = exponent >= gaussian_.sharpness();
    nodes_ = sphere_nodes({0, 0, 1}, 0.7 / std::sqrt(sharpest + 1), 96, 48);
    double total = 0;
    for (SphereNode& n : nodes_) total += n.weight *= inner(n.direction.z);
    for (SphereNode& n : nodes_) n.weight /= total;
  }

  /// Radiance towards a direction at this cosine from the axis, 1/sr.
  double operator()(double cosine) const {
    if (delta_) return lobe_radiance(exponent_, cosine);
    const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
    double sum = 0;
    for (const SphereNode& n : nodes_) sum += n.weight * outer(n.direction.x * sine + n.direction.z * cosine);
    return sum;
  }

 private:
  double inner(double cosine) const {
    return lobe_inside_ ? lobe_radiance(exponent_, cosine) : gaussian_.density(cosine);
  }
  double outer(double cosine) const {
    return lobe_inside_ ? gaussian_.density(cosine) : lobe_radiance(exponent_, cosine);
  }

  double exponent_;
  bool delta_;
  SphericalGaussian gaussian_;
  bool lobe_inside_ = true;
  std::vector<SphereNode> nodes_;
};

}  // namespace coppice::reference
