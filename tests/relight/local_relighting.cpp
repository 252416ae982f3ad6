// Stored V·G of lights in the scene against the sum over all lights.
#include <doctest/doctest.h>

#include <coppice/light/directions.hpp>
#include <coppice/reference/local.hpp>
#include <coppice/relight/local_relighting.hpp>
#include <support/executors.hpp>
#include <support/local_lights.hpp>
#include <support/occluders.hpp>
#include <support/scenes.hpp>
#include <support/shading.hpp>

using namespace coppice;
using support::LightKind;

namespace {

const support::SphereOccluder balls{{{vec3(0.4f, 0.3f, 0), 0.35f}, {vec3(-0.6f, 0, 0.4f), 0.3f}}};

/// Every difference between lights counts; every light is a cluster.
LocalRelightingOptions fine(Lobes lobes = Lobes::sampled) {
  LocalRelightingOptions options;
  options.cuts = {1e-9, unlimited, CutWeight::uniform, CutSearch::threshold};
  options.lobes.lobes = lobes;
  return options;
}

/// Faces between random receivers, with points of every material: at their first corners, or anywhere
/// between.
PreparedView random_view(std::uint32_t faces, bool at_corners, Random& random) {
  PreparedView view;
  for (std::uint32_t f = 0; f < faces; ++f) {
    const uvec3 corners(3 * f, 3 * f + 1, 3 * f + 2);
    const vec3 place = support::in_box(random), normal = random.direction();
    for (int k = 0; k < 3; ++k) {
      view.receivers.emplace_back();
      view.receivers.back().position = place + 0.1f * support::in_box(random);
      view.receivers.back().normal = normal;
      view.receivers.back().horizon = -1;
    }
    view.buffer.faces.push_back({corners, std::uint32_t(view.buffer.points.size())});
    for (ShadingPoint& p : support::random_points(support::wide_materials, 1, random)) {
      p.face = f;
      if (at_corners) p.weight_0 = 1, p.weight_1 = 0;
      const auto at = [&](int k) { return view.receivers[corners[k]].position; };
      view.buffer.points.push_back(p);
      view.buffer.positions.push_back(p.weight_0 * at(0) + p.weight_1 * at(1) +
                                      (1 - p.weight_0 - p.weight_1) * at(2));
    }
  }
  return view;
}

void check_near(const vec3& radiance, const vec3& expected, const vec3& allowed = vec3(0)) {
  CHECK(length(radiance - expected) <= 2e-4f * length(expected) + length(allowed));
}

/// What half a step of the stored roots of V·G makes of every light.
vec3 half_step(const LocalRelighting& relighting, const ShadingPoint& point, const vec3& position,
               std::uint32_t receiver, std::span<const LocalLight> lights) {
  const auto roots = reference::expand(CutView<std::uint16_t>(relighting.cuts().cuts.unpack(receiver)));
  std::vector<float> shares(lights.size());
  for (std::size_t leaf = 0; leaf < roots.size(); ++leaf)
    if (const auto light = relighting.tree().light_of_leaf[leaf]; light != no_light)
      shares[light] = relighting.cuts().scales[receiver] * (1.002f * float(roots[leaf]) + 0.26f);
  return reference::radiance_of_shares(point, position, lights, shares);
}

template <class O>
void check_corners(const PreparedView& view, const LocalRelighting& relighting,
                   std::span<const LocalLight> lights, const O& occluder) {
  const auto radiance = relighting.shade(Serial());
  for (std::size_t p = 0; p < radiance.size(); ++p) {
    const ShadingPoint& point = view.buffer.points[p];
    const vec3& position = view.buffer.positions[p];
    CAPTURE(p);
    check_near(radiance[p], reference::local_radiance(point, position, lights, occluder),
               half_step(relighting, point, position, view.buffer.faces[point.face].receivers.x, lights));
  }
}

}  // namespace

TEST_CASE("points at receivers get the sum over all lights, of every BRDF") {
  Random random(1);
  for (const std::uint32_t count : {1u, 2u, 100u, 597u}) {
    CAPTURE(count);
    const auto lights = support::random_local_lights(random, count);
    const PreparedView view = random_view(20, true, random);
    for (const Lobes lobes : {Lobes::sampled, Lobes::filtered, Lobes::refined}) {
      LocalRelighting relighting(view, lights, balls, fine(lobes), Serial());
      relighting.set_cut(unlimited);
      check_corners(view, relighting, lights, balls);
    }
  }
}

TEST_CASE("between receivers their V·G is interpolated, and directions are those from the point itself") {
  Random random(2);
  const auto lights = support::random_local_lights(random, 200);
  const PreparedView view = random_view(30, false, random);
  LocalRelighting relighting(view, lights, balls, fine(), Serial());
  relighting.set_cut(unlimited);
  const auto leaves = leaf_lights(relighting.tree(), lights);
  const auto radiance = relighting.shade(Serial());
  for (std::size_t p = 0; p < radiance.size(); ++p) {
    const ShadingPoint& point = view.buffer.points[p];
    check_near(radiance[p], reference::local_radiance_from_cuts(
                                point, view.buffer.positions[p], leaves, relighting.cuts().cuts,
                                relighting.cuts().scales, view.buffer.faces[point.face].receivers));
  }
}

