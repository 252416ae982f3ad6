// The kernels of every instruction set against those that this file is compiled for, and against themselves.
#include <doctest/doctest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <cmath>
#include <coppice/brdf/with_brdf.hpp>
#include <coppice/kernels/kernels.hpp>
#include <coppice/relight/compiled_kernels.hpp>
#include <string_view>

#include "relight/lights.hpp"
#include "support/executors.hpp"
#include "support/generators.hpp"

using namespace coppice;
using namespace relight_test;

namespace {

constexpr std::uint32_t light_count = 1024, receiver_count = 30, face_count = 40;
constexpr std::uint32_t granule_log2 = 3;

ShadingPoint random_point(Random& random, std::uint32_t face) {
  ShadingPoint p{};
  vec3 bitangent;
  p.normal = random.direction();
  make_frame(p.normal, p.tangent, bitangent);
  p.to_viewer = normalize(random.direction() + 1.1f * p.normal);
  p.weight_0 = 0.7f * random.uniform();
  p.weight_1 = (1 - p.weight_0) * random.uniform();
  p.face = face;
  return p;
}

/// A point of each BRDF for every face, from rough to polished.
ShadingBuffer random_buffer(Random& random) {
  ShadingBuffer buffer;
  const auto receiver = [&] { return std::uint32_t(random.below(receiver_count)); };
  for (std::uint32_t f = 0; f < face_count; ++f) {
    buffer.faces.push_back({{receiver(), receiver(), receiver()}, std::uint32_t(buffer.points.size())});
    const vec3 diffuse(0.3f, 0.2f, 0.1f), specular(0.4f, 0.5f, 0.6f);
    const auto add = [&]() -> ShadingPoint& { return buffer.points.emplace_back(random_point(random, f)); };
    const float roughness = 0.2f + 0.8f * random.uniform(), exponent = 2 / std::pow(roughness, 4.0f);
    set_lambert(add(), diffuse);
    set_metallic_roughness(add(), specular, random.uniform(), roughness);
    set_phong(add(), diffuse, specular, exponent);
    set_blinn_phong(add(), diffuse, specular, exponent);
    set_ward(add(), diffuse, specular, roughness, random.uniform());
  }
  return buffer;
}

FrameLighting random_frame(const Lights& lights, Random& random) {
  std::vector<CellLight> cells;
  for (std::uint32_t i = 0; i < light_count; ++i) {
    const vec3 radiance(random.uniform(), random.uniform(), random.uniform());
    const float brightness = std::exp(6 * random.uniform());
    cells.push_back({brightness * radiance, 4 * pi / float(light_count)});
  }
  return light_frame(lights.tree, cells, lights.directions, 100, granule_log2);
}

template <Quantised Value>
MaskedCuts<Value> random_cuts(Random& random) {
  MaskedCuts<Value> cuts(light_count, granule_log2);
  for (std::uint32_t i = 0; i < receiver_count; ++i) {
    const auto cut = test_support::random_cut<Value>(random, light_count, 0.9f, 1u << granule_log2);
    cuts.append(CutView<Value>(cut), {random.direction(), -0.5f * random.uniform()});
  }
  return cuts;
}

struct Shaded {
  std::vector<vec3> radiance;
  std::vector<std::uint32_t> clusters;
  bool operator==(const Shaded&) const = default;
};

/// A random scene that kernels can shade in every way.
template <Quantised Value>
struct Scenery {
  Random random{7};
  Lights lights{light_count};
  FrameLighting frame = random_frame(lights, random);
  DenseLights dense{light_count, frame};
  MaskedCuts<Value> cuts = random_cuts<Value>(random);
  std::vector<std::uint64_t> bits;
  ShadingBuffer buffer = random_buffer(random);

  Scenery() {
    for (std::uint32_t i = 0; i < receiver_count; ++i) {
      const auto row = bits_of(lights.tree, random_visibility(lights, random, 0.1f));
      bits.insert(bits.end(), row.begin(), row.end());
    }
  }

