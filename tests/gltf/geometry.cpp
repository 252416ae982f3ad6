#include <doctest/doctest.h>

#include "builder.hpp"

using namespace coppice;
using namespace gltf_test;

TEST_CASE("a square keeps its vertices, sharing and uv") {
  const Scene scene = load(square());
  const Mesh& mesh = scene.mesh;
  REQUIRE(mesh.positions.size() == 4);
  REQUIRE(mesh.triangles.size() == 2);
  CHECK(mesh.triangles[0] == uvec3(0, 1, 2));
  CHECK(mesh.triangles[1] == uvec3(0, 2, 3));
  CHECK(mesh.positions[2] == vec3(1, 1, 0));
  CHECK(mesh.normals[3] == vec3(0, 0, 1));
  CHECK(mesh.uvs[1] == vec2(1, 1));
  CHECK(mesh.materials == std::vector<std::uint32_t>{0, 0});
  CHECK(scene.warnings.empty());
  REQUIRE(scene.materials.size() == 1);
  CHECK(scene.materials[0].metallic == 1);
  CHECK(vec3(mesh.tangents[0]) == vec3(0));
}

TEST_CASE("a .glb and a .gltf of the same scene load alike, whatever they are called") {
  const Folder folder;
  const Scene text = load_gltf(folder.write("text.glb", square().gltf()));
  const Scene binary = load_gltf(folder.write("binary.gltf", square().glb()));
  CHECK(text.mesh.positions == binary.mesh.positions);
  CHECK(text.mesh.triangles == binary.mesh.triangles);
}

TEST_CASE("buffers are read from files beside the scene, not from elsewhere") {
  const Folder folder;
  const Builder builder = square();
  folder.write("data file.bin", builder.bin);
  CHECK(load_gltf(folder.write("scene.gltf", builder.json("data%20file.bin"))).mesh.triangles.size() == 2);
  CHECK_THROWS_AS(load_gltf(folder.write("absent.gltf", builder.json("absent.bin"))), InputError);
  std::filesystem::create_directory(folder.path() / "folder.bin");
  CHECK_THROWS_AS(load_gltf(folder.write("folder.gltf", builder.json("folder.bin"))), InputError);
}

TEST_CASE("a strip and a fan give the triangles of the list, wound alike") {
  for (const int mode : {5, 6}) {
    Builder builder;
    builder.vec3s({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0});
    builder.indices(mode == 5 ? std::vector<std::uint16_t>{0, 1, 2, 3, 4}
                              : std::vector<std::uint16_t>{0, 1, 3, 4, 2});
    builder.meshes = mesh_json(R"("POSITION":0)", R"(,"indices":1,"mode":)" + std::to_string(mode));
    const Scene scene = load(builder);
    const std::size_t count = mode == 5 ? 3 : 2;  // the fan's last triangle lies on an edge
    CHECK(scene.mesh.triangles.size() == count);
    for (const vec3& normal : scene.mesh.normals) CHECK(normal == vec3(0, 0, 1));
  }
}

TEST_CASE("a list without indices takes its vertices in order") {
  const Scene scene = load(triangle());
  REQUIRE(scene.mesh.triangles.size() == 1);
  CHECK(scene.mesh.triangles[0] == uvec3(0, 1, 2));
}

TEST_CASE("indices may be of 8, 16 or 32 bits") {
  const auto with = [](int accessor_type, auto values) {
    Builder builder = triangle();
    builder.add(values, accessor_type, 1, "SCALAR");
    builder.meshes = mesh_json(R"("POSITION":0)", R"(,"indices":1)");
    return load(builder).mesh.positions;
  };
  const std::vector<vec3> expected = with(5121, std::vector<std::uint8_t>{2, 0, 1});
  CHECK(expected[0] == vec3(0, 1, 0));
  CHECK(with(5123, std::vector<std::uint16_t>{2, 0, 1}) == expected);
  CHECK(with(5125, std::vector<std::uint32_t>{2, 0, 1}) == expected);
}

TEST_CASE("points and lines are dropped and counted, and left-over indices too") {
  Builder builder = triangle();
  builder.indices({0, 1, 2, 0});
  builder.meshes =
      R"({"primitives":[{"attributes":{"POSITION":0},"mode":0},{"attributes":{"POSITION":0},"mode":1},)"
      R"({"attributes":{"POSITION":0},"indices":1}]})";
  const Scene scene = load(builder);
  CHECK(scene.mesh.triangles.size() == 1);
  REQUIRE(scene.warnings.size() == 2);
  CHECK(scene.warnings[0] == "2 point and line primitives dropped");
}

TEST_CASE("flat normals unshare vertices, given ones do not") {
  Builder builder;
  builder.vec3s({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 1});
  builder.indices({0, 1, 2, 0, 2, 3});
  builder.meshes = mesh_json(R"("POSITION":0)", R"(,"indices":1)");
  const Mesh mesh = load(builder).mesh;
  REQUIRE(mesh.positions.size() == 6);
  for (const uvec3& t : mesh.triangles) {
    const vec3 geometric = normalize(
        cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]));
    for (int corner = 0; corner < 3; ++corner) CHECK(near(mesh.normals[t[corner]], geometric));
  }
}

TEST_CASE("zero-area triangles and unused vertices are dropped, and counted once") {
  Builder builder = square();
  builder.indices({0, 1, 2, 0, 0, 1, 1, 2, 1});
  builder.meshes = mesh_json(R"("POSITION":0,"NORMAL":1)", R"(,"indices":4)");
  const Scene scene = load(builder);
  CHECK(scene.mesh.triangles.size() == 1);
  CHECK(scene.mesh.materials.size() == 1);
  CHECK(scene.mesh.positions.size() == 3);
  CHECK(scene.mesh.tangents.size() == 3);
  CHECK(scene.warnings == std::vector<std::string>{"2 zero-area triangles dropped"});
}

