// Shading in registers against the plain sum over all lights, for every BRDF.
#include <doctest/doctest.h>

#include <coppice/core/random.hpp>
#include <coppice/light/directions.hpp>
#include <coppice/reference/dense.hpp>
#include <coppice/relight/brute_force.hpp>
#include <coppice/relight/shade.hpp>
#include <coppice/tree/build.hpp>
#include <functional>

using namespace coppice;

namespace {

struct Scenery {
  std::vector<vec3> directions;  // by leaf, as are the powers
  std::vector<vec3> powers;
  LightTree tree;
  FrameLighting frame;

  Scenery(std::uint32_t count, Random& random) {
    const auto by_light = even_directions(count, 8);
    std::vector<LightSample> samples;
    std::vector<CellLight> lights;
    for (const vec3& d : by_light) {
      samples.push_back({d, vec3(0)});
      lights.push_back({vec3(random.uniform(), random.uniform(), random.uniform()), 4 * pi / float(count)});
    }
    tree = build_tree(GeometricMetric(samples));
    frame = light_frame(tree, lights, by_light, tree.leaf_count(), 0);
    for (const std::uint32_t l : tree.light_of_leaf) {
      directions.push_back(l == no_light ? vec3(0, 1, 0) : by_light[l]);
      powers.push_back(l == no_light ? vec3(0) : lights[l].power);
    }
  }
};

ShadingPoint random_point(Random& random) {
  ShadingPoint p{};
  vec3 bitangent;
  p.normal = random.direction();
  make_frame(p.normal, p.tangent, bitangent);
  p.to_viewer = normalize(random.direction() + 1.1f * p.normal);
  p.weight_0 = 0.7f * random.uniform();
  p.weight_1 = (1 - p.weight_0) * random.uniform();
  return p;
}

const std::vector<std::function<void(ShadingPoint&)>> materials{
    [](ShadingPoint& p) {
      set_lambert(p, {0.2f, 0.5f, 0.8f});
    },
    [](ShadingPoint& p) {
      set_metallic_roughness(p, {0.9f, 0.5f, 0.2f}, 0.4f, 0.5f);
    },
    [](ShadingPoint& p) {
      set_phong(p, {0.3f, 0.2f, 0.1f}, {0.4f, 0.5f, 0.6f}, 20);
    },
    [](ShadingPoint& p) {
      set_blinn_phong(p, {0.3f, 0.2f, 0.1f}, {0.4f, 0.5f, 0.6f}, 40);
    },
    [](ShadingPoint& p) {
      set_ward(p, {0.3f, 0.2f, 0.1f}, {0.4f, 0.5f, 0.6f}, 0.2f, 0.5f);
    }};

/// A point for each material, several times over.
std::vector<ShadingPoint> random_points(Random& random) {
  std::vector<ShadingPoint> points;
  for (int i = 0; i < 6; ++i)
    for (const auto& set_material : materials) set_material(points.emplace_back(random_point(random)));
  return points;
}

float interpolate(const ShadingPoint& p, float a, float b, float c) {
  return p.weight_0 * a + p.weight_1 * b + (1 - p.weight_0 - p.weight_1) * c;
}

void check_near(const vec3& value, const vec3& expected) {
  CHECK(length(value - expected) <= 1e-5f * length(expected));
}

/// Rows of bits: one bit in eight, or in long runs, so that whole registers are unseen.
std::vector<std::uint64_t> random_rows(std::size_t words, Random& random) {
  std::vector<std::uint64_t> bits(3 * words);
  for (auto& word : bits)
    word = random.below(2) ? random.bits() & random.bits() & random.bits()
                           : random.bits() << (random.below(63) + 1);
  for (std::size_t w = 0; w < words; w += 2) bits[w] = bits[w + words] = bits[w + 2 * words] = 0;
  return bits;
}

}  // namespace

