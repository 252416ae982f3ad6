// Clusters: every sample once, sizes alike, sides apart; and what the coverage report says.
#include <doctest/doctest.h>

#include <coppice/reference/dart_throwing.hpp>
#include <coppice/transfer/coverage.hpp>
#include <coppice/transfer/room_samples.hpp>
#include <map>
#include <set>

#include "rooms.hpp"
#include "support/executors.hpp"

using namespace coppice;

namespace {

/// A box room with a table top without thickness, 1,500 samples.
const std::vector<SurfaceSample>& room() {
  static const auto samples = [] {
    Scene scene = support::box_room();
    support::add_quad(scene.mesh, {0.2f, 1, 0.2f}, {1.6f, 0, 0}, {0, 0, 3.6f});
    return room_samples(support::particles_in(scene, {vec3(1, 2, 2)}, {.count = 9000}).candidates, Serial(),
                        {.count = 1500});
  }();
  return samples;
}

using Key = std::array<float, 4>;
Key key(const SurfaceSample& s) { return {s.position.x, s.position.y, s.position.z, s.area}; }

std::pair<std::size_t, std::size_t> sizes(const ClusteredSamples& c) {
  std::size_t least = c.size(), most = 0;
  for (std::size_t i = 0; i < c.cluster_count(); ++i)
    least = std::min(least, c.size(i)), most = std::max(most, c.size(i));
  return {least, most};
}

}  // namespace

TEST_CASE("clusters hold every sample once and are of one size, nearly") {
  const auto clustered = cluster_samples(room(), Serial(), {.count = 20});
  REQUIRE(clustered.cluster_count() == 20);
  CHECK(clustered.ends.back() == room().size());
  CHECK(std::ranges::is_sorted(clustered.ends));
  std::multiset<Key> before, after;
  for (const auto& s : room()) before.insert(key(s));
  for (const auto& s : clustered.samples) after.insert(key(s));
  CHECK(before == after);
  const auto [least, most] = sizes(clustered);
  CHECK(least > room().size() / 20 / 2);
  CHECK(most < 2 * room().size() / 20);
}

TEST_CASE("balance makes clusters' sizes more alike than plain k-means and than the nearest roots") {
  const auto ratio = [](const ClusterOptions& options) {
    const auto [least, most] = sizes(cluster_samples(room(), Serial(), options));
    return double(most) / double(least);
  };
  const double balanced = ratio({.count = 24, .balance = 1});
  CHECK(balanced < ratio({.count = 24, .balance = 0}));
  CHECK(balanced < ratio({.count = 24, .steps = 0}));
}

TEST_CASE("without steps samples are with the nearest root, by brute force too") {
  const ClusterOptions options{.count = 16, .steps = 0};
  const auto clustered = cluster_samples(room(), Serial(), options);
  const auto roots = cluster_roots(room(), 16);
  double area = 0;
  for (const auto& s : room()) area += double(s.area);
  const auto size2 = float(area / double(roots.size()));
  std::map<std::uint32_t, std::multiset<Key>> expected;
  for (const auto& s : room())
    expected[reference::nearest_root(s, roots, size2, options.normal_weight)].insert(key(s));
  REQUIRE(clustered.cluster_count() == expected.size());
  std::size_t c = 0;
  for (const auto& [root, members] : expected) {
    std::multiset<Key> found;
    for (const auto& s : clustered.of(c++)) found.insert(key(s));
    CHECK(found == members);
  }
}

TEST_CASE("no cluster holds both sides of a sheet") {
  const auto clustered = cluster_samples(room(), Serial(), {.count = 20});
  for (std::size_t c = 0; c < clustered.cluster_count(); ++c) {
    bool above = false, below = false;
    for (const auto& s : clustered.of(c))
      if (s.side.triangle >= 12) (s.normal.y > 0 ? above : below) = true;
    CHECK_FALSE((above && below));
  }
}

TEST_CASE("neighbours in a cluster's order are near each other") {
  const auto clustered = cluster_samples(room(), Serial(), {.count = 4});
  double step = 0, any = 0, count = 0;
  Random random(1);
  for (std::size_t c = 0; c < 4; ++c) {
    const auto members = clustered.of(c);
    for (std::size_t i = 1; i < members.size(); ++i, ++count) {
      step += double(length(members[i].position - members[i - 1].position));
      any +=
          double(length(members[i].position - members[random.below(std::uint32_t(members.size()))].position));
    }
  }
  CHECK(step < 0.3 * any);
}

TEST_CASE("clusters of none, of one, and more than samples") {
  CHECK(cluster_samples({}, Serial()).cluster_count() == 0);
  CHECK(cluster_samples(room(), Serial(), {.count = 0}).size() == 0);
  const auto one = cluster_samples(room(), Serial(), {.count = 1});
  REQUIRE(one.cluster_count() == 1);
  CHECK(one.size(0) == room().size());
  const std::span<const SurfaceSample> three = std::span(room()).first(3);
  CHECK(cluster_samples(three, Serial(), {.count = 48}).size() == 3);
}

TEST_CASE("clusters are the same for any executor") {
  const auto same = [](const ClusteredSamples& a, const ClusteredSamples& b) {
    return a.ends == b.ends && std::ranges::equal(a.samples, b.samples, {}, key, key);
  };
  const auto serial = cluster_samples(room(), Serial());
  CHECK(same(serial, cluster_samples(room(), support::Backwards())));
  CHECK(same(serial, cluster_samples(room(), support::TwoThreads())));
}

TEST_CASE("the coverage report measures a lattice and finds a hole in it") {
  ClusteredSamples lattice;
  for (int x = 0; x < 10; ++x)
    for (int y = 0; y < 10; ++y) {
      SurfaceSample& s = lattice.samples.emplace_back();
      s.position = vec3(x, y, 0), s.area = 1, s.normal = {0, 0, 1};
    }
  lattice.ends = {30, 70, 100};
  std::vector<SurfaceSample> fresh(4, lattice.samples[55]);
  fresh[1].position += vec3(0.4f, 0, 0);
  fresh[2].position += vec3(0, 0, 0.9f);  // farther than the radius
  fresh[3].normal = {0, 0, -1};           // the side that no sample is on
  ParticleField field;
  field.traced = 7, field.escaped = 5, field.stray = 3;
  const auto report = coverage(lattice, field, fresh, 0.5f, Serial());
  CHECK(report.samples == 100);
  CHECK(report.spacing == doctest::Approx(1));
  CHECK(report.nearest_mean == doctest::Approx(1));
  CHECK(report.nearest_deviation == doctest::Approx(0));
  CHECK(report.nearest_min == doctest::Approx(1));
  CHECK(report.nearest_max == doctest::Approx(1));
  CHECK(report.beyond_radius == doctest::Approx(0.5));
  CHECK(report.smallest_cluster == 30);
  CHECK(report.median_cluster == 30);
  CHECK(report.largest_cluster == 40);
  CHECK(report.traced == 7);
  CHECK(report.escaped == 5);
  CHECK(report.stray == 3);
  const auto none = coverage(ClusteredSamples(), ParticleField(), fresh, 0.5f, Serial());
  CHECK(none.samples == 0);
  CHECK(none.beyond_radius == 1);
}
