// Packets of local lights against the closed forms of one light in double.
#include <doctest/doctest.h>

#include <coppice/reference/local.hpp>
#include <coppice/relight/local_light_packets.hpp>
#include <support/local_lights.hpp>

#include "relight/lights.hpp"

using namespace coppice;
using support::LightKind;
using support::random_local_lights;

namespace {

Receiver receiver_at(const vec3& position, const vec3& normal, float horizon = 0) {
  Receiver r;
  r.position = position, r.normal = normal, r.horizon = horizon;
  return r;
}

/// Rounding of an emission profile as a share: the cosine's, times the slope of a spot's ramp.
double emission_rounding(const LocalLight& light) { return 1e-6 * (1 + 2 * double(length(light.axis))); }

}  // namespace

TEST_CASE("what arrives of each light equals its closed form, for every kind of light") {
  Random random(1);
  const auto lights = random_local_lights(random, 203);
  const LocalLightPackets packets(lights);
  CHECK(packets.count() == 203);
  CHECK(packets.packet_count() == 13);
  for (int i = 0; i < 20; ++i) {
    const vec3 point = 3.0f * support::in_box(random), normal = random.direction();
    for (std::uint32_t l = 0; l < packets.count(); ++l) {
      const auto expected = reference::arriving(lights[l], point);
      const double full =
          1 / std::max(1e-9, glm::dot(expected.direction, expected.direction)) *
          (expected.share + 1 / std::pow(length(lights[l].position - lights[l].w * point), 2));
      const double tolerance = 1e-5 * expected.share + emission_rounding(lights[l]) * full;
      CHECK(std::abs(double(packets.geometry(l, point)) - expected.share) <= tolerance);
      const double cosine = std::max(0.0, glm::dot(expected.direction, glm::dvec3(normal)));
      CHECK(std::abs(double(packets.irradiance_share(l, point, normal)) - expected.share * cosine) <=
            2 * tolerance + 1e-6 * full);
    }
  }
}

TEST_CASE("rays are aimed at lights and end before them; those at distant lights do not end") {
  Random random(2);
  const auto lights = random_local_lights(random, 40);
  const LocalLightPackets packets(lights);
  const vec3 origin(0.3f, -2, 0.7f);
  for (std::uint32_t l = 0; l < 40; ++l) {
    ShadowPacket rays = packet_from(origin);
    packets.aim(l / 16, origin, rays);
    const std::uint32_t i = l % 16;
    const vec3 d(rays.direction_x[i], rays.direction_y[i], rays.direction_z[i]);
    const auto expected = reference::arriving(lights[l], origin);
    CHECK(length(d - vec3(expected.direction)) < 1e-6f);
    if (lights[l].w == 0) {
      CHECK(rays.t_max[i] == std::numeric_limits<float>::infinity());
      continue;
    }
    CHECK(rays.t_max[i] < expected.distance);
    CHECK(rays.t_max[i] > 0.9998 * expected.distance);
  }
}

TEST_CASE("distant lights are the same from everywhere") {
  const std::vector<LocalLight> lights{distant_light(vec3(0.6f, 0.8f, 0), vec3(2), 50)};
  const LocalLightPackets packets(lights);
  const float share = packets.geometry(0, vec3(0));
  CHECK(share * lights[0].intensity.x == doctest::Approx(2));
  for (const vec3& p : {vec3(1, 2, 3), vec3(-1e6f, 1e5f, 7)}) CHECK(packets.geometry(0, p) == share);
}

TEST_CASE("worth tracing are the lights above the horizon that shine towards the receiver") {
  Random random(3);
  const auto lights = random_local_lights(random, 100);
  const LocalLightPackets packets(lights);
  int worth = 0, not_worth = 0;
  for (int i = 0; i < 30; ++i) {
    const Receiver r = receiver_at(support::in_box(random), random.direction(), -0.3f * random.uniform());
    for (std::uint32_t l = 0; l < 112; ++l) {
      const bool is_worth = packets.worth_tracing(l / 16, r) >> (l % 16) & 1;
      if (l >= 100) {
        CHECK_FALSE(is_worth);
        continue;
      }
      const auto expected = reference::arriving(lights[l], r.position);
      const double above = glm::dot(expected.direction, glm::dvec3(r.normal)) - r.horizon;
      if (std::abs(above) < 1e-6 || (expected.share > 0 && expected.share < 1e-6)) continue;
      CHECK(is_worth == (above > 0 && expected.share > 0));
      (is_worth ? worth : not_worth)++;
    }
  }
  CHECK(worth > 300);
  CHECK(not_worth > 300);
}

