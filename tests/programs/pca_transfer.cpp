// pca_transfer as a user runs it: files, linearity, every kind of visibility and basis, and bad input.
#include "programs/pca_studio.hpp"

using namespace coppice;
using namespace program_test;
using nlohmann::json;

namespace {

Image sum(const Image& a, const Image& b, float factor = 1) {
  Image result = a;
  for (std::size_t i = 0; i < result.pixels.size(); ++i)
    result.pixels[i] = factor * (result.pixels[i] + b.pixels[i]);
  return result;
}

bool is_finite_image(const Image& image) {
  return std::ranges::all_of(image.pixels, [](const vec3& p) { return is_finite(p); });
}

/// A light's JSON; `keys` as in the file.
std::string light(const std::string& keys, const std::string& interpolation = "linear") {
  return R"({"interpolation":")" + interpolation + R"(","keys":[)" + keys + "]}";
}

std::string lights(const std::string& list) { return R"({"lights":[)" + list + "]}"; }

const std::string first_light = light(R"({"time":0,"position":[0.6,1.4,0.5],"intensity":[4,3,2]})");
const std::string second_light = light(R"({"time":0,"position":[-0.6,1.6,-0.2],"intensity":[1,2,6]})");

}  // namespace

TEST_CASE("pca_transfer tells its options") {
  const PcaStudio place;
  const Outcome o = place.run("pca_transfer", "--help");
  CHECK(o.code == 0);
  CHECK(o.err.empty());
  for (const char* option :
       {"--scene",          "--out",           "--size",       "--report",     "--path",
        "--through",        "--intensity",     "--light-size", "--lights",     "--surface-samples",
        "--clusters",       "--start",         "--onto",       "--visibility", "--visibility-rank",
        "--lattice-points", "--dome",          "--directions", "--intervals",  "--basis",
        "--transfer-rank",  "--receiver-rank", "--bounces",    "--frames",     "--reference",
        "--splat-width",    "--light-points",  "--store",      "--backend",    "--example-lights"})
    CHECK_MESSAGE(o.out.find(option) != std::string::npos, option);
  CHECK(o.out.find("--env") == std::string::npos);
}

TEST_CASE("a room's image is the sum of its direct and its indirect light") {
  const PcaStudio place;
  const Image image = place.shone("");
  CHECK(place.made() == std::set<std::string>{"image.exr", "image.png", "report.json"});
  const Image direct = place.part("direct"), indirect = place.part("indirect");
  CHECK(rel_rmse(image, sum(direct, indirect)) < 1e-6);
  CHECK(mean(direct) > 0);
  CHECK(mean(indirect) > 0.1 * mean(direct));
  CHECK(is_finite_image(image));
  const json report = place.report();
  CHECK(report["settings"]["visibility"] == "lattice");
  CHECK(report["preparation"]["samples"]["samples"] > 400);
  CHECK(report["preparation"]["samples"]["samples"] < 800);
  CHECK(report["preparation"]["bytes"] > 0);
  for (const char* stage : {"visibility", "projection", "transfer", "expansion", "splats"})
    CHECK_MESSAGE(report["frames"][0]["stages"][stage] >= 0, stage);
  CHECK(report["frames"][0]["lights"] == 1);
  CHECK(report["warnings"].empty());
}

TEST_CASE("with shadow rays and large bases hardly anything is lost") {
  const PcaStudio place;
  const std::string large =
      "--surface-samples 2000 --visibility rays --transfer-rank 200 --receiver-rank 200 ";
  const json fine = place.measured(large + "--transfer-bits 16");
  const Image direct = place.part("direct"), indirect = place.part("indirect"),
              reference = place.part("reference");
  CHECK(error_of(fine) < 0.12);  // a shadow's edge is as sharp as the samples are near
  CHECK(fine["errors"]["mre"] < 0.05);
  CHECK(mean(sum(direct, indirect)) == doctest::Approx(mean(reference)).epsilon(0.02));
  const json coarse = place.measured("--surface-samples 2000 --visibility-rank 2 --transfer-rank 1");
  CHECK(error_of(coarse) > error_of(fine));
}

TEST_CASE("the light of doubled intensity is doubled") {
  const PcaStudio place;
  for (const std::string way : {"", "--basis paper"}) {
    CAPTURE(way);
    const Image once = place.shone("--intensity 3,2,1 " + way);
    const Image twice = place.shone("--intensity 6,4,2 " + way);
    CHECK(rel_rmse(twice, sum(once, once)) < 1e-5);
    CHECK(mean(once) > 0);
  }
}

