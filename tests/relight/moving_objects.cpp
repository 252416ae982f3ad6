// Moving objects by shadow fields against the same scene, posed and prepared anew.
#include <doctest/doctest.h>

#include <coppice/relight/cut_relighting.hpp>
#include <coppice/relight/moving_objects.hpp>
#include <coppice/scene/pose.hpp>
#include <coppice/trade/errors.hpp>
#include <support/executors.hpp>
#include <support/occluders.hpp>
#include <support/scenes.hpp>

using namespace coppice;
using namespace support;

namespace {

struct SceneTracer : TriangleTracer {
  explicit SceneTracer(const Scene& scene) : TriangleTracer(scene.mesh) {}
};

constexpr Raster raster{36, 27, 1};

/// Flies from `from` to `to` within two seconds, and turns over once.
MovingObject flying_ball(const vec3& from, const vec3& to, float radius = 0.3f) {
  MovingObject object;
  add_ball(object.mesh, vec3(0), radius, 5, 1);
  Joint joint;
  joint.translation.times = {0, 2};
  joint.translation.values = {from, to};
  joint.rotation.times = {0, 1, 2};
  for (const float angle : {0.0f, 2.0f, 4.0f})
    joint.rotation.values.push_back(glm::angleAxis(angle, normalize(vec3(1, 2, 3))));
  object.motion.joints = {joint};
  return object;
}

/// A square of ground with a box on it, and what moves over it.
Scene scene_with(std::vector<MovingObject> objects) {
  Scene scene;
  scene.materials = {dielectric({0.6f, 0.6f, 0.55f}, 0.9f), dielectric({0.7f, 0.3f, 0.2f}, 0.6f)};
  add_ground(scene.mesh, 2);
  add_box(scene.mesh, {-1.2f, 0, -0.9f}, {-0.6f, 0.6f, -0.3f}, 1);
  scene.camera = look_at({0.5f, 2.5f, 3.5f}, {0, 0.2f, 0}, 0.8f);
  scene.objects = std::move(objects);
  return scene;
}

CutRelightingOptions relighting_options() {
  CutRelightingOptions o;
  o.raster = raster;
  o.light_count = 512;
  o.pilot_stride = 4;
  o.refine.max_receivers = 1000;
  o.longest_edge = 8;
  o.cuts = {{0.7}};
  return o;
}

MovingOptions moving_options() {
  MovingOptions o;
  o.raster = raster;
  o.sigma = 0.7;
  o.resolution = 8;
  o.shells = 2;
  o.reach = 10;
  o.spacing = 1;
  o.refine = {0.02, 500};
  return o;
}

/// What rests, prepared, and what moves.
template <class E = Serial>
struct System {
  Scene scene;
  SceneTracer tracer{scene};
  E executor;
  Environment environment = sky();
  CutRelighting<> relighting;
  MovingObjects<SceneTracer> objects;

  explicit System(Scene s, const MovingOptions& options = moving_options(), E e = {})
      : scene(std::move(s)),
        executor(e),
        relighting(scene, tracer, *scene.camera, environment, relighting_options(), executor),
        objects(scene, tracer, relighting.view(), relighting.tree(), relighting.directions(),
                relighting.cuts(), *scene.camera, options, executor) {}

  Pose pose(float time) const { return objects.pose(time, executor); }

  Image image(const Pose& pose) {
    const FrameLighting frame = relighting.light(environment, 256);
    const auto shade = [&](const ShadingBuffer& buffer, const MaskedCuts<std::uint8_t>& cuts) {
      std::vector<vec3> radiance(buffer.points.size());
      shade_faces<std::uint8_t>(buffer, cuts, frame, {}, 0, buffer.faces.size(), radiance, {});
      return radiance;
    };
    auto resting = shade(relighting.buffer(), pose.cuts);
    for (std::size_t p = 0; p < resting.size(); ++p)
      if (pose.hidden[p]) resting[p] = vec3(0);
    Image result = resolve(relighting.buffer(), raster, resting);
    for (const PosedObject& object : pose.objects) {
      const Image part = resolve(object.buffer, raster, shade(object.buffer, object.cuts));
      for (std::size_t i = 0; i < result.pixels.size(); ++i) result.pixels[i] += part.pixels[i];
    }
    return result;
  }

  /// The scene as it stands, as if nothing could move.
  Image image_anew(float time) const {
    Scene posed = scene;
    posed.mesh = mesh_at(scene, time);
    posed.objects.clear();
    const SceneTracer posed_tracer(posed);
    CutRelighting<> anew(posed, posed_tracer, *posed.camera, environment, relighting_options(), executor);
    return anew.image(anew.shade(anew.light(environment, 256), executor));
  }
};

double rel_rmse(const Image& image, const Image& reference) {
  return image_errors(image, reference, std::vector<bool>(image.pixels.size(), true)).rel_rmse;
}

bool same(const MaskedCuts<std::uint8_t>& a, const MaskedCuts<std::uint8_t>& b) {
  return std::ranges::equal(a.masks(), b.masks()) && std::ranges::equal(a.values(), b.values());
}

bool same(const Pose& a, const Pose& b) {
  if (!same(a.cuts, b.cuts) || a.hidden != b.hidden || a.objects.size() != b.objects.size()) return false;
  for (std::size_t k = 0; k < a.objects.size(); ++k)
    if (!same(a.objects[k].cuts, b.objects[k].cuts) ||
        a.objects[k].buffer.positions != b.objects[k].buffer.positions)
      return false;
  return true;
}

std::size_t count_hidden(const Pose& pose) { return std::size_t(std::ranges::count(pose.hidden, 1)); }

}  // namespace

