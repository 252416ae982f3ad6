// Runs a program as a shell would, with a small scene and a small environment in a folder that goes away.
#pragma once

#include <doctest/doctest.h>
#include <sys/wait.h>

#include <algorithm>
#include <coppice/exr/read.hpp>
#include <cstdlib>
#include <exr/files.hpp>
#include <exr/hdr_bytes.hpp>
#include <gltf/builder.hpp>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

namespace program_test {

struct Outcome {
  int code = 0;
  std::string out, err;
};

/// Number of lines; a last one without its newline counts, and so does a carriage return.
inline std::ptrdiff_t line_count(const std::string& text) {
  const auto ends = std::ranges::count(text, '\n') + std::ranges::count(text, '\r');
  return ends + (!text.empty() && text.back() != '\n');
}

/// Ground and a box on it, seen from above by the file's camera.
inline gltf_test::Builder still_life(bool with_camera = true) {
  gltf_test::Builder b;
  b.vec3s({-2,    0,    2,    2,    0,    2,    2,    0,    -2,    -2,    0,    -2,     // ground
           -0.5f, 0.1f, 0.5f, 0.5f, 0.1f, 0.5f, 0.5f, 0.1f, -0.5f, -0.5f, 0.1f, -0.5f,  // box
           -0.5f, 0.9f, 0.5f, 0.5f, 0.9f, 0.5f, 0.5f, 0.9f, -0.5f, -0.5f, 0.9f, -0.5f});
  b.indices({0, 1, 2, 0, 2, 3});
  b.indices({8, 9, 10, 8, 10, 11, 4, 6, 5,  4, 7,  6,  4, 5, 9, 4, 9, 8,
             5, 6, 10, 5, 10, 9,  6, 7, 11, 6, 11, 10, 7, 4, 8, 7, 8, 11});
  b.meshes = R"({"primitives":[{"attributes":{"POSITION":0},"indices":1,"material":0},)"
             R"({"attributes":{"POSITION":0},"indices":2,"material":1}]})";
  b.members =
      R"(,"materials":[{"pbrMetallicRoughness":{"baseColorFactor":[0.7,0.7,0.6,1],"metallicFactor":0}},)"
      R"({"pbrMetallicRoughness":{"baseColorFactor":[0.9,0.5,0.2,1],"metallicFactor":1,"roughnessFactor":0.4}}])";
  if (!with_camera) return b;
  b.members += R"(,"cameras":[{"type":"perspective","perspective":{"yfov":0.7,"znear":0.1}}])";
  b.scenes = R"("scene":0,"scenes":[{"nodes":[0,1]}])";
  b.nodes = R"([{"mesh":0},{"camera":0,"translation":[0,2.5,4],"rotation":[-0.2588,0,0,0.9659]}])";
  return b;
}

/// 8 × 4 texels of grey, and a bright one to the upper right.
inline std::string sky() {
  std::string bytes = hdr_bytes::header("-Y 4 +X 8");
  for (int i = 0; i < 32; ++i)
    bytes +=
        hdr_bytes::pixel(i == 13 ? hdr_bytes::Rgbe{200, 190, 150, 133} : hdr_bytes::Rgbe{100, 110, 128, 128});
  return bytes;
}

/// A folder that holds scene.glb and sky.hdr; programs run in it.
class Workplace {
 public:
  Workplace() {
    put("scene.glb", still_life().glb());
    files::put(folder_ / "sky.hdr", sky());
  }

  std::filesystem::path operator/(const std::string& name) const { return folder_ / name; }
  void put(const std::string& name, const gltf_test::Bytes& bytes) const {
    files::put(folder_ / name, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  }

  /// Runs `program arguments` here. Output goes to files beside the folder's own, removed again.
  Outcome run(const std::string& program, const std::string& arguments) const {
    const std::string redirect =
        " >'" + (streams_ / "out").string() + "' 2>'" + (streams_ / "err").string() + "'";
    // Vulkan drivers leak, which a sanitizer would report as the program's own exit code.
    const std::string command = "cd '" + (folder_ / "").string() + "' && ASAN_OPTIONS=detect_leaks=0 '" +
                                COPPICE_PROGRAM_DIR + "/" + program + "' " + arguments + redirect;
    const int status = std::system(command.c_str());
    REQUIRE(WIFEXITED(status));
    return {WEXITSTATUS(status), files::get(streams_ / "out"), files::get(streams_ / "err")};
  }
  /// cut_relighting on the folder's scene and environment at a small size.
  Outcome relight(const std::string& arguments) const {
    return run("cut_relighting",
               "--scene scene.glb --env sky.hdr --light-count 1024 --size 64x48 " + arguments);
  }

  std::set<std::string> names() const {
    std::set<std::string> found;
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / ""))
      found.insert(entry.path().filename());
    return found;
  }
  /// What is here besides scene.glb and sky.hdr.
  std::set<std::string> made() const {
    auto found = names();
    found.erase("scene.glb"), found.erase("sky.hdr");
    return found;
  }

 private:
  files::Directory folder_, streams_;
};

/// Code 2, one line on stderr with `part` in it, nothing on stdout, nothing written.
inline void check_refused(const Workplace& place, const std::string& program, const std::string& arguments,
                          const std::string& part) {
  CAPTURE(arguments);
  const auto before = place.names();
  const Outcome o = place.run(program, arguments);
  CAPTURE(o.err);
  CHECK(o.code == 2);
  CHECK(o.out.empty());
  CHECK(line_count(o.err) == 1);
  CHECK(o.err.find(part) != std::string::npos);
  CHECK(place.names() == before);
}

}  // namespace program_test
