// cut_relighting as a user runs it: files, layers, report, backends.
#include <coppice/exr/write.hpp>
#include <coppice/relight/lobes.hpp>
#include <coppice/trade/errors.hpp>

#include "programs/run.hpp"

using namespace coppice;
using namespace program_test;
using nlohmann::json;

namespace {

double rel_rmse(const Image& image, const Image& reference) {
  return image_errors(image, reference, std::vector<bool>(image.pixels.size(), true)).rel_rmse;
}

double mean(const Image& image) {
  double sum = 0;
  for (const vec3& p : image.pixels) sum += luminance(p);
  return sum / double(image.pixels.size());
}

/// Runs and returns the image.
Image relit(const Workplace& place, const std::string& arguments) {
  const Outcome o = place.relight("--out image.exr " + arguments);
  CAPTURE(o.err);
  REQUIRE(o.code == 0);
  return read_image(place / "image.exr");
}

/// Every value of the report that does not measure time.
json without_times(json report) {
  report["preparation"].erase("seconds");
  report["settings"].erase("threads");
  for (auto& frame : report["frames"])
    for (const char* key :
         {"milliseconds", "milliseconds_lighting", "milliseconds_shading", "brute_force_milliseconds"})
      frame.erase(key);
  return report;
}

}  // namespace

TEST_CASE("a run writes the image, its layers, a preview and the report") {
  const Workplace place;
  const Outcome o = place.relight("--out image.exr --report report.json --reference --seed 5");
  CAPTURE(o.err);
  REQUIRE(o.code == 0);
  CHECK(o.out.empty());
  CHECK(place.made() == std::set<std::string>{"image.exr", "image.png", "report.json"});
  CHECK(files::get(place / "image.png").substr(0, 4) == "\x89PNG");
  const auto names = read_channel_names(place / "image.exr");
  CHECK(std::set<std::string>(names.begin(), names.end()) ==
        std::set<std::string>{"R", "G", "B", "A", "cut_size.Y", "reference.R", "reference.G", "reference.B",
                              "error.R", "error.G", "error.B"});
  const Image image = read_image(place / "image.exr");
  REQUIRE(image.width == 64);
  REQUIRE(image.height == 48);
  const Channel alpha = read_channel(place / "image.exr", "A"),
                sizes = read_channel(place / "image.exr", "cut_size.Y");
  const Channel reference = read_channel(place / "image.exr", "reference.G"),
                error = read_channel(place / "image.exr", "error.G");
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    CHECK((alpha.values[i] == 0 || alpha.values[i] == 1));
    CHECK((sizes.values[i] > 0) == (alpha.values[i] > 0));
    CHECK(image.pixels[i].y - reference.values[i] == error.values[i]);
    if (alpha.values[i] == 0) CHECK(image.pixels[i] == vec3(0));
  }
  CHECK(std::ranges::count(alpha.values, 1.0f) > 500);
}

