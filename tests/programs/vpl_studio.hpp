// Runs glossy_vpls in the room with a lamp, and reads what it wrote.
#pragma once

#include <coppice/trade/errors.hpp>

#include "programs/vpl_room.hpp"

namespace program_test {

inline double rel_rmse(const coppice::Image& image, const coppice::Image& reference) {
  return coppice::image_errors(image, reference, std::vector<bool>(image.pixels.size(), true)).rel_rmse;
}

inline double mean(const coppice::Image& image) {
  double sum = 0;
  for (const coppice::vec3& p : image.pixels) sum += coppice::luminance(p);
  return sum / double(image.pixels.size());
}

inline bool is_black(const coppice::Image& image) {
  return std::ranges::all_of(image.pixels, [](const coppice::vec3& p) { return p == coppice::vec3(0); });
}

inline coppice::Image layer(const std::filesystem::path& path, const std::string& name) {
  const auto channel = [&](const char* colour) { return coppice::read_channel(path, name + colour); };
  const coppice::Channel r = channel(".R"), g = channel(".G"), b = channel(".B");
  coppice::Image image(r.width, r.height);
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    image.pixels[i] = {r.values[i], g.values[i], b.values[i]};
  return image;
}

/// Of a frame's report.
inline double error_of(const nlohmann::json& frame) { return frame["errors"]["rel_rmse"].get<double>(); }

/// The room of room.glb, lit by 512 VPLs at 64 x 48 pixels where the arguments say nothing else.
class Studio : public RoomWorkplace {
 public:
  using RoomWorkplace::RoomWorkplace;

  Outcome shine(std::string arguments) const {
    for (const std::string usual : {"--scene room.glb", "--vpls 512", "--size 64x48", "--emitters 64"})
      if (arguments.find(usual.substr(0, usual.find(' ') + 1)) == std::string::npos) arguments += " " + usual;
    return run("glossy_vpls", arguments);
  }
  /// Runs, and returns the light of the VPLs.
  coppice::Image shone(const std::string& arguments) const {
    const Outcome o = shine("--out image.exr --report report.json " + arguments);
    CAPTURE(arguments);
    CAPTURE(o.err);
    REQUIRE(o.code == 0);
    return part("indirect");
  }
  /// Runs with --reference, and returns the report's first frame.
  nlohmann::json measured(const std::string& arguments) const {
    shone("--reference " + arguments);
    return report()["frames"][0];
  }
  coppice::Image part(const std::string& name) const { return layer(*this / "image.exr", name); }
};

}  // namespace program_test
