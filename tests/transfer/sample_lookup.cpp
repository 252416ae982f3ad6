// The lookup of samples against a search of all.
#include <coppice/core/simd.hpp>
//
#include <doctest/doctest.h>
#include <rapidcheck.h>

#include <coppice/reference/transport.hpp>
#include <coppice/transfer/sample_lookup.hpp>
#include <support/generators.hpp>

using namespace coppice;

namespace {

/// In a box, or on a flat piece of it, with normals along the axes or any; some coincide.
std::vector<SurfaceSample> random_samples(Random& random, std::size_t count, bool flat) {
  std::vector<SurfaceSample> samples(count);
  for (std::size_t i = 0; i < count; ++i) {
    SurfaceSample& sample = samples[i];
    sample.area = 0.5f / float(count);
    sample.normal = flat ? vec3(0, random.uniform() < 0.5f ? 1 : -1, 0) : random.direction();
    sample.position = vec3(random.uniform(), flat ? 0 : random.uniform(), random.uniform());
    if (i > 0 && random.uniform() < 0.1f) sample.position = samples[i - 1].position;
  }
  return samples;
}

}  // namespace

TEST_CASE("The sample that the lookup names is the best of all") {
  CHECK(rc::check([] {
    Random random = test_support::any_random();
    const bool flat = *rc::gen::arbitrary<bool>();
    const std::size_t count = *rc::gen::inRange<std::size_t>(0, 300);
    auto samples = random_samples(random, count, flat);
    const vec3 shift = *rc::gen::element(0.0f, 1.0f, 1000.0f) * vec3(1, -2, 3);
    for (SurfaceSample& sample : samples) sample.position += shift;
    const SampleReach reach{.distance = *rc::gen::element(0.01f, 0.1f, 0.5f, 20.0f),
                            .least_cosine = *rc::gen::element(0.1f, 0.5f, 0.9f)};
    const SampleLookup lookup(samples, reach);
    for (int k = 0; k < 200; ++k) {
      const vec3 at = shift + 1.2f * vec3(random.uniform(), flat ? 0 : random.uniform(), random.uniform());
      const vec3 normal = random_samples(random, 1, flat)[0].normal;
      const auto expected = reference::nearest_sample(samples, at, normal, reach);
      const auto found = lookup.nearest(at, normal);
      RC_ASSERT(found.has_value() == expected.has_value());
      if (!found) continue;
      const auto misfit = [&](std::uint32_t i) {
        return sample_misfit(samples[i].position, samples[i].normal, at, normal, reach);
      };
      RC_ASSERT(misfit(*found) <= misfit(*expected) * (1 + 1e-5f));  // compilers round alike nearly always
    }
  }));
}

TEST_CASE("Light does not bleed through a thin wall or round a corner") {
  std::vector<SurfaceSample> samples(2);
  samples[0] = {.position = vec3(0, 0.001f, 0), .area = 1, .normal = vec3(0, 1, 0), .side = {}};
  samples[1] = {.position = vec3(0, -0.001f, 0), .area = 1, .normal = vec3(0, -1, 0), .side = {}};
  const SampleLookup lookup(samples, {.distance = 2});
  CHECK(lookup.nearest(vec3(0.5f, -0.001f, 0), vec3(0, 1, 0)) == 0u);
  CHECK(lookup.nearest(vec3(0.5f, 0.001f, 0), vec3(0, -1, 0)) == 1u);
  CHECK(lookup.nearest(vec3(0, 0.001f, 0), vec3(1, 0, 0)) == std::nullopt);
}

TEST_CASE("Points out of reach, far away, or without samples have none") {
  std::vector<SurfaceSample> samples(1);
  samples[0] = {.position = vec3(0), .area = 1, .normal = vec3(0, 1, 0), .side = {}};
  const SampleLookup lookup(samples, {.distance = 0.5f});
  CHECK(lookup.nearest(vec3(0.4f, 0, 0), vec3(0, 1, 0)) == 0u);
  for (const float far : {0.6f, 100.0f, 1e30f, -1e30f})
    CHECK(lookup.nearest(vec3(far, 0, 0), vec3(0, 1, 0)) == std::nullopt);
  CHECK(SampleLookup({}, {.distance = 1}).nearest(vec3(0), vec3(0, 1, 0)) == std::nullopt);
}
