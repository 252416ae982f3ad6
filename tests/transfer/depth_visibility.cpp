// Shadows from compressed depth maps against uncompressed ones and shadow rays.
#include <coppice/transfer/depth_visibility.hpp>
//
#include <doctest/doctest.h>

#include <coppice/reference/depth_visibility.hpp>
#include <coppice/transfer/decisions.hpp>
#include <support/executors.hpp>
#include <support/generators.hpp>
#include <support/occluders.hpp>
#include <support/scenes.hpp>

using namespace coppice;

namespace {

/// A box in a closed room of 4 × 3 × 4 m, whose walls face inwards.
struct Room {
  Mesh mesh;
  ClusteredSamples samples;
  std::vector<Flight> flights;
};

std::vector<SurfaceSample> scatter(const Mesh& mesh, std::size_t count) {
  std::vector<TriangleSide> sides;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) sides.push_back({t, t >= 12});
  return scatter_samples(mesh, sides, count, Shares::by_area, 1);
}

Room box_in_room(std::size_t count, std::size_t clusters) {
  Room room;
  support::add_box(room.mesh, {-2, 0, -2}, {2, 3, 2});
  support::add_box(room.mesh, {-0.5f, 0.4f, -0.4f}, {0.4f, 1.3f, 0.5f});
  room.samples.samples = scatter(room.mesh, count);
  for (std::size_t c = 1; c <= clusters; ++c)
    room.samples.ends.push_back(std::uint32_t(room.samples.size() * c / clusters));
  const support::TriangleTracer tracer(room.mesh);
  Random random(3);
  while (room.flights.size() < 20000) {
    const SurfaceSample& s = room.samples.samples[random.below(std::uint32_t(room.samples.size()))];
    const vec3 d = detail::cosine_direction(random, s.normal), origin = ray_origin(s);
    if (const auto hit = tracer.closest(origin, d)) room.flights.push_back({origin, origin + hit->t * d});
  }
  return room;
}

const Room& shared_room() {
  static const Room room = box_in_room(300, 6);
  return room;
}

std::vector<SizedLight> lights_in(const Room& room, std::size_t count) {
  Random random(5);
  std::vector<SizedLight> lights;
  while (lights.size() < count) {
    const Flight& f = room.flights[random.below(std::uint32_t(room.flights.size()))];
    if (length(f.to - f.from) > 0.5f)
      lights.push_back({point_light(glm::mix(f.from, f.to, 0.5f), vec3(1)), 0});
  }
  return lights;
}

template <class Visibility>
std::vector<float> values(const Visibility& visibility, const ClusteredSamples& samples,
                          const SizedLight& light) {
  std::vector<float> result(samples.size(), -1);
  visibility.visibility(light, Serial(), result);
  return result;
}

constexpr float room_limit = 5;

DepthOptions room_options(Dome dome, std::size_t rank, int rounds) {
  return {.directions = dome == Dome::sphere ? 1000u : 500u,
          .dome = dome,
          .rank = rank,
          .rounds = rounds,
          .limit = room_limit};
}

/// Nothing is ever hit.
struct OpenSky {
  std::optional<Hit> closest(const vec3&, const vec3&) const { return std::nullopt; }
};

}  // namespace

TEST_CASE("at full rank compressed depths decide as uncompressed ones") {
  const Room& room = shared_room();
  const support::TriangleTracer tracer(room.mesh);
  for (const Dome dome : {Dome::hemisphere, Dome::sphere}) {
    const auto options = room_options(dome, 300, 0);
    const DepthVisibility<std::int16_t> visibility(room.samples, tracer, nullptr, options, Serial());
    const auto depths = trace_depths(room.samples.samples, visibility.grid(), tracer, options.limit);
    std::size_t different = 0, all = 0;
    for (const SizedLight& light : lights_in(room, 20)) {
      const auto fast = values(visibility, room.samples, light);
      const auto slow = reference::depth_visibility(
          room.samples.samples, visibility.grid(), depths, light, options.limit, options.bias,
          [](const DirectionGrid& grid, const vec3& d) { return grid.nearly_nearest(d); });
      for (std::size_t i = 0; i < fast.size(); ++i) different += fast[i] != slow[i], ++all;
    }
    CHECK(double(different) < 0.002 * double(all));  // by rounding
  }
}

