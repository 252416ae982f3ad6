// How the visibility of a lattice is computed: shadow rays to many lights, then a fit a cluster.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <coppice/light/bounce.hpp>
#include <coppice/transfer/clustered_samples.hpp>
#include <coppice/transfer/decision_factors.hpp>
#include <coppice/transfer/lattice_visibility.hpp>

namespace coppice::detail {

/// Points with a row of their own: those that a light stands at or near which some sample sees.
inline FeatureIndex feature_index(std::size_t points, const DecisionMatrix& matrix,
                                  std::span<const LatticeCorners> lights) {
  std::vector<std::int8_t> most(matrix.stride, -1);
  for (std::size_t i = 0; i < matrix.rows; ++i)
    for (std::size_t t = 0; t < matrix.stride; ++t) most[t] = std::max(most[t], matrix.row(i)[t]);
  FeatureIndex index;
  index.bits.assign((points + 31) / 32, 0);
  for (std::size_t t = 0; t < lights.size(); ++t)
    for (std::uint32_t c = 0; c < lights[t].count && most[t] > 0; ++c)
      index.bits[lights[t].points[c] / 32] |= 1u << (lights[t].points[c] % 32);
  std::uint32_t sum = 0;
  for (const std::uint32_t word : index.bits) {
    index.before.push_back(sum);
    sum += std::uint32_t(std::popcount(word));
  }
  return index;
}

inline std::size_t row_count(const FeatureIndex& index) {
  return index.bits.empty() ? 0 : 1 + index.before.back() + std::size_t(std::popcount(index.bits.back()));
}

/// Rounds component k of all rows to integers of a common step, which it returns; 0 where all are zero.
template <class Integer, class Place>
float quantise_component(const Rows& rows, std::size_t k, Place&& place) {
  float most = 0;
  for (std::size_t i = 0; i < rows.count(); ++i) most = std::max(most, std::abs(rows[i][k]));
  if (!(most > 0)) return 0;
  const float step = most / float(std::numeric_limits<Integer>::max());
  for (std::size_t i = 0; i < rows.count(); ++i) place(i) = Integer(std::lround(rows[i][k] / step));
  return step;
}

template <class Integer>
LatticeCluster<Integer> quantise_factors(const DecisionFactors& factors, FeatureIndex index,
                                         std::size_t rank) {
  const std::size_t samples = factors.left.count(), rows = factors.features.count();
  LatticeCluster<Integer> cluster{std::move(index), std::vector<float>(rank, 0.0f),
                                  std::vector<Integer>(samples * rank), std::vector<Integer>(rows * rank)};
  for (std::size_t k = 0; k < rank; ++k)
    cluster.scales[k] =
        quantise_component<Integer>(
            factors.left, k,
            [&](std::size_t i) -> Integer& { return cluster.coefficients[k * samples + i]; }) *
        quantise_component<Integer>(factors.features, k,
                                    [&](std::size_t r) -> Integer& { return cluster.rows[r * rank + k]; });
  return cluster;
}

/// Shadow rays from samples to lights: +1 seen, -1 hidden, 0 below the sample's horizon.
template <Occluder O>
DecisionMatrix trace_decisions(std::span<const SurfaceSample> samples, std::span<const vec3> lights,
                               const O& occluder) {
  DecisionMatrix matrix(samples.size(), lights.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    std::int8_t* row = matrix.row(i);
    const auto seen = [row](std::size_t t, const vec3&) { row[t] = 1; };
    ShadowBatch batch(occluder, ray_origin(samples[i]), seen);
    for (std::size_t t = 0; t < lights.size(); ++t)
      if (const auto path =
              path_to(point_light(lights[t], vec3(1)), ray_origin(samples[i]), samples[i].normal)) {
        row[t] = -1;
        batch.add(t, *path);
      }
    batch.finish();
  }
  return matrix;
}

/// The lights that the lattice can serve, neighbours together so that rays are alike, and their corners.
struct TrainingLights {
  std::vector<vec3> positions;
  std::vector<LatticeCorners> corners;
};

template <Occluder O>
TrainingLights training_lights(const LightLattice& lattice, std::span<const vec3> lights, const O& occluder) {
  std::vector<std::pair<std::size_t, std::uint32_t>> order;
  std::vector<LatticeCorners> corners(lights.size());
  for (std::uint32_t t = 0; t < lights.size(); ++t) {
    corners[t] = lattice_corners(lattice, lights[t], occluder);
    if (corners[t].count == 0) continue;
    const glm::ivec3 cell = clamp(lattice.cell_of(lights[t]), glm::ivec3(0), lattice.size - 1);
    order.emplace_back(lattice.index(cell), t);
  }
  std::sort(order.begin(), order.end());
  TrainingLights sorted;
  for (const auto& [cell, t] : order)
    sorted.positions.push_back(lights[t]), sorted.corners.push_back(corners[t]);
  return sorted;
}

/// The columns that a fit needs: all lights with a point that has its own row, and a few of the rest, whose
/// one row they share.
inline DecisionMatrix needed_columns(const DecisionMatrix& matrix, const FeatureIndex& index,
                                     std::span<const LatticeCorners> lights, std::vector<FeatureMix>& mixes) {
  std::vector<std::size_t> kept;
  std::size_t unseen = 0;
  for (std::size_t t = 0; t < lights.size(); ++t) {
    FeatureMix mix{{}, lights[t].weights, lights[t].count};
    bool own = false;
    for (std::uint32_t c = 0; c < mix.count; ++c) own |= (mix.rows[c] = index.row(lights[t].points[c])) != 0;
    if (!own && unseen++ % 16 != 0) continue;
    mixes.push_back(mix), kept.push_back(t);
  }
  DecisionMatrix result(matrix.rows, kept.size());
  for (std::size_t i = 0; i < matrix.rows; ++i)
    for (std::size_t t = 0; t < kept.size(); ++t) result.row(i)[t] = matrix.row(i)[kept[t]];
  return result;
}

}  // namespace coppice::detail

