// Light through cones before and after visibility, and batches of them.
#include <doctest/doctest.h>

#include <coppice/sg/lit_cones.hpp>

#include "support/executors.hpp"
#include "support/generators.hpp"

using namespace coppice;
using namespace test_support;

namespace {

LitCone some_cone(Random& random) {
  const vec3 radiance(random.uniform(), random.uniform(), random.uniform());
  return {{random.direction(), 100 * random.uniform()}, radiance, luminance(radiance)};
}

/// Receiver i has i² % 7 cones, the same whichever thread asks.
struct Placer {
  LitCones result;
  const LitCones& place(std::size_t i) {
    Random random(i);
    result = LitCones{};
    for (std::size_t k = 0; k < i * i % 7; ++k) result.cones.push_back(some_cone(random));
    result.untraced = vec3(random.uniform());
    result.clusters = std::uint32_t(i);
    return result;
  }
};

template <class E>
ConeBatch batch_of(std::size_t count, const E& executor) {
  std::vector<ConeReceiver> receivers(count);
  for (std::size_t i = 0; i < count; ++i) receivers[i].index = std::uint32_t(i);
  return place_cones(
      std::move(receivers), [] { return Placer{}; }, executor);
}

}  // namespace

TEST_CASE("all of the light is there where all cones are seen, none where none is") {
  rc::check([] {
    Random random = any_random();
    LitCones lit;
    for (std::uint32_t i = 0; i < 1 + random.below(9); ++i) lit.cones.push_back(some_cone(random));
    lit.untraced = vec3(random.uniform());
    const std::vector<float> open(lit.cones.size(), 1.0f), shut(lit.cones.size(), 0.0f);
    RC_ASSERT(length(visible_light(lit.cones, open, lit.untraced) - lit.unoccluded()) < 1e-5f);
    RC_ASSERT(visible_light(lit.cones, shut, lit.untraced) == vec3(0));
  });
}

TEST_CASE("untraced light is as visible as the cones' mean") {
  LitCones lit;
  lit.cones = {{{vec3(0, 1, 0), 1}, vec3(3), 3}, {{vec3(1, 0, 0), 1}, vec3(1, 0, 1), 1}};
  const std::vector<float> visibility{0.5f, 0.25f};
  const vec3 sum = visible_light(lit.cones, visibility, vec3(8));
  CHECK(length(sum - (vec3(1.75f, 1.5f, 1.75f) + 8.0f * (1.75f / 4))) < 1e-6f);
  CHECK(visible_light({}, {}, vec3(2)) == vec3(2));
}

TEST_CASE("a batch holds the cones of each receiver, one after the other") {
  for (const std::size_t count : {0, 1, 5, 255, 256, 257, 1000}) {
    const ConeBatch batch = batch_of(count, Serial());
    REQUIRE(batch.receivers.size() == count);
    REQUIRE(batch.untraced.size() == count);
    REQUIRE(batch.shapes.size() == batch.cones.size());
    Placer placer;
    std::size_t clusters = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const LitCones& lit = placer.place(i);
      clusters += lit.clusters;
      CHECK(batch.receivers[i].index == i);
      CHECK(batch.untraced[i] == lit.untraced);
      REQUIRE(batch.receivers[i].cones_end - batch.begin_of(i) == lit.cones.size());
      for (std::size_t k = 0; k < lit.cones.size(); ++k) {
        CHECK(batch.cones[batch.begin_of(i) + k].radiance == lit.cones[k].radiance);
        CHECK(batch.shapes[batch.begin_of(i) + k].axis == lit.cones[k].shape.axis);
      }
    }
    CHECK(batch.clusters == clusters);
    CHECK((count == 0 || batch.receivers.back().cones_end == batch.cones.size()));
  }
}

TEST_CASE("any split over threads gives the same batch and the same light") {
  const ConeBatch serial = batch_of(1500, Serial());
  Random random(1);
  std::vector<float> visibility(serial.cones.size());
  for (float& v : visibility) v = random.uniform();
  const std::vector<vec3> light = visible_light(serial, visibility, Serial());
  const auto check = [&](const auto& executor) {
    const ConeBatch other = batch_of(1500, executor);
    CHECK(other.untraced == serial.untraced);
    REQUIRE(other.cones.size() == serial.cones.size());
    for (std::size_t i = 0; i < serial.receivers.size(); ++i)
      REQUIRE(other.receivers[i].cones_end == serial.receivers[i].cones_end);
    for (std::size_t c = 0; c < serial.cones.size(); ++c)
      REQUIRE((other.cones[c].radiance == serial.cones[c].radiance &&
               other.shapes[c].axis == serial.shapes[c].axis));
    CHECK(visible_light(other, visibility, executor) == light);
  };
  check(support::Backwards());
  check(support::Backwards{3});
  check(support::TwoThreads());
  for (std::size_t i = 0; i < light.size(); ++i) {
    const std::size_t first = serial.begin_of(i), count = serial.receivers[i].cones_end - first;
    CHECK(light[i] == visible_light(std::span(serial.cones).subspan(first, count),
                                    std::span(visibility).subspan(first, count), serial.untraced[i]));
  }
}
