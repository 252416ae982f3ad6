// Bad input: exit code 2, one line that names the culprit, nothing written.
#include <coppice/exr/write.hpp>

#include "programs/run.hpp"

using namespace coppice;
using namespace program_test;

namespace {

const std::string small = " --light-count 64 --size 16x12 ";

void check_relight_refused(const Workplace& place, const std::string& arguments, const std::string& part) {
  check_refused(place, "cut_relighting", small + arguments, part);
}

}  // namespace

TEST_CASE("help is no error and names every option") {
  const Workplace place;
  for (const std::string program : {"cut_relighting", "trade"}) {
    const Outcome o = place.run(program, "--help");
    CHECK(o.code == 0);
    CHECK(o.err.empty());
    for (const char* option : {"--scene", "--env", "--rotate-env", "--size", "--samples", "--out", "--report",
                               "--threads", "--seed", "--sigma", "--cut-size", "--light-count", "--lambert",
                               "--lobes", "--lobe-tolerance", "--instructions"})
      CHECK_MESSAGE(o.out.find(option) != std::string::npos, option);
  }
  CHECK(place.made().empty());
}

TEST_CASE("both programs refuse command lines that they do not understand") {
  const Workplace place;
  const std::string files = "--scene scene.glb --env sky.hdr --out image.exr --light-count 64 ";
  for (const std::string program : {"cut_relighting", "trade"}) {
    check_refused(place, program, "", "--");
    check_refused(place, program, "--scene scene.glb --env sky.hdr", "--out");
    check_refused(place, program, files + "--no-such-option", "--no-such-option");
    for (const std::string size : {"0x0", "12", "12x", "x12", "-4x4", "4x4x4", "99999x1", "wide"})
      check_refused(place, program, files + "--size " + size, "--size");
    for (const std::string bad :
         {"--samples 0", "--samples many", "--threads -1", "--light-count 0", "--sigma -1", "--cut-size 0",
          "--receiver-tolerance nan", "--max-cut-size 0", "--max-receivers -1", "--receivers some",
          "--rotate-env nan", "--lobes dull", "--lobe-tolerance nan", "--lobe-tolerance -0.1",
          "--lobe-tolerance 1.5", "--instructions mmx", "--brdf velvet"})
      check_refused(place, program, files + bad, bad.substr(0, bad.find(' ')));
  }
}

TEST_CASE("cut_relighting refuses values outside its options' domains") {
  const Workplace place;
  for (const std::string bad :
       {"--backend abacus", "--lights moon", "--frames 0", "--compare-block 0", "--sigma nan",
        "--rotate-env inf", "--weight heavy", "--weight 1", "--search 0"})
    check_relight_refused(place, "--scene scene.glb --env sky.hdr --out image.exr " + bad,
                          bad.substr(0, bad.find(' ')));
}

TEST_CASE("scenes that cannot be read are named") {
  const Workplace place;
  auto bytes = still_life().glb();
  bytes.resize(bytes.size() / 2);
  place.put("half.glb", bytes);
  files::put(place / "empty.glb", "");
  files::put(place / "words.gltf", "not a scene");
  std::filesystem::create_directory(place / "folder.glb");
  for (const std::string program : {"cut_relighting", "trade"})
    for (const std::string scene :
         {"nowhere.glb", "half.glb", "empty.glb", "words.gltf", "folder.glb", "sky.hdr"})
      check_refused(place, program,
                    small + "--env sky.hdr --out image.exr --report report.json --scene " + scene, scene);
}

TEST_CASE("environments that cannot be read are named") {
  const Workplace place;
  files::put(place / "half.hdr", sky().substr(0, 100));
  std::filesystem::create_directory(place / "folder.hdr");
  Image map(8, 4, vec3(1));
  map.at(3, 2).y = std::nanf("");
  write_exr(place / "nan.exr", 8, 4, {{"", map}});
  map.at(3, 2).y = -1;
  write_exr(place / "negative.exr", 8, 4, {{"", map}});
  for (const std::string program : {"cut_relighting", "trade"})
    for (const std::string env :
         {"nowhere.hdr", "half.hdr", "folder.hdr", "scene.glb", "nan.exr", "negative.exr"})
      check_refused(place, program, small + "--scene scene.glb --out image.exr --env " + env, env);
}

TEST_CASE("outputs that cannot be written are refused before the work, and nothing is left") {
  const Workplace place;
  std::filesystem::create_directory(place / "folder.exr");
  std::filesystem::create_directory(place / "busy.png");
  files::put(place / "file", "kept");
  const std::string inputs = "--scene scene.glb --env sky.hdr ";
  for (const std::string out :
       {"missing/image.exr", "folder.exr", "file/image.exr", "busy.exr", "image.png", "missing/"})
    check_relight_refused(place, inputs + "--out " + out, out.substr(0, out.find('.')));
  for (const std::string report : {"missing/report.json", "folder.exr", "file/report.json"})
    check_relight_refused(place, inputs + "--out image.exr --report " + report, report);
  check_relight_refused(place, inputs + "--frames 2 --out missing/turn.exr", "missing/turn");
  CHECK(files::get(place / "file") == "kept");
}

TEST_CASE("a directory without permission to write is refused") {
  const Workplace place;
  std::filesystem::create_directory(place / "locked");
  std::filesystem::permissions(place / "locked",
                               std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
  if (::geteuid() != 0)
    check_relight_refused(place, "--scene scene.glb --env sky.hdr --out locked/image.exr",
                          "locked/image.exr");
  std::filesystem::permissions(place / "locked", std::filesystem::perms::owner_all);
  CHECK(std::filesystem::is_empty(place / "locked"));
}

TEST_CASE("images to compare with are checked before the work") {
  const Workplace place;
  const Image other(17, 12);
  write_exr(place / "wide.exr", 17, 12, {{"", other}});
  const std::string inputs = "--scene scene.glb --env sky.hdr --out image.exr --report report.json ";
  check_relight_refused(place, inputs + "--compare wide.exr", "wide.exr");
  check_relight_refused(place, inputs + "--compare nowhere.exr", "nowhere.exr");
  check_relight_refused(place, inputs + "--compare scene.glb", "scene.glb");
}
