// The kernels of cones and of products of Gaussians against the CPU.
#include <coppice/vulkan/sg_shader.hpp>
//
#include <doctest/doctest.h>

#include <cmath>
#include <coppice/sg/preconvolved.hpp>

#include "random_input.hpp"
#include "shaded.hpp"
#include "support/executors.hpp"
#include "support/generators.hpp"
#include "support/occluders.hpp"
#include "voxel/scenes.hpp"

using namespace coppice;
using namespace coppice::test;

namespace {

/// 0, or anything from 1e-3 to 1e6.
float random_sharpness(Random& random) {
  return random.below(10) == 0 ? 0 : std::pow(10.0f, 9 * random.uniform() - 3);
}

/// Of all numbers together; 0 where both are 0 throughout.
double relative_rms_of(std::span<const float> a, std::span<const float> reference) {
  REQUIRE(a.size() == reference.size());
  double difference = 0, total = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    difference += std::pow(double(a[i]) - double(reference[i]), 2);
    total += std::pow(double(reference[i]), 2);
  }
  return difference == 0 ? 0 : std::sqrt(difference / total);
}

/// Receivers all over a still life and cones of all sharpnesses, 0 to 12 a receiver. Shading normals lean;
/// one receiver in ten floats in the air or lies outside of the grid.
struct Cones {
  Mesh mesh = support::still_life().mesh;
  support::TriangleTracer tracer{mesh};
  BrickGrid grid = support::grid_of(mesh, {vec3(-2, 0, -2), vec3(2, 1, 2)}, 64);
  std::vector<ConeReceiver> receivers;
  std::vector<SgShape> shapes;

  Cones(std::uint64_t seed, std::uint32_t count) {
    Random random(seed);
    for (std::uint32_t i = 0; i < count; ++i) {
      const auto t = support::corners_of(mesh, random.below(std::uint32_t(mesh.triangles.size())));
      const vec3 n = normalize(cross(t.b - t.a, t.c - t.a));
      vec3 p = support::point_of(random, t) + 1e-4f * n;
      if (random.below(10) == 0) p += 3 * random.uniform() * random.direction();
      for (std::uint32_t k = random.below(13); k > 0; --k) shapes.push_back(random_cone(random, n));
      receivers.push_back({p, std::uint32_t(shapes.size()), n, i, normalize(n + 0.4f * random.direction())});
    }
  }

  static SgShape random_cone(Random& random, const vec3& normal) {
    vec3 axis = random.direction();
    if (random.below(8) == 0) axis = vec3(0, 0, random.below(2) == 0 ? -1 : 1);
    return {random.below(4) == 0 ? axis : normalize(axis + 1.01f * normal), random_sharpness(random)};
  }

  std::vector<float> on_cpu(const BrickGrid& g, const ConeTracerOptions& options) const {
    std::vector<float> visibility(shapes.size(), -1);
    ConeTracer(g, options).trace(tracer, receivers, shapes, visibility, Serial{});
    return visibility;
  }
  std::vector<float> on(ConeShader& shader) const {
    std::vector<float> visibility(shapes.size(), -1);
    shader.trace(tracer, receivers, shapes, visibility, Serial{});
    return visibility;
  }
};

std::size_t count_off(std::span<const float> a, std::span<const float> b) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.size(); ++i) count += !(std::abs(a[i] - b[i]) <= 1e-3f);
  return count;
}

}  // namespace

TEST_CASE("cones of all sharpnesses are as visible on the device as on the CPU") {
  if (!has_device()) return;
  VulkanDevice device;
  const Cones cones(3, 3000);
  VoxelTrace few = default_voxel_trace, one = default_voxel_trace;
  few.rays = 5, few.steps = 7, one.rays = 1;
  for (const ConeTracerOptions& options :
       {ConeTracerOptions{}, ConeTracerOptions{.contact = 0}, ConeTracerOptions{.trace = few},
        ConeTracerOptions{.trace = one, .contact = 6}}) {
    CAPTURE(options.trace.rays);
    CAPTURE(options.contact);
    ConeShader shader(device, options);
    shader.set_grid(cones.grid);
    const auto cpu = cones.on_cpu(cones.grid, options), gpu = cones.on(shader);
    const double difference = relative_rms_of(gpu, cpu);
    MESSAGE("relative RMS difference " << difference << ", off by more than 1e-3: " << count_off(gpu, cpu)
                                       << " of " << cpu.size());
    CHECK(difference < 1e-3);
    CHECK(count_off(gpu, cpu) <= cpu.size() / 1000);
  }
}

TEST_CASE("more rays than a byte has bits are marched on the device without exact ones") {
  if (!has_device()) return;
  VulkanDevice device;
  const Cones cones(4, 500);
  ConeTracerOptions options{.contact = 0};
  options.trace.rays = 40;
  ConeShader shader(device, options);
  shader.set_grid(cones.grid);
  CHECK(relative_rms_of(cones.on(shader), cones.on_cpu(cones.grid, options)) < 1e-3);
}

