// cut_relighting with the scene's own lights, moving objects and stores, as a user runs it.
#include <coppice/trade/errors.hpp>

#include "gltf/clip.hpp"
#include "programs/run.hpp"

using namespace coppice;
using namespace program_test;
using nlohmann::json;

namespace {

/// The still life under a lamp, and a shining square above it that looks down.
gltf_test::Builder lit_life() {
  gltf_test::Builder b = still_life();
  b.vec3s({-0.4f, 2, -0.4f, 0.4f, 2, -0.4f, 0.4f, 2, 0.4f, -0.4f, 2, 0.4f});
  b.indices({0, 1, 2, 0, 2, 3});
  b.meshes.insert(b.meshes.rfind(']'), R"(,{"attributes":{"POSITION":3},"indices":4,"material":2})");
  b.members.insert(
      b.members.find("}]", b.members.find("materials")) + 1,
      R"(,{"emissiveFactor":[1,0.8,0.5],"extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":4}}})");
  b.members +=
      R"(,"extensions":{"KHR_lights_punctual":{"lights":[{"type":"point","color":[0.5,0.7,1],"intensity":6}]}})";
  b.nodes.insert(b.nodes.rfind(']'),
                 R"(,{"translation":[1.4,1.6,0.6],"extensions":{"KHR_lights_punctual":{"light":0}}})");
  b.scenes = R"("scene":0,"scenes":[{"nodes":[0,1,2]}])";
  return b;
}

/// The still life whose box rises by 0.6 and turns by a quarter in one second.
gltf_test::Builder moving_life() {
  gltf_test::Builder b = still_life();
  b.meshes = R"({"primitives":[{"attributes":{"POSITION":0},"indices":1,"material":0}]},)"
             R"({"primitives":[{"attributes":{"POSITION":0},"indices":2,"material":1}]})";
  b.nodes.insert(b.nodes.rfind(']'), R"(,{"mesh":1})");
  b.scenes = R"("scene":0,"scenes":[{"nodes":[0,1,2]}])";
  gltf_test::Clip clip;
  const int input = gltf_test::times(b, {0, 1});
  clip.add(2, "translation", input, b.vec3s({0, 0.4f, 0, 0, 1, 0}));
  clip.add(2, "rotation", input, b.vec4s({0, 0, 0, 1, 0, 0.70710678f, 0, 0.70710678f}));
  b.members += clip.json();
  return b;
}

class LitWorkplace : public Workplace {
 public:
  LitWorkplace() { put("lit.glb", lit_life().glb()); }

  Outcome shine(const std::string& arguments) const {
    return run("cut_relighting", "--scene lit.glb --size 64x48 --emitters 64 --bounces 256 " + arguments);
  }
  Image shone(const std::string& arguments) const {
    const Outcome o = shine("--out image.exr --report report.json " + arguments);
    CAPTURE(o.err);
    REQUIRE(o.code == 0);
    return read_image(*this / "image.exr");
  }
  json report() const { return json::parse(files::get(*this / "report.json")); }
};

double mean(const Image& image) {
  double sum = 0;
  for (const vec3& p : image.pixels) sum += luminance(p);
  return sum / double(image.pixels.size());
}

}  // namespace

TEST_CASE("lamps and shining surfaces: stored and traced visibility agree with a ray to every light") {
  const LitWorkplace place;
  const Image stored = place.shone("--lights scene --reference --sigma 1");
  const json of_stored = place.report();
  CHECK(of_stored["frames"][0]["errors"]["rel_rmse"] < 0.06);
  CHECK(of_stored["preparation"]["lights"]["direct"] == 65);
  CHECK(of_stored["preparation"]["visibility_cuts"]["direct"]["mean"] > 1);
  place.shone("--lights scene --visibility traced --reference --trace-tolerance 0.01");
  CHECK(place.report()["frames"][0]["errors"]["rel_rmse"] < 0.01);
  CHECK(place.report()["frames"][0]["shadow_rays"]["mean"] > 1);
  CHECK(mean(stored) > 0.01);
}

TEST_CASE("a bounce adds light, and the file holds both parts") {
  const LitWorkplace place;
  const Image direct = place.shone("--lights scene --visibility traced"),
              both = place.shone("--lights indirect --visibility traced");
  CHECK(mean(both) > 1.01 * mean(direct));
  CHECK(mean(both) < 2 * mean(direct));
  const auto names = read_channel_names(place / "image.exr");
  const std::set<std::string> channels(names.begin(), names.end());
  CHECK(channels.contains("direct.R"));
  CHECK(channels.contains("indirect.R"));
  place.shone("--lights indirect --reference --sigma 1 --longest-edge 3");
  CHECK(place.report()["frames"][0]["errors"]["mre"] < 0.1);
  CHECK(place.report()["preparation"]["lights"]["indirect"] <= 256);
}

