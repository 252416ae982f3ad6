// Bases for the direct light on clusters of samples, found from example lights.
#pragma once

#include <coppice/transfer/sample_lighting.hpp>
//
#include <cmath>
#include <coppice/core/error.hpp>
#include <coppice/pca/basis.hpp>
#include <coppice/transfer/clustered_samples.hpp>
#include <string>

namespace coppice {

enum class LightBasisKind : std::uint8_t {
  paper,            ///< principal components about the mean (PCA section 4.3.1): affine in the light
  uncentred,        ///< the same about zero: linear in the light
  transport_aware,  ///< the directions whose loss the indirect light shows least: linear in the light
};

struct LightBasisOptions {
  std::size_t rank = 20;   ///< vectors a cluster; for share_ranks the mean of the clusters
  bool scale_rows = true;  ///< examples count by 1/√norm on the cluster: lights near a wall do not rule
  // What follows is of transport_aware_basis alone.
  /// Clusters share all ranks so that the greatest losses over all clusters are least.
  bool share_ranks = true;
  /// λ: how much light that no example showed counts, as a share of the examples' mean variance; > 0.
  double ridge = 0.003;
};

/// The basis of a cluster's direct light: coefficient j is projection[j] · light, and emission[j] is the
/// light that it stands for. projection · emissionᵀ is the identity.
struct ClusterLightBasis {
  Rows projection, emission;  ///< rank rows, a column a sample of the cluster; equal but for transport_aware
  std::vector<float> mean;    ///< of light at unit intensity; zeros where the basis is not centred
  std::vector<double> energies;  ///< a vector, descending: of the light, or of what it causes

  std::size_t rank() const { return projection.count(); }
};

/// A basis for each cluster. Its coefficients lie one cluster's after the other's.
struct LightBasis {
  LightBasisKind kind = LightBasisKind::uncentred;
  std::vector<ClusterLightBasis> clusters;

  bool centred() const { return kind == LightBasisKind::paper; }
  std::size_t coefficient_count() const {
    std::size_t count = 0;
    for (const ClusterLightBasis& cluster : clusters) count += cluster.rank();
    return count;
  }
};

/// What point lights of unit intensity, one at each position, bring to the samples: row l is light l's. With
/// shadow rays; `softening` as for light_directly. Bytes: 4 a light and sample.
template <Occluder O, Executor E>
Rows example_lights(std::span<const SurfaceSample> samples, std::span<const vec3> positions,
                    const O& occluder, const E& executor, float softening) {
  Rows examples(positions.size(), samples.size());
  executor(positions.size(), 1, [&](std::size_t begin, std::size_t end) {
    std::vector<vec3> irradiance(samples.size());
    for (std::size_t l = begin; l < end; ++l) {
      const LocalLight light = point_light(positions[l], vec3(1));
      light_directly(samples, std::span(&light, 1), occluder, Serial(), softening, irradiance);
      for (std::size_t i = 0; i < samples.size(); ++i) examples[l][i] = irradiance[i].x;
    }
  });
  return examples;
}

namespace detail {

/// The example lights on samples [begin, end): a row a light.
inline Rows columns_of(const Rows& rows, std::size_t begin, std::size_t end) {
  Rows part(rows.count(), end - begin);
  for (std::size_t i = 0; i < rows.count(); ++i)
    std::copy_n(rows[i].begin() + std::ptrdiff_t(begin), end - begin, part[i].begin());
  return part;
}

inline void refuse_unless_finite(const Rows& examples) {
  for (std::size_t l = 0; l < examples.count(); ++l)
    for (std::size_t i = 0; i < examples.width; ++i)
      if (!std::isfinite(examples[l][i]))
        throw InputError("example light " + std::to_string(l),
                         "its irradiance at sample " + std::to_string(i) + " is not finite",
                         "give lights and samples with finite positions");
}

/// How much each light counts: 1/norm, so that its row is scaled by 1/√norm; 0 for lights that do not reach.
inline std::vector<float> example_weights(const Rows& rows, bool scale) {
  std::vector<float> weights;
  for (std::size_t l = 0; l < rows.count(); ++l) {
    double sum = 0;
    for (const float x : rows[l]) sum += double(x) * double(x);
    weights.push_back(!scale ? 1.0f : sum > 0 ? float(1 / std::sqrt(sum)) : 0.0f);
  }
  return weights;
}

inline ClusterLightBasis principal_light_basis(const Rows& lights, bool centred,
                                               const LightBasisOptions& options) {
  PcaBasis basis =
      pca(lights,
          {.centred = centred, .rank = options.rank, .weights = example_weights(lights, options.scale_rows)});
  return {basis.vectors, basis.vectors, std::move(basis.mean), std::move(basis.energies)};
}

}  // namespace detail

/// The bases that know light alone: LightBasisKind::paper or uncentred. `examples` holds a row a light, its
/// irradiance at all samples at unit intensity. Vectors are orthonormal. The rank is less where the examples
/// have no more, and 0 where none reaches the cluster. The same for any executor. Cost: pca() a cluster.
/// Throws InputError where an example is not finite.
template <Executor E>
LightBasis principal_light_basis(const ClusteredSamples& samples, const Rows& examples, LightBasisKind kind,
                                 const E& executor, const LightBasisOptions& options = {}) {
  COPPICE_ASSERT(kind != LightBasisKind::transport_aware);
  COPPICE_ASSERT(examples.width == samples.size() || examples.count() == 0);
  detail::refuse_unless_finite(examples);
  LightBasis basis{kind, std::vector<ClusterLightBasis>(samples.cluster_count())};
  executor(samples.cluster_count(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      if (examples.count() == 0) {
        basis.clusters[c].mean.assign(samples.size(c), 0.0f);
        continue;
      }
      const Rows lights = detail::columns_of(examples, samples.begin(c), samples.end(c));
      basis.clusters[c] = detail::principal_light_basis(lights, kind == LightBasisKind::paper, options);
    }
  });
  return basis;
}

/// The emission of vector j of a cluster's basis at all samples (the red and blue fields of PCA Fig. 3).
inline std::vector<float> emission_field(const ClusteredSamples& samples, const LightBasis& basis,
                                         std::size_t cluster, std::size_t j) {
  std::vector<float> field(samples.size(), 0.0f);
  const auto values = basis.clusters[cluster].emission[j];
  std::copy(values.begin(), values.end(), field.begin() + std::ptrdiff_t(samples.begin(cluster)));
  return field;
}

}  // namespace coppice
