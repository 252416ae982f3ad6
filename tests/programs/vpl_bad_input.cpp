// glossy_vpls and bad input: exit code 2, one line that names the culprit, nothing written.
#include <coppice/exr/write.hpp>

#include "programs/vpl_studio.hpp"

using namespace coppice;
using namespace program_test;
using nlohmann::json;

TEST_CASE("glossy_vpls tells its options") {
  const Studio place;
  const Outcome o = place.run("glossy_vpls", "--help");
  CHECK(o.code == 0);
  CHECK(o.err.empty());
  for (const char* option :
       {"--scene",      "--env",     "--rotate-env", "--size",       "--out",       "--report",
        "--threads",    "--seed",    "--vpls",       "--density",    "--spread",    "--emitters",
        "--sky-lights", "--bounces", "--exponents",  "--criterion",  "--threshold", "--clustering",
        "--filter",     "--min-max", "--visibility", "--ray-choice", "--adaptive",  "--epsilon",
        "--backend",    "--frames",  "--animate",    "--reference",  "--compare",   "--compare-minus"})
    CHECK_MESSAGE(o.out.find(option) != std::string::npos, option);
  CHECK(place.made().empty());
}

TEST_CASE("glossy_vpls refuses what it does not understand") {
  const Studio place;
  const std::string common = "--scene room.glb --size 16x12 --vpls 16 --out image.exr --report report.json ";
  for (const std::string bad :
       {"--exponents 5",      "--exponents 5:",    "--exponents 5:60:7", "--exponents nan:60",
        "--exponents 0.5:60", "--min-max 40",      "--min-max 40:x",     "--min-max inf:9",
        "--min-max -1:9",     "--threshold nan",   "--threshold -1",     "--threshold 7",
        "--threshold",        "--epsilon -1",      "--epsilon nan",      "--vpls -1",
        "--vpls many",        "--vpls 1e9",        "--emitters -1",      "--sky-lights 0",
        "--bounces 0",        "--bounces 4",       "--frames 0",         "--frames -3",
        "--criterion hope",   "--clustering heap", "--filter box",       "--visibility guessed",
        "--ray-choice luck",  "--adaptive on",     "--density dense",    "--spread thin",
        "--backend abacus",   "--brdf velvet",     "--rotate-env nan",   "--threads -1",
        "--size 0x4",         "--compare-block 0", "--no-such-option"})
    check_refused(place, "glossy_vpls", common + bad, bad.substr(0, bad.find(' ')));
  check_refused(place, "glossy_vpls", "", "--");
  check_refused(place, "glossy_vpls", "--scene room.glb", "--out");
}

TEST_CASE("glossy_vpls refuses options that do not go together") {
  const Studio place;
  const std::string common = "--scene room.glb --size 16x12 --vpls 16 --out image.exr ";
  for (const auto& [arguments, part] : std::initializer_list<std::pair<std::string, std::string>>{
           {"--samples 4", "--samples"},
           {"--min-max 40:9", "--min-max"},
           {"--visibility traced --criterion angle", "--visibility"},
           {"--criterion angle --threshold 0", "--threshold"},
           {"--visibility traced --backend vulkan", "--backend"},
           {"--compare-minus image.exr", "--compare"}})
    check_refused(place, "glossy_vpls", common + arguments, part);
}

TEST_CASE("glossy_vpls names files that it cannot read") {
  const Studio place;
  auto bytes = room().glb();
  bytes.resize(bytes.size() / 2);
  place.put("half.glb", bytes);
  files::put(place / "half.hdr", sky().substr(0, 100));
  const Image other(17, 12), fitting(16, 12);
  write_exr(place / "wide.exr", 17, 12, {{"", other}});
  write_exr(place / "fitting.exr", 16, 12, {{"", fitting}});
  const std::string common = "--size 16x12 --vpls 16 --out image.exr --report report.json ";
  for (const std::string scene : {"nowhere.glb", "half.glb", "sky.hdr"})
    check_refused(place, "glossy_vpls", common + "--scene " + scene, scene);
  for (const std::string bad :
       {"--env nowhere.hdr", "--env half.hdr", "--compare wide.exr", "--compare nowhere.exr",
        "--compare room.glb", "--compare fitting.exr --compare-minus wide.exr",
        "--compare fitting.exr --compare-minus nowhere.exr"})
    check_refused(place, "glossy_vpls", common + "--scene room.glb " + bad, bad.substr(bad.rfind(' ') + 1));
}

TEST_CASE("glossy_vpls refuses outputs that cannot be written before the work") {
  const Studio place;
  std::filesystem::create_directory(place / "folder.exr");
  std::filesystem::create_directory(place / "busy.png");
  files::put(place / "file", "kept");
  const std::string common = "--scene room.glb --size 16x12 --vpls 16 ";
  for (const std::string out : {"missing/image.exr", "folder.exr", "file/image.exr", "busy.exr", "image.png"})
    check_refused(place, "glossy_vpls", common + "--out " + out, out.substr(0, out.find('.')));
  check_refused(place, "glossy_vpls", common + "--out image.exr --report missing/report.json",
                "missing/report.json");
  check_refused(place, "glossy_vpls", common + "--frames 2 --out missing/turn.exr", "missing/turn");
  CHECK(files::get(place / "file") == "kept");
}
