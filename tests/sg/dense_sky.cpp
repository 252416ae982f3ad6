// The environment as lights that are all summed, and which of them a receiver sees.
#include "sg/skies.hpp"
//
#include <doctest/doctest.h>

#include <coppice/reference/dense.hpp>
#include <coppice/relight/brute_force.hpp>
#include <coppice/sg/dense_sky.hpp>

#include "support/occluders.hpp"

using namespace coppice;
using namespace sg_test;
using namespace test_support;

namespace {

std::span<const LightNode> leaves_of(const FrameLighting& frame) {
  return std::span(frame.nodes).subspan(frame.nodes.size() / 2);
}

glm::dvec3 energy_of(const FrameLighting& frame) {
  glm::dvec3 sum(0);
  for (const LightNode& leaf : leaves_of(frame)) sum += glm::dvec3(leaf.power);
  return sum;
}

vec3 shine(const ShadingPoint& p, const FrameLighting& frame) {
  const auto count = std::uint32_t(frame.nodes.size() / 2);
  const DenseLights lights(count, frame);
  const std::vector<std::uint64_t> all(words_for_bits(count), ~std::uint64_t{0});
  ShadingPoint q = p;
  q.weight_0 = 1, q.weight_1 = 0;
  return shade_brute_force<Skip::nothing>(q, lights, all, all, all);
}

}  // namespace

TEST_CASE("the lights have the energy of the map, and are a power of two") {
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    Random random(seed);
    const Image map = seed == 0 ? random_map(random, 64, 32) : some_map(random, 64, 32, 5);
    const FrameLighting frame = dense_sky(map, 1000);
    CHECK(apart(energy_of(frame), sg_test::energy_of(map)) < 1e-5);
    CHECK(std::has_single_bit(frame.nodes.size()));
    for (const LightNode& leaf : leaves_of(frame)) {
      CHECK(std::abs(length(leaf.direction) - 1) < 1e-5f);
      CHECK(is_never_negative(leaf.power));
    }
  }
}

TEST_CASE("every bright texel is a light of its own where it is") {
  Image map(64, 32, vec3(1));
  const int places[3][2] = {{3, 4}, {40, 15}, {63, 31}};
  for (const auto& [x, y] : places) map.at(x, y) = vec3(1e5f, 1e4f, 1e3f);
  const FrameLighting frame = dense_sky(map, 500);
  for (const auto& [x, y] : places) {
    const vec3 d = texel_direction(x, y, 64, 32);
    const auto found = std::ranges::find_if(leaves_of(frame), [&](const LightNode& l) {
      return l.direction == d && l.power.x > 10 * l.power.y / 2;
    });
    REQUIRE(found != leaves_of(frame).end());
    CHECK(apart(glm::dvec3(found->power), texel_solid_angle(y, 64, 32) * glm::dvec3(map.at(x, y))) < 1e-6);
  }
}

TEST_CASE("a bright texel that is wider than a cell shines from all of its cells") {
  Image map(8, 4, vec3(1));
  map.at(5, 1) = vec3(1000);
  const FrameLighting frame = dense_sky(map, 1000);
  int bright = 0;
  for (const LightNode& leaf : leaves_of(frame)) {
    if (leaf.power.x < 4 * pi / 1000 * 100) continue;
    ++bright;
    CHECK(leaf.power.x < 4 * pi / 1000 * 1000 * 1.5f);
    CHECK(dot(leaf.direction, texel_direction(5, 1, 8, 4)) > 0.8f);
  }
  CHECK(bright > 30);
  CHECK(apart(energy_of(frame), sg_test::energy_of(map)) < 1e-5);
}

TEST_CASE("a black map gives dark lights; one of 1e30, and of one texel, finite ones") {
  CHECK(energy_of(dense_sky(Image(16, 8), 100)) == glm::dvec3(0));
  CHECK(apart(energy_of(dense_sky(Image(1, 1, vec3(1)), 100)), 4 * std::numbers::pi * glm::dvec3(1)) < 1e-6);
  Image huge(16, 8, vec3(1));
  huge.at(5, 5) = vec3(1e30f);
  const FrameLighting frame = dense_sky(huge, 100);
  for (const LightNode& leaf : leaves_of(frame)) CHECK(is_finite(leaf.power));
  CHECK(apart(energy_of(frame), sg_test::energy_of(huge)) < 1e-5);
}

TEST_CASE("under an even sky a plane without occluders shines with its albedo") {
  const FrameLighting frame = dense_sky(Image(32, 16, vec3(1)), 16384);
  ShadingPoint p{};
  p.normal = p.to_viewer = normalize(vec3(0.3f, 1, 0.2f));
  vec3 bitangent;
  make_frame(p.normal, p.tangent, bitangent);
  set_lambert(p, vec3(1));
  CHECK(length(shine(p, frame) - vec3(1)) < 2e-3f);
  p.brdf = BRDF_GGX, p.diffuse = vec3(0), p.specular = p.fresnel = vec3(1), p.alpha_x = p.alpha_y = 0.25f;
  const float albedo = shine(p, frame).x;
  CHECK(albedo > 0.85f);
  CHECK(albedo < 0.98f);
}

TEST_CASE("the sum over the lights is that of the slow twin") {
  Random random(4);
  const FrameLighting frame = dense_sky(some_map(random, 32, 16), 300);
  std::vector<vec3> directions, powers;
  for (const LightNode& leaf : leaves_of(frame))
    directions.push_back(leaf.direction), powers.push_back(leaf.power);
  const std::vector<float> visible(powers.size(), 1.0f);
  for (const ShadingPoint& p : points_of_all_materials(3, random))
    CHECK(apart(glm::dvec3(shine(p, frame)),
                glm::dvec3(reference::dense_radiance(p, directions, powers, visible))) < 1e-4);
}

TEST_CASE("a light is seen where it shines above both horizons and nothing is in the way") {
  Random random(5);
  const support::SphereOccluder balls{{{vec3(1, 1, 0), 0.8f}, {vec3(-1, 2, 0.5f), 0.9f}}};
  Image map = some_map(random, 32, 16);
  for (int x = 0; x < 32; ++x) map.at(x, 3) = vec3(0);
  const FrameLighting frame = dense_sky(map, 700);
  const auto count = std::uint32_t(frame.nodes.size() / 2);
  const DenseLights lights(count, frame);
  std::vector<std::uint64_t> bits(words_for_bits(count), ~std::uint64_t{0});
  for (const float rotation : {0.0f, 1.1f}) {
    const MapFrame turn(rotation);
    ConeReceiver receiver{vec3(0), 0, vec3(0, 1, 0), 0, normalize(vec3(0.4f, 1, -0.3f))};
    see_lights(lights, turn, receiver, balls, bits);
    std::size_t seen = 0, hidden = 0, below = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
      const LightNode& leaf = leaves_of(frame)[i];
      const vec3 d = turn.to_world(leaf.direction);
      const bool is_above = dot(d, receiver.normal) > 0 && dot(d, receiver.shading_normal) > 0;
      const bool is_free = !balls.occluded(receiver.position, d, std::numeric_limits<float>::infinity());
      const bool is_seen = leaf.power != vec3(0) && is_above && is_free;
      REQUIRE((((bits[i / 64] >> (i % 64)) & 1) != 0) == is_seen);
      seen += is_seen, hidden += !is_free, below += !is_above;
    }
    CHECK(seen > 100);
    CHECK(hidden > 20);
    CHECK(below > 100);
  }
}
