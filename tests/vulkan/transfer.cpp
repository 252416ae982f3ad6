// The kernels of moving lights against the CPU: visibility, direct light at samples, and indirect light.
#include <coppice/vulkan/transfer_shader.hpp>
//
#include <doctest/doctest.h>

#include <cmath>
#include <coppice/transfer/sample_lighting.hpp>
#include <numeric>

#include "random_input.hpp"
#include "support/executors.hpp"

using namespace coppice;
using namespace coppice::test;

namespace {

using Sizes = std::vector<std::uint32_t>;

/// Clusters of many sizes, some of them empty.
const Sizes mixed{1, 1000, 0, 3, 64, 0, 255, 257, 2, 5, 0};

Sizes ends_of(const Sizes& sizes) {
  Sizes ends(sizes.size());
  std::partial_sum(sizes.begin(), sizes.end(), ends.begin());
  return ends;
}

std::vector<std::int8_t> random_bytes(Random& random, std::size_t count) {
  std::vector<std::int8_t> bytes(count);
  for (auto& b : bytes) b = std::int8_t(int(random.below(255)) - 127);
  return bytes;
}

std::vector<float> random_floats(Random& random, std::size_t count, float scale) {
  std::vector<float> values(count);
  for (float& x : values) x = scale * random.uniform();
  return values;
}

/// One lattice point in three has no row in a cluster.
FeatureIndex random_index(Random& random, std::uint32_t points) {
  FeatureIndex index;
  index.bits.assign((points + 31) / 32, 0);
  for (std::uint32_t p = 0; p < points; ++p)
    if (random.below(3) > 0) index.bits[p / 32] |= 1u << (p % 32);
  std::uint32_t rows = 0;
  for (const std::uint32_t word : index.bits) {
    index.before.push_back(rows);
    rows += std::uint32_t(std::popcount(word));
  }
  return index;
}

std::size_t row_count(const FeatureIndex& index) {
  std::size_t rows = 1;
  for (const std::uint32_t word : index.bits) rows += std::size_t(std::popcount(word));
  return rows;
}

LatticeVisibility<std::int8_t> random_visibility(Random& random, const Sizes& sizes, std::size_t rank,
                                                 std::uint32_t points) {
  LatticeVisibility<std::int8_t> result;
  result.rank = rank;
  result.ends = ends_of(sizes);
  for (const std::uint32_t size : sizes) {
    LatticeCluster<std::int8_t> cluster;
    cluster.index = random_index(random, points);
    cluster.scales = random_floats(random, rank, 1e-4f);
    cluster.coefficients = random_bytes(random, rank * size);
    cluster.rows = random_bytes(random, rank * row_count(cluster.index));
    result.clusters.push_back(std::move(cluster));
  }
  return result;
}

/// One point in five has no corners, but for the first.
std::vector<LatticeCorners> random_corners(Random& random, std::size_t count, std::uint32_t points) {
  std::vector<LatticeCorners> result(count);
  for (std::size_t i = 0; i < count; ++i) {
    LatticeCorners& corners = result[i];
    if (i > 0 && random.below(5) == 0) continue;
    corners.count = 1 + random.below(8);
    float sum = 0;
    for (std::uint32_t c = 0; c < corners.count; ++c) {
      corners.points[c] = random.below(points);
      sum += corners.weights[c] = 0.01f + random.uniform();
    }
    for (std::uint32_t c = 0; c < corners.count; ++c) corners.weights[c] /= sum;
  }
  return result;
}

ClusterFields<std::int8_t> random_fields(Random& random, const Sizes& sizes, std::uint32_t most) {
  ClusterFields<std::int8_t> fields;
  fields.first.push_back(0);
  for (const std::uint32_t size : sizes) {
    for (std::uint32_t f = random.below(most + 1); f > 0; --f) {
      fields.first.push_back(fields.first.back() + size);
      fields.scales.push_back(0.01f * random.uniform());
    }
    fields.ends.push_back(std::uint32_t(fields.count()));
  }
  fields.values = random_bytes(random, fields.first.back());
  return fields;
}

enum class Basis { plain, offsets, offsets_and_mean };

/// Clusters have 0 to so many coefficients and patterns.
LightTransfer<std::int8_t> random_transfer(Random& random, const Sizes& sizes, std::uint32_t coefficients,
                                           std::uint32_t patterns, Basis basis = Basis::plain) {
  LightTransfer<std::int8_t> result;
  result.sample_ends = ends_of(sizes);
  result.projection = random_fields(random, sizes, coefficients);
  result.patterns = random_fields(random, sizes, patterns);
  if (basis != Basis::plain) result.offsets = random_floats(random, result.projection.count(), 1);
  const std::size_t width = result.projection.count() + (basis == Basis::offsets_and_mean ? 1 : 0);
  for (auto& matrix : result.mix) {
    matrix.width = width;
    matrix.values = random_bytes(random, width * result.patterns.count());
    matrix.scales = random_floats(random, result.patterns.count(), 0.01f);
  }
  return result;
}

std::vector<vec3> random_light(Random& random, std::size_t count) {
  std::vector<vec3> light(count);
  for (vec3& x : light) x = random.below(3) == 0 ? vec3(0) : random_colour(random);
  return light;
}

/// Of all numbers together; 0 where both are 0 throughout.
template <class T>
double relative_rms_of(const std::vector<T>& a, const std::vector<T>& reference) {
  REQUIRE(a.size() == reference.size());
  double difference = 0, total = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const vec3 x(a[i]), y(reference[i]);
    difference += double(dot(x - y, x - y));
    total += double(dot(y, y));
  }
  return difference == 0 ? 0 : std::sqrt(difference / total);
}

