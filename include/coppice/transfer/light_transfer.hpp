// From direct to indirect light by stored bases: projection, a small matrix, expansion.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <coppice/core/math.hpp>
#include <coppice/core/parallel.hpp>
#include <coppice/pca/square_law_rows.hpp>
#include <coppice/transfer/clustered_samples.hpp>
#include <span>
#include <vector>

namespace coppice {

/// Rounded fields over the samples of clusters. Cluster c has the fields [begin(c), ends[c]), each as long as
/// it has samples; field f is scales[f] · values from first[f] on.
template <QuantisedEntry Value>
struct ClusterFields {
  std::vector<std::uint32_t> ends;   ///< a cluster: its fields end before this index; ascending
  std::vector<std::uint32_t> first;  ///< a field: where its values start, and one more: where all end
  std::vector<Value> values;
  std::vector<float> scales;  ///< a field

  std::size_t count() const { return scales.size(); }
  std::size_t begin(std::size_t cluster) const { return cluster == 0 ? 0 : ends[cluster - 1]; }
  std::size_t end(std::size_t cluster) const { return ends[cluster]; }
  std::span<const Value> operator[](std::size_t field) const {
    return std::span(values).subspan(first[field], first[field + 1] - first[field]);
  }
  std::size_t bytes() const {
    return values.size() * sizeof(Value) + scales.size() * sizeof(float) +
           (ends.size() + first.size()) * sizeof(std::uint32_t);
  }
};

/// Rounds a cluster's fields, its rows, and appends them as the next cluster's.
template <QuantisedEntry Value>
void append_cluster(const Rows& fields, ClusterFields<Value>& to) {
  const QuantisedRows<Value> rounded = quantise<Value>(fields);
  if (to.first.empty()) to.first.push_back(0);
  for (std::size_t j = 0; j < rounded.count(); ++j)
    to.first.push_back(std::uint32_t(to.first.back() + rounded.width));
  to.values.insert(to.values.end(), rounded.values.begin(), rounded.values.end());
  to.scales.insert(to.scales.end(), rounded.scales.begin(), rounded.scales.end());
  to.ends.push_back(std::uint32_t(to.count()));
}

/// The indirect light of a static scene, as a function of the direct light at its samples (PCA Eq. 10): each
/// cluster's direct light becomes some coefficients, those of all clusters, by a matrix a channel, the
/// weights of some patterns on each cluster, and the patterns' sum is the indirect irradiance there. All of
/// it is rounded to 8 or 16 bits.
template <QuantisedEntry Value>
struct LightTransfer {
  ClusterFields<Value> projection;  ///< a field a coefficient
  ClusterFields<Value> patterns;    ///< of indirect irradiance
  /// A channel: a row a pattern, a column a coefficient; where the basis is centred, a last column for S·μ.
  SquareLawRows<Value> mix[3];
  std::vector<float> offsets;  ///< a coefficient: that of the examples' mean μ; empty: not centred
  std::vector<std::uint32_t> sample_ends;  ///< a cluster, as ClusteredSamples::ends

  std::size_t sample_count() const { return sample_ends.empty() ? 0 : sample_ends.back(); }
  std::size_t pattern_count() const { return patterns.count(); }
  /// A channel: those of the clusters one after the other, and a last one where S·μ counts.
  std::size_t coefficient_count() const { return mix[0].width; }
  std::size_t bytes() const {
    return projection.bytes() + patterns.bytes() + mix[0].bytes() + mix[1].bytes() + mix[2].bytes() +
           offsets.size() * sizeof(float) + sample_ends.size() * sizeof(std::uint32_t);
  }
};

}  // namespace coppice

namespace coppice::detail::inline HWY_NAMESPACE {

/// Σ values[i] · x[i].
template <QuantisedEntry Value>
float dot_integers(std::span<const Value> values, const float* x) {
  Lanes sums[4] = {0.0f, 0.0f, 0.0f, 0.0f};
  std::size_t i = 0;
  for (; i + 4 * Lanes::width <= values.size(); i += 4 * Lanes::width)
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t at = i + k * Lanes::width;
      sums[k] = mul_add(load_integers(&values[at]), Lanes::load(x + at), sums[k]);
    }
  float sum = sum_of_lanes((sums[0] + sums[1]) + (sums[2] + sums[3]));
  for (; i < values.size(); ++i) sum += float(values[i]) * x[i];
  return sum;
}

/// x[i] += factor · values[i].
template <QuantisedEntry Value>
void add_integers(float factor, std::span<const Value> values, float* x) {
  std::size_t i = 0;
  for (; i + Lanes::width <= values.size(); i += Lanes::width)
    mul_add(factor, load_integers(&values[i]), Lanes::load(x + i)).store(x + i);
  for (; i < values.size(); ++i) x[i] += factor * float(values[i]);
}

/// Coefficients of one channel of a cluster's light.
template <QuantisedEntry Value>
void project_cluster(const LightTransfer<Value>& transfer, std::size_t cluster, const float* light,
                     float intensity, std::span<float> coefficients) {
  const auto& fields = transfer.projection;
  for (std::size_t j = fields.begin(cluster); j < fields.end(cluster); ++j) {
    coefficients[j] = fields.scales[j] * dot_integers(fields[j], light);
    if (!transfer.offsets.empty()) coefficients[j] -= intensity * transfer.offsets[j];
  }
}

