// A room with a lamp and a glossy box, for the programs of virtual point lights (VPLs).
#pragma once

#include <cmath>

#include "gltf/clip.hpp"
#include "programs/run.hpp"

namespace program_test {

/// What is in the room. Metres, seconds.
struct Room {
  bool is_shining = true;    ///< the lamp
  bool has_walls = true;     ///< all but the floor
  bool is_animated = false;  ///< within a second lamp and box pass each other, and the box turns by a quarter
  float time = 0;            ///< at which a room that is not animated stands
};

namespace detail {

/// Quads that face into the room: floor, ceiling, back, left, right.
inline const std::vector<float> room_walls{-1, 0, 1,  1,  0, 1,  1,  0, -1, -1, 0, -1,  //
                                           -1, 2, -1, 1,  2, -1, 1,  2, 1,  -1, 2, 1,   //
                                           -1, 0, -1, 1,  0, -1, 1,  2, -1, -1, 2, -1,  //
                                           -1, 0, 1,  -1, 0, -1, -1, 2, -1, -1, 2, 1,   //
                                           1,  0, -1, 1,  0, 1,  1,  2, 1,  1,  2, -1};

inline std::vector<std::uint16_t> quads(std::uint16_t begin, std::uint16_t end) {
  std::vector<std::uint16_t> indices;
  for (std::uint16_t quad = begin; quad < end; ++quad)
    for (const int corner : {0, 1, 2, 0, 2, 3}) indices.push_back(std::uint16_t(4 * quad + corner));
  return indices;
}

inline std::string primitive(int positions, int indices, int material) {
  return R"({"attributes":{"POSITION":)" + std::to_string(positions) + R"(},"indices":)" +
         std::to_string(indices) + R"(,"material":)" + std::to_string(material) + "}";
}

inline std::string node_at(int mesh, float x, float y, float radians = 0) {
  const std::string turn = std::to_string(std::sin(radians / 2)),
                    rest = std::to_string(std::cos(radians / 2));
  return R"({"mesh":)" + std::to_string(mesh) + R"(,"translation":[)" + std::to_string(x) + "," +
         std::to_string(y) + R"(,0],"rotation":[0,)" + turn + ",0," + rest + "]}";
}

inline std::string room_materials(bool is_shining) {
  const auto plain = [](const char* colour) {
    return R"({"pbrMetallicRoughness":{"baseColorFactor":[)" + std::string(colour) +
           R"(,1],"metallicFactor":0,"roughnessFactor":0.8}},)";
  };
  return R"(,"materials":[)" + plain("0.7,0.7,0.7") + plain("0.8,0.3,0.2") +
         R"({"pbrMetallicRoughness":{"baseColorFactor":[0.9,0.8,0.5,1],"metallicFactor":1,"roughnessFactor":0.4}},)" +
         (is_shining ? R"({"emissiveFactor":[1,0.9,0.7],"extensions":{"KHR_materials_emissive_strength":)"
                       R"({"emissiveStrength":8}}}])"
                     : R"({}])");
}

}  // namespace detail

/// 2 m wide, high and deep, open in front, with a red wall to the left, a lamp below the ceiling that shines
/// down alone, and a box of metal. The camera looks in from the front and sees beside the walls too.
inline gltf_test::Builder room(const Room& r = {}) {
  using namespace detail;
  gltf_test::Builder b = still_life();
  const int box = 2;  // the still life's indices of it, and its positions
  const int walls = b.vec3s(room_walls);
  const int lamp = b.vec3s({-0.3f, 0, -0.3f, 0.3f, 0, -0.3f, 0.3f, 0, 0.3f, -0.3f, 0, 0.3f});
  const int floor = b.indices(quads(0, 1)), grey = b.indices(quads(1, 3)), red = b.indices(quads(3, 4)),
            right = b.indices(quads(4, 5)), one = b.indices(quads(0, 1));
  std::string parts = primitive(walls, floor, 0);
  if (r.has_walls)
    parts +=
        "," + primitive(walls, grey, 0) + "," + primitive(walls, red, 1) + "," + primitive(walls, right, 0);
  b.meshes = R"({"primitives":[)" + parts + R"(]},{"primitives":[)" + primitive(0, box, 2) +
             R"(]},{"primitives":[)" + primitive(lamp, one, 3) + "]}";
  b.nodes = R"([{"mesh":0},)" + node_at(1, -0.4f * r.time, 0, 1.5707963f * r.time) + "," +
            node_at(2, 0.6f * r.time, 1.8f) + R"(,{"camera":0,"translation":[0,1,3.4]}])";
  b.scenes = R"("scene":0,"scenes":[{"nodes":[0,1,2,3]}])";
  b.members = room_materials(r.is_shining) +
              R"(,"cameras":[{"type":"perspective","perspective":{"yfov":0.7,"znear":0.1}}])";
  if (!r.is_animated) return b;
  gltf_test::Clip clip;
  const int input = gltf_test::times(b, {0, 1});
  clip.add(1, "translation", input, b.vec3s({0, 0, 0, -0.4f, 0, 0}));
  clip.add(1, "rotation", input, b.vec4s({0, 0, 0, 1, 0, 0.70710678f, 0, 0.70710678f}));
  clip.add(2, "translation", input, b.vec3s({0, 1.8f, 0, 0.6f, 1.8f, 0}));
  b.members += clip.json();
  return b;
}

/// A workplace that holds room.glb besides.
class RoomWorkplace : public Workplace {
 public:
  explicit RoomWorkplace(const Room& r = {}) { put("room.glb", room(r).glb()); }

  std::set<std::string> made() const {
    auto found = Workplace::made();
    found.erase("room.glb");
    return found;
  }
  nlohmann::json report() const { return nlohmann::json::parse(files::get(*this / "report.json")); }
};

}  // namespace program_test
