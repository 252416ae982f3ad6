// Rigid transforms, keyframes and chains of joints, against matrices and the definitions of glTF.
#include <doctest/doctest.h>

#include <coppice/core/random.hpp>
#include <coppice/scene/pose.hpp>
#include <limits>

using namespace coppice;

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

float distance(const vec3& a, const vec3& b) { return length(a - b); }

// Between the rotations, which q and -q are the same of.
double angle_between(const glm::quat& a, const glm::quat& b) {
  const glm::dquat d = glm::conjugate(glm::dquat(a)) * glm::dquat(b);
  return 2 * std::atan2(length(glm::dvec3(d.x, d.y, d.z)), std::abs(d.w));
}

vec3 any_vector(Random& random) {
  return {2 * random.uniform() - 1, 2 * random.uniform() - 1, 2 * random.uniform() - 1};
}

glm::quat any_rotation(Random& random) {
  const vec3 v = any_vector(random);
  return glm::normalize(glm::quat(random.uniform() + 0.1f, v.x, v.y, v.z));
}

glm::quat about_z(float angle) { return glm::angleAxis(angle, vec3(0, 0, 1)); }

RigidTransform any_transform(Random& random) { return {any_rotation(random), any_vector(random)}; }

glm::dmat4 matrix_of(const RigidTransform& t) {
  glm::dmat4 matrix = glm::mat4_cast(glm::dquat(t.rotation));
  matrix[3] = glm::dvec4(glm::dvec3(t.translation), 1);
  return matrix;
}

}  // namespace

TEST_CASE("a transform, its inverse and its products agree with matrices") {
  Random random(1);
  for (int round = 0; round < 200; ++round) {
    const RigidTransform a = any_transform(random), b = any_transform(random);
    const vec3 p = any_vector(random);
    const glm::dmat4 product = matrix_of(a) * matrix_of(b);
    CHECK(distance((a * b).point(p), vec3(product * glm::dvec4(p, 1))) < 2e-6f);
    CHECK(distance((a * b).direction(p), vec3(product * glm::dvec4(p, 0))) < 2e-6f);
    CHECK(distance(a.inverse().point(a.point(p)), p) < 2e-6f);
    CHECK(distance(a.inverse().direction(a.direction(p)), p) < 2e-6f);
    CHECK(std::abs(length(a.direction(p)) - length(p)) < 1e-6f);
  }
}

TEST_CASE("without keys a track rests, with one it is constant") {
  CHECK(Keyframes<vec3>{}.at(3) == vec3(0));
  CHECK(Keyframes<glm::quat>{}.at(3) == glm::quat(1, 0, 0, 0));
  for (const Interpolation interpolation : {Interpolation::step, Interpolation::linear})
    for (const float time : {-infinity, 0.0f, 2.0f, 9.0f, infinity})
      CHECK(Keyframes<vec3>{interpolation, {2}, {vec3(1, 2, 3)}}.at(time) == vec3(1, 2, 3));
  CHECK(Keyframes<vec3>{Interpolation::cubic_spline, {2}, {vec3(9), vec3(4), vec3(9)}}.at(5) == vec3(4));
}

TEST_CASE("values are clamped outside of the keys and exact at them") {
  const std::vector<float> times{1, 2, 4};
  const std::vector<vec3> values{vec3(1), vec3(5), vec3(-3)};
  std::vector<vec3> with_tangents;
  for (const vec3& value : values) with_tangents.insert(with_tangents.end(), {vec3(7), value, vec3(-8)});
  for (const Interpolation interpolation :
       {Interpolation::step, Interpolation::linear, Interpolation::cubic_spline}) {
    const bool is_cubic = interpolation == Interpolation::cubic_spline;
    const Keyframes<vec3> track{interpolation, times, is_cubic ? with_tangents : values};
    CHECK(track.at(-infinity) == values[0]);
    CHECK(track.at(0.5f) == values[0]);
    for (std::size_t key = 0; key < times.size(); ++key) CHECK(track.at(times[key]) == values[key]);
    CHECK(track.at(4.5f) == values[2]);
    CHECK(track.at(infinity) == values[2]);
  }
}

