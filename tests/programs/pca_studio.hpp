// A closed room with a box, and the program that lights it from PCA bases, run at a small size.
#pragma once

#include "programs/vpl_studio.hpp"

namespace program_test {

/// 2 m wide, high and deep, closed all round, with a red wall to the left and a box on the floor; y = 0 is
/// the floor, x = z = 0 the middle. The camera is inside. Nothing shines.
inline gltf_test::Builder closed_room() {
  using namespace detail;
  gltf_test::Builder b = still_life();
  const int box = 2;  // the still life's indices of it
  std::vector<float> corners = room_walls;
  corners.insert(corners.end(), {1, 0, 1, -1, 0, 1, -1, 2, 1, 1, 2, 1});  // the front, seen from inside
  const int walls = b.vec3s(corners);
  const int floor = b.indices(quads(0, 3)), red = b.indices(quads(3, 4)), rest = b.indices(quads(4, 6));
  b.meshes = R"({"primitives":[)" + primitive(walls, floor, 0) + "," + primitive(walls, red, 1) + "," +
             primitive(walls, rest, 0) + R"(]},{"primitives":[)" + primitive(0, box, 1) + "]}";
  b.nodes = R"([{"mesh":0},)" + node_at(1, -0.3f, -0.1f) +
            R"(,{"camera":0,"translation":[0.3,1.5,0.9],"rotation":[-0.2588,0,0,0.9659]}])";
  b.scenes = R"("scene":0,"scenes":[{"nodes":[0,1,2]}])";
  b.members =
      room_materials(false) + R"(,"cameras":[{"type":"perspective","perspective":{"yfov":1,"znear":0.1}}])";
  return b;
}

/// room.glb is the closed room; 600 samples, 32 x 24 pixels and a light at (0.6, 1.4, 0.5) where the
/// arguments say nothing else.
class PcaStudio : public RoomWorkplace {
 public:
  PcaStudio() { put("room.glb", closed_room().glb()); }

  /// The arguments, with what they do not say and the program needs to be quick.
  static std::string with_usual(std::string arguments) {
    add(arguments, {"--scene room.glb", "--size 32x24", "--surface-samples 600", "--clusters 6",
                    "--transport-rays 64", "--example-lights 200", "--lattice-points 200"});
    return arguments + " ";
  }
  Outcome shine(std::string arguments) const {
    add(arguments, {"--out image.exr", "--report report.json"});
    if (arguments.find("--path") == std::string::npos) add(arguments, {"--through 0.6,1.4,0.5"});
    return run("pca_transfer", with_usual(arguments));
  }
  /// Runs, and returns the image.
  coppice::Image shone(const std::string& arguments) const {
    const Outcome o = shine(arguments);
    CAPTURE(arguments);
    CAPTURE(o.err);
    REQUIRE(o.code == 0);
    return coppice::read_image(*this / "image.exr");
  }
  coppice::Image part(const std::string& name) const { return layer(*this / "image.exr", name); }
  /// Runs with --reference, and returns the report's first frame.
  nlohmann::json measured(const std::string& arguments) const {
    shone("--reference " + arguments);
    return report()["frames"][0];
  }
  void put_text(const std::string& name, const std::string& text) const {
    files::put(*this / name, {text.data(), text.size()});
  }

 private:
  static void add(std::string& arguments, std::initializer_list<std::string> options) {
    for (const std::string& option : options)
      if ((arguments + " ").find(option.substr(0, option.find(' ') + 1)) == std::string::npos)
        arguments += " " + option;
  }
};

}  // namespace program_test