TEST_CASE("several lights add up") {
  const PcaStudio place;
  place.put_text("one.json", lights(first_light));
  place.put_text("two.json", lights(second_light));
  place.put_text("both.json", lights(first_light + "," + second_light));
  for (const std::string way : {"", "--basis paper", "--visibility depth"}) {
    CAPTURE(way);
    const Image one = place.shone("--path one.json " + way), two = place.shone("--path two.json " + way);
    const Image both = place.shone("--path both.json " + way);
    CHECK(place.report()["frames"][0]["lights"] == 2);
    CHECK(rel_rmse(both, sum(one, two)) < 1e-4);
    CHECK(rel_rmse(both, one) > 0.05);
  }
}

TEST_CASE("frames follow the path, and each is the light where it stands") {
  const PcaStudio place;
  const std::string keys = R"({"time":1,"position":[0.6,1.4,0.5],"intensity":[3,3,3],"radius":0.1},)"
                           R"({"time":3,"position":[-0.6,1.6,-0.3]})";
  place.put_text("path.json", lights(light(keys)));
  place.put_text("middle.json",
                 lights(light(R"({"position":[0.3,1.45,0.3],"intensity":[3,3,3],"radius":0.1})")));
  const Outcome o = place.shine("--path path.json --frames 4 --out move.exr");
  CAPTURE(o.err);
  REQUIRE(o.code == 0);
  CHECK(line_count(o.err) == 4);
  for (const char* frame : {"move.0000", "move.0001", "move.0002", "move.0003"})
    for (const char* ending : {".exr", ".png"})
      CHECK_MESSAGE(place.made().contains(std::string(frame) + ending), frame);
  CHECK(place.report()["frames"].size() == 4);
  const Image first = read_image(place / "move.0000.exr"), second = read_image(place / "move.0001.exr"),
              third = read_image(place / "move.0002.exr"), last = read_image(place / "move.0003.exr");
  CHECK(rel_rmse(second, first) == 0);  // time 1 is where the path begins
  CHECK(rel_rmse(last, first) > 0.1);
  // Time 2 of keys at 1 and 3 is their middle, at x = 0, not at 0.3.
  CHECK(rel_rmse(place.shone("--path middle.json"), third) > 0.01);
  place.put_text("middle.json",
                 lights(light(R"({"position":[0,1.5,0.1],"intensity":[3,3,3],"radius":0.1})")));
  CHECK(rel_rmse(place.shone("--path middle.json"), third) < 1e-3);
}

TEST_CASE("a light goes through points named on the command line") {
  const PcaStudio place;
  const Image at_once = place.shone("--through 0.6,1.4,0.5");
  REQUIRE(place.shine("--through 0.6,1.4,0.5 0,1.7,0.3 -0.6,1.4,0.3 --frames 3 --out move.exr").code == 0);
  CHECK(rel_rmse(read_image(place / "move.0000.exr"), at_once) < 1e-6);
  CHECK(rel_rmse(read_image(place / "move.0002.exr"), at_once) > 0.1);
}

TEST_CASE("larger lights have softer shadows, and nearly the same light") {
  const PcaStudio place;
  for (const std::string way : {"", "--visibility depth", "--visibility rays"}) {
    CAPTURE(way);
    const Image point = place.shone(way), ball = place.shone("--light-size 0.3 " + way);
    CHECK(rel_rmse(ball, point) > 0.001);
    CHECK(mean(ball) == doctest::Approx(mean(point)).epsilon(0.15));
  }
}

TEST_CASE("each way to know shadows comes near rays") {
  const PcaStudio place;
  place.shone("--visibility rays");
  const Image rays = place.part("direct");
  for (const std::string way : {"lattice", "lattice --visibility-bits 16", "lattice --shadow smooth", "depth",
                                "depth --dome sphere", "depth --intervals 0", "depth --visibility-bits 16"}) {
    CAPTURE(way);
    place.shone("--visibility " + way);
    const Image direct = place.part("direct");
    CHECK(rel_rmse(direct, rays) < 0.25);
    CHECK(rel_rmse(direct, rays) > 0);
    CHECK(place.report()["preparation"]["visibility"]["bytes"] > 0);
  }
}