TEST_CASE("the report holds settings, counts, times and errors") {
  const Workplace place;
  REQUIRE(
      place
          .relight(
              "--out image.exr --report report.json --reference --compare sky.exr --sigma 1.5 --cut-size 99")
          .code == 2);
  relit(place, "");
  std::filesystem::rename(place / "image.exr", place / "truth.exr");
  REQUIRE(place
              .relight("--out image.exr --report report.json --reference --compare truth.exr --sigma 1.5 "
                       "--cut-size 99")
              .code == 0);
  const json report = json::parse(files::get(place / "report.json"));
  CHECK(report["program"] == "cut_relighting");
  CHECK(report["settings"]["sigma"] == 1.5);
  CHECK(report["settings"]["cut_size"] == 99);
  CHECK(report["settings"]["lights"] == "env");
  CHECK(report["settings"]["light_count"] == 1024);
  CHECK(report["settings"]["width"] == 64);
  CHECK(report["preparation"]["triangles"] == 14);
  CHECK(report["preparation"]["lights"] == 1024);
  for (const char* key :
       {"receivers", "receivers_before_refinement", "shadow_rays", "shading_points", "shading_faces"})
    CHECK(report["preparation"][key] > 0);
  for (const char* key : {"tree", "camera", "refinement", "visibility"})
    CHECK(report["preparation"]["seconds"][key] >= 0);
  const json& cuts = report["preparation"]["visibility_cuts"];
  CHECK(cuts["min"] <= cuts["mean"]);
  CHECK(cuts["mean"] <= cuts["max"]);
  CHECK(cuts["bytes"] > 0);
  REQUIRE(report["frames"].size() == 1);
  const json& frame = report["frames"][0];
  CHECK(frame["illumination_nodes"] == 99);
  CHECK(frame["clusters"]["min"] > 0);
  CHECK(frame["clusters"]["min"] <= frame["clusters"]["mean"]);
  CHECK(frame["clusters"]["mean"] <= frame["clusters"]["max"]);
  for (const char* key : {"milliseconds", "milliseconds_lighting", "milliseconds_shading"})
    CHECK(frame[key] > 0);
  for (const char* key : {"plain", "skipping"}) CHECK(frame["brute_force_milliseconds"][key] > 0);
  for (const char* kind : {"errors", "compared"}) {
    for (const char* key : {"rel_rmse", "mre", "rel_mse", "p99"}) {
      CHECK(frame[kind][key] > 0);
      CHECK(frame[kind][key] < 0.5);
    }
    CHECK(frame[kind]["pixels"] == report["preparation"]["shading_points"]);
  }
}

TEST_CASE("the report tells how light was cut: the defaults, and what was asked for") {
  const Workplace place;
  const auto settings = [&](const std::string& arguments) {
    relit(place, "--report report.json " + arguments);
    return json::parse(files::get(place / "report.json"))["settings"];
  };
  const json usual = settings("");
  CHECK(usual["cut_size"] == 64);
  CHECK(usual["weight"] == "cosine");
  CHECK(usual["search"] == "optimal");
  CHECK(usual["lobes"] == "refined");
  CHECK(usual["lobe_tolerance"] == LobeOptions{}.tolerance);
  CHECK(usual["instructions"] == "auto");
  const json asked = settings(
      "--weight uniform --search threshold --lobes filtered --lobe-tolerance 0.25 --instructions baseline");
  CHECK(asked["weight"] == "uniform");
  CHECK(asked["search"] == "threshold");
  CHECK(asked["lobes"] == "filtered");
  CHECK(asked["lobe_tolerance"] == 0.25);
  CHECK(asked["instructions"] == "baseline");
}

TEST_CASE("each way of cutting changes the image a little") {
  const Workplace place;
  const std::string coarse = "--cut-size 16 ";
  const Image image = relit(place, coarse);
  for (const std::string way : {"--weight uniform", "--search threshold", "--lobes sampled",
                                "--lobes filtered", "--lobe-tolerance 1"}) {
    CAPTURE(way);
    const double difference = rel_rmse(relit(place, coarse + way), image);
    CHECK(difference > 1e-6);
    CHECK(difference < 0.2);
  }
}

TEST_CASE("every set of instructions gives nearly the same image, or is refused by name") {
  const Workplace place;
  const Image image = relit(place, "");
  for (const std::string set : {"avx512", "avx2", "baseline"}) {
    CAPTURE(set);
    const Outcome o = place.relight("--out set.exr --report set.json --instructions " + set);
    if (o.code == 2 && set != "baseline") {
      CHECK(o.err.find("--instructions " + set) != std::string::npos);
      continue;
    }
    REQUIRE(o.code == 0);
    CHECK(rel_rmse(read_image(place / "set.exr"), image) < 1e-4);
    const json report = json::parse(files::get(place / "set.json"));
    CHECK(report["settings"]["instructions"] == set);
    CHECK_FALSE(report["preparation"]["instructions"].get<std::string>().empty());
  }
}

