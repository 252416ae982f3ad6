// glossy_vpls as a user runs it: files, layers, report, comparison.
#include <coppice/exr/write.hpp>

#include "programs/vpl_studio.hpp"

using namespace coppice;
using namespace program_test;
using nlohmann::json;

namespace {

/// These members are there with these values.
void check_members(const json& object, const json& expected) {
  for (const auto& [key, value] : expected.items()) CHECK_MESSAGE(object[key] == value, key);
}

}  // namespace

TEST_CASE("a run writes the image, its parts, a preview and the report") {
  const Studio place;
  const Outcome o = place.shine("--out image.exr --report report.json --reference --adaptive relative");
  CAPTURE(o.err);
  REQUIRE(o.code == 0);
  CHECK(o.out.empty());
  CHECK(line_count(o.err) == 1);
  CHECK(place.made() == std::set<std::string>{"image.exr", "image.png", "report.json"});
  CHECK(files::get(place / "image.png").substr(0, 4) == "\x89PNG");
  const auto names = read_channel_names(place / "image.exr");
  std::set<std::string> expected{"R", "G", "B", "A", "cut_size.Y"};
  for (const std::string part : {"direct", "indirect", "sampled", "reference", "error"})
    for (const char* channel : {".R", ".G", ".B"}) expected.insert(part + channel);
  CHECK(std::set<std::string>(names.begin(), names.end()) == expected);
}

TEST_CASE("the image is the sum of its parts, and black where nothing is") {
  const Studio place;
  const Image indirect = place.shone("--reference");
  const Image image = read_image(place / "image.exr"), direct = place.part("direct"),
              reference = place.part("reference"), error = place.part("error");
  const Channel alpha = read_channel(place / "image.exr", "A");
  REQUIRE(image.width == 64);
  REQUIRE(image.height == 48);
  std::size_t emitters = 0;
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    CHECK((alpha.values[i] == 0 || alpha.values[i] == 1));
    if (alpha.values[i] == 0) CHECK(image.pixels[i] == vec3(0));
    CHECK(indirect.pixels[i] - reference.pixels[i] == error.pixels[i]);
    if (image.pixels[i] == direct.pixels[i] + indirect.pixels[i]) continue;
    CHECK(luminance(image.pixels[i]) > 5);  // the lamp itself
    ++emitters;
  }
  CHECK(emitters > 5);
  CHECK(emitters < 100);
  const auto covered = std::size_t(std::ranges::count(alpha.values, 1.0f));
  CHECK(covered > 2000);
  CHECK(covered < image.pixels.size());
  CHECK(place.report()["frames"][0]["errors"]["pixels"] == covered - emitters);
}

TEST_CASE("VPLs light the ceiling, which the lamp does not reach") {
  const Studio place;
  const Image indirect = place.shone("");
  const Image direct = place.part("direct");
  const Channel alpha = read_channel(place / "image.exr", "A");
  int dark = 0, lit = 0;
  for (int y = 0; y < 10; ++y)
    for (int x = 16; x < 48; ++x) {
      if (alpha.values[std::size_t(y * 64 + x)] == 0 || direct.at(x, y) != vec3(0)) continue;
      ++dark;
      lit += luminance(indirect.at(x, y)) > 0.01f;
    }
  CHECK(dark > 100);
  CHECK(lit == dark);
}

TEST_CASE("the report of VPLs holds the settings, the default ones too") {
  const Studio place;
  place.shone("--threshold 0.02 --bounces 2 --seed 3 --env sky.hdr --sky-lights 32");
  const json report = place.report();
  CHECK(report["program"] == "glossy_vpls");
  CHECK(report["warnings"].empty());
  const json settings = report["settings"];
  check_members(settings, {{"scene", "room.glb"},
                           {"environment", "sky.hdr"},
                           {"width", 64},
                           {"height", 48},
                           {"backend", "cpu"},
                           {"seed", 3},
                           {"vpls", 512},
                           {"bounces", 2},
                           {"emitters", 64},
                           {"sky_lights", 32},
                           {"criterion", "bound"},
                           {"clustering", "squared"},
                           {"filter", "moments"},
                           {"visibility", "none"},
                           {"adaptive", "off"},
                           {"density", "root-irradiance"},
                           {"spread", "elimination"},
                           {"brdf", "gltf"},
                           {"frames", 1},
                           {"animate", false}});
  CHECK(std::abs(settings["threshold"].get<double>() - 0.02) < 1e-6);
  CHECK(report["preparation"]["triangles"] == 24);
  CHECK(report["preparation"]["vpls"] == 512);
  CHECK(report["preparation"]["lights"] > 64);
  CHECK(report["preparation"]["lights"] <= 96);
  CHECK(report["preparation"]["seconds"]["placement"] > 0);
}

