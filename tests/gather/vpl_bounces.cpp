// Light that VPLs send each other, against double loops.
#include <doctest/doctest.h>

#include <algorithm>
#include <coppice/gather/vpl_bounces.hpp>
#include <cstring>

#include "gather/vpls.hpp"
#include "support/executors.hpp"

using namespace coppice;

namespace {

/// A square plate of n · n samples, 1 m wide, whose middle is above the origin.
void add_plate(std::vector<SurfaceSample>& samples, int n, float height, float up) {
  for (int i = 0; i < n * n; ++i) {
    const float x = (float(i % n) + 0.5f) / float(n) - 0.5f, z = (float(i / n) + 0.5f) / float(n) - 0.5f;
    samples.push_back(
        {.position = vec3(x, height, z), .area = 1.0f / float(n * n), .normal = vec3(0, up, 0), .side = {}});
  }
}

/// Two plates that face each other, and one that faces none.
std::vector<SurfaceSample> plates(int n) {
  std::vector<SurfaceSample> samples;
  add_plate(samples, n, 0, 1);
  add_plate(samples, n, 0.8f, -1);
  add_plate(samples, n, -0.5f, -1);
  return samples;
}

/// The first plate lit from above, in spots.
std::vector<VplLight> light_of(std::span<const SurfaceSample> samples, Random& random) {
  std::vector<VplLight> light;
  for (const SurfaceSample& s : samples) {
    const bool is_lit = s.position.y == 0 && random.below(3) != 0;
    if (is_lit)
      light.push_back({support::any_colour(random), 0.1f * random.uniform(),
                       normalize(s.normal + 0.5f * random.direction())});
    else
      light.push_back({vec3(0), 1, s.normal});
  }
  return light;
}

/// Glossy, each sample in its own colours.
struct Leaves {
  std::span<const SurfaceSample> samples;

  std::vector<VplNode> operator()(std::span<const VplLight> light) const {
    std::vector<VplNode> leaves;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const float t = float(i % 7) / 7;
      leaves.push_back(
          vpl_leaf(samples[i], {{0.3f + 0.3f * t, 0.4f, 0.5f}, vec3(0.3f - 0.2f * t), 5 + 20 * t}, light[i]));
    }
    return leaves;
  }
};

/// Σ luminance · direction.
glm::dvec3 towards(const VplLight& l) {
  return support::luminance(glm::dvec3(l.irradiance)) * (1 - double(l.shortfall)) * glm::dvec3(l.direction);
}

struct ExactLight {
  std::vector<glm::dvec3> irradiance, towards;
};

/// Direct light, and what all leaves under `light` bring to each sample: a double loop.
ExactLight bounced(std::span<const SurfaceSample> samples, std::span<const VplLight> direct,
                   std::span<const VplLight> light) {
  ExactLight exact;
  const auto leaves = Leaves{samples}(light);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto r = reference::received(leaves, ray_origin(samples[i]), samples[i].normal);
    exact.irradiance.push_back(glm::dvec3(direct[i].irradiance) + r.irradiance);
    exact.towards.push_back(towards(direct[i]) + r.towards);
  }
  return exact;
}

void check_light(std::span<const VplLight> light, const ExactLight& exact, double tolerance) {
  for (std::size_t i = 0; i < light.size(); ++i) {
    const double size = glm::length(exact.irradiance[i]);
    CHECK(glm::length(glm::dvec3(light[i].irradiance) - exact.irradiance[i]) <= tolerance * size);
    CHECK(glm::length(towards(light[i]) - exact.towards[i]) <= tolerance * size);
  }
}

bool same_bits(std::span<const VplLight> a, std::span<const VplLight> b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

VplLight any_light(Random& random) {
  if (random.below(8) == 0) return {vec3(0), 1, random.direction()};
  return {support::spread(random, 1e-3f, 1e3f) * (0.1f + support::any_colour(random)),
          random.below(4) == 0 ? 0.0f : random.uniform(), random.direction()};
}

}  // namespace

TEST_CASE("both lights together have their energy and their mean direction") {
  Random random(1);
  for (int i = 0; i < 2000; ++i) {
    const VplLight a = any_light(random), b = any_light(random), both = together(a, b);
    CHECK(both.irradiance == a.irradiance + b.irradiance);
    CHECK((both.shortfall >= 0 && both.shortfall <= 1));
    CHECK(std::abs(length(both.direction) - 1) < 1e-6f);
    const double size = support::luminance(glm::dvec3(both.irradiance));
    CHECK(glm::length(towards(both) - (towards(a) + towards(b))) <= 2e-6 * size);
  }
}

