#include <doctest/doctest.h>

#include "builder.hpp"

using namespace coppice;

TEST_CASE("the demo scene loads, with its ground and its camera") {
  const std::filesystem::path assets = std::filesystem::path(COPPICE_SOURCE_DIR) / "assets";
  const Scene scene = load_gltf(assets / "flight_helmet" / "flight_helmet.gltf");
  CHECK(scene.mesh.triangles.size() == 94724);
  CHECK(scene.materials.size() == 7);
  CHECK(scene.textures.size() == 15);
  REQUIRE(scene.camera);
  CHECK(scene.camera->vertical_fov == 0.44f);
  CHECK(scene.camera->forward.z < -0.5f);  // the helmet faces +z
  float lowest = 1e9f;
  for (const vec3& p : scene.mesh.positions) lowest = std::fmin(lowest, p.y);
  CHECK(scene.mesh.positions.back().y == lowest);  // the ground comes last
}