template <class T>
bool is_dark(const std::vector<T>& light) {
  return std::ranges::all_of(light, [](const T& x) { return x == T(0); });
}

std::vector<float> on_cpu(const LatticeVisibility<std::int8_t>& visibility,
                          std::span<const LatticeCorners> points, LatticeShadow shadow) {
  std::vector<float> out(visibility.size(), -1);
  REQUIRE(lattice_visibility(visibility, points, shadow, Serial(), out));
  return out;
}

std::vector<float> on(LatticeVisibilityShader& shader, std::size_t count,
                      std::span<const LatticeCorners> points, LatticeShadow shadow) {
  std::vector<float> out(count, -1);
  REQUIRE(shader.visibility(points, shadow, out));
  return out;
}

std::vector<vec3> on_cpu(const LightTransfer<std::int8_t>& transfer, std::span<const vec3> direct,
                         const vec3& intensity = vec3(1)) {
  std::vector<vec3> out(direct.size(), vec3(-1));
  indirect_irradiance(transfer, direct, Serial(), out, intensity);
  return out;
}

std::vector<vec3> on(LightTransferShader& shader, std::span<const vec3> direct,
                     const vec3& intensity = vec3(1)) {
  std::vector<vec3> out(direct.size(), vec3(-1));
  shader.indirect(direct, out, intensity);
  return out;
}

/// The same, but for hard decisions of one point in 10,000 samples, or one, that rounding decides.
void check_visibility(const LatticeVisibility<std::int8_t>& visibility, LatticeVisibilityShader& shader,
                      std::span<const LatticeCorners> points) {
  const std::size_t count = visibility.size();
  const auto smooth = on_cpu(visibility, points, LatticeShadow::smooth);
  CHECK(relative_rms_of(on(shader, count, points, LatticeShadow::smooth), smooth) < 1e-5);
  const auto hard = on_cpu(visibility, points, LatticeShadow::hard);
  const auto device = on(shader, count, points, LatticeShadow::hard);
  double decisions = 0;
  for (std::size_t i = 0; i < count; ++i) {
    REQUIRE(std::abs(hard[i] - device[i]) < 1.5f / float(points.size()) + 1e-5f);
    decisions += double(std::abs(hard[i] - device[i])) * double(points.size());
  }
  CHECK(decisions <= 1 + 1e-4 * double(count * points.size()));
}

