// Camera rays, the sides they see, the buffer sorted by face, and the image that comes back from it.
#include <doctest/doctest.h>

#include <coppice/core/random.hpp>
#include <coppice/relight/deferred.hpp>
#include <support/executors.hpp>
#include <support/occluders.hpp>
#include <support/scenes.hpp>

using namespace coppice;
using namespace support;

namespace {

struct View {
  Scene scene = still_life();
  TriangleTracer tracer{scene.mesh};
  Raster raster;
  std::vector<CameraHit> hits;
  ReceiverMesh mesh;
  ShadingBuffer buffer;

  explicit View(Raster r) : raster(r), hits(trace_camera(tracer, *scene.camera, r, Serial())) {
    mesh = ReceiverMesh(scene.mesh, sides_seen(scene.mesh, hits));
    buffer = make_shading_buffer(scene, mesh, hits, Shading::metallic_roughness, Serial());
  }
};

std::vector<vec3> random_values(std::size_t count) {
  Random random(3);
  std::vector<vec3> values(count);
  for (vec3& v : values) v = {random.uniform(), random.uniform(), random.uniform()};
  return values;
}

}  // namespace

TEST_CASE("one sample goes through the pixel's centre, more are spread evenly over it") {
  const Raster raster{4, 3, 16};
  CHECK(raster.offset(0) == vec2(0.5f));
  vec2 mean(0);
  for (int s = 0; s < 16; ++s) {
    const vec2 o = raster.offset(s);
    CHECK(o == glm::clamp(o, vec2(0), vec2(0.999999f)));
    for (int t = 0; t < s; ++t) CHECK(length(o - raster.offset(t)) > 0.1f);
    mean += o / 16.0f;
  }
  CHECK(length(mean - vec2(0.5f)) < 0.1f);
}

TEST_CASE("camera rays come back ordered by pixel, the same on two threads") {
  const View view({64, 48, 2});
  CHECK(std::ranges::is_sorted(view.hits, {}, &CameraHit::pixel));
  const auto again = trace_camera(view.tracer, *view.scene.camera, view.raster, TwoThreads());
  REQUIRE(again.size() == view.hits.size());
  for (std::size_t i = 0; i < again.size(); ++i) {
    CHECK(again[i].pixel == view.hits[i].pixel);
    CHECK(again[i].hit.t == view.hits[i].hit.t);
  }
}

TEST_CASE("the side seen is where the vertex normals are, or its back") {
  Scene scene;
  scene.materials = {Material{}};
  add_ground(scene.mesh, 1);
  std::swap(scene.mesh.triangles[0].y, scene.mesh.triangles[0].z);  // wound against its normals
  const TriangleTracer tracer(scene.mesh);
  for (const float height : {1.0f, -1.0f})
    for (const float x : {0.3f, -0.3f}) {
      const auto hit = tracer.closest({x, height, x}, {0, -height, 0});
      REQUIRE(hit);
      CHECK(side_seen(scene.mesh, {*hit, vec3(0, height, 0), 0}).front == (height > 0));
    }
}

TEST_CASE("the buffer is sorted by face and holds every hit once") {
  const View view({64, 48, 3});
  const ShadingBuffer& buffer = view.buffer;
  REQUIRE(buffer.points.size() == view.hits.size());
  std::vector<int> samples(view.raster.pixel_count()), expected = samples;
  for (const auto pixel : buffer.pixels) ++samples[pixel];
  for (const auto& h : view.hits) ++expected[h.pixel];
  CHECK(samples == expected);
  REQUIRE(buffer.faces[0].first_point == 0);
  for (std::size_t f = 0; f < buffer.faces.size(); ++f) {
    REQUIRE(buffer.faces[f].first_point < buffer.end_of(f));
    for (std::uint32_t p = buffer.faces[f].first_point; p < buffer.end_of(f); ++p) {
      CHECK(buffer.points[p].face == f);
      CHECK((p == buffer.faces[f].first_point || buffer.pixels[p - 1] <= buffer.pixels[p]));
    }
  }
}

