// Sums of local lights up their tree against plain sums in long double, and updates against new sums.
#include <doctest/doctest.h>

#include <coppice/relight/local_lighting.hpp>
#include <coppice/tree/build.hpp>
#include <cstring>
#include <support/local_lights.hpp>

#include "support/generators.hpp"

using namespace coppice;
using namespace test_support;

namespace {

LightTree tree_of(std::span<const LocalLight> lights) {
  const auto samples = metric_samples(lights);
  return build_tree(GeometricMetric(samples));
}

template <class T>
bool same_bytes(std::span<const T> a, std::span<const T> b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

bool same_bits(const LocalLighting& a, const LocalLighting& b) {
  return same_bytes<LocalLightNode>(a.frame().nodes, b.frame().nodes) &&
         same_bytes<LocalEmission>(a.emissions(), b.emissions());
}

/// Some numbers of lights below `count`, each once.
std::vector<std::uint32_t> some_of(Random& random, std::uint32_t count, std::uint32_t wanted) {
  auto chosen = shuffled(random, count);
  chosen.resize(std::min(count, wanted));
  return chosen;
}

void update(LocalLighting& lighting, std::span<const LocalLight> lights,
            std::span<const std::uint32_t> changed) {
  std::vector<LocalLight> values;
  for (const std::uint32_t i : changed) values.push_back(lights[i]);
  lighting.update(changed, values);
}

long double luminance_of(const LocalLight& l) {
  return 0.2126L * l.intensity.x + 0.7152L * l.intensity.y + 0.0722L * l.intensity.z;
}

/// Means weighted by luminance, in two passes.
struct ExactSum {
  long double luminance = 0, w = 0, offset = 0, square = 0, softening = 0, variance = 0;
  std::array<long double, 3> power{}, position{}, axis{};

  explicit ExactSum(std::span<const LocalLight> lights) {
    for (const auto& l : lights) luminance += luminance_of(l);
    for (const auto& l : lights) {
      const long double share = luminance > 0 ? luminance_of(l) / luminance : 0;
      w += share * l.w, offset += share * l.offset, square += share * l.square;
      softening += share * l.area / std::numbers::pi_v<long double>;
      for (int k = 0; k < 3; ++k) {
        power[std::size_t(k)] += l.intensity[k];
        position[std::size_t(k)] += share * l.position[k];
        axis[std::size_t(k)] += share * l.axis[k];
      }
    }
    for (const auto& l : lights)
      for (int k = 0; luminance > 0 && k < 3; ++k) {
        const long double off = l.position[k] - position[std::size_t(k)];
        variance += luminance_of(l) / luminance * off * off;
      }
  }
};

bool near(long double value, long double expected, long double size) {
  return std::abs(value - expected) <= 3e-7L * size;
}

/// A node against the sum of its lights.
void check_node(const LocalLightNode& node, const LocalEmission& e, std::span<const LocalLight> lights) {
  const ExactSum sum(lights);
  CHECK(near(e.luminance, sum.luminance, sum.luminance));
  CHECK(near(node.w, sum.w, 1));
  CHECK(near(e.offset, sum.offset, 1000));
  CHECK(near(e.square, sum.square, 1));
  CHECK(near(e.softening, sum.softening, sum.softening));
  CHECK(near(node.variance, sum.variance, sum.variance));
  for (int k = 0; k < 3; ++k) {
    const auto i = std::size_t(k);
    CHECK(near(node.power[k], sum.power[i], sum.power[i]));
    CHECK(near(node.position[k], sum.position[i], std::max(1.0L, std::abs(sum.position[i]))));
    CHECK(near(e.axis[k], sum.axis[i], 1000));
  }
}

void check_contains(const LocalLightNode& node, const LocalEmission& e, std::span<const LocalLight> lights) {
  for (const auto& l : lights)
    if (luminance_of(l) > 0)
      CHECK(glm::length(glm::dvec3(l.position) - glm::dvec3(node.position)) <= double(e.radius));
}

std::vector<LocalLight> lights_below(const LightTree& tree, std::span<const LocalLight> lights,
                                     std::uint32_t h) {
  std::vector<LocalLight> below;
  const LeafRange range = leaves_below(tree.leaf_count(), h);
  for (std::uint32_t leaf = range.begin; leaf < range.end; ++leaf)
    if (tree.light_of_leaf[leaf] != no_light) below.push_back(lights[tree.light_of_leaf[leaf]]);
  return below;
}

bool all_finite(const LocalLighting& lighting) {
  for (std::size_t h = 1; h < lighting.frame().nodes.size(); ++h) {
    const auto& n = lighting.frame().nodes[h];
    const auto& e = lighting.emissions()[h];
    const float values[] = {n.variance, n.w, e.offset, e.square, e.softening, e.radius, e.luminance};
    if (!is_finite(n.power) || !is_finite(n.position) || !is_finite(e.axis)) return false;
    for (const float v : values)
      if (!std::isfinite(v)) return false;
  }
  return true;
}

}  // namespace

TEST_CASE("moving, dimming, switching off and on again give the bits of a new sum") {
  Random random(1);
  for (const std::uint32_t count : {0u, 1u, 2u, 597u, 4096u}) {
    CAPTURE(count);
    auto lights = support::random_local_lights(random, count);
    const auto before = lights;
    const LightTree tree = tree_of(lights);
    LocalLighting lighting(tree, lights);
    for (const std::uint32_t some : {1u, 10u, count}) {
      const auto changed = some_of(random, count, some);
      const auto change = [&](auto&& each) {
        for (const std::uint32_t i : changed) each(lights[i], i);
        update(lighting, lights, changed);
        CHECK(same_bits(lighting, LocalLighting(tree, lights)));
      };
      change([&](LocalLight& l, std::uint32_t) { l.position += random.direction(); });
      change([&](LocalLight& l, std::uint32_t) { l.intensity *= random.uniform(); });
      change([&](LocalLight& l, std::uint32_t) { l.intensity = vec3(0); });
      change([&](LocalLight& l, std::uint32_t i) { l = before[i]; });
    }
    CHECK(same_bits(lighting, LocalLighting(tree, before)));
  }
}

TEST_CASE("nodes hold the sums and the weighted means of their lights") {
  Random random(2);
  const auto lights = support::random_local_lights(random, 100);
  const LightTree tree = tree_of(lights);
  const LocalLighting lighting(tree, lights);
  for (std::uint32_t h = 1; h < 2 * tree.leaf_count(); ++h) {
    const auto below = lights_below(tree, lights, h);
    check_node(lighting.frame().nodes[h], lighting.emissions()[h], below);
    check_contains(lighting.frame().nodes[h], lighting.emissions()[h], below);
  }
}

TEST_CASE("the variance of lights a unit apart survives ten thousand units from the origin") {
  Random random(3);
  auto lights = support::random_local_lights(random, 500, std::array{support::LightKind::point});
  for (auto& l : lights) l.position += vec3(1e4f, -1e4f, 1e4f);
  const LightTree tree = tree_of(lights);
  const LocalLighting lighting(tree, lights);
  const ExactSum sum(lights);
  CHECK(sum.variance > 0.5L);
  CHECK(near(lighting.frame().nodes[1].variance, sum.variance, sum.variance));
}

TEST_CASE("the ball of a node holds all its lit lights, wherever they are") {
  CHECK(rc::check([] {
    Random random = any_random();
    auto lights = support::random_local_lights(random, 1 + random.below(40));
    const vec3 centre = std::pow(10.0f, 6 * random.uniform() - 1) * random.direction();
    for (auto& l : lights) {
      l.position = centre + std::pow(10.0f, 4 * random.uniform() - 3) * l.position;
      l.intensity *= std::pow(10.0f, 12 * random.uniform() - 6) * float(random.below(4) > 0);
    }
    const LightTree tree = tree_of(lights);
    const LocalLighting lighting(tree, lights);
    for (std::uint32_t h = 1; h < 2 * tree.leaf_count(); ++h)
      check_contains(lighting.frame().nodes[h], lighting.emissions()[h], lights_below(tree, lights, h));
  }));
}

TEST_CASE("leaves hold their light as it is") {
  Random random(4);
  const auto lights = support::random_local_lights(random, 37);
  const LightTree tree = tree_of(lights);
  const LocalLighting lighting(tree, lights);
  for (std::uint32_t leaf = 0; leaf < tree.leaf_count(); ++leaf) {
    if (tree.light_of_leaf[leaf] == no_light) continue;
    const LocalLight& l = lights[tree.light_of_leaf[leaf]];
    const LocalLightNode& node = lighting.frame().nodes[tree.leaf_count() + leaf];
    const LocalEmission& e = lighting.emissions()[tree.leaf_count() + leaf];
    CHECK(node.power == l.intensity);
    CHECK(node.position == l.position);
    CHECK(node.w == l.w);
    CHECK(node.variance == 0);
    CHECK(e.axis == l.axis);
    CHECK(e.offset == l.offset);
    CHECK(e.square == l.square);
    CHECK(e.radius == 0);
  }
}

TEST_CASE("intensities from 1e-30 to 1e30, one-hot and black give no NaN") {
  Random random(5);
  auto lights = support::random_local_lights(random, 64);
  const LightTree tree = tree_of(lights);
  auto extreme = lights;
  for (auto& l : extreme) l.intensity *= std::pow(10.0f, 60 * random.uniform() - 30);
  CHECK(all_finite(LocalLighting(tree, extreme)));
  for (auto& l : extreme) l.intensity = vec3(0);
  const LocalLighting black(tree, extreme);
  CHECK(all_finite(black));
  CHECK(black.frame().nodes[1].power == vec3(0));
  CHECK(black.emissions()[1].luminance == 0);
  extreme[17] = lights[17];
  const LocalLighting one(tree, extreme);
  CHECK(all_finite(one));
  CHECK(one.frame().nodes[1].position == lights[17].position);
  CHECK(one.frame().nodes[1].power == lights[17].intensity);
  CHECK(one.frame().nodes[1].variance == 0);
  CHECK(one.emissions()[1].radius == 0);
}

TEST_CASE("the illumination cut splits what is bright, and does without what is dark") {
  Random random(6);
  auto lights = support::random_local_lights(random, 64);
  const LightTree tree = tree_of(lights);
  LocalLighting lighting(tree, lights);
  lighting.set_cut(10, 0);
  CHECK(is_cut(64, lighting.frame().ends));
  CHECK(lighting.frame().ends.size() == 10);
  lighting.set_cut(1000, 0);
  CHECK(lighting.frame().ends.size() == 64);
  for (auto& l : lights) l.intensity = vec3(0);
  const auto all = shuffled(random, 64);
  update(lighting, lights, all);
  lighting.set_cut(1000, 0);
  CHECK(lighting.frame().ends.size() == 1);
  LightTree empty;
  LocalLighting none(empty, {});
  none.set_cut(10, 0);
  CHECK(none.frame().ends.empty());
}