TEST_CASE("the report of VPLs holds counts, times and errors of a frame") {
  const Studio place;
  const json frame = place.measured("--threshold 0.02");
  CHECK(frame["milliseconds"] > 0);
  CHECK(frame["all_vpls_milliseconds"] > 0);
  double sum = 0;
  for (const char* stage : {"pose", "follow", "vpl_direct_light", "bounces", "leaves", "tree", "camera",
                            "direct_light", "gather", "interpolation"}) {
    CHECK_MESSAGE(frame["stages"][stage] >= 0, stage);
    sum += frame["stages"][stage].get<double>();
  }
  CHECK(sum <= 1.001 * frame["milliseconds"].get<double>());
  CHECK(frame["vpls"]["placed"] == 512);
  CHECK(frame["vpls"]["shining"] > 256);
  CHECK(frame["vpls"]["shining"] <= 512);
  CHECK(frame["nodes"]["min"] > 0);
  CHECK(frame["nodes"]["min"] <= frame["nodes"]["mean"]);
  CHECK(frame["nodes"]["mean"] <= frame["nodes"]["max"]);
  CHECK(frame["nodes"]["max"] < 512);
  for (const char* key : {"rel_rmse", "mre", "rel_mse", "p95", "p99"}) {
    CHECK_MESSAGE(frame["errors"][key] > 0, key);
    CHECK_MESSAGE(frame["errors"][key] < 0.1, key);
  }
}

TEST_CASE("the report tells which knobs were turned") {
  const Studio place;
  place.shone(
      "--criterion angle --min-max 40:9 --clustering kd --filter uniform --density area --spread repulsion "
      "--exponents 5:60 --adaptive paper --epsilon 0.5 --brdf phong --ray-choice energy");
  const json settings = place.report()["settings"];
  check_members(settings, {{"criterion", "angle"},
                           {"min_max", {40, 9}},
                           {"clustering", "kd"},
                           {"filter", "uniform"},
                           {"density", "area"},
                           {"spread", "repulsion"},
                           {"exponents", {5, 60}},
                           {"adaptive", "paper"},
                           {"epsilon", 0.5},
                           {"brdf", "phong"},
                           {"ray_choice", "energy"}});
  CHECK(std::abs(settings["threshold"].get<double>() - 0.02) < 1e-6);  // the angle's own default
  place.shone("--criterion angle --min-max --adaptive");
  check_members(place.report()["settings"], {{"min_max", {40, 9}}, {"adaptive", "relative"}});
  place.shone("--visibility traced");
  CHECK(place.report()["settings"]["visibility"] == "traced");
  CHECK(std::abs(place.report()["settings"]["threshold"].get<double>() - 0.02) < 1e-6);
}

TEST_CASE("the layer of cut sizes is what the report sums up") {
  const Studio place;
  place.shone("");
  const Channel sizes = read_channel(place / "image.exr", "cut_size.Y"),
                alpha = read_channel(place / "image.exr", "A");
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < sizes.values.size(); ++i) {
    CHECK((sizes.values[i] > 0) == (alpha.values[i] > 0));
    sum += double(sizes.values[i]), count += double(alpha.values[i]);
  }
  const json frame = place.report()["frames"][0];
  CHECK(frame["gathered_pixels"] == count);
  CHECK(std::abs(frame["nodes"]["mean"].get<double>() - sum / count) < 1e-6 * sum / count);
  CHECK(frame["nodes"]["max"] == std::ranges::max(sizes.values));
}

TEST_CASE("compared with itself a frame has no error, whole, in blocks, or its VPLs alone") {
  const Studio place;
  const Image indirect = place.shone("");
  std::filesystem::rename(place / "image.exr", place / "truth.exr");
  const auto compared = [&](const std::string& arguments) {
    place.shone(arguments);
    return place.report()["frames"][0]["compared"];
  };
  for (const std::string block : {"1", "4"}) {
    const json errors = compared("--compare truth.exr --compare-block " + block);
    CHECK(errors["rel_rmse"] == 0);
    CHECK(errors["pixels"] > 100);
  }
  CHECK(compared("--compare truth.exr --bounces 2")["rel_rmse"] > 0.01);
  const Image direct = layer(place / "truth.exr", "direct");
  write_exr(place / "direct.exr", 64, 48, {{"", direct}});
  CHECK(compared("--compare truth.exr --compare-minus direct.exr")["rel_rmse"] < 1e-5);
  write_exr(place / "direct.exr", 64, 48, {{"", indirect}});
  CHECK(compared("--compare truth.exr --compare-minus direct.exr")["rel_rmse"] > 0.1);
}