TEST_CASE("intervals decide better than plain PCA of the same bytes, and far better than no shadows") {
  const Room& room = shared_room();
  const support::TriangleTracer tracer(room.mesh);
  const FreeCells cells = free_cells(room.flights, 0.15f);
  const auto lights = lights_in(room, 40);
  for (const Dome dome : {Dome::hemisphere, Dome::sphere}) {
    const auto wrong = [&](int rounds) {
      const DepthVisibility<> visibility(room.samples, tracer, &cells, room_options(dome, 10, rounds),
                                         Serial());
      std::vector<float> kept;
      return wrong_decisions(room.samples.samples, lights, tracer, Serial(), [&](const SizedLight& light) {
        return std::span<const float>(kept = values(visibility, room.samples, light));
      });
    };
    const std::vector<float> lit(room.samples.size(), 1.0f);
    const WrongDecisions without =
        wrong_decisions(room.samples.samples, lights, tracer, Serial(),
                        [&](const SizedLight&) { return std::span<const float>(lit); });
    const WrongDecisions plain = wrong(0), intervals = wrong(5);
    CHECK(intervals.plain < plain.plain);
    CHECK(intervals.plain < 0.6 * without.plain);
    CHECK(intervals.pairs > 3000);
  }
}

TEST_CASE("depth visibility is the same for any executor, also for lights with a size") {
  const Room& room = shared_room();
  const support::TriangleTracer tracer(room.mesh);
  const FreeCells cells = free_cells(room.flights, 0.15f);
  const auto options = room_options(Dome::hemisphere, 6, 2);
  const DepthVisibility<> a(room.samples, tracer, &cells, options, Serial());
  const DepthVisibility<> b(room.samples, tracer, &cells, options, support::TwoThreads{});
  CHECK(std::ranges::equal(a.coefficients(), b.coefficients()));
  CHECK(std::ranges::equal(a.basis(), b.basis()));
  CHECK(std::ranges::equal(a.means(), b.means()));
  const SizedLight light{point_light({1.2f, 1.5f, 0.3f}, vec3(1)), 0.2f};
  const auto serial = values(a, room.samples, light);
  std::vector<float> other(serial.size());
  a.visibility(light, support::Backwards{1}, other);
  CHECK(other == serial);
  bool soft = false;
  for (const float x : serial) {
    CHECK((x >= 0 && x <= 1));
    soft |= x > 0.1f && x < 0.9f;
  }
  CHECK(soft);
}

TEST_CASE("where nothing is hit all lights above the horizon are seen, and none below it") {
  const Room& room = shared_room();
  for (const Dome dome : {Dome::hemisphere, Dome::sphere}) {
    const DepthVisibility<> visibility(room.samples, OpenSky(), nullptr, room_options(dome, 6, 0), Serial());
    CHECK(visibility.rank() <= 6);
    for (const vec3 position : {vec3(0.3f, 1.9f, 0.2f), vec3(0, 100, 0), vec3(-30, 1, 2)}) {
      const SizedLight light{point_light(position, vec3(1)), 0};
      const auto seen = values(visibility, room.samples, light);
      for (std::size_t i = 0; i < seen.size(); ++i) {
        const SurfaceSample& s = room.samples.samples[i];
        CHECK(seen[i] == (dot(position - ray_origin(s), s.normal) > 0 ? 1.0f : 0.0f));
      }
    }
    const SizedLight sun{distant_light({0, 1, 0}, vec3(1), 10), 0};
    const auto seen = values(visibility, room.samples, sun);
    for (std::size_t i = 0; i < seen.size(); ++i)
      CHECK(seen[i] == (room.samples.samples[i].normal.y > 0 ? 1.0f : 0.0f));
  }
}

TEST_CASE("a light at a sample gives a number, and one just above it is seen") {
  const Room& room = shared_room();
  const support::TriangleTracer tracer(room.mesh);
  const DepthVisibility<> visibility(room.samples, tracer, nullptr, room_options(Dome::hemisphere, 50, 0),
                                     Serial());
  const SurfaceSample& s = room.samples.samples[10];
  const auto seen = [&](const vec3& position) {
    return values(visibility, room.samples, {point_light(position, vec3(1)), 0})[10];
  };
  for (const vec3& position : {s.position, ray_origin(s)})
    CHECK((seen(position) >= 0 && seen(position) <= 1));
  CHECK(seen(s.position + 0.05f * s.normal) == 1.0f);
}

