// Lobes of BRDFs and their Gaussians by quadrature over the hemisphere, in double.
#pragma once

#include <coppice/reference/lobe.hpp>
#include <coppice/sg/lobe_integral.hpp>

namespace coppice::reference {

/// rings · turns midpoints over the directions above the horizon, as half vectors of a lobe of this width
/// reflect the viewer: dense where a microfacet lobe is. The rings are broken, so that none runs along the
/// horizon.
inline std::vector<SphereNode> reflected_nodes(const glm::dvec3& viewer, double width, int rings, int turns) {
  constexpr double pi = std::numbers::pi;
  const double scale = 0.5 * width, most = std::asinh(1e3 / scale);
  std::vector<SphereNode> nodes;
  for (int i = 0; i < rings; ++i)
    for (int j = 0; j < turns; ++j) {
      const double u = most * (i + std::fmod(0.618034 * (j + 1), 1.0)) / rings;
      const double turn = 2 * pi * (j + 0.5) / turns;
      const double tangent = scale * std::sinh(u), z = 1 / std::sqrt(1 + tangent * tangent);
      const glm::dvec3 half(z * tangent * std::cos(turn), z * tangent * std::sin(turn), z);
      const double part = dot(half, viewer);
      const glm::dvec3 light = 2 * part * half - viewer;
      if (part <= 0 || light.z <= 0) continue;
      const double area = tangent * z * z * z * scale * std::cosh(u) * most / rings * 2 * pi / turns;
      nodes.push_back({light, 4 * part * area});
    }
  return nodes;
}

/// What of a Gaussian lies above the horizon, and the mean of max(0, d.z), for λ and the z of its axis: ring
/// by ring about the axis, each in closed form.
struct HemisphereMoments {
  double share = 0;
  double cosine = 0;
};
inline HemisphereMoments hemisphere_moments(double sharpness, double z, int rings = 4000) {
  const double across = std::sqrt(std::max(0.0, 1 - z * z)), pi = std::numbers::pi;
  const double widest = std::min(pi, 9 / std::sqrt(std::max(sharpness, 1e-3)));
  HemisphereMoments sums;
  double all = 0;
  for (int i = 0; i < rings; ++i) {
    const double angle = widest * (i + 0.5) / rings, half = std::sin(0.5 * angle);
    const double weight = std::exp(-2 * sharpness * half * half) * std::sin(angle);
    const double middle = z * std::cos(angle), swing = across * std::sin(angle);
    const double turn = middle >= swing ? pi : middle <= -swing ? 0 : std::acos(-middle / swing);
    sums.share += weight * turn / pi;
    sums.cosine += weight * (middle * turn + swing * std::sin(turn)) / pi;
    all += weight;
  }
  return {sums.share / all, sums.cosine / all};
}

/// exp(-λ |d - p|²/2).
inline double gaussian(const SgShape& g, const glm::dvec3& d) {
  const glm::dvec3 apart = glm::normalize(glm::dvec3(g.axis)) - d;
  return std::exp(-0.5 * double(g.sharpness) * dot(apart, apart));
}

/// The sum of the lobe's Gaussians at d, above the horizon or not.
inline double unclamped_value(const BrdfLobes& lobes, const glm::dvec3& d) {
  double sum = 0;
  for (int k = 0; k < lobes.count; ++k) {
    const BrdfLobe& lobe = lobes.lobes[std::size_t(k)];
    const double across = dot(d, glm::dvec3(lobes.across));
    sum += double(lobe.amplitude) * gaussian(lobe.shape, d) *
           std::exp(-0.5 * double(lobe.stripe) * across * across);
  }
  return lobes.times_cosine ? sum * std::max(d.z, 0.0) : sum;
}
inline double value(const BrdfLobes& lobes, const glm::dvec3& d) {
  return d.z > 0 ? unclamped_value(lobes, d) : 0;
}

/// Σ f(direction) · weight.
template <class F>
double integrate(std::span<const SphereNode> nodes, F f) {
  double sum = 0;
  for (const SphereNode& n : nodes) sum += f(n.direction) * n.weight;
  return sum;
}

/// ∫ f · G over the nodes: a slice of a BRDF against a Gaussian of light.
template <class F>
double integral_with_light(std::span<const SphereNode> nodes, const SgShape& light, F f) {
  return integrate(nodes, [&](const glm::dvec3& d) { return f(d) * gaussian(light, d); });
}

}  // namespace coppice::reference
