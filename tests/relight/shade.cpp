// Shading in registers against the plain sum over all lights, for every BRDF.
#include <doctest/doctest.h>

#include <coppice/reference/dense.hpp>
#include <coppice/relight/brute_force.hpp>
#include <coppice/relight/shade_faces.hpp>
#include <support/shading.hpp>

using namespace coppice;
using namespace support;

namespace {

/// Lights of random colours, each a piece of the illumination cut.
LitTree coloured_lights(std::uint32_t count, Random& random) {
  return LitTree(count, leaf_count_for(count), 0, [&](const vec3&) { return random_colour(random); });
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

TEST_CASE("clusters of one light each give the sum over all lights, whatever the lobes") {
  Random random(1);
  RefinementScratch scratch;
  for (const std::uint32_t count : {1u, 3u, 100u, 1000u}) {
    const LitTree lit = coloured_lights(count, random);
    const std::uint32_t n = lit.leaf_count();
    ClusterList clusters;
    clusters.reset(n);
    std::vector<std::array<float, 3>> seen(n);
    for (std::uint32_t i = 0; i < n; ++i) {
      for (float& s : seen[i]) s = float(random.below(256));
      clusters.push(n + i, lit.frame.nodes[n + i], seen[i]);
    }
    clusters.pad();
    for (const ShadingPoint& p : random_points(wide_materials, 6, random)) {
      std::vector<float> visibility;
      for (const auto& s : seen) visibility.push_back(interpolate(p, s[0], s[1], s[2]) / 255);
      const vec3 expected =
          reference::dense_radiance(p, lit.leaf_directions(), lit.leaf_powers(), visibility);
      for (const Lobes lobes : {Lobes::sampled, Lobes::filtered, Lobes::refined}) {
        const ShadedPoint shaded = shade_point(p, clusters, 1.0f / 255, {lobes, 0}, lit.frame.nodes, scratch);
        check_near(shaded.radiance, expected);
        CHECK(shaded.clusters == n);
      }
    }
  }
}

TEST_CASE("no clusters give no light") {
  Random random(2);
  ClusterList clusters;
  clusters.reset(0);
  clusters.pad();
  RefinementScratch scratch;
  for (const ShadingPoint& p : random_points(wide_materials, 6, random))
    for (const Lobes lobes : {Lobes::sampled, Lobes::filtered, Lobes::refined}) {
      const ShadedPoint shaded = shade_point(p, clusters, 1, {lobes}, {}, scratch);
      CHECK(shaded.radiance == vec3(0));
      CHECK(shaded.clusters == 0);
    }
}

TEST_CASE("brute force, with or without skipping, equals the plain sum") {
  Random random(3);
  for (const std::uint32_t count : {1u, 3u, 64u, 1000u}) {
    const LitTree lit = coloured_lights(count, random);
    const std::uint32_t n = lit.leaf_count();
    const DenseLights lights(n, lit.frame);
    const std::size_t words = words_for_bits(n);
    const auto bits = random_rows(words, random);
    const std::span<const std::uint64_t> a(bits.data(), words), b(bits.data() + words, words),
        c(bits.data() + 2 * words, words);
    for (const ShadingPoint& p : random_points(wide_materials, 6, random)) {
      std::vector<float> visibility;
      for (std::uint32_t i = 0; i < n; ++i)
        visibility.push_back(interpolate(p, bit_at(a.data(), i), bit_at(b.data(), i), bit_at(c.data(), i)));
      const vec3 expected =
          reference::dense_radiance(p, lit.leaf_directions(), lit.leaf_powers(), visibility);
      check_near(shade_brute_force<Skip::nothing>(p, lights, a, b, c), expected);
      check_near(shade_brute_force<Skip::unseen>(p, lights, a, b, c), expected);
    }
  }
}

TEST_CASE("shading by faces is shading by points, in any split, and counts each point's clusters") {
  Random random(4);
  const LitTree lit = random_lit_tree(256, 20, 0, random);
  MaskedCuts<std::uint8_t> cuts(256, 0);
  cuts.append(Cut<std::uint8_t>{{128, 192, 256}, {255, 0, 100}}, {random.direction(), -0.1f});
  cuts.append(Cut<std::uint8_t>{{64, 128, 256}, {0, 20, 0}});
  cuts.append(Cut<std::uint8_t>{{256}, {200}});
  ShadingBuffer buffer;
  buffer.points = random_points(wide_materials, 6, random);
  buffer.faces = {{{0, 1, 2}, 0}, {{2, 2, 0}, 7}, {{1, 1, 1}, 8}};
  for (const LobeOptions lobes : {LobeOptions{Lobes::sampled}, {Lobes::filtered}, {Lobes::refined, 1e-3f}}) {
    std::vector<vec3> whole(buffer.points.size()), split(buffer.points.size());
    std::vector<std::uint32_t> counts(buffer.points.size());
    shade_faces<std::uint8_t>(buffer, cuts, lit.frame, lobes, 0, 3, whole, counts);
    for (std::size_t f = 3; f-- > 0;)
      shade_faces<std::uint8_t>(buffer, cuts, lit.frame, lobes, f, f + 1, split, {});
    CHECK(whole == split);
    FaceMerger<std::uint8_t> merger(cuts, lit.frame);
    ClusterList clusters;
    RefinementScratch scratch;
    for (std::size_t f = 0; f < 3; ++f) {
      merger.merge(buffer.faces[f].receivers, clusters);
      for (std::uint32_t p = buffer.faces[f].first_point; p < buffer.end_of(f); ++p) {
        const auto shaded =
            shade_point(buffer.points[p], clusters, 1.0f / 255, lobes, lit.frame.nodes, scratch);
        CHECK(counts[p] == shaded.clusters);
        CHECK(whole[p] == shaded.radiance);
        CHECK((lobes.lobes == Lobes::refined || counts[p] == clusters.size()));
      }
    }
    CHECK(std::ranges::any_of(whole, [](const vec3& r) { return r.x > 0; }));
  }
}

TEST_CASE("each point of a face weighs its receivers by its own place in it") {
  Random random(5);
  const LitTree lit = coloured_lights(64, random);
  MaskedCuts<std::uint16_t> cuts(64, 0);
  for (const std::uint16_t value : {65535, 30000, 100}) cuts.append(Cut<std::uint16_t>{{64}, {value}});
  ShadingBuffer buffer;
  buffer.points = random_points(wide_materials, 6, random);
  buffer.faces = {{{2, 0, 1}, 0}};
  std::vector<vec3> radiance(buffer.points.size());
  shade_faces<std::uint16_t>(buffer, cuts, lit.frame, {Lobes::sampled}, 0, 1, radiance, {});
  for (std::size_t i = 0; i < radiance.size(); ++i) {
    const ShadingPoint& p = buffer.points[i];
    const std::vector<float> visibility(64, interpolate(p, 100, 65535, 30000) / 65535);
    check_near(radiance[i],
               reference::dense_radiance(p, lit.leaf_directions(), lit.leaf_powers(), visibility));
  }
}
