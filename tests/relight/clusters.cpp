// The merged clusters of a face against the merge of its unpacked cuts, cluster by cluster.
#include <doctest/doctest.h>

#include <coppice/core/random.hpp>
#include <coppice/cut/merge.hpp>
#include <coppice/light/directions.hpp>
#include <coppice/relight/clusters.hpp>
#include <coppice/tree/build.hpp>

using namespace coppice;

namespace {

struct Cluster {
  vec3 direction, power;
  std::array<float, 3> visible;
  bool operator==(const Cluster&) const = default;
};

struct Lighting {
  LightTree tree;
  FrameLighting frame;
};

/// A few bright lights among dim and dark ones.
Lighting random_lighting(std::uint32_t count, std::size_t nodes, std::uint32_t granule_log2, Random& random) {
  const auto directions = even_directions(count, 4);
  std::vector<LightSample> samples;
  std::vector<CellLight> lights;
  for (const vec3& d : directions) {
    const float kind = random.uniform();
    samples.push_back({d, vec3(0)});
    lights.push_back({kind < 0.3f
                          ? vec3(0)
                          : vec3(random.uniform(), 0.5f, random.uniform()) * (kind > 0.95f ? 100.0f : 1.0f),
                      0.01f});
  }
  Lighting result{build_tree(GeometricMetric(samples)), {}};
  result.frame = light_frame(result.tree, lights, directions, nodes, granule_log2);
  return result;
}

Cut<std::uint8_t> random_cut(std::uint32_t leaf_count, std::uint32_t granule_log2, Random& random) {
  const std::uint32_t granules = leaf_count >> granule_log2;
  const std::size_t size = 1 + random.below(std::min(granules, 200u));
  std::vector<float> priority(2 * std::size_t(granules));
  for (float& p : priority) p = random.uniform();
  auto ends = refine_cut(
      granules, [&](std::uint32_t h) { return priority[h]; }, 0.0, size);
  auto cut = cut_with_values(granules, std::move(ends), [&](std::uint32_t) {
    return std::uint8_t(random.below(3) == 0 ? 0 : random.below(256));
  });
  for (auto& end : cut.ends) end <<= granule_log2;
  return cut;
}

std::vector<Cluster> slow_merge(const MaskedCuts<std::uint8_t>& cuts, const uvec3& r,
                                const Lighting& lighting) {
  const std::uint32_t n = lighting.tree.leaf_count();
  const auto a = cuts.unpack(r.x), b = cuts.unpack(r.y), c = cuts.unpack(r.z);
  const Cut<std::uint8_t> illumination{lighting.frame.ends,
                                       std::vector<std::uint8_t>(lighting.frame.ends.size())};
  std::vector<Cluster> clusters;
  merge_cuts(
      [&](LeafRange range, int va, int vb, int vc, int) {
        const LightNode& node = lighting.frame.nodes[node_of_range(n, range.begin, range.end)];
        if (va + vb + vc > 0 && node.power != vec3(0))
          clusters.push_back({node.direction, node.power, {float(va), float(vb), float(vc)}});
      },
      a, b, c, illumination);
  return clusters;
}

Cluster cluster_at(const ClusterList& list, std::size_t i) {
  const auto at = [&](ClusterList::Field f) { return list.field(f)[i]; };
  return {{at(ClusterList::x), at(ClusterList::y), at(ClusterList::z)},
          {at(ClusterList::red), at(ClusterList::green), at(ClusterList::blue)},
          {at(ClusterList::visible_0), at(ClusterList::visible_1), at(ClusterList::visible_2)}};
}

void check_merge(const MaskedCuts<std::uint8_t>& cuts, const uvec3& receivers, const Lighting& lighting,
                 ClusterList& list) {
  merge_face(cuts, receivers, lighting.frame, list);
  const auto expected = slow_merge(cuts, receivers, lighting);
  REQUIRE(list.size() == expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) REQUIRE(cluster_at(list, i) == expected[i]);
  CHECK(list.padded_size() % Lanes::width == 0);
  CHECK(list.padded_size() < list.size() + Lanes::width);
  for (std::size_t i = list.size(); i < list.padded_size(); ++i) CHECK(cluster_at(list, i).power == vec3(0));
}

}  // namespace

