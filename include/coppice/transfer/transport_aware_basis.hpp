// A basis for direct light that drops what the indirect light would not show.
#pragma once

#include <coppice/transfer/light_basis.hpp>
//
#include <coppice/transfer/interreflection.hpp>
#include <numeric>

namespace coppice {

struct TransportProbesOptions {
  std::size_t count = 512;    ///< probes; 0 to 4,096
  std::uint32_t bounces = 3;  ///< of the light between the samples; more hardly turn the basis
  std::uint64_t seed = 0;
};

namespace detail {

/// Random signs over √(all probes): E[ΩΩᵀ] is the identity.
template <Executor E>
Rows random_probes(std::size_t samples, std::size_t begin, std::size_t end,
                   const TransportProbesOptions& options, const E& executor) {
  Rows probes(samples, end - begin);
  const float size = 1 / std::sqrt(float(options.count));
  executor(samples, 256, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i)
      for (std::size_t k = begin; k < end; ++k) {
        const bool positive = (Random(options.seed + i * options.count + k).bits() & 1) != 0;
        probes.values[i * probes.width + k - begin] = positive ? size : -size;
      }
  });
  return probes;
}

/// Row i times factors[i].
template <Executor E>
void scale_rows(std::span<const float> factors, const E& executor, Rows& rows) {
  executor(rows.count(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      for (float& x : rows[i]) x *= factors[i];
  });
}

/// A matrix that is zero above its diagonal, row by row; C = L·Lᵀ.
struct Triangle {
  Rows rows;

  std::size_t size() const { return rows.count(); }
  std::span<const float> operator[](std::size_t i) const { return rows[i].first(i + 1); }
};

}  // namespace detail

}  // namespace coppice

namespace coppice::detail::inline HWY_NAMESPACE {

/// A row a sample: the lights there, times the square root of their weights' shares.
inline Rows weighted_columns(const Rows& lights, std::span<const float> weights) {
  Rows columns(lights.width, lights.count());
  const float share = 1 / float(lights.count());
  for (std::size_t l = 0; l < lights.count(); ++l)
    for (std::size_t i = 0; i < lights.width; ++i)
      columns[i][l] = lights[l][i] * std::sqrt(weights[l] * share);
  return columns;
}

/// Second moments of the columns of the lights, weighted, below the diagonal; ridge · their mean is added to
/// the diagonal.
inline Rows light_moments(const Rows& lights, std::span<const float> weights, double ridge) {
  const Rows columns = weighted_columns(lights, weights);
  Rows moments(lights.width, lights.width);
  double trace = 0;
  for (std::size_t i = 0; i < lights.width; ++i) {
    for (std::size_t j = 0; j <= i; ++j) moments[i][j] = dot(columns[i], columns[j]);
    trace += double(moments[i][i]);
  }
  for (std::size_t i = 0; i < lights.width; ++i) moments[i][i] += float(ridge * trace / double(lights.width));
  return moments;
}

/// L of the Cholesky factorisation, in float: the basis needs some L with L·Lᵀ near C, not an exact one.
/// Pivots below 1e-6 of the mean diagonal are raised to it.
inline Triangle factorised(Rows moments) {
  double trace = 0;
  for (std::size_t i = 0; i < moments.count(); ++i) trace += double(moments[i][i]);
  const float least = float(1e-6 * trace / double(moments.count()));
  for (std::size_t i = 0; i < moments.count(); ++i) {
    const std::span<float> row = moments[i];
    const std::span<const float> done = row;
    for (std::size_t j = 0; j < i; ++j) {
      const std::span<const float> other = moments[j];
      row[j] = (row[j] - dot(done.first(j), other.first(j))) / other[j];
    }
    row[i] = std::sqrt(std::max(row[i] - dot(done.first(i), done.first(i)), least));
  }
  return {std::move(moments)};
}

/// Lᵀ·Y: row k is that of probe k; responses hold a row a sample.
inline Rows seen_through(const Triangle& factor, const Rows& responses, std::size_t begin) {
  Rows result(responses.width, factor.size());
  for (std::size_t k = 0; k < responses.width; ++k)
    for (std::size_t i = 0; i < factor.size(); ++i)
      add_scaled(responses.values[(begin + i) * responses.width + k], factor[i], result[k].first(i + 1));
  return result;
}

/// The vector w of white light as emission, L·w.
inline void emit(const Triangle& factor, std::span<const float> w, std::span<float> out) {
  for (std::size_t i = 0; i < factor.size(); ++i) out[i] = dot(factor[i], w.first(i + 1));
}

/// And as projection, L⁻ᵀ·w.
inline void solve_transposed(const Triangle& factor, std::span<const float> w, std::span<float> out) {
  std::copy(w.begin(), w.end(), out.begin());
  for (std::size_t i = factor.size(); i-- > 0;) {
    const float x = out[i] / factor[i][i];
    add_scaled(-x, factor[i].first(i), out.first(i));
    out[i] = x;
  }
}

/// Up to `rank` vectors of one cluster, whose first sample is `begin`.
inline ClusterLightBasis transport_aware_cluster(const Rows& lights, const Rows& responses, std::size_t begin,
                                                 std::size_t rank, const LightBasisOptions& options) {
  ClusterLightBasis basis{Rows(0, 0), Rows(0, 0), std::vector<float>(lights.width, 0.0f), {}};
  basis.projection.width = basis.emission.width = lights.width;
  const std::vector<float> weights = example_weights(lights, options.scale_rows);
  if (std::ranges::all_of(lights.values, [](float x) { return x == 0; })) return basis;
  const Triangle factor = factorised(light_moments(lights, weights, options.ridge));
  PcaBasis white = pca(seen_through(factor, responses, begin), {.centred = false, .rank = rank});
  basis.projection = basis.emission = Rows(white.rank(), lights.width);
  for (std::size_t j = 0; j < white.rank(); ++j) {
    emit(factor, white.vectors[j], basis.emission[j]);
    solve_transposed(factor, white.vectors[j], basis.projection[j]);
  }
  basis.energies = std::move(white.energies);
  return basis;
}

}  // namespace coppice::detail::inline HWY_NAMESPACE

