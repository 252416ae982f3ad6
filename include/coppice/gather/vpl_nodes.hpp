// The nodes of a VPL tree: leaves from samples and the light that they receive, clusters by filtering.
#pragma once

#include <coppice/light/vpl_lighting.hpp>
//
#include <coppice/shared/vpl.h>

#include <coppice/lobe/phong_surface.hpp>

namespace coppice {

/// A leaf: the sample shines with what it reflects of the light that arrives. All lights' lobes have one
/// exponent and merge to one lobe of as much energy about the mirrored mean direction, whose mean length is
/// the product of both (Filtering section 2.1).
inline VplNode vpl_leaf(const SurfaceSample& sample, const PhongSurface& surface, const VplLight& light) {
  const vec3& n = sample.normal;
  const float k = surface.exponent, shortfall = lobe_shortfall(k);
  VplNode leaf{};
  leaf.position = sample.position;
  leaf.normal = n;
  leaf.area = sample.area;
  leaf.softening = sample.area / pi;
  leaf.diffuse = leaf.softening * surface.diffuse * light.irradiance;
  leaf.specular = sample.area * ((k + 2) / (k + 1)) * surface.specular * light.irradiance;
  leaf.energy = vpl_energy(leaf.diffuse, leaf.specular);
  leaf.lobe = normalize_or(2 * dot(n, light.direction) * n - light.direction, n);
  leaf.exponent = lobe_exponent(shortfall + (1 - shortfall) * light.shortfall);
  return leaf;
}

/// Sums over the VPLs of a node for the paper's filtering (Filtering section 2.1, "Nonuniform Lobes"), in
/// which every VPL counts alike but for the lobes' directions, which count by magnitude.
struct UniformSums {
  vec3 position{0};
  float count = 0;
  vec3 normal{0};
  float lobes = 0;  ///< VPLs with a lobe
  vec3 lobe{0};     ///< Σ magnitude · direction
  float magnitudes = 0;
  float exponents = 0;

  friend UniformSums operator+(const UniformSums& a, const UniformSums& b) {
    return {a.position + b.position, a.count + b.count,           a.normal + b.normal,      a.lobes + b.lobes,
            a.lobe + b.lobe,         a.magnitudes + b.magnitudes, a.exponents + b.exponents};
  }
};

/// Dark VPLs, which the paper keeps, count for nothing: they have left before.
inline UniformSums uniform_sums(const VplNode& leaf) {
  if (!(leaf.energy > 0)) return {};
  const float magnitude = vpl_luminance(leaf.specular);
  const bool has_lobe = magnitude > 0;
  return {leaf.position,
          1,
          leaf.normal,
          has_lobe ? 1.0f : 0.0f,
          magnitude * leaf.lobe,
          magnitude,
          has_lobe ? leaf.exponent : 0.0f};
}

/// A cluster as the paper filters it: plain means of positions, normals and exponents, and the Toksvig factor
/// of the mean direction (Filtering Eq. 3 and 4). Colours, energy and area add up as in vpl_cluster.
/// Averaging the magnitudes over non-zero lobes only, as the text can be read, would lose energy.
inline VplNode uniform_cluster(const VplNode& a, const VplNode& b, const UniformSums& sums) {
  VplNode c = vpl_cluster(a, b);
  c.variance = 0;
  if (!(sums.count > 0)) return c;
  c.position = sums.position / sums.count;
  c.normal = sums.normal / sums.count;
  if (!(sums.lobes > 0)) return c;
  const float size = length(sums.lobe), shortfall = std::clamp(1 - size / sums.magnitudes, 0.0f, 1.0f);
  c.lobe = normalize_or(sums.lobe, c.lobe);
  c.exponent = lobe_widened(std::max(sums.exponents / sums.lobes, 0.0f), lobe_variance(shortfall));
  return c;
}

}  // namespace coppice
