#include <doctest/doctest.h>

#include <algorithm>
#include <bit>
#include <coppice/embree/threads.hpp>
#include <coppice/embree/tracer.hpp>
#include <limits>
#include <random>
#include <vector>

using namespace coppice;

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
using dvec3 = glm::dvec3;

struct Random {
  std::mt19937 engine;
  explicit Random(unsigned seed) : engine(seed) {}
  float uniform() { return float(engine() >> 8) * 0x1p-24f; }
  vec3 in_cube() { return vec3(uniform(), uniform(), uniform()) * 2.0f - 1.0f; }
  vec3 direction() {
    for (;;) {
      const vec3 v = in_cube();
      if (dot(v, v) > 0.01f && dot(v, v) <= 1) return normalize(v);
    }
  }
};

struct Ray {
  vec3 origin, direction;
  float t_max;
};

std::vector<Ray> random_rays(std::size_t count, unsigned seed) {
  Random random(seed);
  std::vector<Ray> rays(count);
  for (Ray& ray : rays) {
    const vec3 origin = random.in_cube() * 1.5f;
    const vec3 direction = random.direction();
    ray = {origin, direction, random.uniform() < 0.25f ? infinity : 2 * random.uniform()};
  }
  return rays;
}

void add_triangle(Scene& scene, const vec3& a, const vec3& b, const vec3& c) {
  const auto first = std::uint32_t(scene.mesh.positions.size());
  scene.mesh.positions.insert(scene.mesh.positions.end(), {a, b, c});
  scene.mesh.uvs.resize(first + 3);
  scene.mesh.triangles.push_back({first, first + 1, first + 2});
  scene.mesh.materials.push_back(0);
}

/// Triangles of random size in [-1, 1]³; every other one has a material with an alpha mask but no holes, so
/// that both of the tracer's geometries take part.
Scene triangle_soup(std::size_t count, unsigned seed) {
  Random random(seed);
  Scene scene;
  scene.materials.resize(2);
  scene.materials[1].alpha_mask = true;
  for (std::size_t i = 0; i < count; ++i) {
    const vec3 centre = random.in_cube();
    const float size = 0.05f + 0.4f * random.uniform();
    const vec3 a = random.in_cube(), b = random.in_cube(), c = random.in_cube();
    add_triangle(scene, centre + size * a, centre + size * b, centre + size * c);
    scene.mesh.materials.back() = std::uint32_t(i % 2);
  }
  return scene;
}

/// What the slow twin knows of a ray; `unclear` where it passes so near to an edge, an end of the segment or
/// a second hit that rounding decides.
struct Expected {
  std::optional<Hit> hit;
  bool unclear = false;
};

constexpr double margin = 1e-4;

/// Möller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", JGT 1997, in double precision;
/// adds triangle `index` to what is known of the ray.
void intersect(const Mesh& mesh, std::uint32_t index, const Ray& ray, Expected& expected) {
  const uvec3 corners = mesh.triangles[index];
  const dvec3 p0(mesh.positions[corners.x]), direction(ray.direction);
  const dvec3 e1 = dvec3(mesh.positions[corners.y]) - p0, e2 = dvec3(mesh.positions[corners.z]) - p0;
  const dvec3 p = glm::cross(direction, e2), s = dvec3(ray.origin) - p0, q = glm::cross(s, e1);
  const double determinant = glm::dot(e1, p);
  if (determinant == 0) return;
  const double u = glm::dot(s, p) / determinant, v = glm::dot(direction, q) / determinant;
  const double t = glm::dot(e2, q) / determinant;
  const double inside = std::min({u, v, 1 - u - v});
  if (inside < -margin || t < -margin || t > ray.t_max + margin) return;
  if (inside < margin || t < margin || t > ray.t_max - margin) expected.unclear = true;
  if (expected.hit && std::abs(t - double(expected.hit->t)) < margin) expected.unclear = true;
  if (expected.hit && double(expected.hit->t) < t) return;
  const bool front = glm::dot(direction, glm::cross(e1, e2)) < 0;
  expected.hit = Hit{index, float(u), float(v), float(t), front};
}

Expected brute_force(const Scene& scene, const Ray& ray) {
  Expected expected;
  for (std::size_t i = 0; i < scene.mesh.triangles.size(); ++i)
    intersect(scene.mesh, std::uint32_t(i), ray, expected);
  return expected;
}

vec3 position(const Mesh& mesh, const Hit& hit) {
  const uvec3 corners = mesh.triangles[hit.triangle];
  return (1 - hit.u - hit.v) * mesh.positions[corners.x] + hit.u * mesh.positions[corners.y] +
         hit.v * mesh.positions[corners.z];
}

void set_lane(ShadowPacket& packet, std::size_t lane, const Ray& ray) {
  packet.origin_x[lane] = ray.origin.x;
  packet.origin_y[lane] = ray.origin.y;
  packet.origin_z[lane] = ray.origin.z;
  packet.direction_x[lane] = ray.direction.x;
  packet.direction_y[lane] = ray.direction.y;
  packet.direction_z[lane] = ray.direction.z;
  packet.t_max[lane] = ray.t_max;
}

}  // namespace

