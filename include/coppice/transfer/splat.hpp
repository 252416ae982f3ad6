// How light that is known at samples reaches all other points of the surface: Gaussian splats.
#pragma once

#include <array>
#include <coppice/core/parallel.hpp>
#include <coppice/light/thin_samples.hpp>
#include <coppice/scene/occluder.hpp>
#include <cstdint>
#include <span>
#include <vector>

namespace coppice {

/// A point of a surface that asks for light: what a pixel sees, or a vertex of a host's mesh.
struct SplatPoint {
  vec3 position{0};
  vec3 normal{0};  ///< unit; geometric, on the side that is meant
};

struct SplatOptions {
  float width = 0.6f;      ///< standard deviation of a splat, in √area of its sample
  float reach = 3;         ///< standard deviations to which it goes
  float thickness = 0.5f;  ///< distance from a splat's plane that halves its weight, in √area
};

namespace detail {

/// The most samples that share in a point.
inline constexpr std::size_t most_splats = 24;

/// Weight of a sample's splat at a point: a Gaussian of the distance within the sample's plane (on a screen
/// an ellipse), over 1 + (distance between each of the two and the other's plane / thickness)², times the
/// fourth power of the normals' cosine. 0 beyond the reach and where they face apart.
inline float splat_weight(const SurfaceSample& s, const SplatPoint& p, const SplatOptions& o) {
  const float size = std::sqrt(s.area), cosine = dot(s.normal, p.normal);
  const vec3 apart = p.position - s.position;
  const float above = dot(apart, s.normal), below = dot(apart, p.normal);
  const float in_plane2 = std::max(dot(apart, apart) - above * above, 0.0f), sd = o.width * size;
  if (!(cosine > 0) || !(sd > 0) || in_plane2 > o.reach * o.reach * sd * sd) return 0;
  const float thickness = o.thickness * size, h2 = (above * above + below * below) / (thickness * thickness);
  return cosine * cosine * cosine * cosine * std::exp(-0.5f * in_plane2 / (sd * sd)) / (1 + h2);
}

/// A sample that shares in a point.
struct Splat {
  std::uint32_t sample = 0;
  float weight = 0;
};

/// Takes out the splats that something stands before: a wall that is thinner than they are wide. Both ends of
/// the ray are lifted by a tenth of the sample's size. Where all would go they stay.
template <Occluder O>
std::size_t remove_hidden(std::span<const SurfaceSample> samples, const SplatPoint& p, const O& occluder,
                          std::span<Splat> splats) {
  std::array<bool, most_splats> hidden{};
  for (std::size_t first = 0; first < splats.size(); first += 16) {
    ShadowPacket rays;
    const std::size_t count = std::min<std::size_t>(16, splats.size() - first);
    for (std::size_t k = 0; k < 16; ++k) {
      const SurfaceSample& s = samples[splats[first + std::min(k, count - 1)].sample];
      const float lift = 0.1f * std::sqrt(s.area);
      const vec3 from = p.position + lift * p.normal, to = s.position + lift * s.normal - from;
      const float distance = length(to);
      const vec3 d = distance > 0 ? to / distance : p.normal;
      rays.origin_x[k] = from.x, rays.origin_y[k] = from.y, rays.origin_z[k] = from.z;
      rays.direction_x[k] = d.x, rays.direction_y[k] = d.y, rays.direction_z[k] = d.z;
      rays.t_max[k] = distance;
    }
    const std::uint32_t blocked = occluder.occluded(rays, (1u << count) - 1);
    for (std::size_t k = 0; k < count; ++k) hidden[first + k] = (blocked >> k & 1) != 0;
  }
  std::size_t kept = 0;
  for (std::size_t k = 0; k < splats.size(); ++k)
    if (!hidden[k]) splats[kept++] = splats[k];
  return kept > 0 ? kept : splats.size();
}

}  // namespace detail

/// The splats of all points: a sparse matrix whose rows sum to 1 (PCA section 5; normalised). It depends on
/// samples and points alone, so a view or a mesh that rests keeps it from frame to frame.
struct SplatWeights {
  std::vector<std::uint32_t> ends;     ///< a point: its entries end before this index
  std::vector<std::uint32_t> samples;  ///< an entry
  std::vector<float> weights;          ///< an entry; above 0

  std::size_t bytes() const { return 4 * (ends.size() + samples.size() + weights.size()); }

