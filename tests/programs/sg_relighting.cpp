// sg_relighting as a user runs it: bad input, files, frames in which everything changes, and its errors.
#include <coppice/exr/write.hpp>

#include "programs/vpl_studio.hpp"

using namespace coppice;
using namespace program_test;
using nlohmann::json;

namespace {

/// Floor, box and a moving plate under scene.glb's sky, in room.glb; a program that runs quickly.
class OpenAir : public RoomWorkplace {
 public:
  explicit OpenAir(bool is_animated = false)
      : RoomWorkplace({.is_shining = false, .has_walls = false, .is_animated = is_animated}) {}

  Outcome shine(std::string arguments) const {
    for (const std::string usual :
         {"--scene scene.glb", "--env sky.hdr", "--size 48x36", "--light-count 1024", "--voxels 64",
          "--out image.exr", "--report report.json"})
      if (arguments.find(usual.substr(0, usual.find(' ') + 1)) == std::string::npos) arguments += " " + usual;
    return run("sg_relighting", arguments);
  }
  Image shone(const std::string& arguments) const {
    const Outcome o = shine(arguments);
    CAPTURE(arguments);
    CAPTURE(o.err);
    REQUIRE(o.code == 0);
    return read_image(*this / "image.exr");
  }
  /// The report's first frame, of a run with --reference.
  json measured(const std::string& arguments) const {
    shone("--reference " + arguments);
    return report()["frames"][0];
  }
};

void check_shine_refused(const OpenAir& place, const std::string& arguments, const std::string& part) {
  const std::string common = "--size 8x6 --light-count 64 --out image.exr --report report.json ";
  check_refused(place, "sg_relighting", common + arguments, part);
}

/// Every value of the report that does not measure time.
json without_times(json report) {
  report["preparation"].erase("seconds");
  report["settings"].erase("threads");
  for (auto& frame : report["frames"])
    for (const char* key : {"milliseconds", "reference_milliseconds", "stages"}) frame.erase(key);
  return report;
}

void write_map(const OpenAir& place, const std::string& name, const Image& map) {
  write_exr(place / name, map.width, map.height, {{"", map}});
}

bool is_sound(const Image& image) {
  return std::ranges::all_of(image.pixels,
                             [](const vec3& p) { return is_finite(p) && p.x >= 0 && p.y >= 0 && p.z >= 0; });
}

const std::string inputs = "--scene scene.glb --env sky.hdr ";

}  // namespace

TEST_CASE("sg_relighting tells its options") {
  const OpenAir place;
  const Outcome o = place.run("sg_relighting", "--help");
  CHECK(o.code == 0);
  CHECK(o.err.empty());
  for (const char* option : {"--scene",        "--env",         "--rotate-env",     "--env-to",
                             "--size",         "--out",         "--report",         "--threads",
                             "--seed",         "--peaks",       "--frames",         "--peak-threshold",
                             "--animate",      "--light-count", "--cut-size",       "--cones",
                             "--negligible",   "--voxels",      "--lobe-tolerance", "--contact",
                             "--visibility",   "--rays",        "--weights",        "--placement",
                             "--lobes",        "--fit",         "--levels",         "--material",
                             "--roughness-to", "--compare",     "--reference"})
    CHECK_MESSAGE(o.out.find(option) != std::string::npos, option);
}