TEST_CASE("each point's weights and receivers give back its place on the camera ray") {
  const View view({64, 48, 1});
  const Camera& camera = *view.scene.camera;
  for (std::size_t p = 0; p < view.buffer.points.size(); ++p) {
    const ShadingPoint& point = view.buffer.points[p];
    const uvec3 r = view.buffer.faces[point.face].receivers;
    const auto& c = view.mesh.corners();
    const vec3 place = point.weight_0 * c[r.x].position + point.weight_1 * c[r.y].position +
                       (1 - point.weight_0 - point.weight_1) * c[r.z].position;
    const int x = int(view.buffer.pixels[p]) % 64, y = int(view.buffer.pixels[p]) / 64;
    CHECK(length(normalize(place - camera.position) -
                 camera.direction(float(x) + 0.5f, float(y) + 0.5f, 64, 48)) < 1e-5f);
    CHECK(length(normalize(camera.position - place) - point.to_viewer) < 1e-5f);
    CHECK(std::abs(dot(point.normal, point.tangent)) < 1e-5f);
  }
}

TEST_CASE("a pixel is the mean of its samples, missing ones count as zero") {
  const View view({32, 24, 4});
  const auto values = random_values(view.buffer.points.size());
  const Image image = resolve(view.buffer, view.raster, values);
  std::vector<vec3> expected(view.raster.pixel_count(), vec3(0));
  for (std::size_t p = 0; p < values.size(); ++p) expected[view.buffer.pixels[p]] += 0.25f * values[p];
  for (std::size_t i = 0; i < expected.size(); ++i) CHECK(length(image.pixels[i] - expected[i]) < 1e-6f);
}

TEST_CASE("coverage is antialiased: a share between 0 and 1 along silhouettes, its sum near the exact one") {
  const auto covered = [](int samples) {
    const View view({32, 24, samples});
    return direct_image(view.scene, view.raster, view.hits).coverage;
  };
  const auto few = covered(8), many = covered(128);
  int partial = 0;
  double sum = 0, expected = 0;
  for (std::size_t i = 0; i < few.size(); ++i) {
    CHECK(few[i] <= 1 + 1e-6f);
    CHECK(std::abs(few[i] - many[i]) < 0.25f);
    partial += few[i] > 0.01f && few[i] < 0.99f;
    sum += few[i], expected += many[i];
  }
  CHECK(partial > 20);
  CHECK(std::abs(sum - expected) < 0.005 * expected);
}

TEST_CASE("emission is seen from the front, and from behind where the material is double-sided") {
  Scene scene;
  scene.materials = {Material{}};
  scene.materials[0].emission = {1, 2, 3};
  add_ground(scene.mesh, 1);
  const TriangleTracer tracer(scene.mesh);
  const Raster raster{8, 8, 2};
  const auto emitted = [&](float height) {
    Camera camera = look_at({0, height, 0.5f}, vec3(0), 0.4f);
    return direct_image(scene, raster, trace_camera(tracer, camera, raster, Serial())).emission.at(4, 4);
  };
  CHECK(length(emitted(2) - vec3(1, 2, 3)) < 1e-5f);
  CHECK(emitted(-2) == vec3(0));
  scene.materials[0].double_sided = true;
  CHECK(length(emitted(-2) - vec3(1, 2, 3)) < 1e-5f);
}

TEST_CASE("a camera that sees nothing leaves empty buffers and a black image") {
  const Scene scene = still_life();
  const TriangleTracer tracer(scene.mesh);
  const Raster raster{8, 6, 1};
  const auto hits = trace_camera(tracer, look_at({0, 5, 0}, {0, 6, 0.1f}, 0.5f), raster, Serial());
  CHECK(hits.empty());
  CHECK(sides_seen(scene.mesh, hits).empty());
  const auto buffer =
      make_shading_buffer(scene, ReceiverMesh(scene.mesh, {}), hits, Shading::lambert, Serial());
  CHECK(buffer.faces.empty());
  for (const vec3& p : resolve(buffer, raster, {}).pixels) CHECK(p == vec3(0));
}
