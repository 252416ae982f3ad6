// The transport between samples against closed forms, its dense twin, and itself.
#include <coppice/core/simd.hpp>
//
#include <doctest/doctest.h>
#include <rapidcheck.h>

#include <coppice/embree/tracer.hpp>
#include <coppice/light/thin_samples.hpp>
#include <coppice/reference/transport.hpp>
#include <coppice/transfer/interreflection.hpp>
#include <support/executors.hpp>
#include <support/generators.hpp>
#include <support/occluders.hpp>
#include <support/scenes.hpp>

using namespace coppice;

namespace {

Scene scene_of_one_material(const vec3& albedo) {
  Scene scene;
  scene.materials.resize(1);
  scene.materials[0].base_color = albedo;
  return scene;
}

/// The inside of a box: its triangles' backs.
Scene box(const vec3& albedo) {
  Scene scene = scene_of_one_material(albedo);
  support::add_box(scene.mesh, vec3(-1, -1, -1), vec3(2, 1, 1));
  return scene;
}

Scene ball(const vec3& albedo) {
  Scene scene = scene_of_one_material(albedo);
  support::add_ball(scene.mesh, vec3(0), 1, 24);
  return scene;
}

/// Even samples on the backs of all triangles.
std::vector<SurfaceSample> samples_inside(const Scene& scene, std::size_t count, std::uint64_t seed) {
  std::vector<TriangleSide> sides;
  for (std::uint32_t i = 0; i < scene.mesh.triangles.size(); ++i) sides.push_back({i, false});
  auto candidates = scatter_samples(scene.mesh, sides, 6 * count, Shares::by_area, seed);
  for (SurfaceSample& c : candidates) c.colour = scene.materials[0].base_color;
  return thin_samples(candidates, count);
}

struct Room {
  Scene scene;
  EmbreeTracer tracer;
  std::vector<SurfaceSample> samples;

  Room(Scene made, std::size_t count, std::uint64_t seed = 1)
      : scene(std::move(made)), tracer(scene), samples(samples_inside(scene, count, seed)) {}

  SampleLookup lookup() const { return {samples, {.distance = 4 * sample_spacing(samples)}}; }
  Transport transport(const TransportOptions& options) const {
    return build_transport(scene.mesh, samples, lookup(), tracer, Serial(), options);
  }
};

/// A right-hand side that is alike everywhere.
Rows uniform(std::size_t count, const vec3& value) {
  Rows rows(count, 3);
  for (std::size_t i = 0; i < count; ++i)
    for (int c = 0; c < 3; ++c) rows[i][std::size_t(c)] = value[c];
  return rows;
}

/// Of all nodes, a few entries a row at random; some rows have none.
Transport random_transport(Random& random, std::size_t size) {
  Transport transport{.rays = 100};
  for (std::size_t i = 0; i < size; ++i) {
    for (std::uint32_t j = 0; j < size; ++j)
      if (random.uniform() < 0.3f)
        transport.columns.push_back(j), transport.counts.push_back(std::uint16_t(1 + random.below(9)));
    transport.first.push_back(transport.columns.size());
  }
  return transport;
}

Rows random_rows(Random& random, std::size_t count, std::size_t width) {
  Rows rows(count, width);
  for (float& value : rows.values) value = test_support::random_value<float>(random);
  return rows;
}

bool same(const Transport& a, const Transport& b) {
  return a.rays == b.rays && a.first == b.first && a.columns == b.columns && a.counts == b.counts;
}

}  // namespace

TEST_CASE("In a closed box the rows of the transport sum to one") {
  const Room room(box(vec3(0.5f)), 800);
  const Transport transport = room.transport({.rays = 128});
  REQUIRE(transport.size() == room.samples.size());
  for (std::size_t i = 0; i < transport.size(); ++i) {
    CHECK(transport.row_sum(i) <= 1);
    CHECK(transport.row_sum(i) >= 127.0f / 128);  // one ray may pass by an edge
    for (std::size_t e = transport.first[i] + 1; e < transport.first[i + 1]; ++e)
      CHECK(transport.columns[e - 1] < transport.columns[e]);
  }
}

