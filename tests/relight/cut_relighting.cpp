// The whole system on a small scene, against brute force and against what light must do.
#include <doctest/doctest.h>

#include <coppice/relight/cut_relighting.hpp>
#include <coppice/trade/errors.hpp>
#include <support/executors.hpp>
#include <support/occluders.hpp>
#include <support/scenes.hpp>

using namespace coppice;
using namespace support;

namespace {

CutRelightingOptions small_options(std::uint32_t lights = 1024) {
  CutRelightingOptions o;
  o.raster = {64, 48, 1};
  o.light_count = lights;
  o.pilot_stride = 4;
  o.refine.max_receivers = 3000;
  o.keep_bits = true;
  return o;
}

/// A scene with its tracer, prepared.
template <class E = Serial>
struct System {
  Scene scene;
  TriangleTracer tracer{scene.mesh};
  E executor;
  CutRelighting<> relighting;

  System(Scene s, const Environment& environment, const CutRelightingOptions& options)
      : scene(std::move(s)),
        relighting(scene, tracer, scene.camera.value_or(Camera{}), environment, options, executor) {}

  Image shade(const Environment& environment, std::size_t nodes = 256, std::size_t which = 0) {
    const FrameLighting frame = relighting.light(environment, nodes, which);
    return relighting.image(relighting.shade(frame, executor, which));
  }
  template <Skip skip = Skip::nothing>
  Image brute_force(const Environment& environment) {
    return relighting.image(
        relighting.template shade_by_brute_force<skip>(relighting.light(environment, 1), executor));
  }
};

double rel_rmse(const Image& image, const Image& reference) {
  return image_errors(image, reference, std::vector<bool>(image.pixels.size(), true)).rel_rmse;
}

bool is_black(const Image& image) {
  return std::ranges::all_of(image.pixels, [](const vec3& p) { return p == vec3(0); });
}

Scene lone_ball(const vec3& albedo) {
  Scene scene;
  scene.materials = {dielectric(albedo, 1)};
  add_ball(scene.mesh, vec3(0), 1, 16);
  scene.camera = look_at({1, 1.5f, 4}, vec3(0), 0.6f);
  return scene;
}

/// A ball of few faces, whose corners see other skies than the points between them, in a box's shadow.
Scene coarse_ball_by_a_box() {
  Scene scene;
  scene.materials = {dielectric({0.6f, 0.6f, 0.55f}, 0.9f), dielectric({0.7f, 0.3f, 0.2f}, 0.6f)};
  add_ground(scene.mesh, 2, 0, 0);
  add_ball(scene.mesh, {0.3f, 0.6f, 0}, 0.5f, 5, 1);
  add_box(scene.mesh, {-1, 0, -0.5f}, {-0.4f, 0.9f, 0.3f}, 1);
  scene.camera = look_at({0.5f, 2, 3.5f}, {0, 0.35f, 0}, 0.7f);
  return scene;
}

/// The scene and its camera turned by `angle` radians about +Y, +X towards -Z.
Scene turned(Scene scene, float angle) {
  const mat3 turn = glm::mat3_cast(glm::angleAxis(angle, vec3(0, 1, 0)));
  for (vec3& p : scene.mesh.positions) p = turn * p;
  for (vec3& n : scene.mesh.normals) n = turn * n;
  Camera& camera = *scene.camera;
  for (vec3* v : {&camera.position, &camera.right, &camera.up, &camera.forward}) *v = turn * *v;
  return scene;
}

}  // namespace