TEST_CASE("normals of length zero become geometric ones, others are made unit") {
  Builder builder;
  builder.vec3s(corner_positions);
  builder.vec3s({0, 0, 0, 3, 0, 4, 0, 0, 1e-3f});
  builder.meshes = mesh_json(R"("POSITION":0,"NORMAL":1)");
  const Scene scene = load(builder);
  CHECK(scene.mesh.normals[0] == vec3(0, 0, 1));
  CHECK(near(scene.mesh.normals[1], vec3(0.6f, 0, 0.8f)));
  CHECK(near(scene.mesh.normals[2], vec3(0, 0, 1)));
  CHECK(scene.warnings == std::vector<std::string>{"1 zero normals replaced by geometric ones"});
}

TEST_CASE("opposite triangles around a vertex without normal still give it one") {
  Builder builder;
  builder.vec3s(corner_positions);
  builder.vec3s(std::vector<float>(9, 0.0f));
  builder.indices({0, 1, 2, 0, 2, 1});
  builder.meshes = mesh_json(R"("POSITION":0,"NORMAL":1)", R"(,"indices":2)");
  for (const vec3& normal : load(builder).mesh.normals) CHECK(std::fabs(normal.z) == 1);
}

TEST_CASE("normalised and plain integers decode as glTF says") {
  Builder builder;
  builder.add_accessor(
      builder.add_view(std::vector<std::int16_t>{0, 0, 0, 0, 32767, 0, 0, 0, 0, -32768, 0, 0}.data(), 24,
                       R"(,"byteStride":8)"),
      5122, 3, "VEC3", R"(,"normalized":true)");
  builder.add_accessor(
      builder.add_view(std::vector<std::uint8_t>{0, 255, 0, 0, 51, 0, 0, 0, 255, 255, 0, 0}.data(), 12,
                       R"(,"byteStride":4)"),
      5121, 3, "VEC2", R"(,"normalized":true)");
  builder.add_accessor(
      builder.add_view(std::vector<std::int8_t>{0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0}.data(), 12,
                       R"(,"byteStride":4)"),
      5120, 3, "VEC3", R"(,"normalized":true)");
  builder.meshes = mesh_json(R"("POSITION":0,"TEXCOORD_0":1,"NORMAL":2)");
  builder.members =
      R"(,"extensionsUsed":["KHR_mesh_quantization"],"extensionsRequired":["KHR_mesh_quantization"])";
  // The triangle (0,0,0), (1,0,0), (0,-1,0) faces -z; its normals say +z and stay.
  const Mesh mesh = load(builder).mesh;
  CHECK(mesh.positions[1] == vec3(1, 0, 0));
  CHECK(mesh.positions[2] == vec3(0, -1, 0));
  CHECK(mesh.uvs[0] == vec2(0, 1));
  CHECK(mesh.uvs[1].x == doctest::Approx(0.2));
  CHECK(mesh.normals[0] == vec3(0, 0, 1));
}

TEST_CASE("plain integers are taken as they are") {
  Builder builder;
  builder.add(std::vector<std::uint16_t>{0, 0, 0, 0, 500, 0, 0, 0, 0, 500, 0, 0}, 5123, 4, "VEC3");
  builder.views.replace(builder.views.rfind('}'), 1, R"(,"byteStride":8})");
  builder.meshes = mesh_json(R"("POSITION":0)");
  CHECK(load(builder).mesh.positions[1] == vec3(500, 0, 0));
}

TEST_CASE("interleaved attributes are read by their stride") {
  Builder builder;
  std::vector<float> interleaved;
  for (int v = 0; v < 3; ++v) {
    interleaved.insert(interleaved.end(), corner_positions.begin() + 3 * v,
                       corner_positions.begin() + 3 * v + 3);
    interleaved.insert(interleaved.end(), {0, 0, 1});
  }
  const int view =
      builder.add_view(interleaved.data(), interleaved.size() * sizeof(float), R"(,"byteStride":24)");
  builder.add_accessor(view, 5126, 3, "VEC3");
  builder.add_accessor(view, 5126, 3, "VEC3", R"(,"byteOffset":12)");
  builder.meshes = mesh_json(R"("POSITION":0,"NORMAL":1)");
  const Mesh mesh = load(builder).mesh;
  CHECK(mesh.positions[1] == vec3(1, 0, 0));
  CHECK(mesh.normals[2] == vec3(0, 0, 1));
}

TEST_CASE("values that no triangle uses may be anything") {
  Builder builder;
  std::vector<float> positions = corner_positions;
  positions.insert(positions.end(), {NAN, INFINITY, 0});
  builder.vec3s(positions);
  builder.indices({0, 1, 2});
  builder.meshes = mesh_json(R"("POSITION":0)", R"(,"indices":1)");
  CHECK(load(builder).mesh.positions.size() == 3);
}

TEST_CASE("a scene without meshes is empty, with a warning") {
  for (const char* json :
       {R"({"asset":{"version":"2.0"}})", R"({"asset":{"version":"2.0"},"scenes":[{}]})"}) {
    const Scene scene = load_json(json);
    CHECK(scene.mesh.triangles.empty());
    CHECK(scene.warnings == std::vector<std::string>{"the scene has no triangles"});
  }
}
