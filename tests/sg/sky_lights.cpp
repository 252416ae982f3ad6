// Maps as light trees and peaks: nothing is lost, and turned directions are those of a turned map.
#include "sg/skies.hpp"
//
#include <doctest/doctest.h>

using namespace coppice;
using namespace sg_test;
using namespace test_support;

namespace {

glm::dvec3 energy_of(const SkyLights& sky) {
  return glm::dvec3(sky.lighting().nodes[1].power) + sg_energy(sky.parts().peaks);
}

SkyOptions small_sky() { return {.lights = 1024, .pieces = 64}; }

}  // namespace

TEST_CASE("the tree and the peaks together have the energy of the map") {
  SkyLights sky(small_sky());
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    Random random(seed);
    const Image map = seed < 4 ? some_map(random, 64, 32, int(seed)) : random_map(random, 64, 32);
    sky.take(map);
    const glm::dvec3 expected = sg_test::energy_of(map);
    CHECK(apart(energy_of(sky), expected) < 1e-5);
    for (int c = 0; c < 3; ++c) CHECK(close(energy_of(sky)[c], expected[c], 1e-5));
    CHECK(apart(sg_test::energy_of(sky.parts().rest.map) + sg_energy(sky.parts().peaks), expected) < 1e-5);
    CHECK(sky.lighting().nodes.size() == 2048);
    CHECK(is_cut(1024, sky.lighting().ends));
    CHECK(sky.lighting().ends.size() <= 64);
  }
}

TEST_CASE("what is a peak is taken from the map, and all else stays as it is") {
  Random random(1);
  Image map = some_map(random, 64, 32, 0);
  map.at(20, 7) = vec3(2000, 1800, 1500);
  const SkyParts parts = without_peaks(map, SkyOptions().peaks);
  REQUIRE(parts.peaks.size() == 1);
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 64; ++x)
      CHECK(parts.rest.map.at(x, y) == (x == 20 && y == 7 ? vec3(0) : map.at(x, y)));
  CHECK(length(parts.peaks[0].axis - texel_direction(20, 7, 64, 32)) < 1e-6f);
  CHECK(apart(sg_energy(parts.peaks), texel_solid_angle(7, 64, 32) * glm::dvec3(map.at(20, 7))) < 1e-5);
}

TEST_CASE("the number of peaks is never above what is asked for, and what has none stays in the tree") {
  SkyOptions options = small_sky();
  for (const std::size_t most : {0, 1, 2, 4, 5, 32}) {
    Random random(2);
    Image map(64, 32, vec3(0.01f));
    for (int x = 5; x < 17; ++x) map.at(x, 10) = vec3(100);  // a long one, which asks for three
    for (int i = 0; i < 5; ++i) map.at(3 + 10 * i, 20) = vec3(200 + 10 * float(i), 250, 300);
    options.peaks.most = most;
    SkyLights sky(options);
    sky.take(map);
    CHECK(sky.parts().peaks.size() <= most);
    CHECK((sky.parts().peaks.size() > 0) == (most > 0));
    CHECK(apart(energy_of(sky), sg_test::energy_of(map)) < 1e-5);
    if (most == 32) CHECK(sky.parts().peaks.size() == 8);
  }
}

TEST_CASE("a turned environment is looked up in the map's frame") {
  Random random(3);
  const Image map = random_map(random, 64, 32);
  for (const float rotation : {0.0f, 0.3f, -2.0f, 3.1f, 40.0f}) {
    const MapFrame frame(rotation);
    for (int y = 0; y < 32; ++y)
      for (int x = 0; x < 64; ++x) {
        const vec3 d = texel_direction(x, y, 64, 32), world = frame.to_world(d);
        REQUIRE(radiance({map, rotation}, world) == map.at(x, y));
        REQUIRE(length(frame.to_map(world) - d) < 1e-6f);
      }
  }
}

TEST_CASE("a point under the map has its angles") {
  rc::check([] {
    Random random = any_random();
    ShadingPoint p = support::random_point(random);
    set_ward(p, vec3(0.1f, 0.2f, 0.3f), vec3(0.5f), 0.2f, 0.4f);
    const MapFrame frame(10 * random.uniform());
    const ShadingPoint q = frame.to_map(p);
    RC_ASSERT(std::abs(dot(q.normal, q.to_viewer) - dot(p.normal, p.to_viewer)) < 1e-6f);
    RC_ASSERT(std::abs(dot(q.tangent, q.to_viewer) - dot(p.tangent, p.to_viewer)) < 1e-6f);
    RC_ASSERT(std::abs(dot(q.tangent, q.normal)) < 1e-6f);
    RC_ASSERT(q.diffuse == p.diffuse && q.specular == p.specular && q.brdf == p.brdf);
  });
}

TEST_CASE("black, constant, tiny and huge maps are skies") {
  SkyLights sky(small_sky());
  sky.take(Image(16, 8));
  CHECK(energy_of(sky) == glm::dvec3(0));
  CHECK(sky.parts().peaks.empty());
  sky.take(Image(16, 8, vec3(1, 2, 3)));
  CHECK(apart(energy_of(sky), 4 * std::numbers::pi * glm::dvec3(1, 2, 3)) < 1e-6);
  CHECK(sky.parts().peaks.empty());
  sky.take(Image(1, 1, vec3(0.5f)));
  CHECK(apart(energy_of(sky), 2 * std::numbers::pi * glm::dvec3(1)) < 1e-6);
  CHECK(sky.parts().peaks.empty());
  Image huge(16, 8, vec3(1));
  huge.at(3, 2) = vec3(1e30f);
  sky.take(huge);
  CHECK(apart(energy_of(sky), sg_test::energy_of(huge)) < 1e-5);
  REQUIRE(sky.parts().peaks.size() == 1);
  for (const LightNode& node : sky.lighting().nodes) CHECK(is_finite(node.power));
}

TEST_CASE("a sun of 1e5 times the sky is one peak with its energy") {
  SkyLights sky(small_sky());
  Image map(256, 128, vec3(1));
  map.at(100, 40) = vec3(1e5f);
  sky.take(map);
  REQUIRE(sky.parts().peaks.size() == 1);
  CHECK(apart(sg_energy(sky.parts().peaks), texel_solid_angle(40, 256, 128) * glm::dvec3(1e5)) < 1e-5);
  CHECK(apart(energy_of(sky), sg_test::energy_of(map)) < 1e-5);
}

TEST_CASE("a sky that takes other maps in between comes back the same") {
  Random random(4);
  const Image map = some_map(random, 64, 32), other = some_map(random, 32, 32);
  SkyLights sky(small_sky()), fresh(small_sky());
  for (const Image* m : {&map, &other, &map}) sky.take(*m);
  fresh.take(map);
  CHECK(sky.lighting().ends == fresh.lighting().ends);
  REQUIRE(sky.parts().peaks.size() == fresh.parts().peaks.size());
  for (std::size_t i = 0; i < sky.lighting().nodes.size(); ++i) {
    const LightNode &a = sky.lighting().nodes[i], &b = fresh.lighting().nodes[i];
    REQUIRE((a.power == b.power && a.direction == b.direction && a.spread == b.spread));
  }
}
