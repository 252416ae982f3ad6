// Slices of BRDFs, towards one viewer, and how far Gaussians are from them.
#pragma once

#include <coppice/reference/brdf_lobes.hpp>
#include <coppice/sg/brdf_lobes.hpp>

#include "brdf/directions.hpp"

namespace sg_test {

using namespace coppice;
using glm::dvec3;
using reference::SphereNode;

/// Blinn-Phong and Phong take the exponent of this width.
struct Slice {
  uint kind;
  double alpha;
  double cosine;
  double azimuth = 0.7;

  vec3 viewer() const { return vec3(brdf_test::spherical(cosine, azimuth)); }
  dvec3 mirror() const {
    const vec3 v = viewer();
    return glm::normalize(dvec3(-v.x, -v.y, v.z));
  }
  float parameter() const {
    const bool power = kind == BRDF_PHONG || kind == BRDF_BLINN_PHONG;
    return power ? std::max(float(2 / (alpha * alpha) - 2), 1.0f) : float(alpha);
  }
  BrdfTerms<double> terms(const dvec3& d) const {
    return brdf_terms<double>(kind, parameter(), parameter(), d.x, d.y, d.z, viewer());
  }
  double operator()(const dvec3& d) const {
    const BrdfTerms<double> t = terms(d);
    return t.specular + t.fresnel;
  }
  BrdfLobes lobes(LobeFit fit = LobeFit::fitted) const {
    return brdf_lobes(kind, parameter(), parameter(), viewer(), fit);
  }
  /// Dense where the lobe is, none below the horizon.
  std::vector<SphereNode> nodes(int rings = 80, int turns = 48) const {
    if (kind != BRDF_PHONG)
      return reference::reflected_nodes(glm::normalize(dvec3(viewer())), alpha, rings, turns);
    auto all = reference::sphere_nodes(mirror(), alpha, rings, turns);
    std::erase_if(all, [](const SphereNode& n) { return n.direction.z <= 0; });
    return all;
  }
};

/// Relative L2 errors over the directions of the light.
struct FitErrors {
  double sharp = 0;       ///< of the slice itself
  double at_50 = 0;       ///< of the integrals against Gaussians of λ = 50, in closed form
  double at_5 = 0;        ///< of λ = 5
  double energy = 0;      ///< relative error of the whole integral
  double forms_50 = 0;    ///< of the closed form against the quadrature of the same Gaussians
  double forms_5 = 0;     ///< the same
  double below = 0;       ///< share of the Gaussians' energy that lies below the horizon if it is not cut
  double leak_cut = 0;    ///< L2 error from lights (λ = 50) below the horizon alone, over the norm of all
  double leak_uncut = 0;  ///< the same of Gaussians that are not cut
};

inline SgShape upside_down(SgShape shape) {
  shape.axis.z = -shape.axis.z;
  return shape;
}
/// What lies below the horizon of the Gaussians, put above it.
inline BrdfLobes upside_down(BrdfLobes lobes) {
  for (BrdfLobe& lobe : lobes.lobes) lobe.shape = upside_down(lobe.shape);
  return lobes;
}

/// Light from one direction: what the slice, its Gaussians and the closed form make of it.
struct LightIntegrals {
  double exact = 0, quadrature = 0, form = 0, uncut = 0;
};

inline LightIntegrals integrals_of(const BrdfLobes& lobes, const std::vector<SphereNode>& nodes,
                                   const std::vector<double>& values, const std::vector<double>& fits,
                                   const SgShape& light) {
  LightIntegrals sums;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const double g = reference::gaussian(light, nodes[i].direction) * nodes[i].weight;
    sums.exact += g * values[i], sums.quadrature += g * fits[i];
  }
  sums.form = double(lobes_integral(lobes, light));
  sums.uncut = sums.form;
  if (!lobes.times_cosine) sums.uncut += double(lobes_integral(upside_down(lobes), upside_down(light)));
  return sums;
}

inline FitErrors errors_of(const Slice& slice, const BrdfLobes& lobes) {
  const auto nodes = slice.nodes();
  std::vector<double> values, fits;
  double whole = 0, energy = 0, square = 0, apart = 0;
  for (const SphereNode& n : nodes) {
    const double f = slice(n.direction), g = reference::value(lobes, n.direction);
    values.push_back(f), fits.push_back(g);
    whole += f * n.weight, energy += g * n.weight;
    square += f * f * n.weight, apart += (f - g) * (f - g) * n.weight;
  }
  FitErrors e{std::sqrt(apart / square), 0, 0, energy / whole - 1};
  for (const float sharpness : {50.0f, 5.0f}) {
    double norm = 0, error = 0, forms = 0, cut = 0, uncut = 0;
    for (const SphereNode& s : reference::sphere_nodes(slice.mirror(), std::max(slice.alpha, 0.15), 12, 14)) {
      const LightIntegrals x = integrals_of(lobes, nodes, values, fits, {vec3(s.direction), sharpness});
      norm += x.exact * x.exact * s.weight;
      error += (x.form - x.exact) * (x.form - x.exact) * s.weight;
      forms += (x.form - x.quadrature) * (x.form - x.quadrature) * s.weight;
      if (s.direction.z > 0) continue;
      cut += (x.form - x.exact) * (x.form - x.exact) * s.weight;
      uncut += (x.uncut - x.exact) * (x.uncut - x.exact) * s.weight;
    }
    (sharpness > 10 ? e.at_50 : e.at_5) = std::sqrt(error / norm);
    (sharpness > 10 ? e.forms_50 : e.forms_5) = std::sqrt(forms / norm);
    if (sharpness > 10) e.leak_cut = std::sqrt(cut / norm), e.leak_uncut = std::sqrt(uncut / norm);
  }
  const SgShape even{vec3(0, 0, 1), 0};
  const double above = double(lobes_integral(lobes, even));
  const double below = lobes.times_cosine ? 0 : double(lobes_integral(upside_down(lobes), even));
  e.below = below / (above + below);
  return e;
}

}  // namespace sg_test
