#include <doctest/doctest.h>

#include "builder.hpp"

using namespace coppice;
using namespace gltf_test;

namespace {

Mesh square_below(const std::string& nodes) {
  Builder builder = square();
  builder.nodes = nodes;
  return load(builder).mesh;
}

vec3 geometric_normal(const Mesh& mesh, std::size_t triangle) {
  const uvec3 t = mesh.triangles[triangle];
  return normalize(
      cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]));
}

}  // namespace

TEST_CASE("translation, rotation and scale apply in glTF's order, through the hierarchy") {
  // The child scales, then turns +x to +y, then moves by x; the parent moves by z.
  const Mesh mesh = square_below(
      R"([{"translation":[0,0,5],"children":[1]},)"
      R"({"mesh":0,"translation":[10,0,0],"rotation":[0,0,0.70710678,0.70710678],"scale":[2,1,1]}])");
  CHECK(near(mesh.positions[0], vec3(10, 0, 5)));
  CHECK(near(mesh.positions[1], vec3(10, 2, 5)));
  CHECK(near(mesh.positions[3], vec3(9, 0, 5)));
  CHECK(near(mesh.normals[0], vec3(0, 0, 1)));
}

TEST_CASE("a matrix is read by columns") {
  const Mesh mesh = square_below(R"([{"mesh":0,"matrix":[0,1,0,0, -1,0,0,0, 0,0,1,0, 7,8,9,1]}])");
  CHECK(near(mesh.positions[0], vec3(7, 8, 9)));
  CHECK(near(mesh.positions[1], vec3(7, 9, 9)));
}

TEST_CASE("normals stay perpendicular under uneven scale") {
  Builder builder;
  builder.vec3s({0, 0, 0, 1, 0, -1, 0, 1, 0});
  const float h = std::sqrt(0.5f);
  builder.vec3s({h, 0, h, h, 0, h, h, 0, h});
  builder.meshes = mesh_json(R"("POSITION":0,"NORMAL":1)");
  builder.nodes = R"([{"mesh":0,"scale":[4,1,1]}])";
  const Mesh mesh = load(builder).mesh;
  CHECK(near(mesh.normals[0], geometric_normal(mesh, 0)));
  CHECK(near(mesh.normals[0], normalize(vec3(0.25f, 0, 1))));
}

TEST_CASE("a mirrored node is rewound and its normals stay outside") {
  for (const char* scale : {"[-1,1,1]", "[1,-2,1]", "[-1,-1,-1]"}) {
    const Mesh mesh = square_below(std::string(R"([{"mesh":0,"scale":)") + scale + "}]");
    const float z = std::string(scale) == "[-1,-1,-1]" ? -1.0f : 1.0f;
    for (std::size_t t = 0; t < 2; ++t) CHECK(near(geometric_normal(mesh, t), vec3(0, 0, z)));
    CHECK(near(mesh.normals[0], vec3(0, 0, z)));
  }
}

TEST_CASE("a node that flattens its mesh along the normal keeps the normal") {
  const Mesh mesh = square_below(R"([{"mesh":0,"scale":[1,1,0]}])");
  CHECK(mesh.triangles.size() == 2);
  CHECK(near(mesh.normals[0], vec3(0, 0, 1)));
}

TEST_CASE("a node that flattens its mesh to a point leaves no triangles") {
  Builder builder = square();
  builder.nodes = R"([{"mesh":0,"scale":[0,0,0]}])";
  const Scene scene = load(builder);
  CHECK(scene.mesh.triangles.empty());
  CHECK(scene.mesh.positions.empty());
  CHECK(scene.warnings.size() == 2);
}

TEST_CASE("instances of a mesh are copies, nodes outside of the scene are left out") {
  Builder builder = square();
  builder.scenes = R"("scene":1,"scenes":[{"nodes":[2]},{"nodes":[0,1]}])";
  builder.nodes = R"([{"mesh":0},{"mesh":0,"translation":[0,0,1]},{"mesh":0}])";
  const Mesh mesh = load(builder).mesh;
  CHECK(mesh.triangles.size() == 4);
  CHECK(mesh.positions[4] == vec3(0, 0, 1));
  CHECK(mesh.triangles[2] == uvec3(4, 5, 6));
}

TEST_CASE("without scenes every tree of nodes is shown") {
  Builder builder = square();
  builder.scenes = R"("scenes":[])";
  builder.nodes = R"([{"mesh":0},{"children":[0]},{"mesh":0}])";
  CHECK(load(builder).mesh.triangles.size() == 4);
}

TEST_CASE("a chain of 100000 nodes does not exhaust the stack") {
  Builder builder = triangle();
  builder.nodes = "[";
  for (int i = 0; i < 100000; ++i) builder.nodes += R"({"children":[)" + std::to_string(i + 1) + "]},";
  builder.nodes += R"({"mesh":0}])";
  CHECK(load(builder).mesh.triangles.size() == 1);
}

TEST_CASE("cycles and shared children are refused") {
  Builder builder = triangle();
  builder.nodes = R"([{"mesh":0,"children":[1]},{"children":[0]}])";
  CHECK(contains(complaint_of(builder), "cycle"));
  builder.nodes = R"([{"children":[0]}])";
  CHECK(contains(complaint_of(builder), "cycle"));
  builder.nodes = R"([{"mesh":0},{"children":[2]},{"children":[1]}])";
  CHECK(contains(complaint_of(builder), "cycle"));
  builder.nodes = R"([{"children":[1,2]},{"children":[3]},{"children":[3]},{"mesh":0}])";
  CHECK(contains(complaint_of(builder), "more than one parent"));
  builder.nodes = R"([{"mesh":0}])";
  builder.scenes = R"("scenes":[{"nodes":[0,0]}])";
  CHECK(contains(complaint_of(builder), "twice"));
}

TEST_CASE("broken transforms are refused") {
  Builder builder = triangle();
  for (const char* transform :
       {R"("translation":[1,2])", R"("rotation":[0,0,0,0])", R"("rotation":[1,0,0])", R"("scale":[1])",
        R"("matrix":[1,0,0,0])", R"("scale":[1e300,1,1])", R"("translation":[1e30,0,0])",
        R"("matrix":[1,0,0,1, 0,1,0,0, 0,0,1,0, 0,0,0,1])"}) {
    CAPTURE(transform);
    builder.nodes = std::string(R"([{"mesh":0,)") + transform + "}]";
    CHECK(contains(complaint_of(builder), "node 0"));
  }
}
