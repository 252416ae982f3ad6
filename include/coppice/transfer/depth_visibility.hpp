// Shadows of lights inside a scene from compressed depth maps (PCA section 4.2).
#pragma once

#include <coppice/core/simd.hpp>
//
#include <coppice/core/parallel.hpp>
#include <coppice/pca/interval_pca.hpp>
#include <coppice/pca/quantised_rows.hpp>
#include <coppice/transfer/depth_maps.hpp>
#include <coppice/transfer/sized_light.hpp>
#include <optional>

namespace coppice {

struct DepthOptions {
  std::uint32_t directions = 2016;  ///< of the dome; twice as many for the sphere are as dense
  Dome dome = Dome::hemisphere;     ///< of each sample, or one sphere in the world's axes for all
  std::size_t rank = 50;            ///< vectors a cluster, at most
  int rounds = 5;                   ///< of interval PCA; 0: plain PCA of the depths, as in the paper
  float limit = 10;                 ///< m: depths are clamped there; from light_reach()
  float margin = 0.1f;              ///< share by which a depth is raised where free space is far behind it
  float bias = 0.05f;               ///< share of its distance that a light counts as nearer; docs/transfer.md
};

namespace detail {

/// The compressed depth maps of one cluster, before quantisation.
struct DepthCluster {
  std::vector<std::uint16_t> rows;  ///< a direction: its row of `basis`, no_row where no sample sees it
  Rows basis;                       ///< a direction: its entry in each vector
  std::vector<float> mean;          ///< by row of `basis`
  Rows coefficients;                ///< a sample: its rank coefficients
  std::size_t rank = 0;
};

inline constexpr std::uint16_t no_row = 0xffff;

/// Directions above the horizon of at least one sample, numbered in their order.
inline std::vector<std::uint16_t> seen_rows(const Rows& depths) {
  std::vector<std::uint16_t> rows(depths.width, no_row);
  for (std::size_t i = 0; i < depths.count(); ++i)
    for (std::size_t k = 0; k < depths.width; ++k)
      if (depths[i][k] != no_depth) rows[k] = 0;
  std::uint16_t next = 0;
  for (std::uint16_t& row : rows)
    if (row != no_row) row = next++;
  return rows;
}

/// The columns that have a row, in their order.
inline Rows seen_columns(const Rows& from, std::span<const std::uint16_t> rows) {
  Rows to(from.count(), rows.size() - std::size_t(std::ranges::count(rows, no_row)));
  for (std::size_t i = 0; i < from.count(); ++i)
    for (std::size_t k = 0; k < rows.size(); ++k)
      if (rows[k] != no_row) to[i][rows[k]] = from[i][k];
  return to;
}

/// Puts the mean of the others of its column in place of each entry without depth. Every column has others.
inline void fill_with_means(Rows& depths) {
  std::vector<double> sums(depths.width, 0), counts(depths.width, 0);
  for (std::size_t i = 0; i < depths.count(); ++i)
    for (std::size_t k = 0; k < depths.width; ++k)
      if (depths[i][k] != no_depth) sums[k] += double(depths[i][k]), counts[k] += 1;
  for (std::size_t i = 0; i < depths.count(); ++i)
    for (std::size_t k = 0; k < depths.width; ++k)
      if (depths[i][k] == no_depth) depths[i][k] = float(sums[k] / counts[k]);
}

/// Moves the near ends of intervals away from the lights before them: by a share of the depth, no farther
/// than to the middle. Entries without depth become -infinity.
inline void raise_depths(Rows& low, const Rows& high, float margin) {
  for (std::size_t i = 0; i < low.values.size(); ++i) {
    float& x = low.values[i];
    x = x == no_depth ? -std::numeric_limits<float>::infinity()
                      : std::min(x + margin * x, 0.5f * x + 0.5f * high.values[i]);
  }
}

/// The basis with a row for each direction, so that a look-up reads one place.
inline void keep_basis(const PcaBasis& basis, DepthCluster& cluster) {
  cluster.rank = basis.rank();
  cluster.mean = basis.mean;
  cluster.basis = Rows(basis.width(), basis.rank());
  for (std::size_t j = 0; j < basis.rank(); ++j)
    for (std::size_t k = 0; k < basis.width(); ++k) cluster.basis[k][j] = basis.vectors[j][k];
}

/// Compresses depth maps (PCA Eq. 7, 8). `ends` are far_ends(), or empty for plain PCA.
inline DepthCluster compress_depths(const Rows& depths, const Rows& ends, const DepthOptions& options) {
  DepthCluster cluster;
  cluster.rows = seen_rows(depths);
  Rows start = seen_columns(depths, cluster.rows), low = start;
  fill_with_means(start);
  const bool intervals = options.rounds > 0 && ends.count() > 0;
  const Rows high = intervals ? seen_columns(ends, cluster.rows) : start;
  if (intervals)
    raise_depths(low, high, options.margin);
  else
    low = start;
  IntervalPca result =
      interval_pca(low, high, {.rank = options.rank, .rounds = intervals ? options.rounds : 0}, start);
  keep_basis(result.basis, cluster);
  cluster.coefficients = std::move(result.coefficients);
  return cluster;
}

}  // namespace detail

}  // namespace coppice