TEST_CASE("a ball over a plane looks as if the scene were prepared anew at every time") {
  System system(scene_with({flying_ball({-0.9f, 0.5f, 0.4f}, {0.9f, 1, 0.2f})}));
  CHECK(system.objects.size() == 1);
  for (const float time : {0.7f, 2.0f}) {
    CAPTURE(time);
    const Pose pose = system.pose(time);
    CHECK(pose.shadowed_receivers > 0);
    CHECK(count_hidden(pose) > 10);
    CHECK(pose.objects[0].buffer.points.size() > 10);
    const Image anew = system.image_anew(time);
    const double error = rel_rmse(system.image(pose), anew);
    CHECK(error < 0.04);  // measured: 1.7 to 3.2%
    Pose shadowless = pose;
    shadowless.cuts = system.relighting.cuts();
    CHECK(rel_rmse(system.image(shadowless), anew) > 1.5 * error);
  }
}

TEST_CASE("pixels are covered once: by what rests, by an object, or by the one before it") {
  System system(scene_with({flying_ball({-0.9f, 0.5f, 0.4f}, {0.9f, 0.5f, 0.4f}),
                            flying_ball({0.9f, 0.5f, 0.4f}, {-0.9f, 0.5f, 0.3f})}));
  for (const float time : {0.0f, 0.95f, 1.5f}) {
    const Pose pose = system.pose(time);
    std::vector<int> covered(raster.pixel_count());
    const ShadingBuffer& resting = system.relighting.buffer();
    for (std::size_t p = 0; p < resting.points.size(); ++p) covered[resting.pixels[p]] += !pose.hidden[p];
    for (const auto& object : pose.objects)
      for (const std::uint32_t pixel : object.buffer.pixels) ++covered[pixel];
    Scene posed = system.scene;
    posed.mesh = mesh_at(system.scene, time);
    std::vector<int> expected(raster.pixel_count());
    for (const auto& hit : trace_camera(SceneTracer(posed), *posed.camera, raster, Serial()))
      ++expected[hit.pixel];
    std::size_t different = 0;
    for (std::size_t i = 0; i < covered.size(); ++i) different += covered[i] != expected[i];
    CHECK(different <= 2);  // silhouettes, to the rounding of turned rays
  }
}

TEST_CASE("two objects shade the ground and each other") {
  System system(scene_with({flying_ball({-0.4f, 0.4f, 0.3f}, {-0.4f, 0.4f, 0.3f}),
                            flying_ball({0.6f, 1.1f, 0.7f}, {-0.3f, 1.2f, 0.4f}, 0.35f)}));
  const double error = rel_rmse(system.image(system.pose(2)), system.image_anew(2));
  CHECK(error < 0.04);  // measured: 1.7 to 3.2%
}

TEST_CASE("an object beyond its reach leaves the cuts of what rests as they were, bit for bit") {
  System system(scene_with({flying_ball({0, 0.6f, 0}, {0, 20, 0})}));
  CHECK(system.pose(0).shadowed_receivers > 0);
  const Pose far = system.pose(2);
  CHECK(far.shadowed_receivers == 0);
  CHECK(same(far.cuts, system.relighting.cuts()));
  CHECK(far.objects[0].buffer.points.empty());
  CHECK(count_hidden(far) == 0);
}

TEST_CASE("before the first key and after the last objects rest") {
  const System system(scene_with({flying_ball({-0.9f, 0.5f, 0.4f}, {0.9f, 1, 0.2f})}));
  CHECK(same(system.pose(-5), system.pose(0)));
  CHECK(same(system.pose(100), system.pose(2)));
  CHECK_FALSE(same(system.pose(0), system.pose(2)));
}

TEST_CASE("an object without keys rests where its frame is; a scene without objects is what rests") {
  MovingObject still = flying_ball(vec3(0), vec3(0));
  still.motion.joints.clear();
  for (vec3& p : still.mesh.positions) p += vec3(0.3f, 0.5f, 0.3f);
  System system(scene_with({still}));
  const double error = rel_rmse(system.image(system.pose(1)), system.image_anew(1));
  CHECK(error < 0.04);  // measured: 1.7 to 3.2%
  System none(scene_with({}));
  const Pose pose = none.pose(3);
  CHECK(pose.objects.empty());
  CHECK(same(pose.cuts, none.relighting.cuts()));
  CHECK(none.image(pose).pixels == none.image_anew(3).pixels);
}

TEST_CASE("poses do not depend on the executor") {
  MovingOptions coarse = moving_options();
  coarse.resolution = 3, coarse.shells = 1;
  const auto scene = [] { return scene_with({flying_ball({-0.9f, 0.5f, 0.4f}, {0.9f, 1, 0.2f})}); };
  const System one(scene(), coarse);
  CHECK(same(System(scene(), coarse, Backwards()).pose(0.8f), one.pose(0.8f)));
  CHECK(same(System(scene(), coarse, TwoThreads()).pose(0.8f), one.pose(0.8f)));
}
