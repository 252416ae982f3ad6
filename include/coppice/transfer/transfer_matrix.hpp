// The transfer matrix of a basis, solved, and compressed to patterns on the receivers.
#pragma once

#include <coppice/transfer/light_basis.hpp>
#include <coppice/transfer/light_transfer.hpp>
//
#include <coppice/transfer/interreflection.hpp>

namespace coppice {

struct TransferMatrixOptions {
  InterreflectionOptions bounces = {.bounces = 6};
  std::size_t batch = 16;  ///< vectors solved at once, >= 1; memory beside the result: 36 · batch a sample
  /// Of a centred basis: S·μ too, without which most of the light is lost. PCA Eq. 10 has it not.
  bool mean = true;
};

namespace detail {

/// A field of light of a basis: where it starts, and what it is.
struct SentField {
  std::size_t begin = 0;
  std::span<const float> values;
};

/// The emissions of all clusters, and, where wanted, the mean of all.
inline std::vector<std::vector<SentField>> sent_fields(const ClusteredSamples& samples,
                                                       const LightBasis& basis, bool mean) {
  std::vector<std::vector<SentField>> fields;
  for (std::size_t c = 0; c < basis.clusters.size(); ++c)
    for (std::size_t j = 0; j < basis.clusters[c].rank(); ++j)
      fields.push_back({{samples.begin(c), basis.clusters[c].emission[j]}});
  if (!basis.centred() || !mean) return fields;
  std::vector<SentField>& all = fields.emplace_back();
  for (std::size_t c = 0; c < basis.clusters.size(); ++c)
    all.push_back({samples.begin(c), basis.clusters[c].mean});
  return fields;
}

/// Some fields as white light: element (i, 3v + channel).
inline Rows as_white_light(std::span<const std::vector<SentField>> fields, std::size_t samples) {
  Rows light(samples, 3 * fields.size());
  for (std::size_t v = 0; v < fields.size(); ++v)
    for (const SentField& part : fields[v])
      for (std::size_t i = 0; i < part.values.size(); ++i)
        for (std::size_t channel = 0; channel < 3; ++channel)
          light[part.begin + i][3 * v + channel] = part.values[i];
  return light;
}

}  // namespace detail

}  // namespace coppice

namespace coppice::inline HWY_NAMESPACE {

/// Ŝ, the indirect irradiance that the vectors of a basis cause (PCA section 4.3.2, by a solver in place of
/// photons): element (i, 3j + channel) is that at sample i of coefficient j's emission in white. Coefficients
/// are those of the clusters in turn, and last, where the basis is centred, S·μ. The same for any executor.
/// Bytes: 12 a sample and coefficient. Cost: three channels of each through interreflect().
template <Executor E>
Rows transfer_matrix(const Transport& transport, const ClusteredSamples& samples, const LightBasis& basis,
                     const E& executor, const TransferMatrixOptions& options = {}) {
  COPPICE_ASSERT(transport.size() == samples.size() && basis.clusters.size() == samples.cluster_count());
  const auto fields = detail::sent_fields(samples, basis, options.mean);
  const std::vector<vec3> albedos = albedos_of(samples.samples);
  Rows matrix(samples.size(), 3 * fields.size());
  for (std::size_t begin = 0; begin < fields.size(); begin += options.batch) {
    const auto batch = std::span(fields).subspan(begin, std::min(options.batch, fields.size() - begin));
    const Rows sent = detail::as_white_light(batch, samples.size());
    const Rows received = interreflect(transport, albedos, sent, executor, options.bounces);
    for (std::size_t i = 0; i < samples.size(); ++i)
      std::ranges::copy(received[i], matrix[i].begin() + std::ptrdiff_t(3 * begin));
  }
  return matrix;
}

}  // namespace coppice::inline HWY_NAMESPACE

