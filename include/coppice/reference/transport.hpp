// The transport between samples, dense and slow, and the indirect light of the true surfaces by paths.
#pragma once

#include <coppice/core/config.hpp>
#include <coppice/light/bounce.hpp>
#include <coppice/transfer/sample_lookup.hpp>
#include <coppice/transfer/transport.hpp>
#include <optional>
#include <span>
#include <vector>

namespace coppice::reference {

/// The sample of least misfit of all; the first of equals.
inline std::optional<std::uint32_t> nearest_sample(std::span<const SurfaceSample> samples, const vec3& point,
                                                   const vec3& normal, const SampleReach& reach) {
  std::optional<std::uint32_t> best;
  float least = std::numeric_limits<float>::infinity();
  for (std::uint32_t i = 0; i < samples.size(); ++i) {
    const float misfit = sample_misfit(samples[i].position, samples[i].normal, point, normal, reach);
    if (misfit < least) best = i, least = misfit;
  }
  return best;
}

/// A square matrix, row by row.
struct DenseTransport {
  std::size_t size = 0;
  std::vector<double> values;

  double operator()(std::size_t i, std::size_t j) const { return values[i * size + j]; }
};

inline DenseTransport dense(const Transport& transport) {
  DenseTransport result{transport.size(), std::vector<double>(transport.size() * transport.size())};
  for (std::size_t i = 0; i < transport.size(); ++i)
    for (std::size_t e = transport.first[i]; e < transport.first[i + 1]; ++e)
      result.values[i * result.size + transport.columns[e]] += double(transport.counts[e]) / transport.rays;
  return result;
}

/// T·x, one right-hand side.
inline std::vector<double> multiply(const DenseTransport& transport, std::span<const double> x) {
  std::vector<double> result(transport.size);
  for (std::size_t i = 0; i < transport.size; ++i)
    for (std::size_t j = 0; j < transport.size; ++j) result[i] += transport(i, j) * x[j];
  return result;
}

/// Σ_{k=1..bounces} (T·ρ)^k e0, one channel.
inline std::vector<double> interreflect(const DenseTransport& transport, std::span<const double> albedos,
                                        std::vector<double> irradiance, std::uint32_t bounces) {
  std::vector<double> sum(transport.size);
  for (std::uint32_t bounce = 0; bounce < bounces; ++bounce) {
    for (std::size_t i = 0; i < transport.size; ++i) irradiance[i] *= albedos[i];
    irradiance = multiply(transport, irradiance);
    for (std::size_t i = 0; i < transport.size; ++i) sum[i] += irradiance[i];
  }
  return sum;
}

struct PathOptions {
  std::uint32_t paths = 4096;  ///< their first directions are spread evenly
  std::uint32_t bounces = 64;  ///< at most
  std::uint64_t seed = 0;
  Shading shading = Shading::lambert;
};

/// Indirect irradiance at points of a scene by paths: cosine-distributed rays to the true surfaces, their
/// albedo where the ray ends, a shadow ray to each light there. After each surface a path goes on with
/// a chance of its greatest albedo. No bias but what more than `bounces` would add.
template <class Tracer>
class PathTracer {
 public:
  PathTracer(const Scene& scene, const Tracer& tracer, const PathOptions& options)
      : scene_(scene), tracer_(tracer), options_(options) {}

  /// By light, W/m²; all lights share the paths.
  std::vector<vec3> indirect(const SurfaceSample& at, std::span<const LocalLight> lights) const {
    Random random(Random(options_.seed).bits());
    const coppice::detail::CosineDirections directions(options_.paths, at.normal, random);
    std::vector<glm::dvec3> sums(lights.size(), glm::dvec3(0));
    for (std::uint32_t k = 0; k < options_.paths; ++k)
      follow(ray_origin(at), directions[k], lights, random, sums);
    std::vector<vec3> result;
    for (const glm::dvec3& sum : sums) result.push_back(vec3(sum / double(options_.paths)));
    return result;
  }

 private:
  std::optional<SurfaceSample> meet(const vec3& origin, const vec3& direction) const {
    const auto hit = tracer_.closest(origin, direction);
    if (!hit) return std::nullopt;
    SurfaceSample met{.side = {hit->triangle, hit->front}, .u = hit->u, .v = hit->v};
    met.position = position_at(scene_.mesh, *hit);
    met.normal =
        vec3(normalize(coppice::detail::area_normal(scene_.mesh, hit->triangle))) * (hit->front ? 1.0f : -1.0f);
    met.colour = diffuse_albedo(scene_, met, options_.shading);
    return met;
  }

  static vec3 cosine_direction(const vec3& normal, Random& random) {
    return coppice::detail::CosineDirections(1, normal, random)[0];
  }

  void follow(vec3 origin, vec3 direction, std::span<const LocalLight> lights, Random& random,
              std::vector<glm::dvec3>& sums) const {
    vec3 carried(1);
    for (std::uint32_t bounce = 0; bounce < options_.bounces; ++bounce) {
      const auto met = meet(origin, direction);
      if (!met) return;
      carried *= met->colour;
      origin = ray_origin(*met);
      for (std::size_t l = 0; l < lights.size(); ++l)
        if (const auto path = path_to(lights[l], origin, met->normal))
          if (!tracer_.occluded(origin, path->direction, path->t_max))
            sums[l] += glm::dvec3(carried * path->irradiance);
      const float chance = std::min(1.0f, std::max({carried.x, carried.y, carried.z}));
      if (!(random.uniform() < chance)) return;
      carried /= chance;
      direction = cosine_direction(met->normal, random);
    }
  }

  const Scene& scene_;
  const Tracer& tracer_;
  PathOptions options_;
};

}  // namespace coppice::reference
