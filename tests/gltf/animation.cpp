// Objects that the file's animation moves, against files that hold still at the same time.
#include <doctest/doctest.h>

#include <coppice/core/random.hpp>
#include <coppice/scene/pose.hpp>

#include "clip.hpp"

using namespace coppice;
using namespace gltf_test;

namespace {

bool warns(const Scene& scene, const std::string& text) {
  for (const std::string& line : scene.warnings)
    if (contains(line, text)) return true;
  return false;
}

std::string numbers(const std::vector<float>& values) {
  std::string text = "[";
  for (const float value : values) {
    if (text.size() > 1) text += ',';
    text += std::to_string(value);
  }
  return text + "]";
}

// Five nodes in a row, the second and the fourth animated at random with one kind of interpolation, and the
// same with the values of a random time in place of the animation.
class MovingChain {
 public:
  explicit MovingChain(std::uint64_t seed)
      : random_(seed), interpolation_(Interpolation(seed % 3)), time_(3.5f * random_.uniform()) {
    builder_.vec4s({1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, -1, 1, 0, 0, 1});
    builder_.meshes = mesh_json(R"("POSITION":0,"NORMAL":1,"TEXCOORD_0":2,"TANGENT":4)", R"(,"indices":3)");
    still_ = builder_;
    input_ = times(builder_, keys_);
    const std::string mirror = seed % 2 ? R"("scale":[-2,2,2])" : R"("scale":[2,2,2])";
    const std::string first = turn() + R"(,"translation":[1,2,3],)" + mirror;
    const std::string third = turn() + R"(,"scale":[-3,-3,-3])", last = turn() + R"(,"scale":[1.5,-0.5,2])";
    const auto nodes = [&](const std::string& second, const std::string& fourth) {
      return "[{" + first + R"(,"children":[1]},{"scale":[0.5,0.5,0.5],"mesh":0,"children":[2])" + second +
             "},{" + third + R"(,"children":[3]},{"mesh":0,"children":[4])" + fourth + R"(},{"mesh":0,)" +
             last + "}]";
    };
    const std::string rest = R"(,"translation":[0.5,0,1])";
    still_.nodes = nodes(rest + rotation(1), translation(3) + rotation(3));
    builder_.nodes = nodes(rest, "");
    builder_.members = clip_.json();
  }

  float time() const { return time_; }
  const Builder& moving_file() const { return builder_; }
  const Builder& still_file() const { return still_; }

 private:
  float any() { return 2 * random_.uniform() - 1; }
  std::string turn() { return R"("rotation":)" + numbers({any(), any(), any(), 1.5f}); }

  template <class Value>
  Keyframes<Value> any_keyframes() {
    Keyframes<Value> keyframes{interpolation_, keys_, {}};
    keyframes.values.resize(keyframes.values_a_key() * keys_.size());
    for (Value& value : keyframes.values)
      for (int c = 0; c < int(Value::length()); ++c) value[c] = any();
    return keyframes;
  }

  // Adds a channel, and returns its value at the time as a member of a node.
  std::string translation(int node) {
    const auto keyframes = any_keyframes<vec3>();
    std::vector<float> values;
    for (const vec3& v : keyframes.values) values.insert(values.end(), {v.x, v.y, v.z});
    add(node, "translation", builder_.vec3s(values));
    const vec3 t = keyframes.at(time_);
    return R"(,"translation":)" + numbers({t.x, t.y, t.z});
  }

  std::string rotation(int node) {
    auto keyframes = any_keyframes<glm::quat>();
    const std::size_t a_key = keyframes.values_a_key();
    for (std::size_t key = 0; key < keys_.size(); ++key) {
      const float size = glm::length(keyframes.value(key));
      for (std::size_t i = a_key * key; i < a_key * (key + 1); ++i)
        keyframes.values[i] = keyframes.values[i] / size;
    }
    std::vector<float> values;
    for (const glm::quat& q : keyframes.values) values.insert(values.end(), {q.x, q.y, q.z, q.w});
    add(node, "rotation", builder_.vec4s(values));
    const glm::quat q = keyframes.at(time_);
    return R"(,"rotation":)" + numbers({q.x, q.y, q.z, q.w});
  }

  void add(int node, const char* path, int output) {
    static constexpr const char* names[] = {"STEP", "LINEAR", "CUBICSPLINE"};
    clip_.add(node, path, input_, output,
              std::string(R"(,"interpolation":")") + names[int(interpolation_)] + "\"");
  }