namespace coppice {

/// What coefficient j makes all samples receive, in white light (the lit scenes of PCA Fig. 3).
inline std::vector<vec3> response_field(const Rows& matrix, std::size_t j) {
  std::vector<vec3> field;
  for (std::size_t i = 0; i < matrix.count(); ++i)
    field.emplace_back(matrix[i][3 * j], matrix[i][3 * j + 1], matrix[i][3 * j + 2]);
  return field;
}

struct CompressionOptions {
  std::size_t rank = 20;        ///< patterns a receiver cluster; for share_ranks the mean of the clusters
  bool share_ranks = true;      ///< clusters share all patterns so that the greatest losses are least
  std::size_t examples = 1000;  ///< at most so many lights tell how large coefficients are; >= 1
};

}  // namespace coppice

namespace coppice::detail::inline HWY_NAMESPACE {

/// The coefficients of a light at intensity 1.
inline std::vector<float> coefficients_of(const ClusteredSamples& samples, const LightBasis& basis,
                                          std::span<const float> light) {
  std::vector<float> coefficients, part;
  for (std::size_t c = 0; c < samples.cluster_count(); ++c) {
    const ClusterLightBasis& cluster = basis.clusters[c];
    part.assign(light.begin() + std::ptrdiff_t(samples.begin(c)),
                light.begin() + std::ptrdiff_t(samples.end(c)));
    add_scaled(-1, cluster.mean, part);
    for (std::size_t j = 0; j < cluster.rank(); ++j)
      coefficients.push_back(dot(cluster.projection[j], std::span<const float>(part)));
  }
  return coefficients;
}

/// Root mean square of each of `width` coefficients over at most so many of the examples, scaled by 1/√norm.
template <Executor E>
std::vector<float> usual_sizes(const ClusteredSamples& samples, const LightBasis& basis, const Rows& examples,
                               std::size_t most, std::size_t width, const E& executor) {
  const std::size_t count = std::min(most, examples.count());
  Rows squares(count, width);
  executor(count, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t l = begin; l < end; ++l) {
      const std::span<const float> light = examples[l * examples.count() / count];
      std::vector<float> values = coefficients_of(samples, basis, light);
      values.resize(width, 1.0f);
      const float norm = std::sqrt(dot(light, light));
      for (std::size_t j = 0; j < width; ++j) squares[l][j] = norm > 0 ? values[j] * values[j] / norm : 0;
    }
  });
  std::vector<double> sums(width, 0.0);
  for (std::size_t l = 0; l < count; ++l)
    for (std::size_t j = 0; j < width; ++j) sums[j] += double(squares[l][j]);
  std::vector<float> sizes;
  for (const double sum : sums)
    sizes.push_back(float(std::sqrt(sum / double(std::max<std::size_t>(count, 1)))));
  return sizes;
}

/// The patterns of a receiver cluster: principal components of what each coefficient, at its usual size,
/// makes it receive, all colours alike.
inline PcaBasis receiver_patterns(const Rows& matrix, std::size_t begin, std::size_t end,
                                  std::span<const float> sizes, std::size_t rank) {
  Rows received(matrix.width, end - begin);
  for (std::size_t i = begin; i < end; ++i)
    for (std::size_t j = 0; j < matrix.width; ++j) received[j][i - begin] = sizes[j / 3] * matrix[i][j];
  PcaBasis basis = pca(received, {.centred = false, .rank = rank});
  basis.vectors.width = end - begin;
  return basis;
}

/// How many of each cluster's energies are among the `total` greatest.
inline std::vector<std::size_t> shared_ranks(std::span<const PcaBasis> bases, std::size_t total) {
  std::vector<std::pair<double, std::size_t>> all;
  for (std::size_t c = 0; c < bases.size(); ++c)
    for (const double energy : bases[c].energies) all.emplace_back(-energy, c);
  std::ranges::stable_sort(all);
  std::vector<std::size_t> ranks(bases.size(), 0);
  for (std::size_t k = 0; k < std::min(total, all.size()); ++k) ++ranks[all[k].second];
  return ranks;
}