std::vector<SurfaceSample> random_samples(Random& random, std::size_t count) {
  std::vector<SurfaceSample> samples(count);
  for (SurfaceSample& s : samples) {
    s.position = 4.0f * random_colour(random);
    s.normal = random.direction();
  }
  return samples;
}

/// Points, spots and small surfaces in the room, and one far away.
LocalLight random_local_light(Random& random, std::uint32_t kind) {
  const vec3 place = 4.0f * random_colour(random), colour = random_colour(random);
  if (kind % 4 == 0) return point_light(place, colour);
  if (kind % 4 == 1) return spot_light(place, colour, random.direction(), 0.3f, 1.2f);
  if (kind % 4 == 2) return surface_light(place, random.direction(), colour, 0.5f);
  return distant_light(random.direction(), colour, 10);
}

struct RandomFrame {
  Sizes sizes = mixed;
  std::uint32_t lattice_points = 500;
  LatticeVisibility<std::int8_t> visibility;
  LightTransfer<std::int8_t> transfer;
  std::vector<SurfaceSample> samples;
  std::vector<std::vector<LatticeCorners>> corners;
  std::vector<PlacedLight> lights;

  RandomFrame(Random& random, std::uint32_t light_count) {
    visibility = random_visibility(random, sizes, 20, lattice_points);
    transfer = random_transfer(random, sizes, 12, 10, Basis::offsets_and_mean);
    samples = random_samples(random, visibility.size());
    for (std::uint32_t l = 0; l < light_count; ++l)
      corners.push_back(random_corners(random, l % 2 == 0 ? 1 : 25, lattice_points));
    for (std::uint32_t l = 0; l < light_count; ++l)
      lights.push_back({random_local_light(random, l), corners[l]});
  }

  std::vector<vec3> direct_on_cpu(LatticeShadow shadow, float softening) const {
    std::vector<vec3> direct(samples.size(), vec3(0));
    std::vector<float> grey(samples.size());
    for (const PlacedLight& light : lights) {
      const auto seen = on_cpu(visibility, light.points, shadow);
      light_by_visibility(samples, light.light, seen, softening, Serial(), grey);
      for (std::size_t i = 0; i < grey.size(); ++i) direct[i] += grey[i] * light.light.intensity;
    }
    return direct;
  }
  vec3 intensity() const {
    vec3 sum(0);
    for (const PlacedLight& light : lights) sum += light.light.intensity;
    return sum;
  }
};

}  // namespace

TEST_CASE("lights in a lattice are as visible on the device as on the CPU, one after the other") {
  if (!has_device()) return;
  VulkanDevice device;
  Random random(21);
  for (const std::size_t rank : {1u, 5u, 40u}) {
    CAPTURE(rank);
    const auto visibility = random_visibility(random, mixed, rank, 700);
    LatticeVisibilityShader shader(device, visibility);
    for (const std::size_t points : {1u, 2u, 4u, 25u, 3u}) {
      CAPTURE(points);
      check_visibility(visibility, shader, random_corners(random, points, 700));
    }
  }
}

TEST_CASE("more products than one dispatch may sum up go on in the next") {
  if (!has_device()) return;
  VulkanDevice device;
  Random random(22);
  const std::size_t rank = 700, points = 4 * (LATTICE_TERMS_PER_DISPATCH / rank) * 2 + 5;
  const auto visibility = random_visibility(random, {3, 70}, rank, 90);
  LatticeVisibilityShader shader(device, visibility);
  check_visibility(visibility, shader, random_corners(random, points, 90));
  check_visibility(visibility, shader, random_corners(random, LATTICE_POINTS, 90));
}

TEST_CASE("a light that no lattice point serves is told on the device, and nothing is written") {
  if (!has_device()) return;
  VulkanDevice device;
  Random random(23);
  const auto visibility = random_visibility(random, {4, 9}, 3, 40);
  LatticeVisibilityShader shader(device, visibility);
  std::vector<float> out(13, 7);
  CHECK(!shader.visibility({}, LatticeShadow::hard, out));
  CHECK(!shader.visibility(std::vector<LatticeCorners>(3), LatticeShadow::smooth, out));
  CHECK(!shader.milliseconds());
  CHECK(std::ranges::all_of(out, [](float x) { return x == 7; }));
}