TEST_CASE("sg_relighting refuses what it does not understand") {
  const OpenAir place;
  for (const std::string bad : {"--cones 0",
                                "--cones 65",
                                "--cones many",
                                "--voxels 0",
                                "--voxels 4096",
                                "--placement hope",
                                "--visibility guessed",
                                "--weights heavy",
                                "--lobes ear",
                                "--fit dress",
                                "--levels 0",
                                "--levels 9",
                                "--rays 0",
                                "--contact nan",
                                "--contact -1",
                                "--negligible 2",
                                "--negligible nan",
                                "--lobe-tolerance inf",
                                "--lobe-tolerance -1",
                                "--peaks -1",
                                "--peaks 1000",
                                "--peak-threshold 0.5",
                                "--peak-threshold nan",
                                "--roughness-to 2",
                                "--roughness-to nan",
                                "--frames 0",
                                "--light-count 0",
                                "--cut-size 0",
                                "--rotate-env nan",
                                "--threads -1",
                                "--size 0x4",
                                "--no-such-option",
                                "--material",
                                "--material velvet",
                                "--material phong",
                                "--material phong:0",
                                "--material phong:x",
                                "--material ggx:2",
                                "--material ggx:nan",
                                "--material ggx:0.3x",
                                "--material lambert:1"})
    check_shine_refused(place, inputs + bad, bad.substr(0, bad.find(' ')));
  check_refused(place, "sg_relighting", "", "--");
  check_refused(place, "sg_relighting", "--scene scene.glb --env sky.hdr", "--out");
}

TEST_CASE("sg_relighting refuses options that do not go together") {
  const OpenAir place;
  write_map(place, "wide.exr", Image(16, 4, vec3(1)));
  for (const auto& [arguments, part] : std::initializer_list<std::pair<std::string, std::string>>{
           {"--cones 5 --placement packed", "--cones"},
           {"--cones 2 --placement paper", "--cones"},
           {"--voxels 100", "--voxels"},
           {"--env-to wide.exr --frames 2", "wide.exr"},
           {"--env-to sky.hdr", "--env-to"},
           {"--roughness-to 0.5", "--roughness-to"},
           {"--roughness-to 0.5 --frames 2 --material ggx:0.2", "--roughness-to"}})
    check_shine_refused(place, inputs + arguments, part);
}

TEST_CASE("sg_relighting names files that it cannot read, and those that it cannot write") {
  const OpenAir place;
  files::put(place / "half.hdr", sky().substr(0, 100));
  auto bytes = still_life().glb();
  bytes.resize(bytes.size() / 2);
  place.put("half.glb", bytes);
  Image map(8, 4, vec3(1));
  map.at(3, 2).y = std::nanf("");
  write_map(place, "nan.exr", map);
  map.at(3, 2).y = -1;
  write_map(place, "negative.exr", map);
  std::filesystem::create_directory(place / "folder.exr");
  for (const std::string env : {"nowhere.hdr", "half.hdr", "scene.glb", "nan.exr", "negative.exr"}) {
    check_shine_refused(place, "--scene scene.glb --env " + env, env);
    check_shine_refused(place, inputs + "--frames 2 --env-to " + env, env);
  }
  for (const std::string scene : {"nowhere.glb", "half.glb", "sky.hdr"})
    check_shine_refused(place, "--env sky.hdr --scene " + scene, scene);
  for (const std::string out : {"missing/image.exr", "folder.exr", "image.png"})
    check_refused(place, "sg_relighting", inputs + "--size 8x6 --out " + out, out.substr(0, out.find('.')));
  check_refused(place, "sg_relighting", inputs + "--size 8x6 --out image.exr --report missing/report.json",
                "missing/report.json");
  check_shine_refused(place, inputs + "--compare nowhere.exr", "nowhere.exr");
}

TEST_CASE("a run writes the image, its light without shadows, a preview and the report") {
  const OpenAir place;
  const Outcome o = place.shine("--reference");
  CAPTURE(o.err);
  REQUIRE(o.code == 0);
  CHECK(o.out.empty());
  CHECK(line_count(o.err) == 1);
  CHECK(place.made() == std::set<std::string>{"image.exr", "image.png", "report.json"});
  const auto names = read_channel_names(place / "image.exr");
  std::set<std::string> expected{"R", "G", "B", "A", "cut_size.Y"};
  for (const std::string part : {"unoccluded", "reference", "error"})
    for (const char* channel : {".R", ".G", ".B"}) expected.insert(part + channel);
  CHECK(std::set<std::string>(names.begin(), names.end()) == expected);
  const Image image = read_image(place / "image.exr"), open = layer(place / "image.exr", "unoccluded"),
              reference = layer(place / "image.exr", "reference"),
              error = layer(place / "image.exr", "error");
  const Channel alpha = read_channel(place / "image.exr", "A");
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    CHECK(image.pixels[i] - reference.pixels[i] == error.pixels[i]);
    CHECK(luminance(image.pixels[i]) <= 1.0001f * luminance(open.pixels[i]));
    if (alpha.values[i] == 0) CHECK(image.pixels[i] == vec3(0));
  }
  CHECK(is_sound(image));
  CHECK(mean(image) > 0.5 * mean(open));
  CHECK(mean(image) < 0.99 * mean(open));
}