TEST_CASE("lights far away are equal directional lights") {
  Random random(3);
  const auto directions = even_directions(64, 1);
  std::vector<LocalLight> lights;
  std::vector<vec3> irradiances;
  for (const vec3& d : directions) {
    irradiances.push_back(0.05f + 0.5f * (support::in_box(random) + 1.0f));
    lights.push_back(distant_light(d, irradiances.back(), 20));
  }
  const PreparedView view = random_view(20, true, random);
  LocalRelighting relighting(view, lights, balls, fine(), Serial());
  relighting.set_cut(unlimited);
  const auto radiance = relighting.shade(Serial());
  for (std::size_t p = 0; p < radiance.size(); ++p) {
    std::vector<float> visibility;
    for (const vec3& d : directions)
      visibility.push_back(
          !balls.occluded(view.buffer.positions[p], d, std::numeric_limits<float>::infinity()));
    check_near(radiance[p],
               reference::dense_radiance(view.buffer.points[p], directions, irradiances, visibility));
  }
}

TEST_CASE("lights that are dimmed, switched off or on change the image as they must") {
  Random random(4);
  auto lights = support::random_local_lights(random, 150);
  const PreparedView view = random_view(15, true, random);
  LocalRelighting relighting(view, lights, balls, fine(), Serial());
  std::vector<std::uint32_t> changed;
  std::vector<LocalLight> values;
  for (std::uint32_t i = 0; i < 150; i += 2) {
    lights[i].intensity *= i % 4 == 0 ? 0.0f : 2 * random.uniform();
    changed.push_back(i), values.push_back(lights[i]);
  }
  relighting.lighting().update(changed, values);
  relighting.set_cut(unlimited);
  check_corners(view, relighting, lights, balls);
}

TEST_CASE("the image is linear in the intensities, and black without") {
  Random random(5);
  auto lights = support::random_local_lights(random, 100);
  const PreparedView view = random_view(20, false, random);
  LocalRelighting relighting(view, lights, balls, {}, Serial());
  relighting.set_cut(16);
  const auto once = relighting.shade(Serial());
  CHECK(std::ranges::any_of(once, [](const vec3& r) { return r.x > 0; }));
  std::vector<std::uint32_t> all(100);
  std::iota(all.begin(), all.end(), 0u);
  for (const float factor : {4.0f, 0.0f}) {
    auto scaled = lights;
    for (auto& l : scaled) l.intensity *= factor;
    relighting.lighting().update(all, scaled);
    relighting.set_cut(16);
    const auto radiance = relighting.shade(Serial());
    for (std::size_t p = 0; p < radiance.size(); ++p) CHECK(radiance[p] == factor * once[p]);
  }
}

TEST_CASE("coarser cuts and fewer nodes err more, on a scene") {
  const Scene scene = support::still_life();
  const support::TriangleTracer tracer(scene.mesh);
  Random random(6);
  auto lights = support::random_local_lights(random, 256, std::array{LightKind::point, LightKind::surface});
  for (auto& l : lights) l.position = l.position * vec3(1.8f, 0.4f, 1.8f) + vec3(0, 1.6f, 0);
  const LightTree tree = build_local_tree(lights);
  ViewOptions options;
  options.raster = {48, 36, 1};
  options.refine.max_receivers = 1500;
  const PreparedView view =
      prepare_view(scene, tracer, *scene.camera, options, pilot_lights(tree, lights, 64),
                   pilot_lights(tree, lights, 8), Serial());
  const auto shade = [&](double sigma, std::size_t nodes) {
    LocalRelightingOptions local;
    local.cuts.sigma = sigma;
    LocalRelighting relighting(view, lights, tracer, local, Serial());
    relighting.set_cut(nodes);
    return relighting.shade(Serial());
  };
  const auto reference = shade(0.001, unlimited);
  const auto error = [&](const std::vector<vec3>& radiance) {
    double difference = 0, size = 0;
    for (std::size_t p = 0; p < radiance.size(); ++p)
      difference += double(dot(radiance[p] - reference[p], radiance[p] - reference[p])),
          size += double(dot(reference[p], reference[p]));
    return std::sqrt(difference / size);
  };
  const double fine_cut = error(shade(0.5, 256)), coarse_cut = error(shade(4, 256)),
               few = error(shade(0.5, 4));
  CHECK(fine_cut < 0.005);
  CHECK(coarse_cut > 1.5 * fine_cut);
  CHECK(coarse_cut < 0.3);
  CHECK(few > 1.5 * fine_cut);
}

TEST_CASE("images do not depend on the executor; without lights they are black") {
  Random random(7);
  const auto lights = support::random_local_lights(random, 300);
  const PreparedView view = random_view(200, false, random);
  const auto on = [&](const auto& executor) {
    LocalRelighting relighting(view, lights, balls, {}, executor);
    relighting.set_cut(64);
    return relighting.shade(executor);
  };
  const auto one = on(Serial());
  CHECK(on(support::Backwards()) == one);
  CHECK(on(support::TwoThreads()) == one);
  LocalRelighting empty(view, {}, balls, {}, Serial());
  empty.set_cut(64);
  for (const vec3& r : empty.shade(Serial())) CHECK(r == vec3(0));
}

TEST_CASE("pilots are about as many as asked for, and as many as there are at most") {
  Random random(8);
  const auto lights = support::random_local_lights(random, 1000);
  const LightTree tree = build_local_tree(lights);
  CHECK(pilot_lights(tree, lights, 100).count() == 100);
  CHECK(pilot_lights(tree, lights, 5000).count() == 1000);
  CHECK(pilot_lights(tree, lights, 0).count() == 1);
  CHECK(pilot_lights(LightTree(), {}, 100).count() == 0);
}