TEST_CASE("closest agrees with brute force over a triangle soup") {
  for (const std::size_t triangles : {1, 10, 300}) {
    CAPTURE(triangles);
    const Scene scene = triangle_soup(triangles, 11);
    const EmbreeTracer tracer(scene);
    std::size_t unclear = 0, hits = 0, backs = 0;
    const std::vector<Ray> rays = random_rays(4000, 12);
    for (Ray ray : rays) {
      ray.t_max = infinity;
      const Expected expected = brute_force(scene, ray);
      if (expected.unclear) {
        ++unclear;
        continue;
      }
      const std::optional<Hit> hit = tracer.closest(ray.origin, ray.direction);
      REQUIRE(hit.has_value() == expected.hit.has_value());
      if (!hit) continue;
      ++hits;
      backs += !hit->front;
      CHECK(hit->triangle == expected.hit->triangle);
      CHECK(hit->front == expected.hit->front);
      CHECK(hit->t == doctest::Approx(expected.hit->t).epsilon(1e-4));
      CHECK(length(position(scene.mesh, *hit) - (ray.origin + hit->t * ray.direction)) < 1e-4f);
    }
    CHECK(unclear < rays.size() / 20);
    CHECK(hits > 0);
    CHECK(backs > 0);
    CHECK(backs < hits);
  }
}

TEST_CASE("occluded agrees with brute force and respects t_max") {
  const Scene scene = triangle_soup(400, 21);
  const EmbreeTracer tracer(scene);
  const std::vector<Ray> rays = random_rays(6000, 22);
  std::size_t unclear = 0, blocked = 0;
  for (const Ray& ray : rays) {
    const Expected expected = brute_force(scene, ray);
    if (expected.unclear) {
      ++unclear;
      continue;
    }
    const bool occluded = tracer.occluded(ray.origin, ray.direction, ray.t_max);
    blocked += occluded;
    CHECK(occluded == expected.hit.has_value());
  }
  CHECK(unclear < rays.size() / 20);
  CHECK(blocked > rays.size() / 10);
  CHECK(blocked < rays.size() * 9 / 10);
}

TEST_CASE("A shadow ray ends before what lies beyond t_max") {
  Scene scene;
  scene.materials.resize(1);
  add_triangle(scene, {-1, -1, 2}, {1, -1, 2}, {0, 1, 2});
  const EmbreeTracer tracer(scene);
  CHECK(tracer.occluded({0, 0, 0}, {0, 0, 1}, infinity));
  CHECK(tracer.occluded({0, 0, 0}, {0, 0, 1}, 2.001f));
  CHECK_FALSE(tracer.occluded({0, 0, 0}, {0, 0, 1}, 1.999f));
  CHECK_FALSE(tracer.occluded({0, 0, 0}, {0, 0, 1}, 0));
  CHECK_FALSE(tracer.occluded({0, 0, 0}, {0, 0, 1}, -1));
  CHECK_FALSE(tracer.occluded({0, 0, 0}, {0, 0, -1}, infinity));
}

TEST_CASE("A hit has the barycentric coordinates and distance and side of the header") {
  Scene scene;
  scene.materials.resize(1);
  add_triangle(scene, {0, 0, 0}, {4, 0, 0}, {0, 4, 0});
  const EmbreeTracer tracer(scene);
  const std::optional<Hit> front = tracer.closest({1, 2, 3}, {0, 0, -1});
  REQUIRE(front);
  CHECK(front->u == doctest::Approx(0.25f));
  CHECK(front->v == doctest::Approx(0.5f));
  CHECK(front->t == doctest::Approx(3));
  CHECK(front->front);
  const std::optional<Hit> back = tracer.closest({1, 2, -3}, {0, 0, 2});
  REQUIRE(back);
  CHECK(back->t == doctest::Approx(1.5f));  // in lengths of the direction
  CHECK_FALSE(back->front);
}

TEST_CASE("Packets equal single rays and no lane outside the mask is reported") {
  const Scene scene = triangle_soup(200, 31);
  const EmbreeTracer tracer(scene);
  const std::vector<Ray> rays = random_rays(16 * 500, 32);
  const vec3 poison(std::numeric_limits<float>::quiet_NaN());
  Random random(33);
  std::size_t blocked_lanes = 0;
  for (std::size_t first = 0; first < rays.size(); first += 16) {
    std::uint32_t lanes = random.engine() & 0xffff;
    if (first == 0) lanes = 0;
    if (first == 16) lanes = 0xffff;
    ShadowPacket packet;
    std::uint32_t expected = 0;
    for (std::size_t lane = 0; lane < 16; ++lane) {
      const Ray& ray = rays[first + lane];
      const bool used = lanes >> lane & 1;
      set_lane(packet, lane, used ? ray : Ray{poison, poison, -infinity});
      if (used && tracer.occluded(ray.origin, ray.direction, ray.t_max)) expected |= 1u << lane;
    }
    CHECK(tracer.occluded(packet, lanes) == expected);
    blocked_lanes += std::size_t(std::popcount(expected));
  }
  CHECK(blocked_lanes > 500);
}