  const std::vector<float> keys_{0.5f, 1, 3};
  Random random_;
  Interpolation interpolation_;
  float time_;
  Builder builder_ = square(), still_;
  Clip clip_;
  int input_ = 0;
};

void check_same(const Mesh& a, const Mesh& b) {
  REQUIRE(a.positions.size() == b.positions.size());
  for (std::size_t v = 0; v < a.positions.size(); ++v) {
    CHECK(near(a.positions[v], b.positions[v], 3e-5f));
    CHECK(near(a.normals[v], b.normals[v], 1e-5f));
    CHECK(near(vec3(a.tangents[v]), vec3(b.tangents[v]), 1e-5f));
    CHECK(a.tangents[v].w == b.tangents[v].w);
  }
  CHECK(a.triangles == b.triangles);
  CHECK(a.materials == b.materials);
}

}  // namespace

TEST_CASE("unless asked for, animations are not played") {
  const Builder builder = sliding(R"([{"mesh":0,"translation":[7,0,0]}])", 0);
  const Scene scene = load(builder);
  CHECK(scene.objects.empty());
  CHECK(scene.mesh.positions[0] == vec3(7, 0, 0));
  CHECK(scene.warnings == std::vector<std::string>{"1 animations ignored"});
  CHECK(animation_duration(scene) == 0);
}

TEST_CASE("an animated node becomes an object with its scale in its mesh") {
  const Scene scene = load_moving(
      sliding(R"([{"children":[1,2]},{"mesh":0,"name":"slider","scale":[3,2,1]},{"mesh":0}])", 1));
  CHECK(scene.warnings.empty());
  CHECK(scene.mesh.triangles.size() == 2);
  REQUIRE(scene.objects.size() == 1);
  const MovingObject& object = scene.objects[0];
  CHECK(object.name == "slider");
  CHECK(object.mesh.positions[2] == vec3(3, 2, 0));
  CHECK(object.motion.duration() == 2);
  CHECK(animation_duration(scene) == 2);
  CHECK(near(object.motion.at(0).point(vec3(3, 2, 0)), vec3(3, 2, 0)));
  const float h = std::sqrt(0.5f);
  CHECK(near(object.motion.at(1).point(vec3(3, 2, 0)), vec3(2 + h, 5 * h, 0)));
  CHECK(near(object.motion.at(5).point(vec3(3, 2, 0)), vec3(2, 3, 0)));
}

TEST_CASE("an object holds the meshes down to the next animated nodes") {
  const Scene scene = load_moving(
      sliding(R"([{"children":[1,4]},{"children":[2,3]},{"mesh":0},{"mesh":0,"name":"x"},{"mesh":0}])", 1));
  CHECK(scene.mesh.triangles.size() == 2);
  REQUIRE(scene.objects.size() == 1);
  CHECK(scene.objects[0].name == "node 1");
  CHECK(scene.objects[0].mesh.triangles.size() == 4);
}

TEST_CASE("chains of animated and resting, mirrored and scaled nodes stand where a still file puts them") {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    CAPTURE(seed);
    MovingChain chain(seed);
    const Scene scene = load_moving(chain.moving_file());
    CHECK(scene.warnings.empty());
    CHECK(scene.objects.size() == 2);
    CHECK(scene.mesh.triangles.empty());
    check_same(mesh_at(scene, chain.time()), load(chain.still_file()).mesh);
  }
}

TEST_CASE("an animated translation below an uneven scale is rigid, a rotation is not") {
  const std::string nodes = R"([{"scale":[2,1,1],"children":[1]},{"mesh":0,"name":"inner"}])";
  const Scene turning = load_moving(sliding(nodes, 1));
  CHECK(turning.objects.empty());
  CHECK(turning.mesh.positions[1] == vec3(2, 0, 0));
  CHECK(warns(turning, "node 1 \"inner\": an animated rotation below an uneven scale"));

  Builder builder = square();
  Clip clip;
  const int input = times(builder, {0, 1});
  clip.add(1, "translation", input, builder.vec3s({0, 0, 0, 1, 1, 0}));
  builder.nodes = nodes;
  builder.members = clip.json();
  const Scene sliding_only = load_moving(builder);
  REQUIRE(sliding_only.objects.size() == 1);
  CHECK(near(mesh_at(sliding_only, 1).positions[1], vec3(4, 1, 0)));
}

TEST_CASE("a scale that changes keeps its node at rest, one that does not counts") {
  for (const float last : {2.0f, 3.0f}) {
    Builder builder = square();
    Clip clip;
    const int input = times(builder, {0, 1});
    clip.add(0, "translation", input, builder.vec3s({0, 0, 0, 5, 0, 0}));
    clip.add(0, "scale", input, builder.vec3s({2, 2, 2, 2, last, 2}));
    builder.members = clip.json();
    builder.nodes = R"([{"mesh":0,"name":"grower","translation":[0,0,8]}])";
    const Scene scene = load_moving(builder);
    CHECK(warns(scene, "node 0 \"grower\": an animated scale is not supported, it stays at rest") ==
          (last == 3));
    CHECK(scene.objects.size() == (last == 3 ? 0 : 1));
    CHECK(near(mesh_at(scene, 1).positions[2], last == 3 ? vec3(1, 1, 8) : vec3(7, 2, 0)));
  }
}