TEST_CASE("white furnace: a white ball alone under constant light is as bright as the light") {
  CutRelightingOptions options = small_options(4096);
  options.shading = Shading::lambert;
  const Environment white = constant_environment(vec3(1));
  System system(lone_ball(vec3(1)), white, options);
  const auto radiance = system.relighting.shade(system.relighting.light(white, 1024), Serial());
  const ShadingBuffer& buffer = system.relighting.buffer();
  REQUIRE(radiance.size() > 500);
  double worst = 0;
  std::size_t turned_away = 0;
  for (std::size_t p = 0; p < radiance.size(); ++p) {
    const Receiver& receiver = system.relighting.receivers()[buffer.faces[buffer.points[p].face].receivers.x];
    const bool faces_inward =
        dot(buffer.points[p].normal, receiver.normal) < 0;  // at the silhouette, turned to the viewer
    turned_away += faces_inward;
    for (int c = 0; c < 3 && !faces_inward; ++c)
      worst = std::max(worst, std::abs(double(radiance[p][c]) - 1));
  }
  CHECK(turned_away < 5);
  CHECK(worst < 0.01);
}

TEST_CASE("two threads give the same bits") {
  const Environment environment = sky();
  System<Serial> one(still_life(), environment, small_options());
  System<TwoThreads> two(still_life(), environment, small_options());
  CHECK(one.relighting.receivers().size() == two.relighting.receivers().size());
  CHECK(std::ranges::equal(one.relighting.bits(), two.relighting.bits()));
  CHECK(std::ranges::equal(one.relighting.cuts().masks(), two.relighting.cuts().masks()));
  CHECK(one.shade(environment).pixels == two.shade(environment).pixels);
  CHECK(one.brute_force(environment).pixels == two.brute_force(environment).pixels);
}

TEST_CASE("skipping unseen lights changes nothing") {
  const Environment environment = sky();
  System system(still_life(), environment, small_options());
  CHECK(rel_rmse(system.brute_force<Skip::unseen>(environment), system.brute_force(environment)) < 1e-6);
}

TEST_CASE("fine visibility cuts and all illumination nodes converge to all lights") {
  CutRelightingOptions options = small_options();
  options.cuts = {{0.01, 100000}};
  const Environment environment = sky();
  System system(still_life(), environment, options);
  CHECK(rel_rmse(system.shade(environment, 1024), system.brute_force(environment)) < 1e-5);
}

TEST_CASE("the error grows with the threshold and falls with the illumination nodes") {
  CutRelightingOptions options = small_options();
  options.cuts = {{0.3, 10000}, {0.7, 10000}, {1.5, 10000}, {3, 10000}, {6, 10000}};
  const Environment environment = sky();
  System system(still_life(), environment, options);
  const Image reference = system.brute_force(environment);
  double last = 0;
  for (std::size_t which = 0; which < options.cuts.size(); ++which) {
    const double error = rel_rmse(system.shade(environment, 1024, which), reference);
    CAPTURE(which);
    CHECK(error > 0.9 * last);
    CHECK(error < 0.2);
    last = error;
  }
  CHECK(last > 0.005);
  const double few = rel_rmse(system.shade(environment, 4), reference);
  const double some = rel_rmse(system.shade(environment, 64), reference);
  const double many = rel_rmse(system.shade(environment, 1024), reference);
  CHECK(some < few);
  CHECK(many < 1.01 * some);
}

TEST_CASE("cosine cuts need their horizons: without them light leaks round the edges of faces") {
  const Environment environment = sky();
  System system(coarse_ball_by_a_box(), environment, small_options(4096));
  const Image reference = system.brute_force(environment);
  const double with_horizons = rel_rmse(system.shade(environment), reference);
  CHECK(with_horizons < 0.015);
  const auto& cuts = system.relighting.cuts();
  MaskedCuts<std::uint8_t> without(cuts.leaf_count(), cuts.granule_log2());
  for (std::size_t i = 0; i < cuts.size(); ++i) without.append(cuts.unpack(i), no_horizon);
  const ShadingBuffer& buffer = system.relighting.buffer();
  std::vector<vec3> radiance(buffer.points.size());
  shade_faces<std::uint8_t>(buffer, without, system.relighting.light(environment, 256), {}, 0,
                            buffer.faces.size(), radiance, {});
  CHECK(rel_rmse(system.relighting.image(radiance), reference) > 1.8 * with_horizons);
}