TEST_CASE("a light at the point itself gives nothing, and no NaN") {
  const vec3 place(1, 2, 3);
  const std::vector<LocalLight> lights{point_light(place, vec3(1)),
                                       surface_light(place, vec3(0, 1, 0), vec3(1), 0.1f)};
  const LocalLightPackets packets(lights);
  ShadowPacket rays = packet_from(place);
  packets.aim(0, place, rays);
  CHECK(packets.worth_tracing(0, receiver_at(place, vec3(0, 1, 0), -1)) == 0);
  for (std::uint32_t l = 0; l < 2; ++l) {
    CHECK(packets.geometry(l, place) == 0);
    CHECK(packets.irradiance_share(l, place, vec3(0, 1, 0)) == 0);
    CHECK(rays.direction_x[l] == 0);
    CHECK(rays.t_max[l] == 0);
  }
}

TEST_CASE("the leaves of a tree hold its lights, and padding that is never worth a ray") {
  Random random(4);
  const auto lights = random_local_lights(random, 21);
  LightTree tree;
  tree.light_of_leaf.assign(32, no_light);
  for (std::uint32_t l = 0; l < 21; ++l) tree.light_of_leaf[31 - l] = l;
  const auto leaves = leaf_lights(tree, lights);
  REQUIRE(leaves.size() == 32);
  const LocalLightPackets packets(leaves);
  for (std::uint32_t leaf = 0; leaf < 32; ++leaf) {
    if (leaf > 10) {
      CHECK(leaves[leaf].position == lights[31 - leaf].position);
      continue;
    }
    CHECK(packets.geometry(leaf, vec3(1)) == 0);
    CHECK((packets.worth_tracing(0, receiver_at(vec3(1), vec3(0, 1, 0), -1)) >> leaf & 1) == 0);
  }
}

TEST_CASE("lights that are off are traced as if they were on, so that they can be switched on") {
  const std::vector<LocalLight> lights{point_light(vec3(0, 2, 0), vec3(0))};
  const LocalLightPackets packets(lights);
  CHECK(packets.luminance_of(0) == 0);
  CHECK(packets.geometry(0, vec3(0)) == 0.25f);
  CHECK(packets.worth_tracing(0, receiver_at(vec3(0), vec3(0, 1, 0))) == 1);
}

TEST_CASE("an edge has no error where V·G is linear, half where its ends disagree, and none without light") {
  const std::vector<LocalLight> lights{point_light(vec3(0, 1000, 0), vec3(1))};
  const LocalLightPackets packets(lights);
  const std::uint64_t seen = 1, hidden = 0;
  const auto error = [&](std::uint64_t a, std::uint64_t b, std::uint64_t middle) {
    return edge_error(packets, vec3(0, 1, 0), {vec3(-1, 0, 0), {&a, 1}}, {vec3(1, 0, 0), {&b, 1}},
                      {vec3(0), {&middle, 1}});
  };
  CHECK(error(seen, seen, seen) < 1e-5);
  CHECK(error(hidden, hidden, hidden) == 0);
  CHECK(error(seen, hidden, seen) == doctest::Approx(0.5 / 1.1));
  CHECK(error(seen, hidden, hidden) == doctest::Approx(0.5 / 1.1));
  CHECK(error(seen, seen, hidden) == doctest::Approx(1 / 1.1).epsilon(1e-4));
  CHECK(error(hidden, hidden, seen) == doctest::Approx(1 / 1.1));
  const std::vector<LocalLight> near{point_light(vec3(0, 1, 0), vec3(1))};
  const LocalLightPackets near_packets(near);
  const double off = edge_error(near_packets, vec3(0, 1, 0), {vec3(-1, 0, 0), {&seen, 1}},
                                {vec3(1, 0, 0), {&seen, 1}}, {vec3(0), {&seen, 1}});
  CHECK(off == doctest::Approx(0.5 / 1.1));  // 1/2 at both ends, 1 between them
}