TEST_CASE("a visibility of rank 0 hides all, or half of it where it is smooth") {
  if (!has_device()) return;
  VulkanDevice device;
  Random random(24);
  const auto visibility = random_visibility(random, mixed, 0, 40);
  LatticeVisibilityShader shader(device, visibility);
  const auto points = random_corners(random, 6, 40);
  check_visibility(visibility, shader, points);
  CHECK(is_dark(on(shader, visibility.size(), points, LatticeShadow::hard)));
}

TEST_CASE("no samples have no visibility and no light, and no lattice serves nobody") {
  if (!has_device()) return;
  VulkanDevice device;
  Random random(25);
  for (const Sizes& sizes : {Sizes{}, Sizes{0, 0}}) {
    const auto visibility = random_visibility(random, sizes, 3, 40);
    LatticeVisibilityShader seen(device, visibility);
    const auto points = random_corners(random, 2, 40);
    CHECK(seen.visibility(points, LatticeShadow::hard, {}));
    const auto fields = random_transfer(random, sizes, 4, 4);
    LightTransferShader transfer(device, fields);
    transfer.indirect({}, {});
    LightFrameShader frame(device, seen, transfer, {});
    const PlacedLight light{point_light(vec3(0), vec3(1)), points};
    CHECK(frame.light(std::span(&light, 1), LatticeShadow::hard, {}));
  }
  const LatticeVisibility<std::int8_t> nothing;
  LatticeVisibilityShader shader(device, nothing);
  CHECK(!shader.visibility(std::vector<LatticeCorners>(1), LatticeShadow::hard, {}));
}

TEST_CASE("indirect light is the CPU's on the device, for all bases and sizes of clusters") {
  if (!has_device()) return;
  VulkanDevice device;
  Random random(26);
  for (const Basis basis : {Basis::plain, Basis::offsets, Basis::offsets_and_mean})
    for (const Sizes& sizes : {Sizes{1}, Sizes{1000}, mixed, Sizes{40, 70, 13}}) {
      const auto transfer = random_transfer(random, sizes, 20, 20, basis);
      LightTransferShader shader(device, transfer);
      for (int frame = 0; frame < 3; ++frame) {
        const auto direct = random_light(random, transfer.sample_count());
        const vec3 intensity = 5.0f * random_colour(random);
        CHECK(relative_rms_of(on(shader, direct, intensity), on_cpu(transfer, direct, intensity)) < 1e-5);
      }
    }
}

TEST_CASE("without coefficients or without patterns there is no indirect light") {
  if (!has_device()) return;
  VulkanDevice device;
  Random random(27);
  for (const auto& [coefficients, patterns] : {std::pair(0u, 9u), std::pair(9u, 0u), std::pair(0u, 0u)}) {
    const auto transfer = random_transfer(random, mixed, coefficients, patterns);
    LightTransferShader shader(device, transfer);
    const auto direct = random_light(random, transfer.sample_count());
    CHECK(is_dark(on_cpu(transfer, direct)));
    CHECK(is_dark(on(shader, direct)));
  }
}

TEST_CASE("the mean alone lights a room whose centred bases have no vectors") {
  if (!has_device()) return;
  VulkanDevice device;
  Random random(28);
  const auto transfer = random_transfer(random, {30, 50}, 0, 30, Basis::offsets_and_mean);
  REQUIRE(transfer.coefficient_count() == 1);
  REQUIRE(transfer.pattern_count() > 0);
  LightTransferShader shader(device, transfer);
  const auto direct = random_light(random, 80);
  const auto cpu = on_cpu(transfer, direct, vec3(1, 2, 3));
  CHECK(!is_dark(cpu));
  CHECK(relative_rms_of(on(shader, direct, vec3(1, 2, 3)), cpu) < 1e-5);
}