  Shaded shade(const ShadingKernels<Value>& kernels, Lobes lobes, const Executor auto& executor) const {
    Shaded image{std::vector<vec3>(buffer.points.size()), std::vector<std::uint32_t>(buffer.points.size())};
    executor(buffer.faces.size(), 3, [&](std::size_t begin, std::size_t end) {
      kernels.shade_faces(buffer, cuts, frame, {lobes}, begin, end, image.radiance, image.clusters);
    });
    return image;
  }

  Shaded by_brute_force(const ShadingKernels<Value>& kernels, Skip skip,
                        const Executor auto& executor) const {
    Shaded image{std::vector<vec3>(buffer.points.size()), {}};
    executor(buffer.faces.size(), 3, [&](std::size_t begin, std::size_t end) {
      kernels.brute_force(skip, buffer, bits, light_count, dense, begin, end, image.radiance);
    });
    return image;
  }
};

constexpr Lobes all_lobes[] = {Lobes::sampled, Lobes::filtered, Lobes::refined};
const support::Backwards in_one_piece{face_count};
constexpr Skip all_skips[] = {Skip::nothing, Skip::unseen};

void check_close(const Shaded& image, const Shaded& expected) {
  CHECK(image.clusters == expected.clusters);
  for (std::size_t i = 0; i < image.radiance.size(); ++i) {
    CAPTURE(i % 5);
    CHECK(length(image.radiance[i] - expected.radiance[i]) <= 1e-5f * length(expected.radiance[i]));
  }
}

}  // namespace

TEST_CASE("the scene is lit, and refinement has work to do") {
  const Scenery<std::uint8_t> scene;
  const auto& kernels = best_kernels<std::uint8_t>();
  const Shaded filtered = scene.shade(kernels, Lobes::filtered, in_one_piece);
  const Shaded refined = scene.shade(kernels, Lobes::refined, in_one_piece);
  CHECK(std::ranges::count(filtered.radiance, vec3(0)) == 0);
  CHECK(std::ranges::count(filtered.clusters, 0u) == 0);
  std::size_t split = 0;
  for (std::size_t i = 0; i < refined.clusters.size(); ++i)
    split += refined.clusters[i] > filtered.clusters[i];
  CHECK(split > refined.clusters.size() / 2);
}

TEST_CASE_TEMPLATE("every instruction set gives the image of the compiled one", Value, std::uint8_t,
                   std::uint16_t) {
  const Scenery<Value> scene;
  const ShadingKernels<Value>& compiled = compiled_kernels<Value>();
  for (const InstructionSet set : supported_instruction_sets()) {
    CAPTURE(name(set));
    const ShadingKernels<Value>& kernels = kernels_for<Value>(set);
    for (const Lobes lobes : all_lobes)
      check_close(scene.shade(kernels, lobes, in_one_piece), scene.shade(compiled, lobes, in_one_piece));
    for (const Skip skip : all_skips)
      check_close(scene.by_brute_force(kernels, skip, in_one_piece),
                  scene.by_brute_force(compiled, skip, in_one_piece));
  }
}

TEST_CASE("an instruction set gives the same bits again, and in any split over threads") {
  const Scenery<std::uint8_t> scene;
  for (const InstructionSet set : supported_instruction_sets()) {
    CAPTURE(name(set));
    const auto& kernels = kernels_for<std::uint8_t>(set);
    for (const Lobes lobes : all_lobes) {
      const Shaded image = scene.shade(kernels, lobes, in_one_piece);
      CHECK(image == scene.shade(kernels, lobes, in_one_piece));
      CHECK(image == scene.shade(kernels, lobes, support::TwoThreads()));
      CHECK(image == scene.shade(kernels, lobes, support::Backwards{1}));
    }
    for (const Skip skip : all_skips)
      CHECK(scene.by_brute_force(kernels, skip, in_one_piece) ==
            scene.by_brute_force(kernels, skip, support::TwoThreads()));
  }
}
