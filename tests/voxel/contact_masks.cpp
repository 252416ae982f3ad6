// Bits of closed rays against rays one by one, and against the tracer that asks the same.
#include <coppice/voxel/contact_masks.hpp>
//
#include <doctest/doctest.h>

#include "support/executors.hpp"
#include "support/occluders.hpp"
#include "voxel/scenes.hpp"

using namespace coppice;

namespace {

/// Receivers on a still life, 0 to 9 cones each.
struct Contacts {
  Mesh mesh = support::still_life().mesh;
  support::TriangleTracer tracer{mesh};
  BrickGrid grid = support::grid_of(mesh, {vec3(-2, 0, -2), vec3(2, 1, 2)}, 64);
  std::vector<ConeReceiver> receivers;
  std::vector<SgShape> cones;

  Contacts(Random random, std::uint32_t count) {
    for (std::uint32_t i = 0; i < count; ++i) {
      const auto t = support::corners_of(mesh, random.below(std::uint32_t(mesh.triangles.size())));
      const vec3 n = normalize(cross(t.b - t.a, t.c - t.a));
      for (std::uint32_t k = random.below(10); k > 0; --k)
        cones.push_back({normalize(random.direction() + n), std::exp(8 * random.uniform())});
      receivers.push_back({support::point_of(random, t) + 1e-4f * n, std::uint32_t(cones.size()), n, i, n});
    }
  }

  template <Executor E>
  std::vector<std::uint8_t> masks(const ConeTracerOptions& options, const E& executor) const {
    std::vector<std::uint8_t> masks(cones.size(), 255);
    ContactMasks(grid, options).find(tracer, receivers, cones, masks, executor);
    return masks;
  }
};

}  // namespace

TEST_CASE("a bit is set where the ray alone meets something within reach") {
  CHECK(rc::check([] {
    const Contacts scene(test_support::any_random(), 20);
    ConeTracerOptions options;
    options.trace.rays = 1 + std::uint32_t(*rc::gen::inRange(0, 8));
    options.contact = float(*rc::gen::inRange(1, 8));
    const auto masks = scene.masks(options, Serial{});
    const float reach = (options.contact + options.trace.lift) * scene.grid.grid.voxel;
    std::size_t skipped = 0, closed = 0;
    for (std::size_t i = 0, c = 0; i < scene.receivers.size(); ++i)
      for (const ConeReceiver& r = scene.receivers[i]; c < r.cones_end; ++c)
        for (std::uint32_t k = 0; k < 8; ++k) {
          const bool bit = (masks[c] >> k & 1) != 0;
          const ConeRay ray = cone_ray(scene.cones[c], r.normal, k, options.trace.rays);
          const bool met = k < options.trace.rays && ray.share > 0 &&
                           scene.tracer.occluded(r.position, ray.direction, reach);
          RC_ASSERT(!bit || met);
          closed += bit, skipped += met && !bit;  // left out, for the grid says that nothing is near
        }
    RC_ASSERT(skipped <= 1 + closed / 20);
  }));
}

TEST_CASE("where the grid says nothing, all rays are traced, in the directions of cone_ray") {
  Contacts scene(Random(5), 600);
  scene.grid = empty_brick_grid({vec3(-2, 0, -2), vec3(2, 1, 2)}, 64);
  for (SgShape& cone : scene.cones) cone.sharpness = 0.01f * cone.sharpness;  // wide: many rays are turned up
  const ConeTracerOptions options{.contact = 12};
  const auto masks = scene.masks(options, Serial{});
  const float reach = (options.contact + options.trace.lift) * scene.grid.grid.voxel;
  std::size_t closed = 0, different = 0;
  for (std::size_t i = 0, c = 0; i < scene.receivers.size(); ++i)
    for (const ConeReceiver& r = scene.receivers[i]; c < r.cones_end; ++c)
      for (std::uint32_t k = 0; k < 8; ++k) {
        const bool bit = (masks[c] >> k & 1) != 0;
        const ConeRay ray = cone_ray(scene.cones[c], r.normal, k, options.trace.rays);
        closed += bit;
        different += bit != (ray.share > 0 && scene.tracer.occluded(r.position, ray.direction, reach));
      }
  CHECK(closed > 300);
  CHECK(different <= closed / 1000);
}

TEST_CASE("without anything else in the way, cones are as visible as the bits say") {
  const Contacts scene(Random(3), 300);
  const BrickGrid& g = scene.grid;
  const ConeTracerOptions options;
  const auto masks = scene.masks(options, Serial{});
  std::vector<float> with(scene.cones.size()), without(scene.cones.size());
  const ConeTracer tracer(g, options);
  tracer.trace(scene.tracer, scene.receivers, scene.cones, with, Serial{});
  tracer.trace(OpenSpace{}, scene.receivers, scene.cones, without, Serial{});
  std::size_t some = 0;
  for (std::size_t c = 0; c < masks.size(); ++c) {
    if (masks[c] == 0) CHECK(with[c] == without[c]);
    if (masks[c] == 255) CHECK(with[c] == 0);
    some += masks[c] != 0;
  }
  CHECK(some > 100);
}

TEST_CASE("any executor sets the same bits, and without a contact there are none") {
  const Contacts scene(Random(4), 200);
  const auto masks = scene.masks({}, Serial{});
  CHECK(scene.masks({}, support::Backwards{}) == masks);
  CHECK(scene.masks({}, support::TwoThreads{}) == masks);
  CHECK(std::ranges::count(masks, std::uint8_t{0}) < std::ptrdiff_t(masks.size()));
  CHECK(scene.masks({.contact = 0}, Serial{}) == std::vector<std::uint8_t>(masks.size(), 0));
}
