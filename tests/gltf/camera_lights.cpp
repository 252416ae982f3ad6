#include <doctest/doctest.h>

#include "builder.hpp"

using namespace coppice;
using namespace gltf_test;

namespace {

Builder with_camera(const std::string& cameras, const std::string& nodes) {
  Builder builder = triangle();
  builder.nodes = nodes;
  builder.members = R"(,"cameras":[)" + cameras + "]";
  return builder;
}

const std::string perspective = R"({"type":"perspective","perspective":{"yfov":0.8,"znear":0.1}})";
const std::string orthographic =
    R"({"type":"orthographic","orthographic":{"xmag":1,"ymag":1,"znear":0.1,"zfar":10}})";

Builder with_lights(const std::string& lights, const std::string& nodes) {
  Builder builder = triangle();
  builder.nodes = nodes;
  builder.members =
      R"(,"extensionsUsed":["KHR_lights_punctual"],"extensions":{"KHR_lights_punctual":{"lights":[)" +
      lights + "]}}";
  return builder;
}

std::string light_node(int light, const std::string& more = "") {
  return R"({"extensions":{"KHR_lights_punctual":{"light":)" + std::to_string(light) + "}}" + more + "}";
}

}  // namespace

TEST_CASE("a camera takes its node's place and orthonormal axes") {
  // Turned by 90 degrees about +y: it looks along -x.
  const Scene scene = load(with_camera(
      perspective,
      R"([{"children":[1],"scale":[3,2,1]},{"camera":0,"translation":[1,2,3],"rotation":[0,0.70710678,0,0.70710678]}])"));
  REQUIRE(scene.camera);
  const Camera& camera = *scene.camera;
  CHECK(near(camera.position, vec3(3, 4, 3)));
  CHECK(near(camera.forward, vec3(-1, 0, 0)));
  CHECK(near(camera.up, vec3(0, 1, 0)));
  CHECK(near(camera.right, vec3(0, 0, -1)));
  CHECK(camera.vertical_fov == 0.8f);
}

TEST_CASE("the first perspective camera of the walk counts, orthographic ones are warned of") {
  const Scene scene = load(with_camera(
      orthographic + "," + perspective + R"(,{"type":"perspective","perspective":{"yfov":1.5,"znear":0.1}})",
      R"([{"children":[1,2,3],"mesh":0},{"camera":0},{"camera":2},{"camera":1}])"));
  REQUIRE(scene.camera);
  CHECK(scene.camera->vertical_fov == 1.5f);
  CHECK(scene.warnings == std::vector<std::string>{"1 orthographic cameras ignored"});
  CHECK_FALSE(load(triangle()).camera);
}

TEST_CASE("a mirrored or sheared camera stays right-handed and orthonormal") {
  const Scene scene = load(
      with_camera(perspective, R"([{"camera":0,"matrix":[-1,0.2,0,0, 0.3,1,0.5,0, 0,0,2,0, 0,0,0,1]}])"));
  REQUIRE(scene.camera);
  const Camera& camera = *scene.camera;
  CHECK(near(cross(camera.right, camera.up), -camera.forward));
  CHECK(std::fabs(dot(camera.forward, camera.up)) < 1e-6f);
}

TEST_CASE("broken cameras are refused") {
  CHECK(contains(complaint_of(with_camera(perspective, R"([{"camera":4}])")), "no camera 4"));
  CHECK(contains(complaint_of(with_camera(perspective, R"([{"camera":0,"scale":[0,0,0]}])")), "direction"));
  for (const char* fov : {"0", "-1", "3.2"})
    CHECK(contains(complaint_of(with_camera(
                       std::string(R"({"type":"perspective","perspective":{"znear":1,"yfov":)") + fov + "}}",
                       R"([{"camera":0}])")),
                   "yfov"));
}

TEST_CASE("lights take colour times intensity, place and direction") {
  const Scene scene = load(with_lights(
      R"({"type":"point","color":[1,0.5,0],"intensity":10,"range":4},{"type":"directional"},)"
      R"({"type":"spot","intensity":2,"spot":{"innerConeAngle":0.1,"outerConeAngle":0.2}})",
      "[{\"children\":[1,2,3],\"translation\":[0,1,0]}," + light_node(0, R"(,"translation":[2,0,0])") + "," +
          light_node(1, R"(,"rotation":[-0.70710678,0,0,0.70710678],"scale":[2,2,2])") + "," + light_node(2) +
          "]"));
  REQUIRE(scene.lights.size() == 3);
  const PunctualLight& point = scene.lights[0];
  CHECK(point.type == PunctualLightType::point);
  CHECK(near(point.position, vec3(2, 1, 0)));
  CHECK(point.intensity == vec3(10, 5, 0));
  CHECK(point.range == 4);
  const PunctualLight& sun = scene.lights[1];
  CHECK(sun.type == PunctualLightType::directional);
  CHECK(near(sun.direction, vec3(0, -1, 0)));
  CHECK(sun.intensity == vec3(1));
  CHECK(sun.range == 0);
  const PunctualLight& spot = scene.lights[2];
  CHECK(spot.type == PunctualLightType::spot);
  CHECK(near(spot.direction, vec3(0, 0, -1)));
  CHECK(spot.inner_cone == 0.1f);
  CHECK(spot.outer_cone == 0.2f);
}

TEST_CASE("broken lights are refused") {
  const auto complaint = [](const std::string& light, int index = 0) {
    return complaint_of(with_lights(light, std::string("[") + light_node(index) + "]"));
  };
  CHECK(contains(complaint(R"({"type":"point"})", 1), "no light 1"));
  CHECK(contains(complaint(R"({"type":"point"})", -1), "no light -1"));
  CHECK(contains(complaint(R"({"type":"lamp"})"), "lamp"));
  CHECK(contains(complaint(R"({"type":"point","intensity":-1})"), "negative"));
  CHECK(contains(complaint(R"({"type":"point","intensity":1e300})"), "light 0"));
  CHECK(contains(complaint(R"({"type":"point","color":[1,1]})"), "color"));
  CHECK(contains(complaint(R"({"type":"spot","spot":{"innerConeAngle":1,"outerConeAngle":0.5}})"), "cone"));
}