TEST_CASE(
    "light that is not a number stays one on the device, in its channel and on no other cluster's behalf") {
  if (!has_device()) return;
  VulkanDevice device;
  Random random(29);
  auto transfer = random_transfer(random, {5, 6}, 8, 8);
  while (transfer.projection.end(1) == transfer.projection.begin(1) ||
         transfer.patterns.end(0) == transfer.patterns.begin(0))
    transfer = random_transfer(random, {5, 6}, 8, 8);
  LightTransferShader shader(device, transfer);
  auto direct = random_light(random, 11);
  // The first sample of the second cluster, which shares a quad of words with none of the first's fields.
  direct[5].y = std::numeric_limits<float>::quiet_NaN();
  const auto lit = on(shader, direct), cpu = on_cpu(transfer, direct);
  for (std::size_t i = 0; i < lit.size(); ++i) {
    CHECK(std::isnan(lit[i].y) == std::isnan(cpu[i].y));
    CHECK((std::isfinite(lit[i].x) && std::isfinite(lit[i].z)));
  }
  CHECK(std::isnan(lit[0].y));
  // No field of the second cluster: nothing may be read beyond the first.
  transfer.projection.ends[1] = transfer.projection.ends[0];
  transfer.projection.scales.resize(transfer.projection.ends[0]);
  transfer.projection.first.resize(transfer.projection.ends[0] + 1);
  transfer.projection.values.resize(transfer.projection.first.back());
  for (auto& matrix : transfer.mix) {
    matrix.width = transfer.projection.count();
    matrix.values = random_bytes(random, matrix.width * matrix.count());
  }
  LightTransferShader first(device, transfer);
  for (const vec3& x : on(first, direct)) CHECK(std::isfinite(x.y));
}

TEST_CASE("a frame from lights alone is the CPU's: hard and smooth, softened or not, one light and many") {
  if (!has_device()) return;
  VulkanDevice device;
  Random random(30);
  for (const std::uint32_t light_count : {1u, 7u}) {
    const RandomFrame frame(random, light_count);
    LatticeVisibilityShader visibility(device, frame.visibility);
    LightTransferShader transfer(device, frame.transfer);
    for (const float softening : {0.0f, 0.7f}) {
      LightFrameShader shader(device, visibility, transfer, frame.samples, softening);
      std::vector<vec3> direct(frame.samples.size()), indirect(direct), alone(direct);
      for (const LatticeShadow shadow : {LatticeShadow::smooth, LatticeShadow::hard}) {
        REQUIRE(shader.light(frame.lights, shadow, indirect, direct));
        const auto cpu = frame.direct_on_cpu(shadow, softening);
        CHECK(relative_rms_of(direct, cpu) < (shadow == LatticeShadow::hard ? 1e-3 : 1e-5));
        CHECK(relative_rms_of(indirect, on_cpu(frame.transfer, direct, frame.intensity())) < 1e-5);
        REQUIRE(shader.light(frame.lights, shadow, alone));
        CHECK(alone == indirect);
      }
    }
  }
}

TEST_CASE("a frame without lights is black, and one with a light that is not served is refused") {
  if (!has_device()) return;
  VulkanDevice device;
  Random random(31);
  RandomFrame frame(random, 3);
  LatticeVisibilityShader visibility(device, frame.visibility);
  LightTransferShader transfer(device, frame.transfer);
  LightFrameShader shader(device, visibility, transfer, frame.samples);
  std::vector<vec3> direct(frame.samples.size(), vec3(7)), indirect(direct);
  const std::vector<LatticeCorners> outside(2);
  frame.lights[1].points = outside;
  CHECK(!shader.light(frame.lights, LatticeShadow::hard, indirect, direct));
  CHECK(direct.front() == vec3(7));
  CHECK(indirect.back() == vec3(7));
  CHECK(shader.light({}, LatticeShadow::hard, indirect, direct));
  CHECK(is_dark(direct));
  CHECK(is_dark(indirect));
}