namespace coppice::inline HWY_NAMESPACE {

/// Visibility of point lights and balls at samples, from the depths that each sample sees in about 2,016
/// directions, compressed by PCA within each cluster and quantised to 8 or 16 bits. A light is taken as
/// visible where it is nearer than the depth at the four directions nearest to it: four decisions, each a dot
/// product as long as the rank, and their mean. Serves lights anywhere, also outside the space that the
/// examples came from. It can only decide, not say how near a decision is: errors are in docs/transfer.md.
template <QuantisedEntry Value = std::int8_t>
class DepthVisibility {
 public:
  /// Traces and compresses, cluster by cluster. `cells` tell where lights can stand, for interval PCA;
  /// without them, or with no rounds, plain PCA. Does not copy the samples: they must outlive it. Cost: a ray
  /// a sample and direction, and the PCA of every cluster; 12 bytes a sample and direction of the clusters in
  /// work. Preconditions: options.limit finite and > 0, fewer than 65535 directions.
  template <RayTracer T, Executor E>
  DepthVisibility(const ClusteredSamples& samples, const T& tracer, const FreeCells* cells,
                  const DepthOptions& options, const E& executor)
      : samples_(&samples), options_(options), grid_(options.directions, options.dome) {
    COPPICE_ASSERT(options.limit > 0 && std::isfinite(options.limit) && options.directions < 65535);
    std::vector<detail::DepthCluster> clusters(samples.cluster_count());
    executor(clusters.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t c = begin; c < end; ++c) {
        const Rows depths = trace_depths(samples.of(c), grid_, tracer, options.limit);
        Rows ends;
        if (cells && options.rounds > 0) ends = far_ends(samples.of(c), grid_, depths, *cells, options.limit);
        clusters[c] = detail::compress_depths(depths, ends, options);
      }
    });
    keep(clusters);
  }

  /// out[i]: the share of the light's points above the horizon of sample i that it sees, in [0, 1]; 0 where
  /// all are below. `points`: of points_of(); each takes four decisions. The same for any executor.
  /// Precondition: out has the samples' size.
  template <Executor E>
  void visibility(const SizedLight& light, const E& executor, std::span<float> out,
                  std::uint32_t points = 25) const {
    COPPICE_ASSERT(out.size() == samples_->size());
    const std::vector<LocalLight> parts = points_of(light, points);
    executor(samples_->cluster_count(), 1, [&](std::size_t begin, std::size_t end) {
      std::vector<float> coefficients(padded_rank() + Lanes::width);
      for (std::size_t c = begin; c < end; ++c)
        for (std::size_t i = samples_->begin(c); i < samples_->end(c); ++i)
          out[i] = at_sample(c, i, parts, coefficients);
    });
  }

  const DirectionGrid& grid() const { return grid_; }
  const DepthOptions& options() const { return options_; }
  /// Coefficients a sample, and entries a row of the basis.
  std::size_t rank() const { return rank_; }
  /// A sample: its coefficients, rank() of them, in steps of coefficient_scales().
  std::span<const Value> coefficients() const {
    return std::span(coefficients_).first(samples_->size() * rank_);
  }
  std::span<const float> coefficient_scales() const { return coefficient_scales_; }
  /// Rows of all clusters one after the other, rank() entries each, in steps of the cluster's basis_scales().
  std::span<const Value> basis() const { return std::span(basis_).first(means_.size() * rank_); }
  std::span<const float> basis_scales() const { return basis_scales_; }
  /// A row of the basis: the mean depth there, in steps of the cluster's mean_scales().
  std::span<const std::int16_t> means() const { return means_; }
  std::span<const float> mean_scales() const { return mean_scales_; }
  /// Cluster c and direction k: the row at c · directions + k, counted from the cluster's first; 65535 where
  /// no sample of the cluster sees that way. Empty for the hemisphere, where row and direction are the same.
  std::span<const std::uint16_t> rows() const { return rows_; }

  /// Bytes of all these arrays, and of the coefficients among them.
  std::size_t bytes() const {
    return coefficient_bytes() + basis().size_bytes() + means().size_bytes() + rows().size_bytes() +
           basis_scales().size_bytes() + mean_scales().size_bytes();
  }
  std::size_t coefficient_bytes() const {
    return coefficients().size_bytes() + coefficient_scales().size_bytes();
  }

 private:
  std::size_t padded_rank() const { return (rank_ + Lanes::width - 1) / Lanes::width * Lanes::width; }

  void keep(std::span<const detail::DepthCluster> clusters) {
    for (const auto& cluster : clusters) rank_ = std::max(rank_, cluster.rank);
    for (std::size_t c = 0; c < clusters.size(); ++c) {
      begins_.push_back(means_.size());
      keep_coefficients(clusters[c].coefficients, samples_->size(c));
      keep_rows(clusters[c]);
      if (options_.dome == Dome::sphere)
        rows_.insert(rows_.end(), clusters[c].rows.begin(), clusters[c].rows.end());
    }
    basis_.resize(basis_.size() + padded_rank(), 0);  // where loads of whole registers may end
    coefficients_.resize(coefficients_.size() + padded_rank(), 0);
  }

  /// Where a cluster's rank is less, zeros fill the rows.
  void keep_coefficients(const Rows& rows, std::size_t count) {
    const QuantisedRows<Value> quantised = quantise<Value>(rows);
    for (std::size_t i = 0; i < count; ++i) {
      coefficient_scales_.push_back(rows.width > 0 ? quantised.scales[i] : 0.0f);
      for (std::size_t j = 0; j < rank_; ++j)
        coefficients_.push_back(j < rows.width ? quantised[i][j] : Value(0));
    }
  }

  /// One scale for all of a cluster's basis: the entries of an orthonormal basis are alike.
  void keep_rows(const detail::DepthCluster& cluster) {
    Rows basis(cluster.mean.size(), rank_), mean(1, cluster.mean.size());
    for (std::size_t k = 0; k < basis.count(); ++k) std::ranges::copy(cluster.basis[k], basis[k].begin());
    std::ranges::copy(cluster.mean, mean.values.begin());
    basis.width = basis.values.size();
    basis_scales_.push_back(keep_row<Value>(basis, basis_));
    mean_scales_.push_back(keep_row<std::int16_t>(mean, means_));
  }
  template <class To>
  static float keep_row(const Rows& row, std::vector<To>& to) {
    const QuantisedRows<To> quantised = quantise<To>(row);
    to.insert(to.end(), quantised.values.begin(), quantised.values.end());
    return quantised.count() > 0 ? quantised.scales[0] : 0.0f;
  }

  float at_sample(std::size_t cluster, std::size_t i, std::span<const LocalLight> points,
                  std::span<float> coefficients) const {
    const SurfaceSample& sample = samples_->samples[i];
    const vec3 origin = ray_origin(sample);
    const mat3 frame = dome_frame(options_.dome, sample.normal);
    load_coefficients(cluster, i, coefficients);
    std::uint32_t decided = 0;
    float visible = 0;
    for (const LocalLight& point : points) {
      const vec3 across = point.position - point.w * origin;
      if (!(dot(across, sample.normal) > 0)) continue;
      const float distance = length(across);
      const float reach = point.w > 0 ? std::min(distance / point.w, options_.limit) : options_.limit;
      const vec3 direction = across / distance * frame;
      visible += share_of_four(cluster, sample.normal, direction, (1 - options_.bias) * reach, coefficients);
      ++decided;
    }
    return decided > 1 ? visible / float(decided) : visible;
  }

  /// As floats, with the scales of the sample and of the cluster's basis, zeros to the end of a register.
  void load_coefficients(std::size_t cluster, std::size_t i, std::span<float> to) const {
    const Lanes scale = coefficient_scales_[i] * basis_scales_[cluster];
    for (std::size_t j = 0; j < rank_; j += Lanes::width) {
      const Lanes value = scale * load_integers(&coefficients_[i * rank_ + j]);
      select(first_lanes(rank_ - j), value, 0.0f).store(&to[j]);
    }
  }

  /// The share of the four directions nearest to a light's in which it is nearer than the depth: compared
  /// first, averaged then. Directions below the sample's horizon do not count.
  float share_of_four(std::size_t cluster, const vec3& normal, const vec3& direction, float reach,
                      std::span<const float> coefficients) const {
    float visible = 0, count = 0;
    for (const std::uint16_t k : grid_.nearly_nearest(direction)) {
      if (options_.dome == Dome::sphere && !(dot(grid_.directions()[k], normal) > 0)) continue;
      visible += reach <= depth(cluster, row_of(cluster, k), coefficients) ? 1.0f : 0.0f;
      ++count;
    }
    return count > 0 ? visible / count : 1.0f;
  }

  std::size_t row_of(std::size_t cluster, std::uint16_t direction) const {
    return begins_[cluster] + (rows_.empty() ? direction : rows_[cluster * grid_.size() + direction]);
  }

  /// PCA Eq. 9 for one entry.
  float depth(std::size_t cluster, std::size_t row, std::span<const float> coefficients) const {
    Lanes sum = 0.0f;
    for (std::size_t j = 0; j < rank_; j += Lanes::width)
      sum = mul_add(load_integers(&basis_[row * rank_ + j]), Lanes::load(&coefficients[j]), sum);
    return mean_scales_[cluster] * float(means_[row]) + sum_of_lanes(sum);
  }

  const ClusteredSamples* samples_;
  DepthOptions options_;
  DirectionGrid grid_;
  std::size_t rank_ = 0;
  std::vector<Value> coefficients_, basis_;
  std::vector<float> coefficient_scales_, basis_scales_, mean_scales_;
  std::vector<std::int16_t> means_;
  std::vector<std::uint16_t> rows_;
  std::vector<std::size_t> begins_;  ///< a cluster: its first row
};

}  // namespace coppice::inline HWY_NAMESPACE