TEST_CASE("channels of constant values move nothing, but place the node") {
  Builder builder = square();
  Clip clip;
  const int input = times(builder, {0, 1});
  clip.add(0, "translation", input, builder.vec3s({1, 2, 3, 1, 2, 3}));
  builder.members = clip.json();
  const Scene scene = load_moving(builder);
  CHECK(scene.objects.empty());
  CHECK(scene.mesh.positions[0] == vec3(1, 2, 3));
}

TEST_CASE("cameras, lights and morph targets stay at rest, and warnings name their nodes") {
  Builder builder = sliding(R"([{"children":[1,2]},{"camera":0,"name":"eye","translation":[0,0,3]},)"
                            R"({"mesh":0,"extensions":{"KHR_lights_punctual":{"light":0}}}])",
                            0);
  builder.members.replace(builder.members.find(R"("channels":[)"), 12,
                          R"("channels":[{"sampler":0,"target":{"node":2,"path":"weights"}},)");
  builder.members +=
      R"(,"cameras":[{"type":"perspective","perspective":{"yfov":0.8,"znear":0.1}}],)"
      R"("extensionsUsed":["KHR_lights_punctual"],"extensions":{"KHR_lights_punctual":{"lights":[{"type":"point"}]}})";
  const Scene scene = load_moving(builder);
  CHECK(warns(scene, "node 1 \"eye\": an animated camera is not supported, it stays at rest"));
  CHECK(warns(scene, "node 2: an animated light is not supported, it stays at rest"));
  CHECK(warns(scene, "node 2: morph targets are not supported"));
  REQUIRE(scene.camera);
  CHECK(scene.camera->position == vec3(0, 0, 3));
  CHECK(scene.objects.size() == 1);
}

TEST_CASE("only the first animation is played, and channels that are not for nodes are left alone") {
  Builder builder = sliding(R"([{"mesh":0},{"mesh":0}])", 1);
  builder.scenes = R"("scenes":[{"nodes":[0,1]}])";
  builder.members.insert(builder.members.size() - 1, R"(,{"samplers":[],"channels":[]})");
  builder.members.replace(builder.members.find(R"("channels":[)"), 12,
                          R"("channels":[{"sampler":0,"target":{"path":"pointer"}},)"
                          R"({"sampler":0,"target":{"node":0,"path":"visibility"}},)");
  const Scene scene = load_moving(builder);
  CHECK(scene.objects.size() == 1);
  CHECK(scene.warnings == std::vector<std::string>{"1 animations after the first ignored",
                                                   "1 animation channels of unknown properties ignored"});
}

TEST_CASE("normalised rotations are read, whatever their integer") {
  Builder builder = square();
  Clip clip;
  const int input = times(builder, {0, 1});
  const int output = builder.add(std::vector<std::int16_t>{0, 0, 0, 32767, 0, 0, 23170, 23170}, 5122, 4,
                                 "VEC4", R"(,"normalized":true)");
  clip.add(0, "rotation", input, output);
  builder.members = clip.json();
  const Scene scene = load_moving(builder);
  REQUIRE(scene.objects.size() == 1);
  CHECK(near(scene.objects[0].motion.at(1).point(vec3(1, 0, 0)), vec3(0, 1, 0), 1e-5f));
}

TEST_CASE("an object without triangles is none") {
  const Scene scene = load_moving(sliding(R"([{"mesh":0,"scale":[0,0,0]}])", 0));
  CHECK(scene.objects.empty());
  CHECK(warns(scene, "the scene has no triangles"));
}

TEST_CASE("the moving demo scene flies one object past the helmet and the ground for 4 seconds") {
  const std::filesystem::path assets = std::filesystem::path(COPPICE_SOURCE_DIR) / "assets";
  const Scene scene = load_gltf(assets / "flight_helmet" / "flight_helmet_moving.gltf", moving);
  CHECK_FALSE(warns(scene, "rest"));
  CHECK(scene.mesh.triangles.size() == 94724);
  REQUIRE(scene.objects.size() == 1);
  const MovingObject& object = scene.objects[0];
  CHECK(object.motion.duration() == 4);
  float radius = 0;
  for (const vec3& p : object.mesh.positions) radius = std::fmax(radius, length(p));
  const float ground = scene.mesh.positions.back().y;
  for (float time = 0; time <= 4; time += 1.0f / 24) {
    CAPTURE(time);
    const vec3 middle = object.motion.at(time).translation;
    CHECK(middle.y - radius - ground >= 0.5f * radius);
    float closest = 1e9f;
    for (const vec3& p : scene.mesh.positions) closest = std::fmin(closest, length(p - middle));
    CHECK(closest > radius);
  }
}