TEST_CASE("STEP holds the earlier value, LINEAR runs straight to the next") {
  const std::vector<float> times{0, 1, 3};
  const std::vector<vec3> values{vec3(0), vec3(2, 0, 0), vec3(2, 4, 0)};
  const Keyframes<vec3> step{Interpolation::step, times, values};
  CHECK(step.at(std::nextafter(1.0f, 0.0f)) == values[0]);
  CHECK(step.at(2.9f) == values[1]);
  const Keyframes<vec3> linear{Interpolation::linear, times, values};
  CHECK(distance(linear.at(0.25f), vec3(0.5f, 0, 0)) < 1e-6f);
  CHECK(distance(linear.at(2.5f), vec3(2, 3, 0)) < 1e-6f);
}

TEST_CASE("rotations take the shorter way at constant speed, whatever the sign of the quaternion") {
  for (const float sign : {1.0f, -1.0f}) {
    const Keyframes<glm::quat> track{Interpolation::linear, {0, 2}, {about_z(0.2f), sign * about_z(2.6f)}};
    for (const float time : {0.0f, 0.1f, 0.7f, 1.0f, 1.9f, 2.0f}) {
      CHECK(angle_between(track.at(time), about_z(0.2f + 1.2f * time)) < 1e-6);
      CHECK(std::abs(glm::length(track.at(time)) - 1) < 1e-6f);
    }
  }
  const Keyframes<glm::quat> tiny{Interpolation::linear, {0, 1}, {about_z(0), about_z(1e-4f)}};
  CHECK(angle_between(tiny.at(0.5f), about_z(0.5e-4f)) < 1e-7);
}

TEST_CASE("CUBICSPLINE reproduces a cubic, tangents per second") {
  const auto curve = [](double t) { return vec3(1 - 2 * t + 3 * t * t - t * t * t, t * t * t, 5 * t); };
  const auto slope = [](double t) { return vec3(-2 + 6 * t - 3 * t * t, 3 * t * t, 5); };
  Keyframes<vec3> track{Interpolation::cubic_spline, {0, 0.5f, 2}, {}};
  for (const float t : track.times) track.values.insert(track.values.end(), {slope(t), curve(t), slope(t)});
  for (float t = 0; t <= 2; t += 1.0f / 16) CHECK(distance(track.at(t), curve(t)) < 5e-6f);
}

TEST_CASE("CUBICSPLINE arrives by the tangent in and leaves by the tangent out") {
  const Keyframes<vec3> track{Interpolation::cubic_spline,
                              {0, 1, 2},
                              {vec3(9), vec3(0), vec3(1, 0, 0), vec3(0, 2, 0), vec3(3, 0, 0), vec3(0, 0, 4),
                               vec3(5, 0, 0), vec3(1), vec3(9)}};
  const float h = 1e-3f;
  const auto slope = [&](float from, float to) { return (track.at(to) - track.at(from)) / (to - from); };
  CHECK(distance(slope(0, h), vec3(1, 0, 0)) < 0.03f);
  CHECK(distance(slope(1 - h, 1), vec3(0, 2, 0)) < 0.03f);
  CHECK(distance(slope(1, 1 + h), vec3(0, 0, 4)) < 0.03f);
  CHECK(distance(slope(2 - h, 2), vec3(5, 0, 0)) < 0.03f);
}