TEST_CASE("In an integrating sphere indirect light is direct light times albedo over one minus albedo") {
  const vec3 albedo(0.2f, 0.5f, 0.8f);
  const Room room(ball(albedo), 1000);
  const Transport transport = room.transport({.rays = 256});
  // A spot of light on a few samples: a sphere spreads it evenly at the first bounce.
  Rows direct(room.samples.size(), 3);
  double power = 0, area = 0;
  for (std::size_t i = 0; i < room.samples.size(); ++i) {
    area += double(room.samples[i].area);
    if (room.samples[i].position.y < 0.6f) continue;
    power += double(room.samples[i].area);
    for (int c = 0; c < 3; ++c) direct[i][std::size_t(c)] = 1;
  }
  const Rows indirect = interreflect(transport, albedos_of(room.samples), direct, Serial(),
                                     {.bounces = 200, .tolerance = 1e-6f});
  for (int c = 0; c < 3; ++c) {
    const double expected = power / area * double(albedo[c]) / (1 - double(albedo[c]));
    double mean = 0, deviation = 0;
    for (std::size_t i = 0; i < room.samples.size(); ++i) {
      const double value = double(indirect[i][std::size_t(c)]);
      mean += value / double(room.samples.size());
      deviation += (value - expected) * (value - expected) / double(room.samples.size());
    }
    CHECK(mean == doctest::Approx(expected).epsilon(0.02));
    CHECK(std::sqrt(deviation) < 0.06 * expected);
  }
}

TEST_CASE("Form factors between two facing squares are those of the closed form") {
  // Unit squares a unit apart: F = 0.199825 (Howell, configuration C-11).
  Scene scene = scene_of_one_material(vec3(0.5f));
  support::add_quad(scene.mesh, {0, 0, 0}, {0, 0, 1}, {1, 0, 0});
  support::add_quad(scene.mesh, {0, 1, 0}, {1, 0, 0}, {0, 0, 1});
  const EmbreeTracer tracer(scene);
  const std::vector<TriangleSide> sides = {{0, true}, {1, true}, {2, true}, {3, true}};
  const auto samples = thin_samples(scatter_samples(scene.mesh, sides, 6000, Shares::by_area, 3), 1000);
  const SampleLookup lookup(samples, {.distance = 4 * sample_spacing(samples)});
  const Transport transport = build_transport(scene.mesh, samples, lookup, tracer, Serial(), {.rays = 512});
  double share = 0, area = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    share += double(samples[i].area) * double(transport.row_sum(i));
    area += double(samples[i].area);
  }
  CHECK(share / area == doctest::Approx(0.199825).epsilon(0.01));
}

TEST_CASE("What two regions give to each other is the same both ways") {
  const Room room(box(vec3(0.5f)), 1500);
  const Transport transport = room.transport({.rays = 256});
  const auto region = [&](std::size_t i) {
    const vec3 p = glm::max(room.samples[i].position - vec3(-1), 0.0f) / vec3(1.5f, 1, 1);
    return std::size_t(p.x >= 1) + 2 * std::size_t(p.y >= 1) + 4 * std::size_t(p.z >= 1);
  };
  double flow[8][8] = {};
  for (std::size_t i = 0; i < transport.size(); ++i)
    for (std::size_t e = transport.first[i]; e < transport.first[i + 1]; ++e)
      flow[region(i)][region(transport.columns[e])] +=
          double(room.samples[i].area) * transport.counts[e] / transport.rays;
  for (std::size_t a = 0; a < 8; ++a)
    for (std::size_t b = 0; b < a; ++b) {
      REQUIRE(flow[a][b] > 0);
      CHECK(flow[a][b] == doctest::Approx(flow[b][a]).epsilon(0.05));
    }
}

TEST_CASE("The transport is the same for any threads and changes with the seed") {
  const Room room(box(vec3(0.5f)), 400);
  const Transport serial = room.transport({.rays = 64, .seed = 4});
  const auto with = [&](const auto& executor) {
    return build_transport(room.scene.mesh, room.samples, room.lookup(), room.tracer, executor,
                           {.rays = 64, .seed = 4});
  };
  CHECK(same(serial, with(support::TwoThreads())));
  CHECK(same(serial, with(support::Backwards())));
  CHECK_FALSE(same(serial, room.transport({.rays = 64, .seed = 5})));
}