TEST_CASE("shading clusters of one light each equals the sum over all lights") {
  Random random(1);
  for (const std::uint32_t count : {1u, 3u, 100u, 1000u}) {
    const Scenery scene(count, random);
    const std::uint32_t n = scene.tree.leaf_count();
    ClusterList clusters;
    clusters.reset(n);
    std::vector<std::array<float, 3>> seen(n);
    for (std::uint32_t i = 0; i < n; ++i) {
      for (float& s : seen[i]) s = float(random.below(256));
      clusters.push(scene.frame.nodes[n + i], seen[i][0], seen[i][1], seen[i][2]);
    }
    clusters.pad();
    for (const ShadingPoint& p : random_points(random)) {
      std::vector<float> visibility;
      for (const auto& s : seen) visibility.push_back(interpolate(p, s[0], s[1], s[2]) / 255);
      check_near(shade_point(p, clusters, 1.0f / 255),
                 reference::dense_radiance(p, scene.directions, scene.powers, visibility));
    }
  }
}

TEST_CASE("no clusters give no light") {
  Random random(2);
  ClusterList clusters;
  clusters.reset(0);
  clusters.pad();
  for (const ShadingPoint& p : random_points(random)) CHECK(shade_point(p, clusters, 1) == vec3(0));
}

TEST_CASE("brute force, with or without skipping, equals the plain sum") {
  Random random(3);
  for (const std::uint32_t count : {1u, 3u, 64u, 1000u}) {
    const Scenery scene(count, random);
    const std::uint32_t n = scene.tree.leaf_count();
    const DenseLights lights(n, scene.frame);
    const std::size_t words = words_for_bits(n);
    const auto bits = random_rows(words, random);
    const std::span<const std::uint64_t> a(bits.data(), words), b(bits.data() + words, words),
        c(bits.data() + 2 * words, words);
    for (const ShadingPoint& p : random_points(random)) {
      std::vector<float> visibility;
      for (std::uint32_t i = 0; i < n; ++i)
        visibility.push_back(interpolate(p, bit_at(a.data(), i), bit_at(b.data(), i), bit_at(c.data(), i)));
      const vec3 expected = reference::dense_radiance(p, scene.directions, scene.powers, visibility);
      check_near(shade_brute_force<Skip::nothing>(p, lights, a, b, c), expected);
      check_near(shade_brute_force<Skip::unseen>(p, lights, a, b, c), expected);
    }
  }
}

TEST_CASE("shading by faces is shading by points, in any split, and counts each point's clusters") {
  Random random(4);
  const Scenery scene(256, random);
  MaskedCuts<std::uint8_t> cuts(256, 0);
  cuts.append(Cut<std::uint8_t>{{128, 192, 256}, {255, 0, 100}});
  cuts.append(Cut<std::uint8_t>{{64, 128, 256}, {0, 20, 0}});
  cuts.append(Cut<std::uint8_t>{{256}, {200}});
  ShadingBuffer buffer;
  buffer.points = random_points(random);
  buffer.faces = {{{0, 1, 2}, 0}, {{2, 2, 0}, 7}, {{1, 1, 1}, 8}};
  std::vector<vec3> whole(buffer.points.size()), split(buffer.points.size());
  std::vector<std::uint32_t> counts(buffer.points.size());
  shade_faces<std::uint8_t>(buffer, cuts, scene.frame, 0, 3, whole, counts);
  for (std::size_t f = 3; f-- > 0;) shade_faces<std::uint8_t>(buffer, cuts, scene.frame, f, f + 1, split, {});
  CHECK(whole == split);
  ClusterList clusters;
  for (std::size_t f = 0; f < 3; ++f) {
    merge_face(cuts, buffer.faces[f].receivers, scene.frame, clusters);
    for (std::uint32_t p = buffer.faces[f].first_point; p < buffer.end_of(f); ++p) {
      CHECK(counts[p] == clusters.size());
      CHECK(whole[p] == shade_point(buffer.points[p], clusters, 1.0f / 255));
    }
  }
}