namespace coppice::inline HWY_NAMESPACE {

/// Fits the visibility of each cluster's samples from lights: shadow rays, then fit_decisions, which lets
/// entries below a sample's horizon be anything and others lie beyond their decision up to options.cap.
/// `lights` are positions in free space, some times as many as lattice points (LatticeVisibility is fitted to
/// them through the interpolation that serves them later, and so makes up for part of its error); where none
/// are given, the lattice points themselves. options.seed and rank are the same for all clusters. The same
/// for any executor. Cost: a shadow ray a sample and light, then fit_decisions; a byte a pair of a cluster at
/// work.
template <class Integer = std::int8_t, Occluder O, Executor E>
LatticeVisibility<Integer> fit_lattice_visibility(const ClusteredSamples& samples, LightLattice lattice,
                                                  std::span<const vec3> lights, const O& occluder,
                                                  const E& executor, const DecisionOptions& options) {
  LatticeVisibility<Integer> result{std::move(lattice), options.rank, samples.ends, {}};
  const std::span<const vec3> positions = lights.empty() ? result.lattice.positions : lights;
  const auto training = detail::training_lights(result.lattice, positions, occluder);
  result.clusters.resize(samples.cluster_count());
  executor(samples.cluster_count(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      const auto all = detail::trace_decisions(samples.of(c), training.positions, occluder);
      auto index = detail::feature_index(result.lattice.count(), all, training.corners);
      std::vector<FeatureMix> mixes;
      const auto needed = detail::needed_columns(all, index, training.corners, mixes);
      const auto factors = fit_decisions(needed, mixes, detail::row_count(index), options);
      result.clusters[c] = detail::quantise_factors<Integer>(factors, std::move(index), options.rank);
    }
  });
  return result;
}

}  // namespace coppice::inline HWY_NAMESPACE