TEST_CASE("a face's clusters are those of its cuts and the illumination cut, at every size and granule") {
  Random random(5);
  ClusterList list;  // reused: nothing of an earlier face may stay
  for (const std::uint32_t leaves : {1u, 2u, 16u, 4096u})
    for (const double sigma : {0.3, 1.0, 1.5, 2.0, 3.0})
      for (const std::size_t nodes :
           {std::size_t{1}, std::size_t{7}, std::size_t{300}, std::size_t{leaves}}) {
        const std::uint32_t granule_log2 = granule_log2_for(sigma, leaves);
        const Lighting lighting = random_lighting(leaves, nodes, granule_log2, random);
        MaskedCuts<std::uint8_t> cuts(leaves, granule_log2);
        for (int i = 0; i < 3; ++i) cuts.append(random_cut(leaves, granule_log2, random));
        check_merge(cuts, {0, 1, 2}, lighting, list);
        check_merge(cuts, {2, 2, 2}, lighting, list);
      }
}

TEST_CASE("an illumination cut finer than the granules splits them") {
  Random random(6);
  const std::uint32_t granule_log2 = granule_log2_for(3, 4096);
  REQUIRE(granule_log2 == 5);
  const Lighting lighting = random_lighting(4096, 4096, granule_log2, random);
  MaskedCuts<std::uint8_t> cuts(4096, granule_log2);
  cuts.append(Cut<std::uint8_t>{{4096}, {255}});
  ClusterList list;
  check_merge(cuts, {0, 0, 0}, lighting, list);
  CHECK(list.size() > 4096 / 32);
}

TEST_CASE("with everything visible the clusters carry the whole power") {
  Random random(7);
  ClusterList list;
  for (const std::uint32_t count : {1u, 3u, 1000u, 4096u})
    for (const std::size_t nodes : {1u, 50u, 4096u}) {
      const std::uint32_t leaves = leaf_count_for(count), granule_log2 = granule_log2_for(2, leaves);
      const Lighting lighting = random_lighting(count, nodes, granule_log2, random);
      MaskedCuts<std::uint8_t> cuts(leaves, granule_log2);
      for (int i = 0; i < 3; ++i) {
        auto cut = random_cut(leaves, granule_log2, random);
        std::ranges::fill(cut.values, std::uint8_t{255});
        cuts.append(cut);
      }
      merge_face(cuts, {0, 1, 2}, lighting.frame, list);
      glm::dvec3 sum(0);
      for (std::size_t i = 0; i < list.size(); ++i) sum += glm::dvec3(cluster_at(list, i).power);
      const glm::dvec3 total(lighting.frame.nodes[1].power);
      CHECK(glm::length(sum - total) <= 1e-6 * glm::length(total));
    }
}

TEST_CASE("nothing visible or nothing lit leaves no clusters") {
  Random random(8);
  const Lighting lighting = random_lighting(64, 16, 0, random);
  MaskedCuts<std::uint8_t> cuts(64, 0);
  cuts.append(Cut<std::uint8_t>{{32, 64}, {0, 0}});
  cuts.append(Cut<std::uint8_t>{{64}, {255}});
  ClusterList list;
  merge_face(cuts, {0, 0, 0}, lighting.frame, list);
  CHECK(list.size() == 0);
  CHECK(list.padded_size() == 0);
  const auto directions = even_directions(64);
  const auto night =
      light_frame(lighting.tree, std::vector<CellLight>(64, {vec3(0), 0.2f}), directions, 16, 0);
  merge_face(cuts, {1, 1, 1}, night, list);
  CHECK(list.size() == 0);
}
