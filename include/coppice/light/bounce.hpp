// Light that walls give back: samples of the lit surfaces, which shine with what they receive (one bounce).
#pragma once

#include <coppice/light/direct_irradiance.hpp>
//
#include <coppice/core/parallel.hpp>
#include <coppice/light/scene_lights.hpp>
#include <coppice/light/thin_samples.hpp>

namespace coppice {

struct BounceOptions {
  std::size_t count = 32768;  ///< samples at most (Cuts section 4.1)
  std::uint64_t seed = 0;
  Shading shading = Shading::metallic_roughness;
};

/// The share of the light that arrives which leaves again, taken as diffuse: the base colour for Lambert;
/// otherwise the diffuse colour of set_material and f0 with it. So a metal's reflection leaves too, in all
/// directions, and a white dielectric gives back everything.
inline vec3 diffuse_albedo(const Scene& scene, const SurfaceSample& sample, Shading shading) {
  const Material& material = scene.materials[scene.mesh.materials[sample.side.triangle]];
  const vec2 uv = surface_at(scene.mesh, hit_of(sample)).uv;
  const vec3 base = textured(scene, material.base_color, material.base_color_texture, uv);
  if (shading == Shading::lambert) return base;
  const float metallic = textured(scene, vec3(material.metallic), material.metallic_roughness_texture, uv).z;
  const vec3 f0 = glm::mix(vec3(0.04f), base, metallic);
  return base * (1 - metallic) * (vec3(1) - f0) + f0;
}

/// Where shadow rays of a sample begin: above the surface by what float positions resolve.
inline vec3 ray_origin(const SurfaceSample& sample) {
  const vec3 size = glm::abs(sample.position);
  return sample.position + 4e-6f * std::max({size.x, size.y, size.z, 1e-3f}) * sample.normal;
}

}  // namespace coppice

namespace coppice::detail::inline HWY_NAMESPACE {

/// Those that a light reaches, in their order.
template <Occluder O, Executor E>
std::vector<SurfaceSample> lit_samples(std::span<const SurfaceSample> samples, const DirectIrradiance& direct,
                                       const O& occluder, const E& executor, std::uint64_t seed) {
  std::vector<std::uint8_t> lit(samples.size(), 0);
  executor(samples.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Random random(Random(seed + i).bits());
      lit[i] = direct.reaches(occluder, ray_origin(samples[i]), samples[i].normal, random);
    }
  });
  std::vector<SurfaceSample> result;
  for (std::size_t i = 0; i < samples.size(); ++i)
    if (lit[i]) result.push_back(samples[i]);
  return result;
}

/// How many points to scatter so that about `wanted` of them are lit, judged by a pilot; 32 times that at
/// most.
template <Occluder O, Executor E>
std::size_t scatter_count(const Scene& scene, std::span<const TriangleSide> sides, std::size_t wanted,
                          const DirectIrradiance& direct, const O& occluder, const E& executor,
                          std::uint64_t seed) {
  constexpr std::size_t pilots = 4096;
  const auto pilot = scatter_samples(scene.mesh, sides, pilots, Shares::by_area, seed);
  const std::size_t lit = lit_samples(pilot, direct, occluder, executor, seed).size();
  const double share = std::max(1.0 / 32, double(lit) / double(pilots));
  return std::max(pilots, std::size_t(double(wanted) / share));
}

}  // namespace coppice::detail::inline HWY_NAMESPACE

namespace coppice::inline HWY_NAMESPACE {

/// Chooses where light bounces: `count` samples over the sides of triangles that any of the lights reaches,
/// even by area, their colour the mean albedo of what they stand for. Sides that none of them reaches take no
/// sample and no area; lights may dim or recolour later at will, but what was dark stays black. Sides too
/// faintly lit: DirectIrradiance::reaches. Fewer samples where hardly anything is lit. The same for any
/// executor. Cost: five candidates a lit sample and as many unlit ones as there is unlit area, each with 16
/// to 80 rays, then one second to thin 32,768: docs/light.md.
template <Occluder O, Executor E>
std::vector<SurfaceSample> bounce_samples(const Scene& scene, std::span<const LocalLight> lights,
                                          const O& occluder, const E& executor,
                                          const BounceOptions& options) {
  if (options.count == 0 || lights.empty()) return {};
  const DirectIrradiance direct(lights);
  const auto sides = triangle_sides(scene, [](const Material&) { return true; });
  const std::size_t scattered = detail::scatter_count(scene, sides, candidates_a_sample * options.count,
                                                      direct, occluder, executor, options.seed);
  auto candidates = scatter_samples(scene.mesh, sides, scattered, Shares::by_area, options.seed);
  std::erase_if(candidates, [&](const SurfaceSample& c) { return !is_solid(scene, c); });
  candidates = detail::lit_samples(candidates, direct, occluder, executor, options.seed);
  for (SurfaceSample& c : candidates) c.colour = diffuse_albedo(scene, c, options.shading);
  return thin_samples(candidates, options.count);
}

/// Lights the samples for a frame: out[i] is sample i as a surface light of radiance albedo/π · irradiance,
/// black where nothing arrives; position, normal and area are the sample's, whatever the lights. Exact up to
/// `most_rays` lights, else as DirectIrradiance says. The same for any executor. Cost: a shadow ray a sample
/// and light. Precondition: out has the samples' size.
template <Occluder O, Executor E>
void light_samples(std::span<const SurfaceSample> samples, std::span<const LocalLight> lights,
                   const O& occluder, const E& executor, std::span<LocalLight> out,
                   std::size_t most_rays = 4096) {
  COPPICE_ASSERT(out.size() == samples.size());
  const DirectIrradiance direct(lights, most_rays);
  executor(samples.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const SurfaceSample& s = samples[i];
      Random random(Random(i).bits());
      const vec3 irradiance = direct.at(occluder, ray_origin(s), s.normal, random);
      out[i] = surface_light(s.position, s.normal, s.colour / pi * irradiance, s.area);
    }
  });
}

}  // namespace coppice::inline HWY_NAMESPACE
