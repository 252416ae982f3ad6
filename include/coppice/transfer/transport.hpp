// The transport of light between samples: what each receives of what the others give back.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <algorithm>
#include <array>
#include <coppice/core/config.hpp>
#include <coppice/core/parallel.hpp>
#include <coppice/core/random.hpp>
#include <coppice/light/bounce.hpp>
#include <coppice/pca/rows.hpp>
#include <coppice/scene/hit.hpp>
#include <coppice/transfer/sample_lookup.hpp>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace coppice {

/// A sparse square matrix T over samples, row by row: T_ij is the share of sample i's rays, spread as the
/// cosine, that end at what sample j stands for: its form factor. With radiosity B_j = albedo_j · E_j, the
/// irradiance that the samples get from each other is T·B (PCA Eq. 2 for diffuse surfaces). Rows sum to 1 at
/// most; what leaves the scene, or ends where no sample stands, is missing. A_i T_ij ≈ A_j T_ji.
struct Transport {
  std::uint32_t rays = 1;                   ///< a sample; T_ij = counts / rays
  std::vector<std::uint64_t> first = {0};   ///< row i: entries [first[i], first[i + 1])
  std::vector<std::uint32_t> columns = {};  ///< ascending in a row
  std::vector<std::uint16_t> counts = {};   ///< of rays, > 0

  std::size_t size() const { return first.size() - 1; }
  /// Of memory, 6 an entry.
  std::size_t bytes() const {
    return first.size() * sizeof(first[0]) + columns.size() * (sizeof(columns[0]) + sizeof(counts[0]));
  }
  /// Σ_j T_ij: the share of sample i's rays that end at samples.
  float row_sum(std::size_t i) const {
    std::uint64_t sum = 0;
    for (std::uint64_t e = first[i]; e < first[i + 1]; ++e) sum += counts[e];
    return float(sum) / float(rays);
  }
};

/// Tᵀ, the adjoint: what each sample gives to the others. O(entries), one thread.
inline Transport transposed(const Transport& transport) {
  Transport result{.rays = transport.rays};
  result.first.assign(transport.size() + 1, 0);
  for (const std::uint32_t column : transport.columns) ++result.first[column + 1];
  for (std::size_t i = 0; i < transport.size(); ++i) result.first[i + 1] += result.first[i];
  result.columns.resize(transport.columns.size());
  result.counts.resize(transport.counts.size());
  std::vector<std::uint64_t> next(result.first.begin(), result.first.end() - 1);
  for (std::size_t i = 0; i < transport.size(); ++i)
    for (std::uint64_t e = transport.first[i]; e < transport.first[i + 1]; ++e) {
      const std::uint64_t to = next[transport.columns[e]]++;
      result.columns[to] = std::uint32_t(i);
      result.counts[to] = transport.counts[e];
    }
  return result;
}

struct TransportOptions {
  std::uint32_t rays = 512;  ///< a sample, 1 to 65,535: 512 for drafts, 2,016 for a final result
  std::uint64_t seed = 0;
};

namespace detail {

/// Unit normals of the triangles' fronts; zero where there is no area.
inline std::vector<vec3> front_normals(const Mesh& mesh) {
  std::vector<vec3> normals;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const glm::dvec3 normal = area_normal(mesh, i);
    const double size = length(normal);
    normals.push_back(size > 0 ? vec3(normal / size) : vec3(0));
  }
  return normals;
}

/// Directions about a normal, as dense as the cosine: a Fibonacci lattice on the square, shifted at random,
/// and turned into a disc, azimuth slowly so that rays that follow each other meet the same things.
class CosineDirections {
 public:
  CosineDirections(std::uint32_t count, const vec3& normal, Random& random) : count_(count), normal_(normal) {
    make_frame(normal, tangent_, bitangent_);
    shift_ = {random.uniform(), random.uniform()};
  }
  vec3 operator[](std::uint32_t k) const {
    constexpr double golden = 0.61803398874989484820;
    const float square = fraction(shift_.x + float(std::fmod(k * golden, 1.0)));
    const float azimuth = 2 * pi * fraction(shift_.y + (float(k) + 0.5f) / float(count_));
    const float radius = std::sqrt(square);
    return normalize(radius * std::cos(azimuth) * tangent_ + radius * std::sin(azimuth) * bitangent_ +
                     std::sqrt(1 - square) * normal_);
  }