TEST_CASE("the report of cones holds settings, counts and the time of each stage") {
  const OpenAir place;
  const json frame = place.measured("--cones 5 --negligible 0");
  const json report = place.report();
  CHECK(report["program"] == "sg_relighting");
  CHECK(report["warnings"].empty());
  const json expected{{"scene", "scene.glb"},
                      {"environment", "sky.hdr"},
                      {"width", 48},
                      {"height", 36},
                      {"cones", 5},
                      {"lights", 1024},
                      {"cut_size", 256},
                      {"placement", "cut"},
                      {"visibility", "voxels"},
                      {"voxels", 64},
                      {"frames", 1},
                      {"animate", false}};
  for (const auto& [key, value] : expected.items()) CHECK_MESSAGE(report["settings"][key] == value, key);
  CHECK(report["preparation"]["triangles"] == 14);
  CHECK(report["preparation"]["voxels"]["bricks"] > 0);
  double sum = 0;
  for (const char* stage : {"geometry", "environment", "camera", "placement", "visibility", "sum"}) {
    CHECK_MESSAGE(frame["stages"][stage] >= 0, stage);
    sum += frame["stages"][stage].get<double>();
  }
  CHECK(sum <= 1.001 * frame["milliseconds"].get<double>());
  CHECK(frame["cones"]["max"].get<double>() <= 5 + frame["peaks"].get<double>());
  CHECK(frame["cones"]["mean"] > 3);
  CHECK(frame["points"] > 500);
  CHECK(frame["clusters"] > 100);
  CHECK(frame["reference_lights"] >= 1024);
}

TEST_CASE("errors against all lights are small with rays, and somewhat larger with voxels") {
  const OpenAir place;
  const double by_rays = error_of(place.measured("--visibility rays --rays 64 --cones 16"));
  const double by_voxels = error_of(place.measured("--visibility voxels --voxels 128 --cones 16"));
  CHECK(by_rays < 0.01);
  CHECK(by_voxels < 0.05);
  CHECK(by_voxels > 1.2 * by_rays);
  const double one = error_of(place.measured("--visibility rays --rays 64 --cones 1"));
  CHECK(one > 3 * by_rays);
}

TEST_CASE("every placement, weight, fit and visibility gives nearly the same image") {
  const OpenAir place;
  const Image usual = place.shone("--visibility rays --rays 64");
  for (const auto& [way, most] : std::initializer_list<std::pair<std::string, double>>{
           {"--visibility voxels", 0.15},
           {"--placement packed --visibility rays", 0.15},
           {"--placement packed", 0.2},
           {"--placement packed --weights lights --lobes warped --fit pyramid --levels 2", 0.2},
           {"--placement packed --cones 19 --visibility rays", 0.15},
           {"--placement paper --visibility rays", 0.5},
           {"--placement paper --cones 1", 0.6}}) {
    CAPTURE(way);
    const Image image = place.shone(way);
    CHECK(is_sound(image));
    CHECK(rel_rmse(image, usual) < most);
    CHECK(rel_rmse(image, usual) > 1e-4);
  }
}

