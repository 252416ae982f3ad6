// Visibility of lights anywhere in free space, from a lattice of light positions.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <bit>
#include <coppice/core/parallel.hpp>
#include <coppice/transfer/integer_lanes.hpp>
#include <coppice/transfer/light_lattice.hpp>
#include <coppice/transfer/sized_light.hpp>

namespace coppice {

/// Which of a cluster's feature rows belongs to a lattice point: the first to points that no sample of the
/// cluster sees, one each to the others, in the order of points.
struct FeatureIndex {
  std::vector<std::uint32_t> bits;    ///< bit p % 32 of word p / 32: lattice point p has a row of its own
  std::vector<std::uint32_t> before;  ///< rows of the points before a word's first

  std::uint32_t row(std::uint32_t point) const {
    const std::uint32_t word = bits[point / 32], bit = 1u << (point % 32);
    return (word & bit) == 0 ? 0 : 1 + before[point / 32] + std::uint32_t(std::popcount(word & (bit - 1)));
  }
};

/// How the visibility of a light is decided.
enum class LatticeShadow {
  hard,    ///< 0 or 1 by the sign, and a sized light's the mean over its points
  smooth,  ///< ½ + ½ value, clamped, of features averaged over the light's points: one product a sample
};

/// A cluster's part: margin(i, light) = Σ_k scales[k] · coefficient(i, k) · Σ weights · row(point)[k], above
/// zero where the light is seen. What the samples' horizon hides has no meaning. Integer: int8_t or int16_t.
template <class Integer>
struct LatticeCluster {
  FeatureIndex index;
  std::vector<float> scales;          ///< by component
  std::vector<Integer> coefficients;  ///< component k of sample i at k · samples + i
  std::vector<Integer> rows;          ///< component k of feature row r at r · rank + k
};

/// Visibility by cluster. The lattice serves lights in the free space that it was made for.
template <class Integer = std::int8_t>
struct LatticeVisibility {
  LightLattice lattice;
  std::size_t rank = 0;
  std::vector<std::uint32_t> ends;  ///< of the clusters' samples, as ClusteredSamples::ends
  std::vector<LatticeCluster<Integer>> clusters;

  std::size_t size() const { return ends.empty() ? 0 : ends.back(); }
  std::size_t begin(std::size_t cluster) const { return cluster == 0 ? 0 : ends[cluster - 1]; }
  /// Of coefficients, rows, scales and indices; the lattice itself is left out.
  std::size_t bytes() const {
    std::size_t sum = 0;
    for (const auto& c : clusters)
      sum += (c.coefficients.size() + c.rows.size()) * sizeof(Integer) +
             4 * (c.scales.size() + c.index.bits.size() + c.index.before.size());
    return sum;
  }
};

}  // namespace coppice