 private:
  static float fraction(float x) { return x >= 1 ? x - 1 : x; }

  std::uint32_t count_;
  vec3 normal_, tangent_, bitangent_;
  vec2 shift_;
};

/// Rows of the transport, one after the other.
struct TransportRows {
  std::vector<std::uint32_t> ends, columns;
  std::vector<std::uint16_t> counts;

  /// The samples at which the rays of one row ended, with repetitions; sorts them.
  void append(std::vector<std::uint32_t>& met) {
    std::ranges::sort(met);
    for (std::size_t k = 0; k < met.size(); ++k)
      if (k > 0 && met[k] == met[k - 1])
        ++counts.back();
      else
        columns.push_back(met[k]), counts.push_back(1);
    ends.push_back(std::uint32_t(columns.size()));
  }
};

/// Traces the rays of a sample: the samples where they end.
template <RayTracer T>
class RowTracer {
 public:
  RowTracer(std::span<const vec3> normals, const SampleLookup& lookup, const T& tracer,
            const TransportOptions& options)
      : normals_(normals), lookup_(lookup), tracer_(tracer), options_(options) {}

  void trace(std::size_t index, const SurfaceSample& sample, std::vector<std::uint32_t>& met) const {
    met.clear();
    Random random(Random(options_.seed + index).bits());
    const CosineDirections directions(options_.rays, sample.normal, random);
    const vec3 origin = ray_origin(sample);
    for (std::uint32_t k = 0; k < options_.rays; ++k) {
      const vec3 direction = directions[k];
      const auto hit = tracer_.closest(origin, direction);
      if (!hit) continue;
      const vec3 normal = normals_[hit->triangle] * (hit->front ? 1.0f : -1.0f);
      if (const auto found = lookup_.nearest(origin + hit->t * direction, normal)) met.push_back(*found);
    }
  }

 private:
  std::span<const vec3> normals_;
  const SampleLookup& lookup_;
  const T& tracer_;
  TransportOptions options_;
};

/// Puts the blocks' rows together; takes their memory.
inline Transport join_rows(std::vector<TransportRows>& blocks, std::uint32_t rays) {
  Transport transport{.rays = rays};
  std::size_t entries = 0;
  for (const TransportRows& block : blocks) entries += block.columns.size();
  transport.columns.reserve(entries), transport.counts.reserve(entries);
  for (TransportRows& block : blocks) {
    const std::uint64_t before = transport.columns.size();
    for (const std::uint32_t end : block.ends) transport.first.push_back(before + end);
    transport.columns.insert(transport.columns.end(), block.columns.begin(), block.columns.end());
    transport.counts.insert(transport.counts.end(), block.counts.begin(), block.counts.end());
    block = {};
  }
  return transport;
}

}  // namespace detail