  /// Calls visit(sample, weight) for the splats of a point.
  template <class Visit>
  void for_each(std::size_t point, Visit&& visit) const {
    for (std::uint32_t e = point == 0 ? 0 : ends[point - 1]; e < ends[point]; ++e)
      visit(samples[e], weights[e]);
  }
};

namespace detail {

/// Of the nearest samples that face alike, those that reach the point and that nothing hides, heaviest first,
/// with weights that sum to 1; where none reaches it, the nearest alone.
template <Occluder O>
class SplatSearch {
 public:
  SplatSearch(std::span<const SurfaceSample> samples, const O& occluder, const SplatOptions& options)
      : samples_(samples), occluder_(occluder), options_(options), finder_(positions_of(samples)) {}

  std::span<const Splat> find(const SplatPoint& p, std::array<Splat, most_splats>& splats) const {
    std::array<std::uint32_t, most_splats> found;
    std::array<float, most_splats> distance2;
    auto near = finder_.nearest(p.position, found, distance2,
                                [&](std::uint32_t i) { return dot(samples_[i].normal, p.normal) > 0.5f; });
    if (near.empty()) near = finder_.nearest(p.position, std::span(found).first(1), distance2);
    std::size_t count = 0;
    for (const std::uint32_t i : near)
      if (const float w = splat_weight(samples_[i], p, options_); w > 0) splats[count++] = {i, w};
    if (count == 0 && !near.empty()) splats[count++] = {near.front(), 1};
    count = remove_hidden(samples_, p, occluder_, std::span(splats).first(count));
    normalise(std::span(splats).first(count));
    return std::span(splats).first(count);
  }

 private:
  static void normalise(std::span<Splat> splats) {
    std::ranges::sort(splats, [](const Splat& a, const Splat& b) {
      return a.weight != b.weight ? a.weight > b.weight : a.sample < b.sample;
    });
    float sum = 0;
    for (const Splat& s : splats) sum += s.weight;
    for (Splat& s : splats) s.weight /= sum;
  }

  std::span<const SurfaceSample> samples_;
  const O& occluder_;
  const SplatOptions& options_;
  SampleFinder finder_;
};

}  // namespace detail

/// The weights of samples at points. No bleeding: samples that face away by more than 60° do not share in a
/// point, nor those off its plane, nor those behind a wall. A point that no splat reaches takes the nearest
/// sample that faces alike. The same for any executor. Cost: 3 µs and some ten rays a point. Without samples
/// all rows are empty. Precondition: areas are above 0.
template <Occluder O, Executor E>
SplatWeights splat_weights(std::span<const SurfaceSample> samples, std::span<const SplatPoint> points,
                           const O& occluder, const E& executor, const SplatOptions& options = {}) {
  SplatWeights result;
  result.ends.resize(points.size(), 0);
  if (samples.empty()) return result;
  const detail::SplatSearch<O> search(samples, occluder, options);
  std::vector<std::array<detail::Splat, detail::most_splats>> splats(points.size());
  executor(points.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      result.ends[i] = std::uint32_t(search.find(points[i], splats[i]).size());
  });
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::uint32_t k = 0; k < result.ends[i]; ++k) {
      result.samples.push_back(splats[i][k].sample);
      result.weights.push_back(splats[i][k].weight);
    }
    result.ends[i] = std::uint32_t(result.samples.size());
  }
  return result;
}

/// out[i] = Σ weight · value of point i's samples. Precondition: `out` has a place a point.
template <class T, Executor E>
void splat(const SplatWeights& weights, std::span<const T> values, std::span<T> out, const E& executor) {
  COPPICE_ASSERT(out.size() == weights.ends.size());
  executor(out.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      T sum(0);
      weights.for_each(i, [&](std::uint32_t sample, float weight) { sum += weight * values[sample]; });
      out[i] = sum;
    }
  });
}

/// Three of the points of `corners`, and barycentric weights.
struct SplatCorners {
  uvec3 points{0};
  vec3 weights{0};
};

/// The weights of points that are interpolated between others, as between the vertices of a host's mesh.
/// Precondition: `places` name points of `corners`.
inline SplatWeights interpolate(const SplatWeights& corners, std::span<const SplatCorners> places) {
  SplatWeights result;
  result.ends.reserve(places.size());
  for (const SplatCorners& place : places) {
    for (int k = 0; k < 3; ++k) {
      if (!(place.weights[k] > 0)) continue;
      corners.for_each(place.points[k], [&](std::uint32_t sample, float weight) {
        result.samples.push_back(sample);
        result.weights.push_back(place.weights[k] * weight);
      });
    }
    result.ends.push_back(std::uint32_t(result.samples.size()));
  }
  return result;
}

}  // namespace coppice