TEST_CASE("materials for all surfaces: Lambert is even, a mirror is not") {
  const OpenAir place;
  write_map(place, "even.exr", Image(8, 4, vec3(1)));
  const std::string even = "--env even.exr --visibility rays ";
  for (const std::string material : {"lambert", "phong:50", "ggx:0.3"}) {
    CAPTURE(material);
    const Image image = place.shone(even + "--material " + material);
    CHECK(is_sound(image));
    CHECK(place.report()["settings"]["material"] == material);
    const Image open = layer(place / "image.exr", "unoccluded");
    const Channel alpha = read_channel(place / "image.exr", "A");
    for (std::size_t i = 0; i < open.pixels.size(); ++i) {
      if (alpha.values[i] == 0) continue;
      if (material == "lambert") CHECK(std::abs(open.pixels[i].y - 0.5f) < 0.01f);
      CHECK(open.pixels[i].y < 1.1f);
      CHECK(open.pixels[i].y > 0.2f);
    }
  }
}

TEST_CASE("a black environment gives a black image, one of 1e30 and one of one texel finite ones") {
  const OpenAir place;
  for (const std::string placement : {"cut", "packed", "paper"}) {
    CAPTURE(placement);
    write_map(place, "map.exr", Image(8, 4));
    const std::string arguments = "--env map.exr --reference --placement " + placement;
    CHECK(is_black(place.shone(arguments)));
    CHECK(place.report()["frames"][0]["peaks"] == 0);
    Image map(8, 4, vec3(1));
    map.at(5, 1) = vec3(1e30f);
    write_map(place, "map.exr", map);
    const Image bright = place.shone(arguments);
    CHECK(is_sound(bright));
    CHECK(mean(bright) > 1e25);
    write_map(place, "map.exr", Image(1, 1, vec3(1)));
    const Image even = place.shone(arguments);
    CHECK(is_sound(even));
    CHECK(mean(even) > 0.05);
  }
}

TEST_CASE("an empty scene gives a black image") {
  const OpenAir place;
  files::put(place / "empty.gltf", R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[]}]})");
  for (const std::string way : {"--visibility voxels", "--visibility rays", "--placement packed"}) {
    CAPTURE(way);
    CHECK(is_black(place.shone("--scene empty.gltf --reference --size 8x6 " + way)));
    CHECK(place.report()["frames"][0]["points"] == 0);
  }
}

TEST_CASE("light, materials, shape and rotation change together, and each frame tells its stages") {
  const OpenAir place(true);
  Image to(8, 4, vec3(0.2f, 0.3f, 2));
  write_map(place, "to.exr", to);
  const Outcome o = place.shine(
      "--scene room.glb --frames 4 --animate --rotate-env 30 --env-to to.exr --roughness-to 0.2 --reference "
      "--out move.exr --voxels 128");
  CAPTURE(o.err);
  REQUIRE(o.code == 0);
  CHECK(line_count(o.err) == 4);
  std::set<std::string> expected{"report.json", "to.exr"};
  for (const char* frame : {"move.0000", "move.0001", "move.0002", "move.0003"})
    for (const char* ending : {".exr", ".png"}) expected.insert(std::string(frame) + ending);
  CHECK(place.made() == expected);
  const json frames = place.report()["frames"];
  REQUIRE(frames.size() == 4);
  for (std::size_t i = 0; i < 4; ++i) {
    CAPTURE(i);
    for (const char* stage :
         {"geometry", "environment", "light_tree", "camera", "placement", "visibility", "sum"})
      CHECK_MESSAGE(frames[i]["stages"][stage] >= 0, stage);
    CHECK(frames[i]["stages"].contains("voxel_update") == (i > 0));
    if (i > 0) CHECK(frames[i]["stages"]["voxel_bricks_refreshed"] > 0);
    CHECK(error_of(frames[i]) < 0.1);
  }
  const Image first = read_image(place / "move.0000.exr"), last = read_image(place / "move.0003.exr");
  CHECK(rel_rmse(last, first) > 0.2);
  vec3 sum(0);
  for (const vec3& p : last.pixels) sum += p;
  CHECK(sum.z > 2 * sum.x);  // the second map is blue
}