TEST_CASE("compared with itself an image has no error, whole or in blocks") {
  const Workplace place;
  relit(place, "");
  std::filesystem::rename(place / "image.exr", place / "truth.exr");
  for (const std::string block : {"1", "4"}) {
    REQUIRE(place.relight("--out image.exr --report report.json --compare truth.exr --compare-block " + block)
                .code == 0);
    const json frame = json::parse(files::get(place / "report.json"))["frames"][0];
    CHECK(frame["compared"]["rel_rmse"] == 0);
    CHECK(frame["compared"]["pixels"] > 0);
  }
}

TEST_CASE("the error against all lights falls as both knobs turn") {
  const Workplace place;
  const auto error = [&](const std::string& knobs) {
    REQUIRE(place.relight("--out image.exr --report report.json --reference " + knobs).code == 0);
    return json::parse(files::get(place / "report.json"))["frames"][0]["errors"]["rel_rmse"].get<double>();
  };
  const double coarse = error("--sigma 4 --cut-size 16"), fine = error("--sigma 0.01 --cut-size 1024");
  CHECK(coarse > 1e-3);
  CHECK(fine < 1e-5);
}

TEST_CASE("one thread and two give the same files") {
  const Workplace place;
  REQUIRE(place.relight("--out one.exr --report one.json --reference --threads 1").code == 0);
  REQUIRE(place.relight("--out two.exr --report two.json --reference --threads 2").code == 0);
  CHECK(files::get(place / "one.exr") == files::get(place / "two.exr"));
  CHECK(files::get(place / "one.png") == files::get(place / "two.png"));
  const auto report = [&](const char* name) { return without_times(json::parse(files::get(place / name))); };
  CHECK(report("one.json") == report("two.json"));
}

TEST_CASE("frames are numbered and each is turned further") {
  const Workplace place;
  const std::string fine = "--sigma 0.01 --cut-size 1024 ";  // the error of cuts would hide a wrong turn
  REQUIRE(place.relight(fine + "--out turn.exr --report report.json --frames 2 --rotate-env 90").code == 0);
  CHECK(place.made() == std::set<std::string>{"turn.0000.exr", "turn.0000.png", "turn.0001.exr",
                                              "turn.0001.png", "report.json"});
  const json frames = json::parse(files::get(place / "report.json"))["frames"];
  REQUIRE(frames.size() == 2);
  CHECK(frames[0]["rotation_degrees"] == 0);
  CHECK(std::abs(frames[1]["rotation_degrees"].get<double>() - 90) < 1e-3);
  const Image still = read_image(place / "turn.0000.exr"), turned = read_image(place / "turn.0001.exr");
  CHECK(still.pixels == relit(place, fine).pixels);
  CHECK(rel_rmse(turned, still) > 0.05);
  const Image lights_moved = relit(place, fine + "--rotate-env 90");  // they stand where its own sun is
  CHECK(rel_rmse(lights_moved, turned) < 0.02);
}

TEST_CASE("a scene without a camera is seen whole, with a warning") {
  const Workplace place;
  place.put("scene.glb", still_life(false).glb());
  const Outcome o = place.relight("--out image.exr");
  REQUIRE(o.code == 0);
  CHECK(o.err.find("no camera") != std::string::npos);
  CHECK(std::ranges::count(read_channel(place / "image.exr", "A").values, 1.0f) > 300);
}

TEST_CASE("a scene without triangles gives a black image") {
  const Workplace place;
  files::put(place / "scene.gltf", R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[]}]})");
  const Outcome o =
      place.run("cut_relighting",
                "--scene scene.gltf --env sky.hdr --light-count 64 --size 8x6 --reference --out image.exr");
  CAPTURE(o.err);
  REQUIRE(o.code == 0);
  for (const vec3& p : read_image(place / "image.exr").pixels) CHECK(p == vec3(0));
}