namespace coppice {

namespace detail {

/// Keeps `total` vectors: those of the greatest energy over all clusters.
inline void keep_greatest(std::vector<ClusterLightBasis>& clusters, std::size_t total) {
  std::vector<std::pair<double, std::size_t>> all;
  for (std::size_t c = 0; c < clusters.size(); ++c)
    for (const double energy : clusters[c].energies) all.emplace_back(-energy, c);
  std::ranges::stable_sort(all);
  std::vector<std::size_t> ranks(clusters.size(), 0);
  for (std::size_t k = 0; k < std::min(total, all.size()); ++k) ++ranks[all[k].second];
  for (std::size_t c = 0; c < clusters.size(); ++c) {
    clusters[c].energies.resize(ranks[c]);
    clusters[c].projection.values.resize(ranks[c] * clusters[c].projection.width);
    clusters[c].emission.values.resize(ranks[c] * clusters[c].emission.width);
  }
}

}  // namespace detail

}  // namespace coppice

namespace coppice::inline HWY_NAMESPACE {

/// SᵀΩ for random probes Ω, a row a sample, so that SᵀS is about the product of the result with its
/// transpose: what light at each sample causes elsewhere, in luminance. Probes see all receivers and all
/// emitters at once, where S itself is a dense matrix of all samples. A draft of T will do. The same for any
/// executor. Cost: a pass over Tᵀ a bounce and 64 probes.
template <Executor E>
Rows transport_probes(const Transport& transport, std::span<const vec3> albedos, const E& executor,
                      const TransportProbesOptions& options = {}) {
  COPPICE_ASSERT(albedos.size() == transport.size());
  std::vector<float> grey;
  for (const vec3& albedo : albedos) grey.push_back(luminance(albedo));
  const Transport adjoint = transposed(transport);
  Rows responses(transport.size(), options.count), received;
  for (std::size_t begin = 0; begin < options.count; begin += 64) {
    const std::size_t end = std::min(begin + 64, options.count);
    Rows sent = detail::random_probes(transport.size(), begin, end, options, executor);
    for (std::uint32_t bounce = 0; bounce < options.bounces; ++bounce) {
      apply(adjoint, sent, executor, received);
      detail::scale_rows(grey, executor, received);
      for (std::size_t i = 0; i < transport.size(); ++i)
        for (std::size_t k = begin; k < end; ++k)
          responses.values[i * options.count + k] += received.values[i * received.width + k - begin];
      std::swap(sent, received);
    }
  }
  return responses;
}

/// LightBasisKind::transport_aware (not in the paper). Light on a cluster is taken as x = L·z with z white
/// and L·Lᵀ = C = the examples' second moments + λI. The best rank-r approximation of S·L is by the leading
/// eigenvectors W of LᵀSᵀS·L, so x is projected with WᵀL⁻¹ and emitted as L·W: no other r numbers a cluster
/// lose less of the indirect light of such lights, in the mean square. Coefficients have about unit variance.
/// SᵀS is taken from `responses` = transport_probes(). The rank is 0 where no example reaches a cluster or
/// nothing comes back. The same for any executor. Cost: lights · n² + n³/3 + probes · n² operations for a
/// cluster of n. Throws InputError where an example is not finite.
template <Executor E>
LightBasis transport_aware_basis(const ClusteredSamples& samples, const Rows& examples, const Rows& responses,
                                 const E& executor, const LightBasisOptions& options = {}) {
  COPPICE_ASSERT(examples.width == samples.size() || examples.count() == 0);
  COPPICE_ASSERT(responses.values.size() == samples.size() * responses.width);
  COPPICE_ASSERT(options.ridge > 0);
  detail::refuse_unless_finite(examples);
  const std::size_t rank = options.share_ranks ? 3 * options.rank : options.rank;
  LightBasis basis{LightBasisKind::transport_aware, std::vector<ClusterLightBasis>(samples.cluster_count())};
  executor(samples.cluster_count(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      Rows lights = detail::columns_of(examples, samples.begin(c), samples.end(c));
      if (examples.count() == 0) lights = Rows(1, samples.size(c));
      basis.clusters[c] = detail::transport_aware_cluster(lights, responses, samples.begin(c), rank, options);
    }
  });
  if (options.share_ranks) detail::keep_greatest(basis.clusters, options.rank * samples.cluster_count());
  return basis;
}

}  // namespace coppice::inline HWY_NAMESPACE