/// One channel of a cluster's indirect light.
template <QuantisedEntry Value>
void expand_cluster(const LightTransfer<Value>& transfer, std::size_t cluster, std::span<const float> weights,
                    std::span<float> light) {
  const auto& fields = transfer.patterns;
  std::ranges::fill(light, 0.0f);
  for (std::size_t j = fields.begin(cluster); j < fields.end(cluster); ++j)
    add_integers(fields.scales[j] * weights[j], fields[j], light.data());
}

inline std::size_t first_sample(std::span<const std::uint32_t> ends, std::size_t cluster) {
  return cluster == 0 ? 0 : ends[cluster - 1];
}

}  // namespace coppice::detail::inline HWY_NAMESPACE

namespace coppice::inline HWY_NAMESPACE {

/// First stage: coefficients of the direct irradiance at all samples, red ones, then green, then blue.
/// `intensity` is the sum of the lights' intensities, over that of the examples (1 W/sr): centred bases alone
/// need it, in which the light is their mean times it and a rest; it is not seen otherwise. The same for any
/// executor. Preconditions: as many values as samples; room for 3 · coefficient_count().
template <QuantisedEntry Value, Executor E>
void project(const LightTransfer<Value>& transfer, std::span<const vec3> direct, const E& executor,
             std::span<float> coefficients, const vec3& intensity = vec3(1)) {
  const std::size_t count = transfer.coefficient_count();
  COPPICE_ASSERT(direct.size() == transfer.sample_count() && coefficients.size() == 3 * count);
  executor(transfer.sample_ends.size(), 1, [&](std::size_t begin, std::size_t end) {
    std::vector<float> light;
    for (std::size_t c = begin; c < end; ++c) {
      const std::size_t first = detail::first_sample(transfer.sample_ends, c);
      light.resize(transfer.sample_ends[c] - first);
      for (int channel = 0; channel < 3; ++channel) {
        for (std::size_t i = 0; i < light.size(); ++i) light[i] = direct[first + i][channel];
        detail::project_cluster(transfer, c, light.data(), intensity[channel],
                                coefficients.subspan(std::size_t(channel) * count, count));
      }
    }
  });
  if (count > transfer.projection.count())
    for (int channel = 0; channel < 3; ++channel)
      coefficients[std::size_t(channel + 1) * count - 1] = intensity[channel];
}

/// The same for a grey light, then tinted by its colour: a third of the work. `direct` is what the light
/// brings at intensity 1. Exact for one light, or several of one colour.
template <QuantisedEntry Value, Executor E>
void project_grey(const LightTransfer<Value>& transfer, std::span<const float> direct, const vec3& colour,
                  const E& executor, std::span<float> coefficients) {
  const std::size_t count = transfer.coefficient_count();
  COPPICE_ASSERT(direct.size() == transfer.sample_count() && coefficients.size() == 3 * count);
  const std::span<float> grey = coefficients.first(count);
  executor(transfer.sample_ends.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c)
      detail::project_cluster(transfer, c, &direct[detail::first_sample(transfer.sample_ends, c)], 1, grey);
  });
  if (count > transfer.projection.count()) grey.back() = 1;
  for (std::size_t j = 0; j < count; ++j) {
    const vec3 tinted = grey[j] * colour;
    for (std::size_t channel = 3; channel-- > 0;) coefficients[channel * count + j] = tinted[int(channel)];
  }
}

/// Second stage: the patterns' weights, red ones, then green, then blue. Precondition: room for
/// 3 · pattern_count().
template <QuantisedEntry Value, Executor E>
void mix(const LightTransfer<Value>& transfer, std::span<const float> coefficients, const E& executor,
         std::span<float> weights) {
  const std::size_t count = transfer.pattern_count(), from = transfer.coefficient_count();
  COPPICE_ASSERT(coefficients.size() == 3 * from && weights.size() == 3 * count);
  executor(3 * count, 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k)
      weights[k] = dot(transfer.mix[k / count], k % count, coefficients.subspan(k / count * from, from));
  });
}

/// Third stage: the indirect irradiance (W/m²) at all samples. May be slightly below 0 where it is dark.
template <QuantisedEntry Value, Executor E>
void expand(const LightTransfer<Value>& transfer, std::span<const float> weights, const E& executor,
            std::span<vec3> indirect) {
  const std::size_t count = transfer.pattern_count();
  COPPICE_ASSERT(indirect.size() == transfer.sample_count() && weights.size() == 3 * count);
  executor(transfer.sample_ends.size(), 1, [&](std::size_t begin, std::size_t end) {
    std::vector<float> light;
    for (std::size_t c = begin; c < end; ++c) {
      const std::size_t first = detail::first_sample(transfer.sample_ends, c);
      light.resize(transfer.sample_ends[c] - first);
      for (int channel = 0; channel < 3; ++channel) {
        detail::expand_cluster(transfer, c, weights.subspan(std::size_t(channel) * count, count), light);
        for (std::size_t i = 0; i < light.size(); ++i) indirect[first + i][channel] = light[i];
      }
    }
  });
}

/// All three stages (PCA section 5): the indirect irradiance that direct irradiance causes, both at all
/// samples.
template <QuantisedEntry Value, Executor E>
void indirect_irradiance(const LightTransfer<Value>& transfer, std::span<const vec3> direct,
                         const E& executor, std::span<vec3> indirect, const vec3& intensity = vec3(1)) {
  std::vector<float> coefficients(3 * transfer.coefficient_count()), weights(3 * transfer.pattern_count());
  project(transfer, direct, executor, coefficients, intensity);
  mix(transfer, coefficients, executor, weights);
  expand(transfer, weights, executor, indirect);
}

}  // namespace coppice::inline HWY_NAMESPACE
