// Animations of glossy_vpls, and what must not change its image: threads and backends.
#include "programs/vpl_studio.hpp"

using namespace coppice;
using namespace program_test;
using nlohmann::json;

namespace {

/// Every value of the report that does not measure time.
json without_times(json report) {
  report["preparation"].erase("seconds");
  report["settings"].erase("threads");
  for (auto& frame : report["frames"])
    for (const char* key : {"milliseconds", "all_vpls_milliseconds", "stages"}) frame.erase(key);
  return report;
}

}  // namespace

TEST_CASE("frames are numbered; the report tells what each has cost") {
  const Studio place({.is_animated = true});
  const Outcome o = place.shine("--frames 4 --animate --reference --out move.exr --report report.json");
  CAPTURE(o.err);
  REQUIRE(o.code == 0);
  CHECK(line_count(o.err) == 4);
  std::set<std::string> expected{"report.json"};
  for (const char* frame : {"move.0000", "move.0001", "move.0002", "move.0003"})
    for (const char* ending : {".exr", ".png"}) expected.insert(std::string(frame) + ending);
  CHECK(place.made() == expected);
  const json frames = place.report()["frames"];
  REQUIRE(frames.size() == 4);
  for (const json& frame : frames) {
    const json& stages = frame["stages"];
    for (const char* stage : {"pose", "follow", "vpl_direct_light", "bounces", "leaves", "tree", "camera",
                              "direct_light", "gather", "interpolation"})
      CHECK_MESSAGE(stages[stage] >= 0, stage);
    CHECK(stages["changed_vpls"] > 256);
    CHECK(stages["changed_vpls"] <= 512);
    CHECK(stages["tree_looseness"] > 0);
    CHECK(stages["tree_looseness"] < 1);
    CHECK(stages["tree_rebuilt"].is_boolean());
    CHECK(error_of(frame) < 0.02);
  }
  CHECK(frames[0]["stages"]["tree_rebuilt"] == true);
  CHECK(frames[0]["stages"]["changed_vpls"] == 512);
  CHECK(frames[1]["stages"]["tree_rebuilt"] == false);
}

TEST_CASE("frames of an animation are the scene as it stands at their times") {
  const Studio place({.is_animated = true});
  const std::string all = "--threshold 0 --vpls 2048 --density area ";
  REQUIRE(place.shine(all + "--frames 4 --animate --out move.exr").code == 0);
  const Image first = layer(place / "move.0000.exr", "indirect"),
              last = layer(place / "move.0003.exr", "indirect");
  place.put("room.glb", room().glb());
  CHECK(rel_rmse(first, place.shone(all)) < 1e-5);
  CHECK(rel_rmse(layer(place / "move.0000.exr", "direct"), place.part("direct")) < 1e-5);
  CHECK(rel_rmse(last, first) > 0.1);
  place.put("room.glb", room({.time = 0.75f}).glb());
  const Image still = place.shone(all);  // its VPLs lie elsewhere
  CHECK(rel_rmse(last, still) < 0.25 * rel_rmse(first, still));
  CHECK(std::abs(mean(last) / mean(still) - 1) < 0.03);
  CHECK(rel_rmse(layer(place / "move.0003.exr", "direct"), place.part("direct")) < 0.05);
}

TEST_CASE("a tree that was brought up to date gathers as one that was built anew") {
  const Studio place({.is_animated = true});
  const std::string arguments = "--frames 4 --animate --reference --threshold 0 --report report.json ";
  for (const std::string way : {"", "--filter uniform", "--clustering kd", "--bounces 2"}) {
    CAPTURE(way);
    REQUIRE(place.shine(arguments + "--out move.exr " + way).code == 0);
    for (const json& frame : place.report()["frames"]) CHECK(error_of(frame) < 1e-5);
  }
}

TEST_CASE("where nothing moves no VPL changes, and frames are equal") {
  const Studio place;
  for (const std::string animate : {"", "--animate"}) {
    REQUIRE(place.shine("--frames 2 --out still.exr --report report.json " + animate).code == 0);
    CHECK(files::get(place / "still.0000.exr") == files::get(place / "still.0001.exr"));
    const json stages = place.report()["frames"][1]["stages"];
    CHECK(stages["changed_vpls"] == 0);
    CHECK(stages["tree_rebuilt"] == false);
  }
}

TEST_CASE("one thread and two give the same files, whatever is asked for") {
  const Studio place({.is_animated = true});
  for (const std::string way :
       {"--bounces 2 --adaptive relative", "--visibility traced --seed 5", "--criterion angle --min-max 40:9",
        "--spread repulsion --clustering kd --filter uniform", "--density irradiance --env sky.hdr"}) {
    CAPTURE(way);
    const std::string arguments = "--size 48x36 --frames 2 --animate --reference " + way;
    REQUIRE(place.shine(arguments + " --out one.exr --report one.json --threads 1").code == 0);
    REQUIRE(place.shine(arguments + " --out two.exr --report two.json --threads 2").code == 0);
    for (const std::string file : {".0000.exr", ".0001.exr", ".0000.png", ".0001.png"})
      CHECK(files::get(place / ("one" + file)) == files::get(place / ("two" + file)));
    const auto report = [&](const char* name) {
      return without_times(json::parse(files::get(place / name)));
    };
    CHECK(report("one.json") == report("two.json"));
  }
}

TEST_CASE("Vulkan gathers the light that the processor gathers") {
  const Studio place;
  for (const std::string way :
       {"", "--filter uniform", "--criterion angle --threshold 0.002", "--criterion angle --min-max 40:9",
        "--vpls 0", "--frames 2 --animate", "--adaptive relative --bounces 2"}) {
    CAPTURE(way);
    place.put("room.glb", room({.is_animated = way.find("animate") != std::string::npos}).glb());
    const Outcome o = place.shine("--backend vulkan --out vulkan.exr " + way);
    if (o.code == 2 && o.err.find("--backend vulkan") != std::string::npos) {
      CHECK_FALSE(std::filesystem::exists(place / "vulkan.exr"));
      MESSAGE("SKIPPED: ", o.err);
      return;
    }
    CAPTURE(o.err);
    REQUIRE(o.code == 0);
    REQUIRE(place.shine("--out cpu.exr " + way).code == 0);
    const std::string ending = place.made().contains("cpu.exr") ? ".exr" : ".0001.exr";
    const Image cpu = layer(place / ("cpu" + ending), "indirect"),
                vulkan = layer(place / ("vulkan" + ending), "indirect");
    CHECK(rel_rmse(vulkan, cpu) < 1e-3);
    CHECK(is_black(cpu) == (way == "--vpls 0"));
    for (const char* name : {"cpu.exr", "vulkan.exr"}) std::filesystem::remove(place / name);
  }
}

TEST_CASE("by solid angle the points of Vulkan walk alone: fewer nodes, and nearly the same light") {
  const Studio place;
  const json cpu = place.measured("--criterion angle");
  const Image indirect = place.part("indirect");
  const Outcome o =
      place.shine("--backend vulkan --criterion angle --reference --out image.exr --report report.json");
  if (o.code == 2 && o.err.find("--backend vulkan") != std::string::npos) {
    MESSAGE("SKIPPED: ", o.err);
    return;
  }
  CAPTURE(o.err);
  REQUIRE(o.code == 0);
  const json vulkan = place.report()["frames"][0];
  CHECK(vulkan["nodes"]["mean"] < cpu["nodes"]["mean"]);
  CHECK(error_of(vulkan) < 0.01);
  CHECK(rel_rmse(place.part("indirect"), indirect) < 0.01);
}