TEST_CASE("splines of rotations stay unit, even through zero") {
  const glm::quat still(0, 0, 0, 0), a = about_z(0.3f);
  const Keyframes<glm::quat> through_zero{
      Interpolation::cubic_spline, {0, 1}, {still, a, still, still, -a, still}};
  CHECK(angle_between(through_zero.at(0.5f), a) < 1e-6);
  Random random(2);
  Keyframes<glm::quat> wild{Interpolation::cubic_spline, {0, 1, 3}, {}};
  for (int key = 0; key < 3; ++key)
    wild.values.insert(wild.values.end(),
                       {any_rotation(random) * 20.0f, any_rotation(random), any_rotation(random) * 1e38f});
  for (float t = 0; t <= 3; t += 0.01f) CHECK(std::abs(glm::length(wild.at(t)) - 1) < 1e-5f);
}

TEST_CASE("a chain applies the outermost joint last, each at its own time") {
  const Keyframes<vec3> slide{Interpolation::linear, {0, 2}, {vec3(0), vec3(2, 0, 0)}};
  const Keyframes<glm::quat> turn{Interpolation::linear, {0, 1}, {about_z(0), about_z(pi / 2)}};
  const Motion motion{{{{}, turn}, {slide, {}}}};  // slides along an arm that turns
  CHECK(motion.duration() == 2);
  CHECK(Motion{}.duration() == 0);
  CHECK(distance(motion.at(0).point(vec3(1, 0, 0)), vec3(1, 0, 0)) < 1e-6f);
  CHECK(distance(motion.at(1).point(vec3(1, 0, 0)), vec3(0, 2, 0)) < 1e-6f);
  CHECK(distance(motion.at(9).point(vec3(1, 0, 0)), vec3(0, 3, 0)) < 1e-6f);
  CHECK(Motion{}.at(1).point(vec3(1, 2, 3)) == vec3(1, 2, 3));
}

TEST_CASE("a long chain stays rigid") {
  Random random(3);
  Motion motion;
  for (int i = 0; i < 1000; ++i)
    motion.joints.push_back({{}, {Interpolation::step, {0}, {any_rotation(random) * 1.0001f}}});
  CHECK(std::abs(glm::length(motion.at(0).rotation) - 1) < 1e-6f);
}

TEST_CASE("a posed scene holds its mesh at rest and then its objects where they are") {
  const auto triangle = [](float z, std::uint32_t material) {
    return Mesh{{{0, 0, z}, {1, 0, z}, {0, 1, z}},
                std::vector<vec3>(3, vec3(1, 0, 0)),
                std::vector<vec4>(3, vec4(0, 1, 0, -1)),
                {{0, 0}, {1, 0}, {0, 1}},
                {{0, 1, 2}},
                {material}};
  };
  Scene scene;
  scene.mesh = triangle(0, 0);
  const Joint joint{{Interpolation::linear, {0, 1}, {vec3(0), vec3(0, 0, 6)}},
                    {Interpolation::linear, {0, 0.5f}, {about_z(0), about_z(pi / 2)}}};
  scene.objects.push_back({"first", triangle(1, 3), {{joint}}});
  scene.objects.push_back({"second", triangle(2, 4), {}});
  CHECK(animation_duration(scene) == 1);
  const Mesh mesh = mesh_at(scene, 0.5f);
  REQUIRE(mesh.positions.size() == 9);
  CHECK(mesh.positions[1] == vec3(1, 0, 0));
  CHECK(distance(mesh.positions[4], vec3(0, 1, 4)) < 1e-6f);
  CHECK(distance(mesh.normals[4], vec3(0, 1, 0)) < 1e-6f);
  CHECK(distance(vec3(mesh.tangents[4]), vec3(-1, 0, 0)) < 1e-6f);
  CHECK(mesh.tangents[4].w == -1);
  CHECK(mesh.uvs[4] == vec2(1, 0));
  CHECK(mesh.positions[7] == vec3(1, 0, 2));
  CHECK(mesh.triangles == std::vector<uvec3>{{0, 1, 2}, {3, 4, 5}, {6, 7, 8}});
  CHECK(mesh.materials == std::vector<std::uint32_t>{0, 3, 4});
}