TEST_CASE("Applied to many vectors at once the transport equals its dense twin") {
  CHECK(rc::check([] {
    Random random = test_support::any_random();
    const std::size_t size = *rc::gen::inRange<std::size_t>(0, 40);
    const std::size_t width = *rc::gen::inRange<std::size_t>(1, 150);
    const Transport transport = random_transport(random, size);
    const Rows x = random_rows(random, size, width);
    Rows out;
    apply(transport, x, Serial(), out);
    RC_ASSERT(out.width == width && out.values.size() == x.values.size());
    const auto dense = reference::dense(transport);
    for (std::size_t k = 0; k < width; ++k) {
      std::vector<double> column(size);
      for (std::size_t i = 0; i < size; ++i) column[i] = double(x[i][k]);
      const auto expected = reference::multiply(dense, column);
      for (std::size_t i = 0; i < size; ++i) RC_ASSERT(std::abs(double(out[i][k]) - expected[i]) <= 1e-5);
    }
  }));
}

TEST_CASE("The adjoint of the transport is its dense twin's transpose") {
  CHECK(rc::check([] {
    Random random = test_support::any_random();
    const Transport transport = random_transport(random, *rc::gen::inRange<std::size_t>(0, 40));
    const Transport adjoint = transposed(transport);
    const auto a = reference::dense(transport), b = reference::dense(adjoint);
    RC_ASSERT(adjoint.size() == transport.size() && same(transposed(adjoint), transport));
    for (std::size_t i = 0; i < a.size; ++i)
      for (std::size_t j = 0; j < a.size; ++j) RC_ASSERT(a(i, j) == b(j, i));
  }));
}

TEST_CASE("Interreflections equal the dense twin's, channel by channel, and any threads give the same") {
  CHECK(rc::check([] {
    Random random = test_support::any_random();
    const std::size_t size = *rc::gen::inRange<std::size_t>(1, 30);
    const std::size_t vectors = *rc::gen::inRange<std::size_t>(1, 30);
    const std::uint32_t bounces = *rc::gen::inRange<std::uint32_t>(0, 9);
    const Transport transport = random_transport(random, size);
    const Rows direct = random_rows(random, size, 3 * vectors);
    std::vector<vec3> albedos;
    for (std::size_t i = 0; i < size; ++i)
      albedos.emplace_back(random.uniform(), random.uniform(), random.uniform());
    const Rows result = interreflect(transport, albedos, direct, Serial(), {.bounces = bounces});
    RC_ASSERT(result.values ==
              interreflect(transport, albedos, direct, support::Backwards(), {.bounces = bounces}).values);
    RC_ASSERT(result.values ==
              interreflect(transport, albedos, direct, support::TwoThreads(), {.bounces = bounces}).values);
    const auto dense = reference::dense(transport);
    for (std::size_t k = 0; k < direct.width; ++k) {
      std::vector<double> e(size), albedo(size);
      for (std::size_t i = 0; i < size; ++i)
        e[i] = double(direct[i][k]), albedo[i] = double(albedos[i][int(k % 3)]);
      const auto expected = reference::interreflect(dense, albedo, e, bounces);
      for (std::size_t i = 0; i < size; ++i)
        RC_ASSERT(std::abs(double(result[i][k]) - expected[i]) <= 1e-4 * (1 + std::abs(expected[i])));
    }
  }));
}

TEST_CASE("The series ends early where a bounce adds less than the tolerance") {
  const Room room(ball(vec3(0.5f)), 300);
  const Transport transport = room.transport({.rays = 64});
  const Rows direct = uniform(room.samples.size(), vec3(1));
  const auto albedos = albedos_of(room.samples);
  // Bounce b adds ρ^b: to stay above 0.01 of the sum, about 1, it needs b <= 6.
  const Rows early = interreflect(transport, albedos, direct, Serial(), {.bounces = 100, .tolerance = 0.01f});
  const Rows seven = interreflect(transport, albedos, direct, Serial(), {.bounces = 7});
  CHECK(early.values == seven.values);
}