TEST_CASE("shaders that have moved, and frames that took turns with single calls, give the same bits") {
  if (!has_device()) return;
  VulkanDevice device;
  Random random(32);
  const RandomFrame frame(random, 4);
  LatticeVisibilityShader visibility(device, frame.visibility);
  LightTransferShader transfer(device, frame.transfer);
  LightFrameShader shader(device, visibility, transfer, frame.samples);
  std::vector<vec3> direct(frame.samples.size()), first(direct), second(direct);
  REQUIRE(shader.light(frame.lights, LatticeShadow::hard, first, direct));
  LatticeVisibilityShader moved(std::move(visibility));
  LightTransferShader moved_too(std::move(transfer));
  const auto seen = on(moved, direct.size(), frame.corners[1], LatticeShadow::hard);
  CHECK(on(moved, direct.size(), frame.corners[1], LatticeShadow::hard) == seen);
  CHECK(on(moved_too, direct, frame.intensity()) == first);
  LightFrameShader moved_frame(std::move(shader));
  REQUIRE(moved_frame.light(frame.lights, LatticeShadow::hard, second));
  CHECK(second == first);
}

TEST_CASE("the light of a sample is that of light_by_visibility, near and far, above the horizon and below") {
  Random random(33);
  const auto samples = random_samples(random, 300);
  const std::vector<float> seen(samples.size(), 1);
  std::vector<float> cpu(samples.size());
  for (std::uint32_t kind = 0; kind < 8; ++kind) {
    LocalLight light = random_local_light(random, kind);
    if (kind >= 4 && light.w > 0) light.position = samples[0].position + 1e-3f * samples[0].normal;
    light_by_visibility(samples, light, seen, 0.5f, Serial(), cpu);
    const SampleLight shared{light.position,  light.w,      light.axis,      light.offset,
                             light.intensity, light.square, light.area / pi, 0.25f};
    std::size_t lit = 0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const float value = sample_irradiance(shared, samples[i].position, samples[i].normal);
      CHECK(value == doctest::Approx(cpu[i]).epsilon(1e-5));
      lit += value > 0;
    }
    CHECK(lit > 20);
  }
}

TEST_CASE("the device's clock tells the stages of a frame, where it has one") {
  if (!has_device()) return;
  VulkanDevice device;
  Random random(34);
  const RandomFrame frame(random, 2);
  LatticeVisibilityShader visibility(device, frame.visibility);
  LightTransferShader transfer(device, frame.transfer);
  LightFrameShader shader(device, visibility, transfer, frame.samples);
  std::vector<vec3> direct(frame.samples.size()), indirect(direct);
  CHECK(!shader.times());
  REQUIRE(shader.light(frame.lights, LatticeShadow::hard, indirect, direct));
  on(transfer, direct);
  on(visibility, direct.size(), frame.corners[1], LatticeShadow::hard);
  if (!shader.times()) return;
  CHECK(shader.times()->direct > 0);
  CHECK(shader.times()->projection > 0);
  REQUIRE(transfer.times());
  CHECK(transfer.times()->direct == 0);
  CHECK(transfer.times()->mix > 0);
  CHECK(transfer.times()->expansion > 0);
  REQUIRE(visibility.milliseconds());
  CHECK(*visibility.milliseconds() > 0);
}

TEST_CASE("the validation layer has nothing to say of moving lights") {
  if (!has_device({.validation = true})) return;
  VulkanDevice device({.validation = true});
  Random random(35);
  const RandomFrame frame(random, 3);
  LatticeVisibilityShader visibility(device, frame.visibility);
  LightTransferShader transfer(device, frame.transfer);
  LightFrameShader shader(device, visibility, transfer, frame.samples);
  std::vector<vec3> direct(frame.samples.size()), indirect(direct);
  CHECK(shader.light(frame.lights, LatticeShadow::hard, indirect, direct));
  check_visibility(frame.visibility, visibility, frame.corners[1]);
  CHECK(relative_rms_of(on(transfer, direct), on_cpu(frame.transfer, direct)) < 1e-5);
  for (const std::string& message : device.validation_messages()) FAIL_CHECK(message);
}