TEST_CASE("refined lobes keep the highlights that sampled and filtered ones lose") {
  Scene scene = still_life();
  for (Material& material : scene.materials) material.metallic = 1, material.roughness = 0.25f;
  CutRelightingOptions options = small_options();
  options.cuts = {{0.5, 1000}};
  const Environment environment = sky();
  System system(scene, environment, options);
  const Image reference = system.brute_force(environment);
  const FrameLighting frame = system.relighting.light(environment, 64);
  const auto error = [&](const LobeOptions& lobes) {
    return rel_rmse(system.relighting.image(system.relighting.shade(frame, Serial(), 0, {}, lobes)),
                    reference);
  };
  const double refined = error({Lobes::refined});
  CHECK(refined < 0.015);
  CHECK(error({Lobes::refined, 0.1f}) > 1.5 * refined);
  CHECK(error({Lobes::filtered}) > 10 * refined);
  CHECK(error({Lobes::sampled}) > 2 * error({Lobes::filtered}));
  CHECK(rel_rmse(system.shade(environment, 64), reference) == refined);
}

TEST_CASE("turning scene, camera and environment together leaves the image, but for the lattice of lights") {
  Environment environment = sky();
  const Image image = System(still_life(), environment, small_options(2048)).shade(environment, 2048);
  for (const float degrees : {90.0f, 37.0f}) {
    CAPTURE(degrees);
    environment.rotation = glm::radians(degrees);
    System system(turned(still_life(), environment.rotation), environment, small_options(2048));
    const double error = rel_rmse(system.shade(environment, 2048), image);
    CHECK(error < 0.02);  // measured: 0.7% at 4,096 lights
    CHECK(error > 0);
  }
}

TEST_CASE("turning the environment the wrong way shows") {
  Environment environment = sky();
  const Image image = System(still_life(), environment, small_options()).shade(environment);
  environment.rotation = glm::radians(-37.0f);
  System system(turned(still_life(), glm::radians(37.0f)), environment, small_options());
  CHECK(rel_rmse(system.shade(environment), image) > 0.1);
}

TEST_CASE("an empty scene and a view past the scene give black images") {
  const Environment environment = sky();
  System nothing(Scene{}, environment, small_options());
  CHECK(is_black(nothing.shade(environment)));
  CHECK(is_black(nothing.brute_force(environment)));
  Scene past = still_life();
  past.camera = look_at({0, 5, 0}, {0, 6, 0.1f}, 0.5f);
  System system(past, environment, small_options());
  CHECK(is_black(system.shade(environment)));
  CHECK(system.relighting.receivers().empty());
}

TEST_CASE("a black environment gives a black image, and emitters shine in it") {
  const Environment night = constant_environment(vec3(0));
  System system(still_life(), night, small_options());
  CHECK(is_black(system.shade(night)));
  CHECK(is_black(system.brute_force(night)));
  Scene lamp = still_life();
  lamp.materials[1].emission = vec3(5);
  System lit(lamp, night, small_options());
  const Image image = lit.shade(night);
  CHECK(std::ranges::count(image.pixels, vec3(5)) > 50);
  CHECK(image.pixels == lit.relighting.direct().emission.pixels);
}

TEST_CASE("one texel of 1e30 gives finite values that agree with all lights") {
  Environment environment = constant_environment(vec3(0), 64, 32);
  environment.map.at(40, 6) = vec3(1e30f);
  CutRelightingOptions options = small_options();
  options.cuts.push_back({0.01, 100000});
  System system(still_life(), environment, options);
  const Image coarse = system.shade(environment), fine = system.shade(environment, 1024, 1);
  const Image reference = system.brute_force(environment);
  for (const vec3& p : coarse.pixels) CHECK(is_finite(p));
  CHECK(rel_rmse(coarse, reference) < 0.2);
  CHECK(rel_rmse(fine, reference) < 1e-5);
  CHECK(std::ranges::any_of(reference.pixels, [](const vec3& p) { return p.x > 1e25f; }));
}