TEST_CASE("bits of closed rays close them, on the device as in exact shadow") {
  if (!has_device()) return;
  VulkanDevice device;
  const Cones cones(5, 200);
  ConeShader shader(device);
  std::vector<std::uint8_t> closed(cones.shapes.size(), 0);
  std::vector<float> open(closed.size()), half(closed.size()), none(closed.size(), -1);
  shader.march(cones.receivers, cones.shapes, closed, open);
  std::ranges::fill(closed, std::uint8_t{255});
  shader.march(cones.receivers, cones.shapes, closed, none);
  CHECK(none == std::vector<float>(closed.size(), 0));
  for (std::size_t i = 0; i < closed.size(); ++i) closed[i] = i % 3 == 0 ? 255 : 0;
  shader.march(cones.receivers, cones.shapes, closed, half);
  for (std::size_t i = 0; i < closed.size(); ++i) REQUIRE(half[i] == (i % 3 == 0 ? 0 : open[i]));
}

TEST_CASE("without a grid all is open that is above the horizon, and a grid can be taken back") {
  if (!has_device()) return;
  VulkanDevice device;
  const Cones cones(6, 400);
  const BrickGrid empty = empty_brick_grid({vec3(-1), vec3(1)}, 16), none;
  ConeShader shader(device, {.contact = 0});
  const auto cpu = cones.on_cpu(none, {.contact = 0});
  CHECK(relative_rms_of(cones.on(shader), cpu) < 1e-5);
  CHECK(std::ranges::count(cpu, 1.0f) > 100);
  shader.set_grid(cones.grid);
  const auto shadowed = cones.on(shader);
  CHECK(relative_rms_of(shadowed, cpu) > 0.1);
  shader.set_grid(empty);
  CHECK(relative_rms_of(cones.on(shader), cpu) < 1e-5);
  shader.set_grid(cones.grid);
  CHECK(cones.on(shader) == shadowed);
}

TEST_CASE("no receivers, and receivers without cones, leave nothing to trace on the device") {
  if (!has_device()) return;
  VulkanDevice device;
  ConeShader shader(device);
  const std::vector<ConeReceiver> receivers(3, {vec3(0), 0, vec3(0, 1, 0), 0, vec3(0, 1, 0)});
  std::vector<float> visibility(1, -1);
  shader.trace(OpenSpace{}, {}, {}, visibility, Serial{});
  shader.trace(OpenSpace{}, receivers, {}, visibility, Serial{});
  CHECK(visibility[0] == -1);
  CHECK(!shader.milliseconds());
}

TEST_CASE("pieces of any size trace the same bits") {
  if (!has_device()) return;
  VulkanDevice device;
  const Cones cones(7, 150);
  ConeShader whole(device);
  whole.set_grid(cones.grid);
  const auto all = cones.on(whole);
  for (const std::size_t piece : {1u, 7u, 100u, 500u}) {
    CAPTURE(piece);
    ConeShader shader(device, {}, piece);
    shader.set_grid(cones.grid);
    CHECK(cones.on(shader) == all);
  }
}

namespace {

std::vector<SgLight> random_lights(Random& random, std::size_t count) {
  std::vector<SgLight> lights;
  for (std::size_t i = 0; i < count; ++i) {
    const vec3 amplitude = random.below(5) == 0 ? vec3(0) : 10.0f * random_colour(random) - vec3(1);
    lights.push_back(sg_light({random.direction(), random_sharpness(random)}, amplitude));
  }
  return lights;
}

/// One in four about the axis of a light, one in eight opposed, one in eight of one axis.
std::vector<SgPair> random_pairs(Random& random, std::size_t count, std::span<const SgLight> lights) {
  std::vector<SgPair> pairs;
  for (std::size_t i = 0; i < count; ++i) {
    SgPair pair{{random.direction(), random_sharpness(random)},
                {random.direction(), random_sharpness(random)}};
    const std::uint32_t kind = random.below(8);
    if (kind < 2 && !lights.empty()) pair.lobe.axis = lights[random.below(std::uint32_t(lights.size()))].axis;
    if (kind == 2) pair.cone.axis = -pair.lobe.axis;
    if (kind > 2 && kind < 5) pair.cone.axis = normalize(pair.lobe.axis + 0.1f * random.direction());
    if (kind == 5) pair.cone = pair.lobe;
    pairs.push_back(pair);
  }
  return pairs;
}

struct ProductDifferences {
  double mean, scale, light;
};

/// From LightColumns, which PreconvolvedEnvironment is filled by.
ProductDifferences differences(std::span<const SgPairMean> device, std::span<const SgPair> pairs,
                               std::span<const SgLight> lights) {
  detail::LightColumns columns;
  for (const SgLight& light : lights) columns.append(light);
  columns.pad();
  std::vector<vec3> cpu, gpu, light, cpu_light;
  std::vector<float> scales, cpu_scales;
  REQUIRE(device.size() == pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const SgProduct product = sg_product(pairs[i].lobe, pairs[i].cone);
    cpu.push_back(columns.mean(product.axis, product.sharpness)), gpu.push_back(device[i].mean);
    cpu_scales.push_back(product.scale), scales.push_back(device[i].scale);
    vec3 sum(0);
    for (const SgLight& l : lights)
      sum += sg_triple_product({l.axis, l.sharpness}, pairs[i].lobe, pairs[i].cone) * l.amplitude;
    cpu_light.push_back(sum), light.push_back(sg_pair_light(pairs[i], device[i]));
  }
  return {relative_rms(gpu, cpu), relative_rms_of(scales, cpu_scales), relative_rms(light, cpu_light)};
}

void check_products(SgProductShader& shader, std::span<const SgPair> pairs, std::span<const SgLight> lights) {
  shader.set_lights(lights);
  const ProductDifferences d = differences(shader.means(pairs), pairs, lights);
  MESSAGE("relative RMS difference of means " << d.mean << ", of scales " << d.scale
                                              << ", of triple products " << d.light);
  CHECK(d.mean < 1e-3);
  CHECK(d.scale < 1e-4);
  CHECK(d.light < 1e-3);
}

}  // namespace

