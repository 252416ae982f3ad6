// One ray a cluster: right on the mean over the draws, whatever is in between, and counted.
#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <coppice/gather/traced_gather.hpp>
#include <cstring>

#include "gather/vpls.hpp"
#include "support/executors.hpp"

using namespace coppice;

namespace {

constexpr VplChoice choices[] = {VplChoice::energy, VplChoice::contribution};
constexpr std::uint32_t mixed_sizes[] = {1, 4, 8, 2};
const support::HalfSpace blocked{normalize(vec3(1, 0.3f, -0.2f)), 0.4f};
const support::SphereOccluder balls{{{vec3(0.5f, 0.3f, 0), 0.7f}, {vec3(-0.8f, -0.4f, 0.6f), 0.6f}}};

/// Counts the rays that it is asked for, and sees through everything.
struct CountingOccluder {
  std::atomic<std::size_t>& rays;

  bool occluded(const vec3&, const vec3&, float) const {
    ++rays;
    return false;
  }
  std::uint32_t occluded(const ShadowPacket&, std::uint32_t lanes) const {
    rays += std::size_t(std::popcount(lanes));
    return 0;
  }
};

/// The sum over the VPLs that the point sees.
template <Occluder O>
glm::dvec3 seen(std::span<const VplNode> vpls, const GlossyPoint& p, const O& occluder) {
  glm::dvec3 sum(0);
  for (const VplNode& n : vpls) {
    const vec3 way = n.position - p.position;
    const float distance = length(way);
    if (distance > 0 && !occluder.occluded(p.position, way / distance, distance * (1 - 1e-4f)))
      sum += reference::reflected(n, p);
  }
  return sum;
}

bool same_bits(const Gathered& a, const Gathered& b) {
  return a.nodes == b.nodes && a.tests == b.tests && a.radiance.size() == b.radiance.size() &&
         std::memcmp(a.radiance.data(), b.radiance.data(), a.radiance.size() * sizeof(vec3)) == 0;
}

/// Mean and its standard error, a channel.
struct Mean {
  glm::dvec3 sum{0}, squares{0};
  double count = 0;

  void add(const glm::dvec3& x) { sum += x, squares += x * x, ++count; }
  glm::dvec3 mean() const { return sum / count; }
  glm::dvec3 error() const {
    return glm::sqrt(glm::max(squares / count - mean() * mean(), glm::dvec3(0)) / count);
  }
};

/// Checks each point's mean over the seeds; returns how many channels had any spread.
template <Occluder O>
std::size_t check_mean(const VplTree& tree, std::span<const VplNode> vpls, const PointGroups& groups,
                       VplChoice choice, const O& occluder, int draws, float threshold) {
  std::vector<Mean> means(groups.points.size());
  for (int seed = 0; seed < draws; ++seed) {
    const Gathered g =
        gather_traced(tree, groups, threshold, choice, occluder, std::uint64_t(1000 * seed), Serial());
    for (std::size_t i = 0; i < means.size(); ++i) means[i].add(glm::dvec3(g.radiance[i]));
  }
  std::size_t spread = 0;
  for (std::size_t i = 0; i < means.size(); ++i) {
    const glm::dvec3 exact = seen(vpls, groups.points[i], occluder), error = means[i].error();
    CAPTURE(i);
    for (int c = 0; c < 3; ++c) {
      CHECK(std::abs(means[i].mean()[c] - exact[c]) <= 4 * error[c] + 1e-4 * exact[c] + 1e-9);
      spread += error[c] > 1e-4 * exact[c];
    }
  }
  return spread;
}

template <Occluder O>
void check_choices(std::uint64_t seed, const O& occluder, const VplTreeOptions& options) {
  Random random(seed);
  const auto vpls = support::room_vpls(random, 200, 30);
  const VplTree tree(vpls, options);
  const PointGroups groups = support::in_groups(support::room_points(random, 12, 30), mixed_sizes);
  for (const VplChoice choice : choices)
    CHECK(check_mean(tree, vpls, groups, choice, occluder, 2000, 30) > 8);
}

std::vector<VplNode> leaves_of(const VplTree& tree) { return support::vpls_below(tree, 1); }

}  // namespace