/// Traces the transport between samples of a scene: `rays` rays a sample by the tracer, each to the sample
/// that the lookup names at its end. The mesh is the one that the tracer's hits speak of. The same for any
/// executor. Cost: a ray and a lookup each: docs/transfer.md. Preconditions: the lookup is over the same
/// samples; 1 <= rays <= 65,535; normals are unit.
template <RayTracer T, Executor E>
Transport build_transport(const Mesh& mesh, std::span<const SurfaceSample> samples,
                          const SampleLookup& lookup, const T& tracer, const E& executor,
                          const TransportOptions& options = {}) {
  COPPICE_ASSERT(options.rays > 0 && options.rays <= std::numeric_limits<std::uint16_t>::max());
  constexpr std::size_t block_size = 64;
  const std::vector<vec3> normals = detail::front_normals(mesh);
  const detail::RowTracer<T> rows(normals, lookup, tracer, options);
  std::vector<detail::TransportRows> blocks((samples.size() + block_size - 1) / block_size);
  executor(blocks.size(), 1, [&](std::size_t begin, std::size_t end) {
    std::vector<std::uint32_t> met;
    for (std::size_t b = begin; b < end; ++b)
      for (std::size_t i = b * block_size; i < std::min((b + 1) * block_size, samples.size()); ++i) {
        rows.trace(i, samples[i], met);
        blocks[b].append(met);
      }
  });
  return detail::join_rows(blocks, options.rays);
}

}  // namespace coppice

namespace coppice::detail::inline HWY_NAMESPACE {

/// Columns [begin, begin + count registers) of a row of T·x.
template <std::size_t count>
void apply_row(const Transport& transport, std::size_t row, const Rows& x, std::size_t begin, float* out) {
  std::array<Lanes, count> sums;
  sums.fill(Lanes(0.0f));
  for (std::uint64_t e = transport.first[row]; e < transport.first[row + 1]; ++e) {
    const float* from = x.values.data() + transport.columns[e] * x.width + begin;
    const Lanes weight = float(transport.counts[e]);
    for (std::size_t k = 0; k < count; ++k)
      sums[k] = mul_add(weight, Lanes::load(from + k * Lanes::width), sums[k]);
  }
  const Lanes share = 1 / float(transport.rays);
  for (std::size_t k = 0; k < count; ++k) (share * sums[k]).store(out + begin + k * Lanes::width);
}

/// The last columns, from `begin`, fewer than a register's.
inline void apply_rest(const Transport& transport, std::size_t row, const Rows& x, std::size_t begin,
                       float* out) {
  std::array<float, Lanes::width> sums{};
  const std::size_t count = x.width - begin;
  for (std::uint64_t e = transport.first[row]; e < transport.first[row + 1]; ++e) {
    const float* from = x.values.data() + transport.columns[e] * x.width + begin;
    for (std::size_t k = 0; k < count; ++k) sums[k] += float(transport.counts[e]) * from[k];
  }
  for (std::size_t k = 0; k < count; ++k) out[begin + k] = sums[k] * (1 / float(transport.rays));
}

}  // namespace coppice::detail::inline HWY_NAMESPACE

namespace coppice::inline HWY_NAMESPACE {

/// T·x for many right-hand sides at once, one a column of x: row j holds those of sample j. Sums run in the
/// order of the entries: the same for any executor; relative error below entries-in-a-row · 6e-8 where x has
/// one sign. Fastest where the width is a multiple of 4 registers (64 floats with AVX-512): the matrix is
/// read once for these. Preconditions: as many rows as T; `out` is not x, and becomes of its size.
template <Executor E>
void apply(const Transport& transport, const Rows& x, const E& executor, Rows& out) {
  COPPICE_ASSERT(x.values.size() == transport.size() * x.width && &x != &out);
  constexpr std::size_t wide = 4;
  out.width = x.width;
  out.values.resize(x.values.size());
  for (std::size_t begin = 0; begin < x.width;) {
    const std::size_t registers = std::min(wide, (x.width - begin) / Lanes::width);
    executor(transport.size(), 64, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        float* row = out.values.data() + i * out.width;
        if (registers == wide)
          detail::apply_row<wide>(transport, i, x, begin, row);
        else if (registers > 0)
          detail::apply_row<1>(transport, i, x, begin, row);
        else
          detail::apply_rest(transport, i, x, begin, row);
      }
    });
    begin = registers == 0 ? x.width : begin + (registers == wide ? wide : 1) * Lanes::width;
  }
}

}  // namespace coppice::inline HWY_NAMESPACE
