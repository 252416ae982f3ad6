#include <doctest/doctest.h>

#include "builder.hpp"

using namespace coppice;
using namespace gltf_test;

namespace {

// Gives the builder's first material a normal texture.
Builder with_normal_texture(Builder builder) {
  const Bytes image = png(1, 1, {128, 128, 255, 255});
  builder.members =
      R"(,"images":[{"uri":"data:image/png;base64,)" + base64(image) +
      R"("}],"textures":[{"source":0}],"materials":[{"normalTexture":{"index":0,"scale":0.5}}])";
  const std::size_t end = builder.meshes.rfind("}]}");
  builder.meshes.insert(end, R"(,"material":0)");
  return builder;
}

void check_orthonormal(const Mesh& mesh) {
  for (std::size_t v = 0; v < mesh.tangents.size(); ++v) {
    const vec3 tangent(mesh.tangents[v]);
    CHECK(std::fabs(length(tangent) - 1) < 1e-6f);
    CHECK(std::fabs(dot(tangent, mesh.normals[v])) < 1e-6f);
  }
}

}  // namespace

TEST_CASE("tangents follow u, the bitangent points against v") {
  const Mesh mesh = load(with_normal_texture(square())).mesh;
  for (const vec4& tangent : mesh.tangents) CHECK(tangent == vec4(1, 0, 0, 1));
}

TEST_CASE("mirrored uv flip the handedness") {
  Builder builder = square();
  builder.vec2s({1, 1, 0, 1, 0, 0, 1, 0});
  builder.meshes = mesh_json(R"("POSITION":0,"NORMAL":1,"TEXCOORD_0":4)", R"(,"indices":3)");
  for (const vec4& tangent : load(with_normal_texture(builder)).mesh.tangents)
    CHECK(tangent == vec4(-1, 0, 0, -1));
}

TEST_CASE("tangents on a mirrored node keep bitangents against v") {
  Builder builder = with_normal_texture(square());
  builder.nodes = R"([{"mesh":0,"scale":[-1,1,1]}])";
  const Mesh mesh = load(builder).mesh;
  for (std::size_t v = 0; v < mesh.tangents.size(); ++v) {
    const vec4 t = mesh.tangents[v];
    CHECK(near(vec3(t), vec3(-1, 0, 0)));
    CHECK(near(t.w * cross(mesh.normals[v], vec3(t)), vec3(0, 1, 0)));
  }
}

TEST_CASE("degenerate uv leave no tangent, and no NaN") {
  Builder builder = square();
  builder.vec2s({0.5f, 0.5f, 0.5f, 0.5f, 0.5f, 0.5f, 0.5f, 0.5f});
  builder.meshes = mesh_json(R"("POSITION":0,"NORMAL":1,"TEXCOORD_0":4)", R"(,"indices":3)");
  for (const vec4& tangent : load(with_normal_texture(builder)).mesh.tangents) {
    CHECK(vec3(tangent) == vec3(0));
    CHECK(std::fabs(tangent.w) == 1);
  }
}

TEST_CASE("generated tangents are orthogonal to bent normals") {
  Builder builder = square();
  builder.vec3s({0.3f, 0, 1, 0, 0.5f, 1, -0.2f, 0.1f, 1, 0, 0, 1});
  builder.meshes = mesh_json(R"("POSITION":0,"NORMAL":4,"TEXCOORD_0":2)", R"(,"indices":3)");
  check_orthonormal(load(with_normal_texture(builder)).mesh);
}

TEST_CASE("given tangents are placed and made orthonormal, zero ones stay zero") {
  Builder builder = square();
  builder.vec4s({2, 0, 1, 1, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, 5, 1});
  builder.meshes = mesh_json(R"("POSITION":0,"NORMAL":1,"TANGENT":4)", R"(,"indices":3)");
  builder.nodes = R"([{"mesh":0,"scale":[-2,1,1]}])";
  const Mesh mesh = load(builder).mesh;
  CHECK(mesh.tangents[0] == vec4(-1, 0, 0, -1));
  CHECK(mesh.tangents[1] == vec4(-1, 0, 0, 1));
  CHECK(vec3(mesh.tangents[2]) == vec3(0));
  CHECK(vec3(mesh.tangents[3]) == vec3(0));
}