namespace coppice::detail::inline HWY_NAMESPACE {

/// features[k] += share · scales[k] · Σ weights · row(point)[k].
template <class Integer>
void add_features(const LatticeCluster<Integer>& cluster, const LatticeCorners& corners, float share,
                  std::span<float> features) {
  const std::size_t rank = features.size();
  for (std::uint32_t c = 0; c < corners.count; ++c) {
    const Integer* row = cluster.rows.data() + cluster.index.row(corners.points[c]) * rank;
    const float weight = share * corners.weights[c];
    for (std::size_t k = 0; k < rank; ++k) features[k] += weight * cluster.scales[k] * float(row[k]);
  }
}

/// Calls store(i, margins of the lanes from sample i on, how many of them count) for all samples.
template <class Integer, class Store>
void for_margins(const LatticeCluster<Integer>& cluster, std::span<const float> features, std::size_t samples,
                 Store&& store) {
  const Integer* q = cluster.coefficients.data();
  const std::size_t rank = features.size(), whole = samples / Lanes::width * Lanes::width;
  for (std::size_t i = 0; i < whole; i += Lanes::width) {
    Lanes sum(0.0f);
    for (std::size_t k = 0; k < rank; ++k)
      sum = mul_add(load_integers(q + k * samples + i), Lanes(features[k]), sum);
    store(i, sum, Lanes::width);
  }
  if (whole == samples) return;
  float rest[Lanes::width] = {};
  for (std::size_t i = whole; i < samples; ++i)
    for (std::size_t k = 0; k < rank; ++k) rest[i - whole] += float(q[k * samples + i]) * features[k];
  store(whole, Lanes::load(rest), samples - whole);
}

/// out[i] += share · value(margin) for all samples of a cluster.
template <class Integer, class Value>
void add_visibility(const LatticeCluster<Integer>& cluster, std::span<const float> features,
                    std::span<float> out, float share, Value&& value) {
  for_margins(cluster, features, out.size(), [&](std::size_t i, Lanes margin, std::size_t count) {
    float values[Lanes::width] = {};
    (Lanes(share) * value(margin)).store(values);
    if (count == Lanes::width) {
      (Lanes::load(out.data() + i) + Lanes::load(values)).store(out.data() + i);
      return;
    }
    for (std::size_t j = 0; j < count; ++j) out[i + j] += values[j];
  });
}

inline Lanes hard_decision(Lanes margin) { return select(margin > Lanes(0.0f), Lanes(1.0f), Lanes(0.0f)); }
inline Lanes smooth_decision(Lanes margin) {
  return min(max(mul_add(Lanes(0.5f), margin, Lanes(0.5f)), Lanes(0.0f)), Lanes(1.0f));
}

/// A cluster's visibility from a light's points; those without corners count as hidden.
template <class Integer>
void cluster_visibility(const LatticeCluster<Integer>& cluster, std::span<const LatticeCorners> points,
                        LatticeShadow shadow, std::span<float> features, std::span<float> out) {
  const float share = 1 / float(points.size());
  std::fill(out.begin(), out.end(), 0.0f);
  std::fill(features.begin(), features.end(), 0.0f);
  float known = 0;
  for (const LatticeCorners& corners : points) {
    if (corners.count == 0) continue;
    if (shadow == LatticeShadow::smooth) {
      add_features(cluster, corners, 1, features), known += 1;
      continue;
    }
    std::fill(features.begin(), features.end(), 0.0f);
    add_features(cluster, corners, 1, features);
    add_visibility(cluster, features, out, share, hard_decision);
  }
  if (shadow != LatticeShadow::smooth || known == 0) return;
  for (float& f : features) f /= known;
  add_visibility(cluster, features, out, known * share, smooth_decision);
}

}  // namespace coppice::detail::inline HWY_NAMESPACE

namespace coppice::inline HWY_NAMESPACE {

/// The visibility, in [0, 1], of a light that stands at `points` (lattice_corners, one for each of its
/// points) at every sample; points that the lattice does not serve count as hidden. out[i] has no meaning
/// where the light is below sample i's horizon. False, and nothing written, where no point is served: the
/// caller then takes shadow rays. The same for any executor. Cost: rank multiply-adds a sample, and for hard
/// shadows and each point. Precondition: out has size() elements.
template <class Integer, Executor E>
bool lattice_visibility(const LatticeVisibility<Integer>& visibility, std::span<const LatticeCorners> points,
                        LatticeShadow shadow, const E& executor, std::span<float> out) {
  COPPICE_ASSERT(out.size() == visibility.size());
  if (std::none_of(points.begin(), points.end(), [](const LatticeCorners& c) { return c.count > 0; }))
    return false;
  executor(visibility.clusters.size(), 4, [&](std::size_t begin, std::size_t end) {
    std::vector<float> features(visibility.rank);
    for (std::size_t c = begin; c < end; ++c)
      detail::cluster_visibility(visibility.clusters[c], points, shadow, features,
                                 out.subspan(visibility.begin(c), visibility.ends[c] - visibility.begin(c)));
  });
  return true;
}

/// The same for a light with a size, as points_of says.
template <class Integer, Occluder O, Executor E>
bool lattice_visibility(const LatticeVisibility<Integer>& visibility, const SizedLight& light,
                        LatticeShadow shadow, const O& occluder, const E& executor, std::span<float> out,
                        std::uint32_t points = 25) {
  std::vector<LatticeCorners> corners;
  for (const LocalLight& point : points_of(light, points))
    corners.push_back(lattice_corners(visibility.lattice, point.position, occluder));
  return lattice_visibility(visibility, corners, shadow, executor, out);
}

}  // namespace coppice::inline HWY_NAMESPACE
