// Cones packed into the lobes of a BRDF, and how much light each stands for: the paper's placement.
#pragma once

#include <coppice/sg/cone_cut.hpp>
//
#include <concepts>
#include <coppice/sg/brdf_lobes.hpp>
#include <coppice/sg/cones.hpp>

namespace coppice::inline HWY_NAMESPACE {

/// Tells the mean radiance under a Gaussian: PreconvolvedEnvironment by a lookup, LightColumns by a pass over
/// all Gaussians of the light.
template <class L>
concept MeanLight = requires(const L& light, const SgShape& shape) {
  { light.mean(shape) } -> std::same_as<vec3>;
};

struct PackedConeOptions {
  int cones = 7;  ///< in each lobe: 1, 3, 7, 13 or 19
  LobeFit fit = LobeFit::fitted;
  /// The light through a cone is the triple product of lobe, cone and light itself (SG Eq. 2), with one
  /// Gaussian for Lambert's lobe too; it is not brought to the unoccluded light. The paper, literally.
  bool is_literal = false;
};

/// Packs cones into the diffuse lobe and into the glossy one. The light of a lobe that is no peak's is shared
/// out between its cones by the triple products of lobe, cone and light, so that without occluders it is what
/// the sum over the lights makes it; peaks have their own cones. Keeps its scratch between points.
template <MeanLight Light>
class PackedCones {
 public:
  /// `tree`: the lights as the BRDF is summed over them; `light`: those of them that are no peak's, as
  /// Gaussians; `peaks`: of the tree. All in the same frame.
  PackedCones(const ProductTree& tree, const Light& light, std::span<const SgLight> peaks,
              const PackedConeOptions& options)
      : light_(light), peaks_(peaks), options_(options), unoccluded_(tree) {}

  /// The result is good until the next call.
  const LitCones& place(const ShadingPoint& point) {
    result_ = LitCones{};
    const vec3 viewer = brdf_viewer_to_local(point.normal, point.tangent, point.to_viewer);
    if (point.diffuse != vec3(0)) {
      ShadingPoint diffuse = point;
      diffuse.specular = diffuse.fresnel = vec3(0);
      place_lobe(diffuse, options_.is_literal ? one_gaussian(viewer) : lambert_lobes(viewer),
                 cones_of(lambert_lobes(viewer), options_.cones));
    }
    if (point.specular != vec3(0) || point.fresnel != vec3(0)) {
      ShadingPoint glossy = point;
      glossy.diffuse = vec3(0);
      const BrdfLobes lobes = brdf_lobes(point, options_.fit);
      if (lobes.count > 0) place_lobe(glossy, lobes, cones_of(lobes, options_.cones));
    }
    return result_;
  }

 private:
  /// cos/π as one Gaussian of the same integral, 13% off and 11% of it below the horizon.
  static BrdfLobes one_gaussian(const vec3& viewer) {
    BrdfLobes lobes = lambert_lobes(viewer);
    lobes.times_cosine = false;
    lobes.lobes[0].shape.sharpness = 2.133f;
    lobes.lobes[0].amplitude = sg_normalisation(2.133f);
    return lobes;
  }

  void place_lobe(const ShadingPoint& point, const BrdfLobes& lobes, const LobeCones& cones) {
    const vec3 whole = place_peaks(point, lobes);
    std::array<vec3, 19> weights{};
    vec3 sum(0);
    for (std::size_t j = 0; j < std::size_t(cones.count); ++j) {
      weights[j] = glm::max(weight(point, lobes, cones.shapes[j]), vec3(0));
      sum += weights[j];
    }
    for (std::size_t j = 0; j < std::size_t(cones.count); ++j) {
      vec3 radiance = weights[j] * colour(point, lobes);
      for (int c = 0; c < 3 && !options_.is_literal; ++c)
        radiance[c] = whole[c] * (sum[c] > 0 ? weights[j][c] / sum[c] : cones.shares[j]);
      result_.cones.push_back({{to_world(point, cones.shapes[j].axis), cones.shapes[j].sharpness},
                               radiance,
                               luminance(radiance)});
    }
  }

  /// Returns the light that is no peak's.
  vec3 place_peaks(const ShadingPoint& point, const BrdfLobes& lobes) {
    if (!options_.is_literal) {
      const LitCones& known = unoccluded_.place_peaks(point);
      result_.clusters += known.clusters;
      result_.cones.insert(result_.cones.end(), known.cones.begin(), known.cones.end());
      return known.untraced;
    }
    for (const SgLight& peak : peaks_) {
      const SgShape shape{peak.axis, peak.sharpness};
      float sum = 0;
      for (int k = 0; k < lobes.count; ++k) {
        const BrdfLobe& lobe = lobes.lobes[std::size_t(k)];
        sum += lobe.amplitude *
               sg_inner_product({to_world(point, lobe.shape.axis), lobe.shape.sharpness}, shape);
      }
      const vec3 radiance = sum * peak.amplitude * colour(point, lobes);
      result_.cones.push_back({shape, radiance, luminance(radiance)});
    }
    return vec3(0);
  }

  /// ∫ lobe · cone · light, the part of the lobe below the horizon left out unless it is to be literal.
  vec3 weight(const ShadingPoint& point, const BrdfLobes& lobes, const SgShape& cone) const {
    vec3 sum(0);
    for (int k = 0; k < lobes.count; ++k) {
      const BrdfLobe& lobe = lobes.lobes[std::size_t(k)];
      const SgProduct product = sg_product(lobe.shape, cone);
      if (options_.is_literal) {
        sum += lobe.amplitude * product.scale * sg_integral(product.sharpness) *
               light_.mean({to_world(point, product.axis), product.sharpness});
        continue;
      }
      const LobeIntegral part = lobe_integral(lobes, lobe, cone);
      sum += part.value * light_.mean({to_world(point, normalize_or(part.direction, product.axis)),
                                       product.sharpness + (lobes.times_cosine ? 2.0f : 0.5f * lobe.stripe)});
    }
    return sum;
  }

  /// Of a literal lobe: Fresnel's factor is that of the mirror direction.
  static vec3 colour(const ShadingPoint& point, const BrdfLobes& lobes) {
    const float w = lobes.schlick ? detail::schlick_towards(lobes.viewer, lobes.lobes[0].shape.axis) : 0.0f;
    return point.diffuse + (1 - w) * point.specular + w * point.fresnel;
  }

  static vec3 to_world(const ShadingPoint& p, const vec3& local) {
    return local.x * p.tangent + local.y * cross(p.normal, p.tangent) + local.z * p.normal;
  }

  const Light& light_;
  std::span<const SgLight> peaks_;
  PackedConeOptions options_;
  ConeCut unoccluded_;
  LitCones result_;
};

}  // namespace coppice::inline HWY_NAMESPACE