TEST_CASE("rank 0 and clusters of one sample decide by the mean depth") {
  const Room room = box_in_room(40, 40);
  const support::TriangleTracer tracer(room.mesh);
  const auto options = room_options(Dome::hemisphere, 5, 0);
  const DepthVisibility<> visibility(room.samples, tracer, nullptr, options, Serial());
  CHECK(visibility.rank() == 0);
  const auto depths = trace_depths(room.samples.samples, visibility.grid(), tracer, options.limit);
  for (const SizedLight& light : lights_in(room, 20))
    CHECK(values(visibility, room.samples, light) ==
          reference::depth_visibility(
              room.samples.samples, visibility.grid(), depths, light, options.limit, options.bias,
              [](const DirectionGrid& grid, const vec3& d) { return grid.nearly_nearest(d); }));
  const DepthVisibility<> none(shared_room().samples, support::TriangleTracer(shared_room().mesh), nullptr,
                               room_options(Dome::sphere, 0, 0), Serial());
  CHECK(none.rank() == 0);
  CHECK(none.coefficients().empty());
}

TEST_CASE("no samples and empty clusters are served") {
  const DepthOptions options = room_options(Dome::sphere, 5, 0);
  const ClusteredSamples none;
  const DepthVisibility<> visibility(none, OpenSky(), nullptr, options, Serial());
  visibility.visibility({point_light(vec3(1), vec3(1)), 0}, Serial(), {});
  CHECK(visibility.basis().empty());
  ClusteredSamples gap = shared_room().samples;
  gap.ends.insert(gap.ends.begin(), 0u);
  gap.ends.insert(gap.ends.begin() + 3, gap.ends[2]);
  const support::TriangleTracer tracer(shared_room().mesh);
  const DepthVisibility<> with(gap, tracer, nullptr, options, Serial());
  const DepthVisibility<> without(shared_room().samples, tracer, nullptr, options, Serial());
  const SizedLight light{point_light({1.2f, 1.5f, 0.3f}, vec3(1)), 0};
  CHECK(values(with, gap, light) == values(without, gap, light));
}

TEST_CASE("free space begins behind a solid again, never behind the walls of a room") {
  const Room& room = shared_room();
  const FreeCells cells = free_cells(room.flights, 0.15f);
  const vec3 origin(-1.5f, 0.85f, 0);  // the box lies between x = -0.5 and 0.4
  const float begin = cells.next_free(origin, {1, 0, 0}, 1.0f, 10);
  CHECK(begin > 1.5f);
  CHECK(begin <= 1.9f + 1e-5f);
  CHECK(std::isinf(cells.next_free(origin, {1, 0, 0}, 1.0f, 1.2f)));
  CHECK(std::isinf(cells.next_free(origin, {-1, 0, 0}, 0.5f, 10)));
  CHECK(std::isinf(cells.next_free(origin, normalize(vec3(-1, 0.5f, 1)), 0.75f, 10)));
  CHECK(cells.is_free({1, 2, 1}));
  CHECK_FALSE(cells.is_free({0, 0.85f, 0}));
  CHECK_FALSE(cells.is_free({50, 0, 0}));
}

TEST_CASE("the reach of lights is the wanted share of their distances") {
  const Room& room = shared_room();
  std::vector<vec3> positions;
  for (const SizedLight& light : lights_in(room, 50)) positions.push_back(light.light.position);
  const float reach = light_reach(room.samples.samples, positions, 0.9);
  std::size_t within = 0, all = 0;
  for (const SurfaceSample& s : room.samples.samples)
    for (const vec3& p : positions)
      if (dot(p - s.position, s.normal) > 0) ++all, within += length(p - s.position) <= reach;
  CHECK(double(within) / double(all) == doctest::Approx(0.9).epsilon(0.002));
  CHECK(std::isinf(light_reach({}, positions)));
}