TEST_CASE("a scene without lights is black, and the report says so") {
  const Workplace place;
  for (const std::string visibility : {"stored", "traced"})
    for (const std::string lights : {"scene", "indirect"}) {
      const Outcome o = place.run("cut_relighting",
                                  "--scene scene.glb --size 32x24 --out image.exr --report r.json "
                                  "--reference --lights " +
                                      lights + " --visibility " + visibility);
      CAPTURE(o.err);
      REQUIRE(o.code == 0);
      CHECK(mean(read_image(place / "image.exr")) == 0);
      CHECK(json::parse(files::get(place / "r.json"))["warnings"].back().get<std::string>().find(
                "no lights") != std::string::npos);
    }
}

TEST_CASE("a store saves the rays and gives the same image, for every kind of light") {
  const LitWorkplace place;
  for (const std::string lights : {"env", "scene", "indirect"}) {
    CAPTURE(lights);
    const std::string arguments =
        "--env sky.hdr --light-count 1024 --out image.exr --report report.json --lights " + lights +
        " --store " + lights + ".h5";
    REQUIRE(place.shine(arguments).code == 0);
    const std::string first = files::get(place / "image.exr");
    const Outcome again = place.shine(arguments);
    REQUIRE(again.code == 0);
    CHECK(again.err.find("is reused") != std::string::npos);
    CHECK(files::get(place / "image.exr") == first);
    const Outcome finer = place.shine(arguments + " --sigma 1");
    REQUIRE(finer.code == 0);
    CHECK(finer.err.find("was made with sigma 2") != std::string::npos);
    CHECK(finer.err.find("computed anew") != std::string::npos);
  }
}

TEST_CASE("a store of another scene is told apart; a damaged one is refused and left alone") {
  const LitWorkplace place;
  const std::string arguments =
      "--env sky.hdr --light-count 256 --size 32x24 --out image.exr --store kept.h5 --scene ";
  REQUIRE(place.run("cut_relighting", arguments + "scene.glb").code == 0);
  const Outcome other = place.run("cut_relighting", arguments + "lit.glb");
  REQUIRE(other.code == 0);
  CHECK(other.err.find("scene") != std::string::npos);
  CHECK(other.err.find("computed anew") != std::string::npos);
  std::string bytes = files::get(place / "kept.h5");
  bytes[bytes.size() / 2] ^= 1;
  files::put(place / "kept.h5", bytes);
  check_refused(place, "cut_relighting", arguments + "lit.glb", "kept.h5");
  files::put(place / "kept.h5", "somebody's notes");
  check_refused(place, "cut_relighting", arguments + "lit.glb", "kept.h5");
  CHECK(files::get(place / "kept.h5") == "somebody's notes");
}

TEST_CASE("an animation without moving objects is a row of equal frames") {
  const Workplace place;
  REQUIRE(place.relight("--animate --frames 2 --out frame.exr").code == 0);
  CHECK(files::get(place / "frame.0000.exr") == files::get(place / "frame.0001.exr"));
}

TEST_CASE("a moving object: shadow fields agree with the scene posed and prepared anew") {
  const Workplace place;
  place.put("moving.glb", moving_life().glb());
  const std::string arguments =
      "--scene moving.glb --env sky.hdr --light-count 4096 --size 64x48 --longest-edge 4 --animate --frames "
      "3 "
      "--out frame.exr --report report.json ";
  const Outcome o = place.run("cut_relighting", arguments + "--reference");
  CAPTURE(o.err);
  REQUIRE(o.code == 0);
  const json report = json::parse(files::get(place / "report.json"));
  CHECK(report["preparation"]["moving"]["objects"] == 1);
  for (const json& frame : report["frames"]) {
    CHECK(frame["errors"]["rel_rmse"] < 0.05);
    CHECK(frame["shadowed_receivers"] > 10);
  }
  CHECK(files::get(place / "frame.0000.exr") != files::get(place / "frame.0001.exr"));
  const std::string last = files::get(place / "frame.0002.exr");
  REQUIRE(place.run("cut_relighting", arguments + "--reference --threads 1").code == 0);
  CHECK(files::get(place / "frame.0002.exr") == last);
}

TEST_CASE("traced visibility poses the whole scene in every frame") {
  const LitWorkplace place;
  place.put("moving.glb", moving_life().glb());
  const Outcome o = place.run("cut_relighting",
                              "--scene moving.glb --size 32x24 --lights scene --visibility traced "
                              "--animate --frames 2 --out frame.exr");
  CAPTURE(o.err);
  CHECK(o.code == 0);
  CHECK(place.made().contains("frame.0001.exr"));
}

TEST_CASE("choices that do not go together are refused before the work") {
  const Workplace place;
  const std::string common = "--scene scene.glb --size 16x12 --out image.exr ";
  for (const auto& [arguments, part] : std::initializer_list<std::pair<std::string, std::string>>{
           {"--lights env", "--env"},
           {"--env sky.hdr --visibility traced", "--visibility"},
           {"--lights scene --animate", "--animate"},
           {"--lights scene --visibility traced --store a.h5", "--store"},
           {"--lights scene --emitters -1", "--emitters"},
           {"--lights scene --trace-tolerance nan", "--trace-tolerance"},
           {"--lights scene --visibility guessed", "--visibility"},
           {"--env sky.hdr --store nowhere/a.h5", "nowhere"}})
    check_refused(place, "cut_relighting", common + arguments, part);
}