/// The patterns of all clusters.
template <Executor E>
std::vector<Rows> find_patterns(const ClusteredSamples& samples, const Rows& matrix,
                                std::span<const float> sizes, const CompressionOptions& options,
                                const E& executor) {
  std::vector<PcaBasis> bases(samples.cluster_count());
  const std::size_t rank = options.share_ranks ? 3 * options.rank : options.rank;
  executor(bases.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c)
      if (!sizes.empty()) bases[c] = receiver_patterns(matrix, samples.begin(c), samples.end(c), sizes, rank);
  });
  const std::vector<std::size_t> ranks = shared_ranks(
      bases, options.share_ranks ? options.rank * bases.size() : std::numeric_limits<std::size_t>::max());
  std::vector<Rows> patterns;
  for (std::size_t c = 0; c < bases.size(); ++c) {
    patterns.push_back(std::move(bases[c].vectors));
    patterns[c].width = samples.size(c);
    patterns[c].values.resize(ranks[c] * patterns[c].width);
  }
  return patterns;
}

/// The rows of the matrix that a cluster receives by, seen through its patterns: rows[channel] has a row a
/// pattern.
inline void mix_rows(const Rows& matrix, std::size_t begin, const Rows& patterns, std::size_t at,
                     Rows (&rows)[3]) {
  std::vector<float> sum(matrix.width);
  for (std::size_t k = 0; k < patterns.count(); ++k) {
    std::ranges::fill(sum, 0.0f);
    for (std::size_t i = 0; i < patterns.width; ++i) add_scaled(patterns[k][i], matrix[begin + i], sum);
    for (std::size_t j = 0; j < matrix.width; ++j) rows[j % 3][at + k][j / 3] = sum[j];
  }
}

}  // namespace coppice::detail::inline HWY_NAMESPACE

namespace coppice::inline HWY_NAMESPACE {

/// The transfer as it is stored and used: on each receiver cluster the matrix's rows lie near a space of few
/// patterns, which all colours share. Patterns are the principal components, uncentred, of the matrix'
/// columns there, each times the usual size of its coefficient over the examples; they are orthonormal, so
/// the mixing rows are the patterns' products with the matrix. `examples` as for the basis. The rank is less
/// where the matrix has no more. The same for any executor. Cost: samples · n · 3 · coefficients operations
/// for clusters of n.
template <QuantisedEntry Value, Executor E>
LightTransfer<Value> compress_transfer(const ClusteredSamples& samples, const LightBasis& basis,
                                       const Rows& matrix, const Rows& examples, const E& executor,
                                       const CompressionOptions& options = {}) {
  const std::size_t clusters = samples.cluster_count(), width = matrix.width / 3;
  COPPICE_ASSERT(matrix.values.size() == samples.size() * matrix.width);
  COPPICE_ASSERT(examples.width == samples.size() || examples.count() == 0);
  const std::vector<float> sizes =
      detail::usual_sizes(samples, basis, examples, options.examples, width, executor);
  const std::vector<Rows> patterns = detail::find_patterns(samples, matrix, sizes, options, executor);
  LightTransfer<Value> transfer;
  transfer.sample_ends = samples.ends;
  for (std::size_t c = 0; c < clusters; ++c) {
    append_cluster(patterns[c], transfer.patterns);
    append_cluster(basis.clusters[c].projection, transfer.projection);
  }
  Rows rows[3] = {Rows(transfer.patterns.count(), width), Rows(transfer.patterns.count(), width),
                  Rows(transfer.patterns.count(), width)};
  executor(clusters, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c)
      detail::mix_rows(matrix, samples.begin(c), patterns[c], transfer.patterns.begin(c), rows);
  });
  for (std::size_t channel = 0; channel < 3; ++channel) {
    transfer.mix[channel] = quantise_by_squares<Value>(rows[channel]);
    transfer.mix[channel].width = width;
  }
  if (basis.centred())
    for (std::size_t c = 0; c < clusters; ++c)
      for (std::size_t j = transfer.projection.begin(c); j < transfer.projection.end(c); ++j)
        transfer.offsets.push_back(
            transfer.projection.scales[j] *
            detail::dot_integers(transfer.projection[j], basis.clusters[c].mean.data()));
  return transfer;
}

}  // namespace coppice::inline HWY_NAMESPACE