TEST_CASE("the light under products of Gaussians of all sharpnesses is that of the CPU") {
  if (!has_device()) return;
  VulkanDevice device;
  SgProductShader shader(device);
  for (const std::size_t count : {1u, 10u, 800u}) {
    Random random(10 + count);
    const auto lights = random_lights(random, count);
    check_products(shader, random_pairs(random, 1500, lights), lights);
  }
}

TEST_CASE("no lights are dark under all products, and no pairs have no means") {
  if (!has_device()) return;
  VulkanDevice device;
  SgProductShader shader(device);
  Random random(11);
  const auto pairs = random_pairs(random, 100, {});
  const auto lights = random_lights(random, 50);
  shader.set_lights(lights);
  const auto lit = shader.means(pairs);
  CHECK(std::ranges::count(lit, vec3(0), &SgPairMean::mean) < 100);
  CHECK(shader.means({}).empty());
  CHECK(!shader.milliseconds());
  shader.set_lights({});
  const auto dark = shader.means(pairs);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    REQUIRE(dark[i].mean == vec3(0));
    REQUIRE(dark[i].scale == lit[i].scale);
  }
}

TEST_CASE("all that shines is found where lights are more than one kernel may meet") {
  if (!has_device()) return;
  VulkanDevice device;
  SgProductShader shader(device);
  Random random(12);
  const auto lights = random_lights(random, 70'000);
  check_products(shader, random_pairs(random, 20, lights), lights);
}

TEST_CASE("pieces of any size multiply to the same bits, as does a shader that has moved") {
  if (!has_device()) return;
  VulkanDevice device;
  Random random(13);
  const auto lights = random_lights(random, 30);
  const auto pairs = random_pairs(random, 200, lights);
  SgProductShader first(device);
  first.set_lights(lights);
  const auto all = first.means(pairs);
  SgProductShader whole(std::move(first));
  const auto same = [](const SgPairMean& a, const SgPairMean& b) {
    return a.mean == b.mean && a.scale == b.scale;
  };
  CHECK(std::ranges::equal(whole.means(pairs), all, same));
  for (const std::size_t piece : {1u, 64u, 199u}) {
    SgProductShader shader(device, piece);
    shader.set_lights(lights);
    CHECK(std::ranges::equal(shader.means(pairs), all, same));
  }
}

TEST_CASE("the device's clock tells that more lights take longer to multiply, where it has one") {
  if (!has_device()) return;
  VulkanDevice device;
  SgProductShader shader(device);
  Random random(14);
  const auto pairs = random_pairs(random, 2000, {});
  shader.set_lights(random_lights(random, 1));
  shader.means(pairs);
  if (!shader.milliseconds()) return;
  const double few = *shader.milliseconds();
  shader.set_lights(random_lights(random, 2000));
  shader.means(pairs);
  CHECK(few >= 0);
  CHECK(*shader.milliseconds() > few);
}

TEST_CASE("the validation layer has nothing to say of cones and products") {
  if (!has_device({.validation = true})) return;
  VulkanDevice device({.validation = true});
  Random random(15);
  const Cones cones(16, 50);
  ConeShader tracer(device);
  tracer.set_grid(cones.grid);
  CHECK(relative_rms_of(cones.on(tracer), cones.on_cpu(cones.grid, {})) < 1e-3);
  SgProductShader products(device);
  const auto lights = random_lights(random, 20);
  check_products(products, random_pairs(random, 50, lights), lights);
  for (const std::string& message : device.validation_messages()) FAIL_CHECK(message);
}