TEST_CASE("Black surfaces give back nothing and white ones a term a bounce") {
  const Room room(ball(vec3(0, 1, 1)), 300);
  const Transport transport = room.transport({.rays = 64});
  const Rows indirect = interreflect(transport, albedos_of(room.samples),
                                     uniform(room.samples.size(), vec3(1, 1, 0)), Serial(), {.bounces = 8});
  for (std::size_t i = 0; i < room.samples.size(); ++i) {
    CHECK(indirect[i][0] == 0);
    CHECK(indirect[i][1] == doctest::Approx(8).epsilon(0.02));
    CHECK(indirect[i][2] == 0);
  }
}

TEST_CASE("No samples, one sample, and samples that see nothing have empty rows") {
  Scene scene = scene_of_one_material(vec3(0.5f));
  support::add_ground(scene.mesh, 1);
  const EmbreeTracer tracer(scene);
  const std::vector<TriangleSide> sides = {{0, true}, {1, true}};
  for (const std::size_t count : {0u, 1u, 50u}) {
    const auto samples = scatter_samples(scene.mesh, sides, count, Shares::by_area, 2);
    const SampleLookup lookup(samples, {.distance = 1});
    const Transport transport = build_transport(scene.mesh, samples, lookup, tracer, Serial(), {.rays = 32});
    CHECK(transport.size() == samples.size());
    CHECK(transport.columns.empty());
    const Rows indirect = interreflect(transport, albedos_of(samples), uniform(samples.size(), vec3(1)),
                                       Serial(), {.bounces = 3});
    for (const float value : indirect.values) CHECK(value == 0);
  }
}

TEST_CASE("Not a number stays one and does not end the series as converged") {
  const Room room(ball(vec3(0.5f)), 100);
  const Transport transport = room.transport({.rays = 64});
  Rows direct = uniform(room.samples.size(), vec3(1));
  direct[0][0] = std::numeric_limits<float>::quiet_NaN();
  const Rows indirect =
      interreflect(transport, albedos_of(room.samples), direct, Serial(), {.bounces = 4, .tolerance = 0.5f});
  bool lost = false, other_channel_clean = true;
  for (std::size_t i = 0; i < room.samples.size(); ++i) {
    lost |= std::isnan(indirect[i][0]);
    other_channel_clean &= !std::isnan(indirect[i][1]);
  }
  CHECK(lost);
  CHECK(other_channel_clean);
}

TEST_CASE("The tail stands for the bounces that are left out") {
  // Half the ball is red, half blue: the exact sum is that of many bounces.
  Room room(ball(vec3(0.7f)), 500);
  for (SurfaceSample& s : room.samples)
    s.colour = s.position.x > 0 ? vec3(0.9f, 0.5f, 0) : vec3(0.8f, 0.6f, 1);
  const Transport transport = room.transport({.rays = 128});
  const auto albedos = albedos_of(room.samples);
  Random random(3);
  const Rows direct = random_rows(random, room.samples.size(), 6);
  const Rows all = interreflect(transport, albedos, direct, Serial(), {.bounces = 40});
  const auto tail = interreflection_tail(transport, albedos, Serial(), 4, 40);
  const Rows short_sum = interreflect(transport, albedos, direct, Serial(), {.bounces = 4});
  const Rows with_tail = interreflect(transport, albedos, direct, Serial(), {.bounces = 4, .tail = tail});
  double missing = 0, error = 0, size = 0;
  for (std::size_t k = 0; k < all.values.size(); ++k) {
    missing += std::pow(double(short_sum.values[k] - all.values[k]), 2);
    error += std::pow(double(with_tail.values[k] - all.values[k]), 2);
    size += std::pow(double(all.values[k]), 2);
  }
  CHECK(missing > 0.01 * size);
  CHECK(error < 1e-4 * size);
}

TEST_CASE("The tail is finite for black, white, and unreached samples") {
  const Room room(ball(vec3(0, 1, 0.5f)), 200);
  const Transport transport = room.transport({.rays = 64});
  for (const vec3& t : interreflection_tail(transport, albedos_of(room.samples), Serial(), 2, 10)) {
    CHECK(t.x == 0);
    CHECK(t.y == doctest::Approx(8).epsilon(0.02));
    CHECK(t.z == doctest::Approx(1).epsilon(0.02));  // 1/2 + 1/4 + ... + 1/256
  }
  Transport empty;
  empty.first = {0, 0};
  const std::vector<vec3> white = {vec3(1)};
  CHECK(interreflection_tail(empty, white, Serial(), 2)[0] == vec3(0));
}
