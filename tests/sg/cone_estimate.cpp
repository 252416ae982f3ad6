// Light through cones after visibility, against the sum over all lights with a shadow ray each.
#include "sg/skies.hpp"
//
#include <doctest/doctest.h>

#include <coppice/reference/cone_cut.hpp>
#include <coppice/sg/cone_cut.hpp>
#include <coppice/sg/ray_cones.hpp>

#include "support/occluders.hpp"

using namespace coppice;
using namespace sg_test;
using namespace test_support;

namespace {

using support::SphereOccluder;

constexpr auto as_they_are = [](const vec3& d) { return d; };

const SphereOccluder balls{{{vec3(1, 1, 0), 0.8f}, {vec3(-1, 1.5f, 0.5f), 0.9f}, {vec3(0, 1, -2), 1.2f}}};

/// Points on the ground below the balls that see the viewer.
struct Ground {
  std::vector<ShadingPoint> points;
  std::vector<ConeReceiver> receivers;

  Ground(std::span<const support::SetMaterial> materials, int count, Random& random) {
    for (int i = 0; i < count; ++i)
      for (const auto& set_material : materials) {
        ShadingPoint p{};
        vec3 bitangent;
        p.normal = normalize(vec3(0, 1, 0) + 0.3f * random.direction());
        make_frame(p.normal, p.tangent, bitangent);
        p.to_viewer = normalize(random.direction() + vec3(0, 1.2f, 0));
        set_material(p);
        points.push_back(p);
        const vec3 position(4 * random.uniform() - 2, 0, 4 * random.uniform() - 2);
        receivers.push_back({position, 0, vec3(0, 1, 0), std::uint32_t(receivers.size()), p.normal});
      }
  }
  /// The same under an environment that is turned, with all else.
  void turn(const MapFrame& frame) {
    for (ShadingPoint& p : points)
      p.normal = frame.to_world(p.normal), p.tangent = frame.to_world(p.tangent),
      p.to_viewer = frame.to_world(p.to_viewer);
    for (ConeReceiver& r : receivers)
      r.position = frame.to_world(r.position), r.normal = frame.to_world(r.normal),
      r.shading_normal = frame.to_world(r.shading_normal);
  }
};

/// Points, directions of the cones and the map in the frame of `turn`.
std::vector<vec3> estimate(const ProductTree& tree, const Ground& ground, const SphereOccluder& occluder,
                           const MapFrame& turn, const ConeCutOptions& options, std::uint32_t rays) {
  struct Placer {
    ConeCut cut;
    const Ground& ground;
    const MapFrame& turn;
    const LitCones& place(std::size_t i) { return cut.place(turn.to_map(ground.points[i])); }
  };
  ConeBatch batch = place_cones(
      ground.receivers,
      [&] {
        return Placer{ConeCut(tree, options), ground, turn};
      },
      Serial());
  for (SgShape& shape : batch.shapes) shape.axis = turn.to_world(shape.axis);
  std::vector<float> visibility(batch.shapes.size());
  RayCones(occluder, rays).trace(batch.receivers, batch.shapes, visibility, Serial());
  return visible_light(batch, visibility, Serial());
}

double error_of(const std::vector<vec3>& light, const Ground& ground, const SkyLights& sky) {
  RelativeRms error;
  for (std::size_t i = 0; i < light.size(); ++i)
    error.add(light[i], reference::relit(ground.points[i], sky.lighting().nodes, sky.parts().peaks,
                                         ground.receivers[i], balls, as_they_are));
  return error.value();
}

}  // namespace

TEST_CASE("light through cones is near the sum with a ray each, and nearer with more cones") {
  Random random(1);
  SkyLights sky({.lights = 2048, .pieces = 256});
  for (const int lamps : {0, 1}) {
    sky.take(some_map(random, 128, 64, lamps));
    const ProductTree tree(sky.lighting(), sky.parts().peaks);
    for (const auto* materials : {&support::wide_materials, &support::narrow_materials}) {
      const bool is_wide = materials == &support::wide_materials;
      const auto chosen = std::span(*materials).subspan(is_wide ? 0 : 1);
      const Ground ground(chosen, 30, random);
      const auto error = [&](std::uint32_t cones) {
        return error_of(estimate(tree, ground, balls, MapFrame(0), {.cones = cones, .negligible = 0}, 256),
                        ground, sky);
      };
      const double one = error(1), seven = error(7), many = error(64);
      // Measured: 0.10, 0.05 to 0.06, 0.015 to 0.017 where lobes are wide; 0.21 to 0.23, 0.07, 0.05 else.
      CHECK(seven < 0.7 * one);
      CHECK(many < 0.9 * seven);
      CHECK(seven < 0.1);
      CHECK(many < (is_wide ? 0.03 : 0.07));
    }
  }
}