TEST_CASE("light with nothing stays what it is, nothing with nothing is dark") {
  const VplLight none{vec3(0), 1, vec3(0, 1, 0)}, some{vec3(1, 2, 3), 0.25f, normalize(vec3(1, 1, 0))};
  for (const VplLight& l : {together(some, none), together(none, some)}) {
    CHECK(l.irradiance == some.irradiance);
    CHECK(l.shortfall == doctest::Approx(0.25).epsilon(1e-6));
    CHECK(length(l.direction - some.direction) < 1e-6f);
  }
  const VplLight dark = together(none, none);
  CHECK((dark.irradiance == vec3(0) && dark.shortfall == 1 && dark.direction == none.direction));
}

TEST_CASE("what nodes send to a point is the double sum") {
  Random random(2);
  for (const std::size_t count : {0u, 1u, 15u, 16u, 17u, 200u}) {
    const VplTree tree(support::room_vpls(random, count, 1e3f));
    for (const bool are_clusters : {false, true}) {
      std::vector<std::uint32_t> ids(tree.leaf_count());
      std::iota(ids.begin(), ids.end(), are_clusters ? tree.leaf_count() / 2 : tree.leaf_count());
      std::vector<VplNode> nodes;
      for (const std::uint32_t h : ids) nodes.push_back(tree.nodes()[h]);
      VplArrays arrays;
      arrays.assign(tree.nodes(), ids);
      for (const GlossyPoint& p : support::room_points(random, 20)) {
        const VplLight light = receive_nodes(arrays, p);
        const auto exact = reference::received(nodes, p.position, p.normal);
        const double size = glm::length(exact.irradiance);
        CHECK(glm::length(glm::dvec3(light.irradiance) - exact.irradiance) <= 1e-4 * size + 1e-12);
        CHECK(glm::length(towards(light) - exact.towards) <= 1e-4 * size + 1e-12);
        if (size == 0) CHECK((light.shortfall == 1 && light.direction == p.normal));
      }
    }
  }
}

TEST_CASE("VPLs are grouped each once, with those that are near and face alike") {
  Random random(3);
  for (const std::size_t count : {0u, 1u, 2u, 33u, 500u}) {
    std::vector<SurfaceSample> samples;
    for (std::size_t i = 0; i < count; ++i) {
      const auto [position, normal] = support::on_wall(random);
      samples.push_back({.position = position, .area = 0.1f, .normal = normal, .side = {}});
    }
    const PointGroups groups = group_vpls(samples);
    std::vector<int> times(count);
    CHECK((groups.ends.empty() ? 0 : groups.ends.back()) == count);
    for (std::size_t g = 0; g < groups.size(); ++g) {
      CHECK((!groups.group(g).empty() && groups.group(g).size() <= 32));
      for (const GlossyPoint& p : groups.group(g)) {
        ++times[p.pixel];
        CHECK((p.position == ray_origin(samples[p.pixel]) && p.normal == samples[p.pixel].normal));
        CHECK(dot(p.normal, groups.group(g)[0].normal) >= 0.9f);
      }
    }
    CHECK(std::ranges::all_of(times, [](int t) { return t == 1; }));
  }
}

TEST_CASE("one bounce is the direct light") {
  Random random(4);
  const auto samples = plates(4);
  const auto direct = light_of(samples, random);
  const auto never = [](std::span<const VplLight>) {
    FAIL_CHECK("no leaves are needed");
    return std::vector<VplNode>{};
  };
  for (const int bounces : {0, 1})
    CHECK(same_bits(with_bounces(samples, direct, never, {.bounces = bounces}, support::nothing, Serial()),
                    direct));
}

TEST_CASE("two bounces between facing plates are a double loop over all pairs") {
  Random random(5);
  const auto samples = plates(8);
  const auto direct = light_of(samples, random);
  const BounceGather options{.bounces = 2, .threshold = 0};
  const auto light = with_bounces(samples, direct, Leaves{samples}, options, support::nothing, Serial());
  check_light(light, bounced(samples, direct, direct), 1e-5);
  for (std::size_t i = 0; i < 64; ++i) {
    CHECK(light[i + 64].irradiance.x > 0);        // it had no direct light
    CHECK(light[i + 128].irradiance == vec3(0));  // it sees none
    CHECK(light[i].irradiance == direct[i].irradiance);
  }
}