TEST_CASE("with nothing in between the mean is the sum over all VPLs, for both choices") {
  check_choices(1, support::nothing, {});
  check_choices(2, support::nothing, {.filter = VplFilter::uniform});
}

TEST_CASE("with something in between the mean is the sum over the VPLs that are seen") {
  check_choices(3, blocked, {});
  check_choices(4, balls, {});
}

TEST_CASE("trees of fewer leaves than a register has lanes are right on the mean too") {
  Random random(5);
  for (const std::size_t count : {1u, 2u, 3u, 4u, 7u}) {
    const auto vpls = support::room_vpls(random, count, 30);
    const VplTree tree(vpls);
    const PointGroups groups = support::in_groups(support::room_points(random, 20, 30), mixed_sizes);
    for (const VplChoice choice : choices) check_mean(tree, vpls, groups, choice, blocked, 1000, 10);
  }
}

TEST_CASE("where every VPL has its ray the sum is exact, whatever the seed") {
  Random random(6);
  const auto vpls = support::room_vpls(random, 150, 30);
  const VplTree tree(vpls);
  const PointGroups groups = support::in_groups(support::room_points(random, 60, 30), mixed_sizes);
  for (const VplChoice choice : choices)
    for (const std::uint64_t seed : {0u, 1u}) {
      const Gathered g = gather_traced(tree, groups, 0, choice, balls, seed, Serial());
      for (std::size_t i = 0; i < groups.points.size(); ++i) {
        const glm::dvec3 exact = seen(vpls, groups.points[i], balls);
        CHECK(glm::length(glm::dvec3(g.radiance[i]) - exact) <= 1e-4 * glm::length(exact) + 1e-9);
      }
    }
}

TEST_CASE("what carries light arrives from the VPLs that were drawn") {
  Random random(7);
  const auto vpls = support::room_vpls(random, 60, 30);
  const VplTree tree(vpls);
  const TracedNodes traced(tree, VplChoice::contribution);
  std::vector<std::uint32_t> ids(tree.leaf_count());
  std::iota(ids.begin(), ids.end(), tree.leaf_count());
  for (GlossyPoint p : support::room_points(random, 20)) {
    p.diffuse = vec3(pi), p.specular = vec3(0);
    std::uint32_t rays = 0;
    const auto arrived = traced.arrive(p, ids, Random(1), balls, rays);
    std::vector<VplNode> visible;
    for (const VplNode& n : leaves_of(tree))
      if (seen(std::span(&n, 1), p, balls) != glm::dvec3(0)) visible.push_back(n);
    const auto exact = reference::received(visible, p.position, p.normal);
    CHECK(glm::length(arrived.radiance - exact.irradiance) <= 1e-4 * glm::length(exact.irradiance) + 1e-9);
    CHECK(glm::length(arrived.towards - exact.towards) <= 1e-4 * support::luminance(exact.irradiance) + 1e-9);
  }
}

TEST_CASE("rays are counted, one a cluster at most, none where nothing is brought") {
  Random random(8);
  const VplTree tree(support::room_vpls(random, 300));
  auto points = support::room_points(random, 100);
  points[7].position = vec3(0, 9, 0), points[7].normal = vec3(0, 1, 0);
  const PointGroups groups = support::in_groups(points, mixed_sizes);
  std::vector<std::size_t> sizes(points.size());
  const std::size_t tests =
      GroupLists(tree, groups, 0.1f, Serial(), SplitBy::bound)
          .for_each(0, groups.size(), [&](std::size_t first, auto group, auto ids) {
            std::fill_n(sizes.begin() + std::ptrdiff_t(first), group.size(), ids.size());
          });
  for (const VplChoice choice : choices) {
    std::atomic<std::size_t> rays = 0;
    const Gathered g = gather_traced(tree, groups, 0.1f, choice, CountingOccluder{rays}, 3, Serial());
    CHECK(rays > 0);
    CHECK(std::accumulate(g.nodes.begin(), g.nodes.end(), std::size_t{0}) == rays);
    for (std::size_t i = 0; i < points.size(); ++i) CHECK(g.nodes[i] <= sizes[i]);
    CHECK((g.nodes[7] == 0 && g.radiance[7] == vec3(0)));
    CHECK(g.tests == tests);
  }
}

