// Groups of points: complete, within tiles, alike.
#include <doctest/doctest.h>

#include <algorithm>
#include <coppice/gather/point_groups.hpp>
#include <cstring>

#include "gather/vpls.hpp"

using namespace coppice;

namespace {

constexpr vec3 eye(0.3f, 0.1f, -4);

/// Some of the pixels of an image of two bumpy planes with points at random depths among them.
std::vector<GlossyPoint> points_of_image(Random& random, int width, int height) {
  std::vector<GlossyPoint> points;
  for (int i = 0; i < width * height; ++i) {
    if (random.below(5) == 0) continue;
    const float x = float(i % width) / float(width), y = float(i / width) / float(height);
    const bool is_left = x < 0.4f, is_odd = random.below(20) == 0;
    const vec3 place(x, y, is_odd ? 3 * random.uniform() : is_left ? 0.5f * x : 1 - y);
    const vec3 normal = normalize(vec3(is_left ? -1 : 1, 1, -2) + 0.2f * random.direction());
    points.push_back(support::any_point(random, place, normal));
    support::look_from(points.back(), normalize(eye - place));
    points.back().pixel = std::uint32_t(i);
  }
  return points;
}

std::uint32_t tile_of(const GlossyPoint& p, std::uint32_t width, std::uint32_t tile) {
  const std::uint32_t columns = (width + tile - 1) / tile;
  return p.pixel / width / tile * columns + p.pixel % width / tile;
}

}  // namespace

TEST_CASE("every point is in one group, unchanged but for the group's number") {
  Random random(1);
  for (const int width : {1, 7, 8, 37, 64}) {
    auto points = points_of_image(random, width, 29);
    const PointGroups groups = group_points(points, width, eye);
    REQUIRE(groups.points.size() == points.size());
    std::size_t first = 0;
    for (std::size_t g = 0; g < groups.size(); ++g) {
      CHECK(groups.first(g) == first);
      CHECK(!groups.group(g).empty());
      for (const GlossyPoint& p : groups.group(g)) CHECK(p.group == g);
      first = groups.ends[g];
    }
    CHECK(first == points.size());
    auto found = groups.points;
    std::ranges::sort(found, {}, &GlossyPoint::pixel);
    for (GlossyPoint& p : found) p.group = 0;
    CHECK(std::memcmp(found.data(), points.data(), points.size() * sizeof(GlossyPoint)) == 0);
  }
}

TEST_CASE("groups stay in their tiles, in the order of tiles and first points") {
  Random random(2);
  for (const int tile : {1, 3, 8, 100}) {
    const PointGroups groups = group_points(points_of_image(random, 50, 31), 50, eye, {.tile = tile});
    std::pair<std::uint32_t, std::uint32_t> last{0, 0};
    for (std::size_t g = 0; g < groups.size(); ++g) {
      const std::uint32_t at = tile_of(groups.group(g)[0], 50, std::uint32_t(tile));
      for (const GlossyPoint& p : groups.group(g)) {
        CHECK(tile_of(p, 50, std::uint32_t(tile)) == at);
        CHECK(p.pixel >= groups.group(g)[0].pixel);
      }
      const std::pair here{at, groups.group(g)[0].pixel};
      CHECK((g == 0 || here > last));
      last = here;
    }
  }
}

TEST_CASE("points of a group are like its first, and a later group's first is like no earlier one's") {
  Random random(3);
  const GroupOptions options{.normal_cosine = 0.9f, .mirror_cosine = 0.8f, .plane = 0.05f, .reach = 0.08f};
  const PointGroups groups = group_points(points_of_image(random, 64, 48), 64, eye, options);
  CHECK(groups.size() > 100);
  CHECK(groups.size() < groups.points.size() / 3);
  const auto alike = [&](const GlossyPoint& a, const GlossyPoint& b) {
    const double depth = double(length(a.position - eye));
    const glm::dvec3 apart(b.position - a.position);
    return double(dot(a.normal, b.normal)) >= 0.9 && double(dot(a.mirror, b.mirror)) >= 0.8 &&
           std::abs(glm::dot(apart, glm::dvec3(a.normal))) <= 0.05 * depth &&
           glm::length(apart) <= 0.08 * depth;
  };
  std::size_t wrong = 0;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const GlossyPoint& first = groups.group(g)[0];
    for (const GlossyPoint& p : groups.group(g)) wrong += !alike(first, p);
    for (std::size_t before = 0; before < g; ++before)
      if (tile_of(groups.group(before)[0], 64, 8) == tile_of(first, 64, 8))
        wrong += alike(groups.group(before)[0], first);
  }
  CHECK(wrong == 0);
}

TEST_CASE("no point makes no group, one point one") {
  Random random(4);
  CHECK(group_points({}, 5, eye).size() == 0);
  CHECK(group_points({}, 5, eye).points.empty());
  auto points = support::room_points(random, 1);
  for (const std::uint32_t pixel : {0u, 14u, 1000000u}) {
    points[0].pixel = pixel;
    const PointGroups one = group_points(points, 5, eye);
    REQUIRE(one.size() == 1);
    CHECK(one.group(0).size() == 1);
    CHECK((one.points[0].pixel == pixel && one.points[0].group == 0));
  }
  points[0].position = eye;  // no depth at all
  CHECK(group_points(std::vector{points[0], points[0]}, 5, eye).size() == 1);
}

TEST_CASE("tiles of scattered points grow so that they hold about 64, up to 64 pixels") {
  for (const auto& [points, tile] :
       {std::pair{10000u, 8}, {2500u, 16}, {1111u, 24}, {100u, 64}, {1u, 64}, {0u, 64}})
    CHECK(scattered_groups(points, 10000).tile == tile);
  for (std::size_t points = 157; points <= 10000; points += 97) {
    const int tile = scattered_groups(points, 10000).tile;
    CHECK(double(points) / 10000 * tile * tile == doctest::Approx(64).epsilon(0.15));
  }
}
