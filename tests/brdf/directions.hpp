// Directions and quadrature for the tests of BRDFs.
#pragma once

#include <algorithm>
#include <cmath>
#include <coppice/core/math.hpp>
#include <numbers>
#include <random>

namespace brdf_test {

using coppice::vec3;
using glm::dvec3;

inline dvec3 spherical(double z, double azimuth) {
  const double r = std::sqrt(std::max(0.0, 1 - z * z));
  return {r * std::cos(azimuth), r * std::sin(azimuth), z};
}

/// Uniform in the upper hemisphere.
inline vec3 random_direction(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  const double z = std::max(1e-3, unit(random));
  return vec3(spherical(z, 2 * std::numbers::pi * unit(random)));
}

/// The mean over side² midpoints (u, v) of the unit square, in double.
template <class F>
double mean_over_square(int side, F f) {
  double sum = 0;
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) sum += f((i + 0.5) / side, (j + 0.5) / side);
  return sum / (double(side) * side);
}

/// ∫ cosine_weighted(wi) dωi over the hemisphere, by half vectors drawn from a GGX lobe of this width: exact
/// in the limit for any integrand, quick where it is a lobe about the half vector.
template <class F>
double integral_over_half_vectors(const vec3& wo, double alpha, int side, F cosine_weighted) {
  const dvec3 viewer(wo);
  return mean_over_square(side, [&](double u, double v) {
    const double tangent2 = alpha * alpha * u / (1 - u);
    const dvec3 h = spherical(1 / std::sqrt(1 + tangent2), 2 * std::numbers::pi * v);
    const double h_viewer = glm::dot(h, viewer);
    const dvec3 wi = 2 * h_viewer * h - viewer;
    if (h_viewer <= 0 || wi.z <= 0) return 0.0;
    const double t = alpha / (h.z * h.z * (alpha * alpha + tangent2));
    const double density = t * t * h.z / std::numbers::pi / (4 * h_viewer);
    return double(cosine_weighted(vec3(wi))) / density;
  });
}

/// The same by directions drawn from cosⁿ about the mirror direction.
template <class F>
double integral_about_mirror(const vec3& wo, double exponent, int side, F cosine_weighted) {
  const vec3 axis(-wo.x, -wo.y, wo.z);
  vec3 tangent, bitangent;
  coppice::make_frame(axis, tangent, bitangent);
  return mean_over_square(side, [&](double u, double v) {
    const double cosine = std::pow(u, 1 / (exponent + 1));
    const double sine = std::sqrt(-std::expm1(2 * std::log(u) / (exponent + 1)));
    const double azimuth = 2 * std::numbers::pi * v;
    const dvec3 wi = dvec3(tangent) * (sine * std::cos(azimuth)) +
                     dvec3(bitangent) * (sine * std::sin(azimuth)) + dvec3(axis) * cosine;
    const double density = (exponent + 1) / (2 * std::numbers::pi) * std::pow(cosine, exponent);
    return wi.z > 0 ? double(cosine_weighted(vec3(wi))) / density : 0.0;
  });
}

}  // namespace brdf_test