TEST_CASE("environment, points and occluder turned together leave what is seen") {
  Random random(2);
  SkyLights sky({.lights = 1024, .pieces = 128});
  sky.take(some_map(random, 64, 32, 1));
  const ProductTree tree(sky.lighting(), sky.parts().peaks);
  const Ground still(support::wide_materials, 20, random);
  const MapFrame turn(1.9f);
  Ground turned = still;
  turned.turn(turn);
  SphereOccluder turned_balls = balls;
  for (support::Sphere& ball : turned_balls.spheres) ball.centre = turn.to_world(ball.centre);
  const auto to_world = [&](const vec3& d) { return turn.to_world(d); };
  RelativeRms cones, rays;
  const std::vector<vec3> before = estimate(tree, still, balls, MapFrame(0), {}, 1024),
                          after = estimate(tree, turned, turned_balls, turn, {}, 1024);
  for (std::size_t i = 0; i < before.size(); ++i) {
    cones.add(after[i], glm::dvec3(before[i]));
    rays.add(vec3(reference::relit(turn.to_map(turned.points[i]), sky.lighting().nodes, sky.parts().peaks,
                                   turned.receivers[i], turned_balls, to_world)),
             reference::relit(still.points[i], sky.lighting().nodes, sky.parts().peaks, still.receivers[i],
                              balls, as_they_are));
  }
  CHECK(cones.value() < 0.01);  // rays of a cone start at another angle
  CHECK(rays.value() < 1e-4);
}

TEST_CASE("nothing in the way leaves the unoccluded light, and a ball around a point takes it all") {
  Random random(3);
  SkyLights sky({.lights = 1024, .pieces = 128});
  sky.take(some_map(random, 64, 32));
  const ProductTree tree(sky.lighting(), sky.parts().peaks);
  Ground ground(support::wide_materials, 10, random);
  for (std::size_t i = 0; i < ground.receivers.size(); ++i)
    ground.receivers[i].normal = ground.receivers[i].shading_normal;
  const SphereOccluder nothing, around{{{vec3(0), 10}}};
  const auto open = estimate(tree, ground, nothing, MapFrame(0), {}, 16);
  const auto shut = estimate(tree, ground, around, MapFrame(0), {}, 16);
  ConeCut cut(tree);
  RelativeRms error;
  for (std::size_t i = 0; i < open.size(); ++i) {
    error.add(open[i], glm::dvec3(cut.place(ground.points[i]).unoccluded()));
    CHECK(shut[i] == vec3(0));
    CHECK(is_never_negative(open[i]));
  }
  CHECK(error.value() < 0.01);
}

TEST_CASE("one texel casts the hard shadow of a point light") {
  Random random(4);
  SkyLights sky({.lights = 256, .pieces = 16});
  Image map(1024, 512);
  map.at(300, 100) = vec3(1e5f);
  sky.take(map);
  const ProductTree tree(sky.lighting(), sky.parts().peaks);
  const vec3 towards = texel_direction(300, 100, 1024, 512);
  const Ground ground(std::span(support::wide_materials).first(1), 300, random);
  const auto light = estimate(tree, ground, balls, MapFrame(0), {}, 16);
  int lit = 0, dark = 0, between = 0;
  ConeCut cut(tree);
  for (std::size_t i = 0; i < light.size(); ++i) {
    const bool is_hidden = balls.occluded(ground.receivers[i].position, towards, 1e30f);
    const vec3 whole = cut.place(ground.points[i]).unoccluded();
    if (light[i] == vec3(0) && is_hidden)
      ++dark;
    else if (light[i] == whole && !is_hidden)
      ++lit;
    else
      ++between;
  }
  CHECK(lit > 100);
  CHECK(dark > 30);
  CHECK(between < 10);
}