TEST_CASE("one, two or three lights and one pixel are enough") {
  for (const std::uint32_t lights : {1u, 2u, 3u}) {
    CutRelightingOptions options = small_options(lights);
    options.raster = {1, 1, 1};
    options.cuts = {{0.001, 8}};
    const Environment environment = constant_environment(vec3(1), 1, 1);
    System system(still_life(), environment, options);
    CHECK(is_finite(system.shade(environment).pixels[0]));
    CHECK(rel_rmse(system.shade(environment), system.brute_force(environment)) < 1e-5);
  }
}

TEST_CASE("maps of any size can follow one another") {
  const Environment white = constant_environment(vec3(1));
  System system(still_life(), white, small_options());
  const Image image = system.shade(white, 1024);
  CHECK(rel_rmse(system.shade(constant_environment(vec3(1), 100, 37), 1024), image) < 0.01);
  CHECK(rel_rmse(system.shade(constant_environment(vec3(2), 1, 1), 1024),
                 system.shade(constant_environment(vec3(2)), 1024)) < 0.01);
  CHECK(system.shade(white, 1024).pixels == image.pixels);
}

TEST_CASE("the image is linear in the light") {
  const Environment environment = sky(), white = constant_environment(vec3(0.5f), 128, 64);
  Environment both = environment;
  for (vec3& p : both.map.pixels) p = 2.0f * p + 0.5f;
  System system(still_life(), environment, small_options());
  const Image a = system.brute_force(environment), b = system.brute_force(white),
              sum = system.brute_force(both);
  Image expected = a;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) expected.pixels[i] = 2.0f * a.pixels[i] + b.pixels[i];
  CHECK(rel_rmse(sum, expected) < 0.002);  // the mean direction inside a cell follows its light
}

TEST_CASE("receivers everywhere give nearly the image of receivers on what is seen") {
  const Environment environment = sky();
  CutRelightingOptions options = small_options();
  options.refine.max_receivers = 20000;
  System seen(still_life(), environment, options);
  options.scope = ReceiverScope::all;
  System all(still_life(), environment, options);
  CHECK(all.relighting.receivers().size() > seen.relighting.receivers().size());
  CHECK(rel_rmse(all.shade(environment), seen.shade(environment)) < 0.05);
}

TEST_CASE("more samples a pixel converge to the mean of a finer image") {
  const Environment environment = sky();
  CutRelightingOptions options = small_options();
  options.raster = {32, 24, 16};
  const Image soft = System(still_life(), environment, options).shade(environment);
  options.raster = {128, 96, 1};
  const Image fine = System(still_life(), environment, options).shade(environment);
  std::vector<bool> counts;
  const Image means = block_means(fine, std::vector<bool>(fine.pixels.size(), true), 4, counts);
  CHECK(rel_rmse(soft, means) < 0.1);
}

TEST_CASE("the report and the counts of clusters tell what happened") {
  const Environment environment = sky();
  System system(still_life(), environment, small_options());
  const PreparationReport& report = system.relighting.report();
  CHECK(report.receivers == system.relighting.receivers().size());
  CHECK(report.unrefined_receivers < report.receivers);
  CHECK(report.receivers <= 3000);
  CHECK(report.rays > 0);
  CHECK(report.rays <= report.receivers * 1024);
  std::vector<std::uint32_t> clusters(system.relighting.buffer().points.size());
  const FrameLighting frame = system.relighting.light(environment, 64);
  system.relighting.shade(frame, Serial(), 0, clusters);
  const auto highest = *std::ranges::max_element(clusters);
  CHECK(highest > 64);
  CHECK(highest <= 1024);
}