TEST_CASE("each further bounce is a loop over the light of the last") {
  Random random(6);
  const auto samples = plates(6);
  const auto direct = light_of(samples, random);
  auto last = direct;
  for (int bounces = 2; bounces <= 5; ++bounces) {
    const BounceGather options{.bounces = bounces, .threshold = 0};
    const auto light = with_bounces(samples, direct, Leaves{samples}, options, support::nothing, Serial());
    check_light(light, bounced(samples, direct, last), 1e-5);
    last = light;
  }
}

TEST_CASE("the default threshold errs little, and any executor makes the same bits") {
  Random random(7);
  const auto samples = plates(12);
  const auto direct = light_of(samples, random);
  for (const bool is_traced : {false, true}) {
    const BounceGather options{.bounces = 3, .is_traced = is_traced, .seed = 5};
    const auto with = [&](const auto& executor) {
      return with_bounces(samples, direct, Leaves{samples}, options, support::nothing, executor);
    };
    const auto light = with(Serial());
    CHECK(same_bits(light, with(support::Backwards())));
    CHECK(same_bits(light, with(support::TwoThreads())));
    if (is_traced) continue;
    auto exact_options = options;
    exact_options.threshold = 0;
    const auto exact =
        with_bounces(samples, direct, Leaves{samples}, exact_options, support::nothing, Serial());
    double off = 0, total = 0;
    for (std::size_t i = 0; i < light.size(); ++i) {
      off += std::abs(double(luminance(light[i].irradiance) - luminance(exact[i].irradiance)));
      total += double(luminance(exact[i].irradiance));
    }
    CHECK(off > 0);
    CHECK(off < 0.01 * total);  // measured: 0.0025
  }
}

TEST_CASE("traced bounces are right on the mean, with and without something in between") {
  Random random(8);
  const auto samples = plates(6);
  const auto direct = light_of(samples, random);
  const auto leaves = Leaves{samples}(direct);
  const support::SphereOccluder ball{{{vec3(0.1f, 0.4f, 0), 0.25f}}};
  for (const auto& occluder : {support::nothing, ball}) {
    constexpr int draws = 1500;
    const VplTree tree(shining(leaves));
    const PointGroups groups = group_vpls(samples);
    std::vector<glm::dvec3> sum(samples.size()), squares(samples.size());
    for (int seed = 0; seed < draws; ++seed) {
      const BounceGather options{.threshold = 5, .is_traced = true, .seed = std::uint64_t(1000 * seed)};
      const auto light = receive_at_vpls(tree, groups, options, occluder, Serial());
      for (std::size_t i = 0; i < samples.size(); ++i) {
        const glm::dvec3 t = towards(light[i]);
        const glm::dvec3 x(support::luminance(glm::dvec3(light[i].irradiance)), t.x, t.y);
        sum[i] += x, squares[i] += x * x;
      }
    }
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const vec3 origin = ray_origin(samples[i]);
      std::vector<VplNode> seen;
      for (const VplNode& n : leaves) {
        const float distance = length(n.position - origin);
        if (!occluder.occluded(origin, (n.position - origin) / distance, distance * (1 - 1e-4f)))
          seen.push_back(n);
      }
      const auto r = reference::received(seen, origin, samples[i].normal);
      const glm::dvec3 exact(support::luminance(r.irradiance), r.towards.x, r.towards.y);
      const glm::dvec3 mean = sum[i] / double(draws);
      const glm::dvec3 error =
          glm::sqrt(glm::max(squares[i] / double(draws) - mean * mean, 0.0) / double(draws));
      for (int k = 0; k < 3; ++k) CHECK(std::abs(mean[k] - exact[k]) <= 4 * error[k] + 1e-4 * exact.x);
    }
  }
}

TEST_CASE("in the dark VPLs receive nothing, and stay as they are") {
  const auto samples = plates(3);
  std::vector<VplLight> dark;
  for (const SurfaceSample& s : samples) dark.push_back({vec3(0), 1, s.normal});
  for (const bool is_traced : {false, true}) {
    const BounceGather options{.bounces = 3, .is_traced = is_traced};
    CHECK(same_bits(with_bounces(samples, dark, Leaves{samples}, options, support::nothing, Serial()), dark));
  }
  CHECK(with_bounces({}, {}, Leaves{{}}, {.bounces = 2}, support::nothing, Serial()).empty());
}