TEST_CASE("each basis comes near the solver, and its rank matters") {
  const PcaStudio place;
  const std::string large = "--visibility rays --transfer-rank 200 --receiver-rank 200 --transfer-bits 16";
  place.shone(large);
  const Image exact = place.part("indirect");
  for (const std::string basis : {"transport", "uncentred", "paper"}) {
    CAPTURE(basis);
    const auto error = [&](const std::string& rank) {
      place.shone("--visibility rays --transfer-rank " + rank + " --basis " + basis);
      return rel_rmse(place.part("indirect"), exact);
    };
    const double many = error("30");
    CHECK(many < 0.05);
    CHECK(many > 0);
    CHECK(error("1") > many);
  }
  place.shone("--bounces 0");
  CHECK(is_black(place.part("indirect")));
}

TEST_CASE("splats may be summed at vertices") {
  const PcaStudio place;
  place.shone("");
  const Image pixels = place.part("indirect");
  place.shone("--onto vertices");  // a wall has four, in its corners, where it is darker
  const Image vertices = place.part("indirect");
  CHECK(is_finite_image(vertices));
  CHECK(rel_rmse(vertices, pixels) > 0);
  CHECK(mean(vertices) == doctest::Approx(mean(pixels)).epsilon(0.5));
}

TEST_CASE("a store spares the second run its precomputation") {
  const PcaStudio place;
  const Image made = place.shone("--store room.h5");
  REQUIRE(place.made().contains("room.h5"));
  const json first = place.report();
  const Image read = place.shone("--store room.h5");
  const json second = place.report();
  CHECK(rel_rmse(read, made) == 0);
  CHECK(first["preparation"]["store"] != second["preparation"]["store"]);
  CHECK(first["preparation"]["seconds"].contains("transfer_matrix"));
  CHECK_FALSE(second["preparation"]["seconds"].contains("transfer_matrix"));
  const Image other = place.shone("--store room.h5 --clusters 9");
  CHECK(rel_rmse(other, made) > 0);
  CHECK(place.report()["preparation"]["seconds"].contains("transfer_matrix"));
  CHECK(error_of(place.measured("--store room.h5 --clusters 9")) < 0.25);
}

TEST_CASE("one thread and two make the same image of a room") {
  const PcaStudio place;
  for (const std::string way : {"", "--visibility depth --basis uncentred --light-size 0.1"}) {
    CAPTURE(way);
    REQUIRE(place.shine("--threads 1 --reference --out one.exr " + way).code == 0);
    REQUIRE(place.shine("--threads 2 --reference --out two.exr " + way).code == 0);
    CHECK(files::get(place / "one.exr") == files::get(place / "two.exr"));
    CHECK(files::get(place / "one.png") == files::get(place / "two.png"));
  }
}

TEST_CASE("without lights the image is black, and a warning says why") {
  const PcaStudio place;
  const std::string common = PcaStudio::with_usual("--out image.exr --report report.json ");
  for (const auto& [arguments, part] : std::initializer_list<std::pair<std::string, std::string>>{
           {"", "--path"}, {"--lights scene", "nothing shines"}}) {
    CAPTURE(arguments);
    const Outcome o = place.run("pca_transfer", common + arguments);
    CAPTURE(o.err);
    REQUIRE(o.code == 0);
    CHECK(is_black(read_image(place / "image.exr")));
    REQUIRE(place.report()["warnings"].size() == 1);
    CHECK(place.report()["warnings"][0].get<std::string>().find(part) != std::string::npos);
  }
  place.put_text("none.json", lights(""));
  CHECK(is_black(place.shone("--path none.json")));
}

TEST_CASE("where no surface can be reached there is no indirect light, and a warning says why") {
  const PcaStudio place;
  place.put_text("empty.gltf",
                 R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"camera":0}],)"
                 R"("cameras":[{"type":"perspective","perspective":{"yfov":1,"znear":0.1}}]})");
  for (const std::string way : {"", "--visibility depth", "--visibility rays", "--onto vertices"}) {
    CAPTURE(way);
    CHECK(is_black(place.shone("--scene empty.gltf --reference " + way)));
    REQUIRE_FALSE(place.report()["warnings"].empty());
    CHECK(place.report()["warnings"].back().get<std::string>().find("no surface") != std::string::npos);
  }
  const Outcome o = place.run("trade", "pca_transfer --scene empty.gltf --size 8x6 --out trade.csv");
  CHECK(o.code == 2);
  CHECK(o.err.find("--start") != std::string::npos);
  CHECK_FALSE(place.made().contains("trade.csv"));
}

