// A small room for the tests: a box with samples, clusters, transport, and lights.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <coppice/embree/tracer.hpp>
#include <coppice/light/thin_samples.hpp>
#include <coppice/transfer/interreflection.hpp>
#include <coppice/transfer/light_basis.hpp>
#include <coppice/transfer/transport_aware_basis.hpp>
#include <support/scenes.hpp>

namespace {

using namespace coppice;

/// Six clusters, one a side of the box more or less; walls of two colours; lights at random inside.
struct LitBox {
  ClusteredSamples samples;
  Transport transport;
  Rows examples, unseen;
  InterreflectionOptions bounces = {.bounces = 4};

  explicit LitBox(std::size_t count = 360, std::size_t lights = 150) {
    Scene scene;
    scene.materials.resize(1);
    support::add_box(scene.mesh, vec3(-1, -1, -1), vec3(2, 1, 1));
    const EmbreeTracer tracer(scene);
    std::vector<TriangleSide> sides;
    for (std::uint32_t i = 0; i < scene.mesh.triangles.size(); ++i) sides.push_back({i, false});
    samples.samples = thin_samples(scatter_samples(scene.mesh, sides, 6 * count, Shares::by_area, 1), count);
    for (SurfaceSample& s : samples.samples)
      s.colour = s.position.x > 0.5f ? vec3(0.8f, 0.3f, 0.2f) : vec3(0.5f, 0.6f, 0.7f);
    for (std::size_t c = 1; c <= 6; ++c) samples.ends.push_back(std::uint32_t(c * samples.size() / 6));
    const SampleLookup lookup(samples.samples, {.distance = 4 * sample_spacing(samples.samples) + 1e-3f});
    transport = build_transport(scene.mesh, samples.samples, lookup, tracer, Serial(), {.rays = 128});
    examples = lit_by(tracer, lights, 11);
    unseen = lit_by(tracer, 8, 77);
  }

  Rows probes() const { return transport_probes(transport, albedos_of(samples.samples), Serial()); }

 private:
  Rows lit_by(const EmbreeTracer& tracer, std::size_t count, std::uint64_t seed) const {
    Random random(seed);
    std::vector<vec3> positions;
    for (std::size_t l = 0; l < count; ++l) {
      const float x = random.uniform(), y = random.uniform(), z = random.uniform();
      positions.emplace_back(-0.9f + 2.8f * x, -0.9f + 1.8f * y, -0.9f + 1.8f * z);
    }
    return example_lights(samples.samples, positions, tracer, Serial(),
                          0.5f * softening_distance(samples.samples));
  }
};

inline std::vector<vec3> as_grey(std::span<const float> light) {
  std::vector<vec3> result;
  for (const float x : light) result.emplace_back(x);
  return result;
}

inline double squared_norm(std::span<const vec3> a) {
  double sum = 0;
  for (const vec3& x : a) sum += double(coppice::dot(x, x));
  return sum;
}

inline double squared_difference(std::span<const vec3> a, std::span<const vec3> b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += double(coppice::dot(a[i] - b[i], a[i] - b[i]));
  return sum;
}

}  // namespace
