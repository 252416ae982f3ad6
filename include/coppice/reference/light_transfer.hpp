// Indirect light through a basis, in full: project, emit, and solve. The twin of transfer/light_transfer.hpp.
#pragma once

#include <coppice/transfer/light_basis.hpp>
//
#include <coppice/transfer/interreflection.hpp>

namespace coppice::reference {

/// The light that a basis keeps of direct irradiance, sample by sample. `intensity` as for project(); a
/// centred basis gives back the mean times it where `mean` is set, and leaves it out otherwise (PCA Eq. 10 as
/// it stands).
inline std::vector<vec3> kept_light(const ClusteredSamples& samples, const LightBasis& basis,
                                    std::span<const vec3> direct, const vec3& intensity = vec3(1),
                                    bool mean = true) {
  std::vector<vec3> kept(samples.size(), vec3(0));
  for (std::size_t c = 0; c < samples.cluster_count(); ++c) {
    const ClusterLightBasis& cluster = basis.clusters[c];
    const std::size_t begin = samples.begin(c);
    for (std::size_t i = 0; i < samples.size(c); ++i)
      if (mean) kept[begin + i] = intensity * cluster.mean[i];
    for (std::size_t j = 0; j < cluster.rank(); ++j) {
      glm::dvec3 coefficient(0);
      for (std::size_t i = 0; i < samples.size(c); ++i)
        coefficient +=
            double(cluster.projection[j][i]) * glm::dvec3(direct[begin + i] - intensity * cluster.mean[i]);
      for (std::size_t i = 0; i < samples.size(c); ++i)
        kept[begin + i] += vec3(coefficient * double(cluster.emission[j][i]));
    }
  }
  return kept;
}

/// Solves for the indirect irradiance of one light's direct irradiance.
inline std::vector<vec3> solved(const Transport& transport, const ClusteredSamples& samples,
                                std::span<const vec3> direct, const InterreflectionOptions& options) {
  Rows light(samples.size(), 3);
  for (std::size_t i = 0; i < samples.size(); ++i)
    for (std::size_t channel = 0; channel < 3; ++channel) light[i][channel] = direct[i][int(channel)];
  const Rows received = interreflect(transport, albedos_of(samples.samples), light, Serial(), options);
  std::vector<vec3> indirect;
  for (std::size_t i = 0; i < samples.size(); ++i)
    indirect.emplace_back(received[i][0], received[i][1], received[i][2]);
  return indirect;
}

/// The indirect irradiance of the light that a basis keeps, without any compression. Cost: a solution.
inline std::vector<vec3> indirect_irradiance(const Transport& transport, const ClusteredSamples& samples,
                                             const LightBasis& basis, std::span<const vec3> direct,
                                             const InterreflectionOptions& options,
                                             const vec3& intensity = vec3(1), bool mean = true) {
  return solved(transport, samples, kept_light(samples, basis, direct, intensity, mean), options);
}

}  // namespace coppice::reference
