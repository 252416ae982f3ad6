// Lit trees, random cuts over them, and points of every material.
#pragma once

#include <coppice/brdf/with_brdf.hpp>
#include <coppice/core/random.hpp>
#include <coppice/cut/masked_cuts.hpp>
#include <coppice/cut/select.hpp>
#include <coppice/light/directions.hpp>
#include <coppice/relight/frame_lighting.hpp>
#include <coppice/tree/build.hpp>
#include <functional>
#include <vector>

namespace support {

using coppice::Random;
using coppice::ShadingPoint;
using coppice::vec3;

/// Even directions under the given lights: their tree, and its nodes with an illumination cut.
struct LitTree {
  std::vector<vec3> directions;  ///< by light
  std::vector<coppice::CellLight> lights;
  coppice::LightTree tree;
  coppice::FrameLighting frame;

  template <class Power>
  LitTree(std::uint32_t count, std::size_t nodes, std::uint32_t granule_log2, Power&& power_towards)
      : directions(coppice::even_directions(count, 4)) {
    std::vector<coppice::LightSample> samples;
    for (const vec3& d : directions) {
      samples.push_back({d, vec3(0)});
      lights.push_back({power_towards(d), 4 * coppice::pi / float(count)});
    }
    tree = coppice::build_tree(coppice::GeometricMetric(samples));
    frame = coppice::light_frame(tree, lights, directions, nodes, granule_log2);
  }

  std::uint32_t leaf_count() const { return tree.leaf_count(); }

  /// Of the leaves, in their order.
  std::vector<vec3> leaf_directions() const {
    std::vector<vec3> result;
    for (std::uint32_t i = 0; i < leaf_count(); ++i)
      result.push_back(frame.nodes[leaf_count() + i].direction);
    return result;
  }
  std::vector<vec3> leaf_powers() const {
    std::vector<vec3> result;
    for (std::uint32_t i = 0; i < leaf_count(); ++i) result.push_back(frame.nodes[leaf_count() + i].power);
    return result;
  }
};

inline vec3 random_colour(Random& random) { return {random.uniform(), random.uniform(), random.uniform()}; }

/// A few bright lights among dim, dark and purely red, green or blue ones.
inline LitTree random_lit_tree(std::uint32_t count, std::size_t nodes, std::uint32_t granule_log2,
                               Random& random) {
  return LitTree(count, nodes, granule_log2, [&](const vec3&) {
    const float kind = random.uniform();
    const vec3 colour = random_colour(random);
    if (kind < 0.3f) return vec3(0);
    if (kind < 0.5f) return vec3(glm::equal(vec3(float(random.below(3))), vec3(0, 1, 2))) * colour;
    return colour * (kind > 0.95f ? 100.0f : 1.0f);
  });
}

/// Up to 200 pieces of random sizes, a third of them dark.
template <coppice::Quantised Value>
coppice::Cut<Value> random_visibility_cut(std::uint32_t leaf_count, std::uint32_t granule_log2,
                                          Random& random) {
  const std::uint32_t granules = leaf_count >> granule_log2;
  const std::size_t size = 1 + random.below(std::min(granules, 200u));
  std::vector<float> priority(2 * std::size_t(granules));
  for (float& p : priority) p = random.uniform();
  auto ends = coppice::refine_cut(
      granules, [&](std::uint32_t h) { return priority[h]; }, 0.0, size);
  auto cut = coppice::cut_with_values(granules, std::move(ends), [&](std::uint32_t) {
    return random.below(3) == 0 ? Value(0) : Value(random.bits());
  });
  for (auto& end : cut.ends) end <<= granule_log2;
  return cut;
}

/// A normal, a viewer above its horizon, and weights of three receivers.
inline ShadingPoint random_point(Random& random) {
  ShadingPoint p{};
  vec3 bitangent;
  p.normal = random.direction();
  coppice::make_frame(p.normal, p.tangent, bitangent);
  p.to_viewer = normalize(random.direction() + 1.1f * p.normal);
  p.weight_0 = 0.7f * random.uniform();
  p.weight_1 = (1 - p.weight_0) * random.uniform();
  return p;
}

using SetMaterial = std::function<void(ShadingPoint&)>;

/// One of each BRDF, with lobes that many lights fall into.
inline const std::vector<SetMaterial> wide_materials{
    [](ShadingPoint& p) {
      coppice::set_lambert(p, {0.2f, 0.5f, 0.8f});
    },
    [](ShadingPoint& p) {
      coppice::set_metallic_roughness(p, {0.9f, 0.5f, 0.2f}, 0.4f, 0.5f);
    },
    [](ShadingPoint& p) {
      coppice::set_phong(p, {0.3f, 0.2f, 0.1f}, {0.4f, 0.5f, 0.6f}, 20);
    },
    [](ShadingPoint& p) {
      coppice::set_blinn_phong(p, {0.3f, 0.2f, 0.1f}, {0.4f, 0.5f, 0.6f}, 40);
    },
    [](ShadingPoint& p) {
      coppice::set_ward(p, {0.3f, 0.2f, 0.1f}, {0.4f, 0.5f, 0.6f}, 0.2f, 0.5f);
    }};

/// Those that reflect specularly, with lobes of a few degrees.
inline const std::vector<SetMaterial> narrow_materials{
    [](ShadingPoint& p) {
      coppice::set_metallic_roughness(p, {0.9f, 0.5f, 0.2f}, 1, 0.2f);
    },
    [](ShadingPoint& p) {
      coppice::set_metallic_roughness(p, {0.9f, 0.5f, 0.2f}, 0, 0.3f);
    },
    [](ShadingPoint& p) {
      coppice::set_phong(p, {0.3f, 0.2f, 0.1f}, {0.4f, 0.5f, 0.6f}, 500);
    },
    [](ShadingPoint& p) {
      coppice::set_blinn_phong(p, {0.3f, 0.2f, 0.1f}, {0.4f, 0.5f, 0.6f}, 1000);
    },
    [](ShadingPoint& p) {
      coppice::set_ward(p, {0.3f, 0.2f, 0.1f}, {0.4f, 0.5f, 0.6f}, 0.05f, 0.1f);
    }};

/// `count` points of each material.
inline std::vector<ShadingPoint> random_points(std::span<const SetMaterial> materials, int count,
                                               Random& random) {
  std::vector<ShadingPoint> points;
  for (int i = 0; i < count; ++i)
    for (const auto& set_material : materials) set_material(points.emplace_back(random_point(random)));
  return points;
}

}  // namespace support