TEST_CASE("a VPL drawn by what it brings has less spread than one drawn by energy") {
  Random random(9);
  const auto vpls = support::room_vpls(random, 300, 30);
  const VplTree tree(vpls);
  const PointGroups groups = support::in_groups(support::room_points(random, 30, 30), std::array{1u});
  double squared[2]{};
  for (const VplChoice choice : choices)
    for (std::uint64_t seed = 0; seed < 50; ++seed) {
      const Gathered g = gather_traced(tree, groups, 1, choice, support::nothing, 1000 * seed, Serial());
      for (std::size_t i = 0; i < groups.points.size(); ++i) {
        const double exact = support::luminance(reference::reflected_by_all(vpls, groups.points[i]));
        const double off = double(luminance(g.radiance[i])) - exact;
        if (exact > 1e-6) squared[int(choice)] += off * off / (exact * exact);
      }
    }
  if (Lanes::width == 1)
    CHECK(squared[1] == squared[0]);  // there is one to choose from
  else
    CHECK(squared[1] < 0.7 * squared[0]);  // measured: 0.54 of 4 lanes, 0.05 of 16
}

TEST_CASE("the seed and the pixel decide, not the executor or the group's place") {
  Random random(10);
  const VplTree tree(support::room_vpls(random, 400));
  const PointGroups groups = support::in_groups(support::room_points(random, 300), mixed_sizes);
  for (const VplChoice choice : choices) {
    const auto on = [&](const auto& executor, std::uint64_t seed) {
      return gather_traced(tree, groups, 0.2f, choice, balls, seed, executor);
    };
    const Gathered one = on(Serial(), 1);
    CHECK(same_bits(one, on(support::Backwards(), 1)));
    CHECK(same_bits(one, on(support::Backwards{1}, 1)));
    CHECK(same_bits(one, on(support::TwoThreads(), 1)));
    CHECK(!same_bits(one, on(Serial(), 777)));
  }
}

TEST_CASE("VPLs that bring next to nothing stay next to nothing, whatever is drawn") {
  std::uint64_t last = 0;  // a seed of the greatest random number
  while (Random(last).uniform() < 1 - 0x1p-24f) ++last;
  Random random(11);
  GlossyPoint p{};
  p.normal = p.mirror = vec3(0, 1, 0), p.exponent = 1, p.diffuse = vec3(1);
  std::size_t finite = 0;
  for (int round = 0; round < 3000; ++round) {
    std::vector<VplNode> vpls;
    for (std::size_t i = 0; i < Lanes::width; ++i) {
      VplNode n = support::any_vpl(random, vec3(float(i), 3, 0), vec3(0, -1, 0));
      n.specular = vec3(0), n.diffuse = vec3(random.uniform());
      if (random.below(4) == 0) n.diffuse = vec3(3e-40f, 0, 3e-40f);
      n.energy = vpl_energy(n.diffuse, n.specular);
      vpls.push_back(n);
    }
    const VplTree tree(vpls);
    std::uint32_t rays = 0;
    const vec3 radiance = TracedNodes(tree, VplChoice::contribution)
                              .reflect(p, std::array{1u}, Random(last), support::nothing, rays);
    finite += is_finite(radiance);
  }
  CHECK(finite == 3000);
}

TEST_CASE("without light or VPLs no ray is traced, and a VPL at the point itself takes none") {
  Random random(12);
  auto vpls = support::room_vpls(random, 30);
  const auto points = support::room_points(random, 20);
  const PointGroups groups = support::in_groups(points, mixed_sizes);
  VplNode at = vpls[0];
  at.position = points[0].position, at.diffuse = vec3(1);
  for (VplNode& n : vpls) n.diffuse = n.specular = vec3(0), n.energy = 0;
  for (const VplChoice choice : choices) {
    for (const VplTree& tree : {VplTree(vpls), VplTree(std::vector<VplNode>{})}) {
      const Gathered g = gather_traced(tree, groups, 0.1f, choice, balls, 1, Serial());
      for (std::size_t i = 0; i < points.size(); ++i) CHECK((g.radiance[i] == vec3(0) && g.nodes[i] == 0));
    }
    const Gathered g = gather_traced(VplTree(std::vector{at}), groups, 0.1f, choice, balls, 1, Serial());
    CHECK((g.radiance[0] == vec3(0) && g.nodes[0] == 0));
  }
}