TEST_CASE("a black environment gives a black image, one of 1e30 a finite one") {
  const Workplace place;
  Image map(8, 4);
  write_exr(place / "sky.exr", 8, 4, {{"", map}});
  const std::string arguments =
      "--scene scene.glb --env sky.exr --light-count 256 --size 32x24 --reference --out image.exr";
  REQUIRE(place.run("cut_relighting", arguments).code == 0);
  for (const vec3& p : read_image(place / "image.exr").pixels) CHECK(p == vec3(0));
  map.at(5, 1) = vec3(1e30f);
  write_exr(place / "sky.exr", 8, 4, {{"", map}});
  REQUIRE(place.run("cut_relighting", arguments).code == 0);
  const Image image = read_image(place / "image.exr");
  for (const vec3& p : image.pixels) CHECK(is_finite(p));
  CHECK(mean(image) > 1e25);
}

TEST_CASE("Lambert changes the metal and leaves the brightness in reason") {
  const Workplace place;
  const Image usual = relit(place, ""), lambert = relit(place, "--lambert");
  CHECK(rel_rmse(lambert, usual) > 0.02);
  CHECK(mean(lambert) < 2 * mean(usual));
  CHECK(mean(lambert) > 0.5 * mean(usual));
}

TEST_CASE("samples antialias: alpha is a share of coverage, the image stays near") {
  const Workplace place;
  const Image sharp = relit(place, ""), soft = relit(place, "--samples 4");
  const Channel alpha = read_channel(place / "image.exr", "A");
  CHECK(std::ranges::count_if(alpha.values, [](float a) { return a > 0.1f && a < 0.9f; }) > 10);
  for (const float a : alpha.values) CHECK(std::abs(4 * a - std::round(4 * a)) < 1e-5f);
  CHECK(rel_rmse(soft, sharp) < 0.25);
}

TEST_CASE("receivers everywhere and a seed give nearly the same image") {
  const Workplace place;
  const Image image = relit(place, "");
  CHECK(rel_rmse(relit(place, "--receivers all"), image) < 0.05);
  CHECK(rel_rmse(relit(place, "--seed 7"), image) < 0.05);
}

TEST_CASE("Vulkan gives the image of the CPU") {
  const Workplace place;
  const Image image = relit(place, "");
  const Outcome o = place.relight("--backend vulkan --out vulkan.exr");
  if (o.code == 2 && o.err.find("--backend vulkan") != std::string::npos) {
    CHECK_FALSE(std::filesystem::exists(place / "vulkan.exr"));
    MESSAGE("SKIPPED: ", o.err);
    return;
  }
  CAPTURE(o.err);
  REQUIRE(o.code == 0);
  CHECK(rel_rmse(read_image(place / "vulkan.exr"), image) < 1e-4);
}

TEST_CASE("the shortest program writes its image") {
  const Workplace place;
  CHECK(place.run("first_light", "scene.glb").code == 2);
  check_refused(place, "first_light", "nowhere.glb sky.hdr image.exr", "nowhere.glb");
}

TEST_CASE("--beta clusters lights by what pilot receivers see, whose rays are traced once") {
  const Workplace place;
  const auto report_with = [&](const std::string& beta) {
    const Image image = relit(place, "--report report.json --reference --cut-size 1024 --sigma 0.5" + beta);
    CHECK(mean(image) > 0);
    return json::parse(files::get(place / "report.json"));
  };
  const json geometric = report_with(""), mixed = report_with(" --beta 0.5");
  CHECK(geometric["settings"]["beta"] == 1);
  CHECK(geometric["preparation"]["pilot_rays"] == 0);
  CHECK(mixed["settings"]["beta"] == 0.5);
  CHECK(mixed["preparation"]["pilot_rays"] > 0);
  CHECK(mixed["preparation"]["pilot_receivers"] > 0);
  CHECK(mixed["preparation"]["shadow_rays"] == geometric["preparation"]["shadow_rays"]);
  CHECK(mixed["visibility_cuts"] != geometric["visibility_cuts"]);
  CHECK(mixed["frames"][0]["errors"]["rel_rmse"] < 0.05);
  CHECK(place.relight("--out image.exr --beta 1.5").code == 2);
}