TEST_CASE("frames are the scene and the map as they stand at their times") {
  const OpenAir place(true);
  Image to(8, 4, vec3(0.2f, 0.3f, 2));
  to.at(2, 1) = vec3(9);
  write_map(place, "to.exr", to);
  const std::string rays = "--scene room.glb --visibility rays --rays 64 ";
  REQUIRE(place.shine(rays + "--frames 3 --animate --env-to to.exr --out move.exr").code == 0);
  const Image last = read_image(place / "move.0002.exr");
  place.put("room.glb", room({.is_shining = false, .has_walls = false, .time = 2.0f / 3}).glb());
  const Image still = place.shone(rays + "--env to.exr");
  CHECK(rel_rmse(last, still) < 1e-4);
  CHECK(rel_rmse(read_image(place / "move.0000.exr"), still) > 0.2);
}

TEST_CASE("voxels that were brought up to date are those that were built anew") {
  const OpenAir place(true);
  REQUIRE(place.shine("--scene room.glb --frames 3 --animate --out move.exr --reference").code == 0);
  for (const json& frame : place.report()["frames"]) CHECK(error_of(frame) < 0.2);
}

TEST_CASE("where nothing moves frames are equal") {
  const OpenAir place;
  REQUIRE(place.shine("--frames 2 --out still.exr").code == 0);
  CHECK(files::get(place / "still.0000.exr") == files::get(place / "still.0001.exr"));
}

TEST_CASE("frame i is turned by i times the angle, and a whole turn changes nothing") {
  const OpenAir place;
  REQUIRE(place.shine("--frames 3 --rotate-env 120 --out turn.exr").code == 0);
  const Image still = read_image(place / "turn.0000.exr"), once = read_image(place / "turn.0001.exr"),
              twice = read_image(place / "turn.0002.exr");
  CHECK(still.pixels == place.shone("").pixels);
  CHECK(once.pixels == place.shone("--rotate-env 120").pixels);
  CHECK(twice.pixels == place.shone("--rotate-env 240").pixels);
  CHECK(rel_rmse(once, still) > 0.05);
  CHECK(rel_rmse(twice, once) > 0.05);
  CHECK(rel_rmse(place.shone("--rotate-env 360"), still) < 1e-3);
}

TEST_CASE("scene and environment turned together leave the image") {
  const OpenAir place;
  REQUIRE(place.shine("--scene scene.glb --visibility rays --rays 256").code == 0);
  const Image still = read_image(place / "image.exr");
  gltf_test::Builder turned = still_life();  // by 90 degrees about +Y, with its camera
  turned.nodes = R"([{"mesh":0,"rotation":[0,0.70710678,0,0.70710678]},)"
                 R"({"rotation":[0,0.70710678,0,0.70710678],"children":[2]},)"
                 R"({"camera":0,"translation":[0,2.5,4],"rotation":[-0.2588,0,0,0.9659]}])";
  place.put("scene.glb", turned.glb());
  const Image after = place.shone("--scene scene.glb --visibility rays --rays 256 --rotate-env 90");
  CHECK(rel_rmse(after, still) < 0.01);
  CHECK(rel_rmse(place.shone("--scene scene.glb --visibility rays --rays 256 --rotate-env -90"), still) >
        0.05);
}

TEST_CASE("one thread and two give the same files of cones") {
  const OpenAir place(true);
  for (const std::string way : {"--visibility voxels --roughness-to 0.4", "--visibility rays --seed 5",
                                "--placement packed --rotate-env 20", "--placement paper --samples 2"}) {
    CAPTURE(way);
    const std::string arguments = "--scene room.glb --size 32x24 --frames 2 --animate --reference " + way;
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

TEST_CASE("compared with itself an image of cones has no error") {
  const OpenAir place;
  place.shone("");
  std::filesystem::rename(place / "image.exr", place / "truth.exr");
  for (const std::string block : {"1", "4"}) {
    place.shone("--compare truth.exr --compare-block " + block);
    const json errors = place.report()["frames"][0]["compared"];
    CHECK(errors["rel_rmse"] == 0);
    CHECK(errors["pixels"] > 50);
  }
}