TEST_CASE("the file's own lamp lights its room") {
  const PcaStudio place;
  place.put("room.glb", room().glb());
  const std::string common = PcaStudio::with_usual("--out image.exr --report report.json --lights scene");
  const Outcome o = place.run("pca_transfer", common + " --emitters 8");
  CAPTURE(o.err);
  REQUIRE(o.code == 0);
  CHECK(place.report()["frames"][0]["lights"] == 8);
  CHECK(mean(place.part("direct")) > 0);
  CHECK(mean(place.part("indirect")) > 0);
}

TEST_CASE("pca_transfer refuses paths of lights that it cannot read") {
  const PcaStudio place;
  const std::string common = PcaStudio::with_usual("--out image.exr --path path.json");
  const std::string at = R"("position":[0,1,0])";
  for (const auto& [text, part] : std::initializer_list<std::pair<std::string, std::string>>{
           {"lights", "path.json"},
           {"[]", "\"lights\""},
           {R"({"lights":{}})", "\"lights\""},
           {lights("{}"), "light 0"},
           {lights(light("")), "light 0"},
           {lights(first_light + "," + light("{}")), "light 1, key 0"},
           {lights(light("3")), "key 0"},
           {lights(light(R"({"position":[0,1]})")), "\"position\""},
           {lights(light(R"({"position":[0,1,"x"]})")), "\"position\""},
           {lights(light(R"({"position":[0,1,1e999]})")), "path.json"},
           {lights(light("{\"time\":1," + at + "},{\"time\":1," + at + "}")), "sort"},
           {lights(light("{\"time\":2," + at + "},{\"time\":1," + at + "}")), "key 1"},
           {lights(light("{" + at + R"(,"radius":-1})")), "\"radius\""},
           {lights(light("{" + at + R"(,"intensity":[1,-1,1]})")), "\"intensity\""},
           {lights(light("{" + at + "}", "curly")), "\"interpolation\""}}) {
    CAPTURE(text);
    place.put_text("path.json", text);
    check_refused(place, "pca_transfer", common, part);
  }
  check_refused(place, "pca_transfer", PcaStudio::with_usual("--out image.exr --path none.json"),
                "none.json");
}

TEST_CASE("pca_transfer refuses what it does not understand") {
  const PcaStudio place;
  const std::string common = PcaStudio::with_usual("--out image.exr ");
  for (const std::string bad : {"--through a,b",        "--through 1,2",
                                "--through 1,2,3x",     "--intensity 1,2 --through 0,1,0",
                                "--light-size -1",      "--light-size nan",
                                "--light-points 0",     "--lights sun",
                                "--curvature 3",        "--start here",
                                "--onto faces",         "--splat-width 0",
                                "--visibility guessed", "--visibility-rank -1",
                                "--visibility-bits 12", "--shadow black",
                                "--dome flat",          "--directions 2",
                                "--intervals -1",       "--basis fourier",
                                "--transfer-rank 0",    "--receiver-rank 0",
                                "--transfer-bits 4",    "--bounces 65",
                                "--frames 0",           "--backend abacus",
                                "--env sky.hdr",        "--no-such-option"})
    check_refused(place, "pca_transfer", common + bad, bad.substr(0, bad.find(' ')));
  for (const std::string bad : {"--surface-samples 0", "--clusters 0", "--transport-rays 0", "--size 0x4"})
    check_refused(place, "pca_transfer", PcaStudio::with_usual("--out image.exr " + bad),
                  bad.substr(0, bad.find(' ')));
  check_refused(place, "pca_transfer", "--scene room.glb", "--out");
  check_refused(place, "pca_transfer", "--scene missing.glb --out image.exr", "missing.glb");
}

TEST_CASE("pca_transfer refuses options that do not go together") {
  const PcaStudio place;
  const std::string common = PcaStudio::with_usual("--out image.exr ");
  place.put_text("path.json", lights(first_light));
  check_refused(place, "pca_transfer", common + "--path path.json --through 0,1,0", "--through");
  check_refused(place, "pca_transfer", common + "--lights scene --through 0,1,0", "--lights scene");
  check_refused(place, "pca_transfer", common + "--lights scene --path path.json", "--lights scene");
  check_refused(place, "pca_transfer", common + "--visibility depth --store room.h5", "--store");
}