TEST_CASE("A scene without triangles blocks nothing") {
  const Scene scene;
  const EmbreeTracer tracer(scene);
  ShadowPacket packet;
  const std::vector<Ray> rays = random_rays(16, 41);
  for (std::size_t lane = 0; lane < 16; ++lane) {
    set_lane(packet, lane, rays[lane]);
    CHECK_FALSE(tracer.closest(rays[lane].origin, rays[lane].direction));
    CHECK_FALSE(tracer.occluded(rays[lane].origin, rays[lane].direction, infinity));
  }
  CHECK(tracer.occluded(packet, 0xffff) == 0);
}

TEST_CASE("Degenerate triangles are never hit and hide nothing") {
  Scene scene;
  scene.materials.resize(1);
  add_triangle(scene, {0, 0, 1}, {0, 0, 1}, {0, 0, 1});   // a point
  add_triangle(scene, {-1, 0, 1}, {1, 0, 1}, {0, 0, 1});  // a line
  add_triangle(scene, {-1, -1, 2}, {1, -1, 2}, {0, 1, 2});
  const EmbreeTracer tracer(scene);
  for (const float x : {-0.25f, 0.0f, 0.25f}) {
    const std::optional<Hit> hit = tracer.closest({x, 0, 0}, {0, 0, 1});
    REQUIRE(hit);
    CHECK(hit->triangle == 2);
    CHECK_FALSE(tracer.occluded({x, 0, 0}, {0, 0, 1}, 1.5f));
  }
}

TEST_CASE("A surface is watertight along its edges for camera rays, and inside its triangles for all") {
  constexpr std::uint32_t cells = 24;
  Scene scene;
  scene.materials.resize(1);
  Random random(51);
  for (std::uint32_t y = 0; y <= cells; ++y)
    for (std::uint32_t x = 0; x <= cells; ++x)
      scene.mesh.positions.push_back({float(x) / 7, float(y) / 7, 0.2f * random.uniform()});
  for (std::uint32_t y = 0; y < cells; ++y)
    for (std::uint32_t x = 0; x < cells; ++x) {
      const std::uint32_t corner = y * (cells + 1) + x, above = corner + cells + 1;
      scene.mesh.triangles.insert(scene.mesh.triangles.end(),
                                  {{corner, corner + 1, above}, {above, corner + 1, above + 1}});
    }
  scene.mesh.materials.resize(scene.mesh.triangles.size());
  const EmbreeTracer tracer(scene);

  const vec3 eye(1.3f, 1.7f, 40);
  std::size_t leaks = 0;
  for (std::uint32_t y = 1; y < cells; ++y)
    for (std::uint32_t x = 1; x < cells; ++x) {
      const std::uint32_t corner = y * (cells + 1) + x;
      for (const std::uint32_t other : {corner + 1, corner + cells + 1, corner + cells})
        for (const float along : {0.1f, 0.3f, 0.5f, 0.8f}) {
          const vec3 target = glm::mix(scene.mesh.positions[corner], scene.mesh.positions[other], along);
          leaks += !tracer.closest(eye, normalize(target - eye));
        }
    }
  CHECK(leaks == 0);
  for (const uvec3& t : scene.mesh.triangles) {
    const float u = 0.05f + 0.45f * random.uniform(), v = 0.05f + 0.4f * random.uniform();
    const auto& p = scene.mesh.positions;
    const vec3 target = (1 - u - v) * p[t.x] + u * p[t.y] + v * p[t.z];
    CHECK(tracer.occluded(eye, normalize(target - eye), infinity));
  }
}

TEST_CASE("Rays from two threads give what one thread gives") {
  const Scene scene = triangle_soup(200, 61);
  const EmbreeTracer tracer(scene);
  const std::vector<Ray> rays = random_rays(20000, 62);
  const auto trace = [&](const auto& executor) {
    std::vector<float> distances(rays.size());
    executor(rays.size(), 64, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const std::optional<Hit> hit = tracer.closest(rays[i].origin, rays[i].direction);
        const bool blocked = tracer.occluded(rays[i].origin, rays[i].direction, rays[i].t_max);
        distances[i] = (hit ? hit->t + float(hit->triangle) : -1) + (blocked ? 1000.0f : 0.0f);
      }
    });
    return distances;
  };
  CHECK(trace(Threads(2)) == trace(Serial{}));
}

TEST_CASE("A moved tracer keeps its scene") {
  const Scene full = triangle_soup(50, 71), empty;
  const std::vector<Ray> rays = random_rays(500, 72);
  EmbreeTracer first(full), moved(empty);
  std::vector<bool> before, after;
  for (const Ray& ray : rays) before.push_back(first.occluded(ray.origin, ray.direction, ray.t_max));
  moved = std::move(first);
  for (const Ray& ray : rays) after.push_back(moved.occluded(ray.origin, ray.direction, ray.t_max));
  CHECK(before == after);
  CHECK(std::ranges::count(before, true) > 0);
}
