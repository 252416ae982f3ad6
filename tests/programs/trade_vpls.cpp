// trade glossy_vpls as a user runs it: a row for each way to gather, with time and error.
#include <sstream>

#include "programs/vpl_room.hpp"

using namespace coppice;
using namespace program_test;
using nlohmann::json;

namespace {

using Cells = std::vector<std::string>;

/// The CSV that a run wrote.
class Table {
 public:
  explicit Table(const std::string& csv) {
    std::istringstream lines(csv);
    for (std::string line; std::getline(lines, line);) {
      std::istringstream cells(line + ",");  // so that a last cell that is empty counts too
      for (rows_.emplace_back(); std::getline(cells, line, ',');) rows_.back().push_back(line);
    }
    REQUIRE(rows_.size() > 1);
    for (const Cells& row : rows_) REQUIRE(row.size() == rows_[0].size());
  }

  std::size_t size() const { return rows_.size() - 1; }
  /// The cells of a column, by its name in the first row.
  Cells words(const std::string& name) const {
    const auto at = std::ranges::find(rows_[0], name);
    REQUIRE(at != rows_[0].end());
    Cells cells;
    for (std::size_t i = 1; i <= size(); ++i) cells.push_back(rows_[i][std::size_t(at - rows_[0].begin())]);
    return cells;
  }
  std::vector<double> column(const std::string& name) const {
    std::vector<double> values;
    for (const auto& cell : words(name)) values.push_back(std::stod(cell));
    return values;
  }

 private:
  std::vector<Cells> rows_;
};

const std::string slow_inputs = "glossy_vpls --scene room.glb --size 64x48 --emitters 64 --out trade.csv ";
const std::string inputs = slow_inputs + "--repeat 1 ";

Table sweep(const RoomWorkplace& place, const std::string& arguments) {
  const Outcome o = place.run("trade", inputs + arguments);
  CAPTURE(arguments);
  CAPTURE(o.err);
  REQUIRE(o.code == 0);
  return Table(files::get(place / "trade.csv"));
}

}  // namespace

TEST_CASE("a sweep of VPLs writes a row for every combination, a report and a table") {
  const RoomWorkplace place;
  const Outcome o = place.run("trade", inputs +
                                           "--report report.json --vpls 64,256 --bounces 1,2 "
                                           "--gather bound:0,bound:0.05,angle:0.1");
  CAPTURE(o.err);
  REQUIRE(o.code == 0);
  CHECK(place.made() == std::set<std::string>{"trade.csv", "report.json"});
  const Table table(files::get(place / "trade.csv"));
  REQUIRE(table.size() == 12);
  CHECK(table.words("scene") == Cells(12, "room.glb"));
  CHECK(table.column("vpls") == std::vector<double>{64, 64, 64, 64, 64, 64, 256, 256, 256, 256, 256, 256});
  CHECK(table.column("bounces") == std::vector<double>{1, 1, 1, 2, 2, 2, 1, 1, 1, 2, 2, 2});
  CHECK(table.words("pixels") == Cells(12, ""));
  const auto errors = table.column("rel_rmse"), least = table.column("nodes_min"),
             nodes = table.column("nodes_mean"), most = table.column("nodes_max"),
             shining = table.column("shining"), vpls = table.column("vpls");
  for (std::size_t i = 0; i < 12; ++i) {
    CAPTURE(i);
    CHECK(table.words("gather")[i] == Cells{"bound:0", "bound:0.05", "angle:0.1"}[i % 3]);
    CHECK(least[i] <= nodes[i]);
    CHECK(nodes[i] <= most[i]);
    CHECK(most[i] <= shining[i]);
    CHECK(shining[i] > 0);
    CHECK(shining[i] <= vpls[i]);
    CHECK(table.column("microseconds")[i] > 0);
    for (const char* ratio : {"times_brute_shining", "times_brute_all"})
      CHECK_MESSAGE(table.column(ratio)[i] >= 0, ratio);
    if (i % 3 == 0) {
      CHECK(errors[i] < 1e-5);
    } else {
      CHECK(errors[i] > errors[i - i % 3]);
      CHECK(errors[i] < 0.3);
      CHECK(table.column("p95")[i] >= table.column("mre")[i]);
    }
  }
  const json report = json::parse(files::get(place / "report.json"));
  CHECK(report["settings"]["vpls"] == json{64, 256});
  CHECK(report["settings"]["gather"] == json{"bound:0", "bound:0.05", "angle:0.1"});
  REQUIRE(report["rows"].size() == 12);
  for (std::size_t i = 0; i < 12; ++i) {
    CHECK(report["rows"][i]["gather"] == table.words("gather")[i]);
    CHECK(std::abs(report["rows"][i]["errors"]["rel_rmse"].get<double>() - errors[i]) < 1e-6);
    CHECK(std::abs(report["rows"][i]["nodes"]["mean"].get<double>() - nodes[i]) < 0.06);
  }
}

TEST_CASE("the table on stdout has a row for each of the CSV, and as many cells in each") {
  const RoomWorkplace place;
  const Outcome o = place.run("trade", inputs + "--vpls 64 --gather bound:0.01,angle:0.1 --pixels uniform:4");
  REQUIRE(o.code == 0);
  std::istringstream lines(o.out);
  std::vector<std::ptrdiff_t> bars;
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("|")) bars.push_back(std::ranges::count(line, '|'));
  REQUIRE(bars.size() == 2 + 4);
  for (const std::ptrdiff_t count : bars) CHECK(count == bars[0]);
  CHECK(o.out.find("relRMSE") != std::string::npos);
  CHECK(o.out.find("angle:0.1") != std::string::npos);
  CHECK(o.out.find(" dB") != std::string::npos);
}

TEST_CASE("every kind of gathering and of trees can be named") {
  const RoomWorkplace place;
  const Table table =
      sweep(place,
            "--vpls 256 --gather bound:0.01,bound:0.01:kd,bound:0.01:lengths,"
            "bound:0.01:uniform,bound:0.01:kd:uniform,min-max:40:9:0.1,traced:0.05,energy:0.05,"
            "traced:0,energy:0");
  REQUIRE(table.size() == 10);
  const auto errors = table.column("rel_rmse"), nodes = table.column("nodes_mean"),
             bias = table.column("bias");
  for (std::size_t i = 0; i < 5; ++i) {
    CAPTURE(i);
    CHECK(errors[i] < 0.05);
    CHECK(nodes[i] > 1);
    if (i > 0) CHECK(errors[i] != errors[0]);
  }
  CHECK(errors[5] < 2);          // min-max cuts know no error
  CHECK(errors[6] < errors[7]);  // drawn by what they bring, VPLs bring less noise
  CHECK(errors[7] < 0.2);
  CHECK(std::abs(bias[6]) < 0.02);
  CHECK(errors[8] < 1e-5);
  CHECK(errors[9] < 1e-5);
}

TEST_CASE("--pixels measures images of which some pixels are gathered, with their PSNR") {
  const RoomWorkplace place;
  const Table table = sweep(place,
                            "--vpls 256 --gather bound:0,traced:0.01 "
                            "--pixels relative:0,relative:0.07,paper:0.3,uniform:2,uniform:4,uniform:8");
  REQUIRE(table.size() == 8);  // no images of traced light
  CHECK(table.words("pixels") ==
        Cells{"", "relative:0", "relative:0.07", "paper:0.3", "uniform:2", "uniform:4", "uniform:8", ""});
  const auto share = table.column("pixel_share"), psnr = table.column("psnr_db"),
             errors = table.column("rel_rmse");
  CHECK(share[1] == 1);
  CHECK(psnr[1] > 100);
  CHECK(errors[1] < 1e-5);
  for (std::size_t i = 2; i < 7; ++i) {
    CAPTURE(i);
    CHECK(share[i] < 1);
    CHECK(share[i] > 0);
    CHECK(psnr[i] > 10);
    CHECK(psnr[i] < 80);
    CHECK(errors[i] > 1e-4);
    CHECK(table.column("bias")[i] != 0);
  }
  for (std::size_t i = 5; i < 7; ++i) {
    CHECK(share[i] < share[i - 1]);
    CHECK(psnr[i] < psnr[i - 1]);
  }
}

TEST_CASE("images are measured against the light of their own bounces") {
  const RoomWorkplace place;
  const Table table = sweep(place, "--vpls 128 --bounces 2,3 --gather bound:0 --pixels relative:0");
  REQUIRE(table.size() == 4);
  CHECK(table.column("shining")[0] == table.column("shining")[2]);
  for (const double error : table.column("rel_rmse")) CHECK(error < 1e-5);
}

TEST_CASE("however few points are asked for, some are measured") {
  const RoomWorkplace place;
  const auto points = [&](const std::string& count) {
    const Outcome o = place.run("trade", inputs + "--vpls 64 --gather bound:0.01 --points " + count);
    REQUIRE(o.code == 0);
    CHECK(Table(files::get(place / "trade.csv")).column("nodes_mean")[0] > 0);
    const auto at = o.out.find("over ");
    REQUIRE(at != std::string::npos);
    return std::stoi(o.out.substr(at + 5));
  };
  const int few = points("16"), some = points("512"), all = points("100000");
  CHECK(few > 0);
  CHECK(few < some);
  CHECK(some < all);
  CHECK(all < 64 * 48);
}

TEST_CASE("a single VPL, lit or not, is measured") {
  const RoomWorkplace place;
  const Table table = sweep(place, "--vpls 1,2,3 --gather bound:0,angle:0.02,traced:0");
  REQUIRE(table.size() == 9);
  for (const double error : table.column("rel_rmse")) CHECK(error < 1e-5);
}

TEST_CASE("repetitions change nothing but times, and neither do threads") {
  const RoomWorkplace place;
  const auto rows = [&](const std::string& arguments) {
    REQUIRE(place.run("trade", slow_inputs + "--vpls 64 --gather bound:0.01,traced:0.05 " + arguments).code ==
            0);
    return Table(files::get(place / "trade.csv"));
  };
  const Table one = rows("--repeat 1 --threads 1"), three = rows("--repeat 3 --threads 2");
  for (const char* name :
       {"shining", "nodes_min", "nodes_mean", "nodes_max", "tests", "rel_rmse", "mre", "p95", "bias"})
    CHECK_MESSAGE(one.words(name) == three.words(name), name);
}

TEST_CASE("trade glossy_vpls tells its options, and they stand in for the program's own") {
  const RoomWorkplace place;
  const Outcome o = place.run("trade", "glossy_vpls --help");
  CHECK(o.code == 0);
  CHECK(o.err.empty());
  for (const char* option : {"--scene", "--env", "--size", "--out", "--report", "--threads", "--seed",
                             "--vpls", "--bounces", "--gather", "--pixels", "--points", "--repeat",
                             "--density", "--spread", "--exponents", "--visibility"})
    CHECK_MESSAGE(o.out.find(option) != std::string::npos, option);
  for (const std::string option : {"--criterion", "--threshold", "--clustering", "--filter", "--min-max",
                                   "--ray-choice", "--adaptive", "--epsilon", "--frames"}) {
    CHECK_MESSAGE(o.out.find(option) == std::string::npos, option);
    check_refused(place, "trade", inputs + option + " 1", option);
  }
  CHECK(place.made().empty());
}

TEST_CASE("trade glossy_vpls refuses ways to gather that are none") {
  const RoomWorkplace place;
  for (const std::string bad :
       {"bound", "bound:", "bound:x", "bound:-1", "bound:nan", "bound:inf", "bound:0.01:0.02", "angle:0",
        "angle:7", "angle:0.02:heap", "min-max:40:0.02", "min-max:40:x:0.02", "glance:0.1", ":0.01",
        "bound:0.01;angle:0.02", "bound:1e99"})
    check_refused(place, "trade", inputs + "--gather '" + bad + "'", "--gather");
  for (const std::string bad : {"relative", "relative:", "relative:-1", "relative:nan", "paper:x",
                                "uniform:3", "uniform:0", "random:4", "relative:0.07:2"})
    check_refused(place, "trade", inputs + "--pixels " + bad, "--pixels");
}

TEST_CASE("trade glossy_vpls refuses bad input before the work") {
  const RoomWorkplace place;
  for (const std::string bad :
       {"--vpls 0", "--vpls 64,x", "--bounces 4", "--bounces 1,0", "--points 4", "--repeat 0", "--repeat x",
        "--samples 4", "--exponents 5", "--no-such-option"})
    check_refused(place, "trade", slow_inputs + bad, bad.substr(0, bad.find(' ')));
  check_refused(place, "trade", "glossy_vpls --scene room.glb", "--out");
  const std::string start = "glossy_vpls --size 16x12 --vpls 16 --scene ";
  for (const std::string scene : {"nowhere.glb", "sky.hdr"})
    check_refused(place, "trade", start + scene + " --out trade.csv", scene);
  check_refused(place, "trade", start + "room.glb --out missing/trade.csv", "missing/trade.csv");
  check_refused(place, "trade", start + "room.glb --out trade.csv --report missing/r.json", "missing/r.json");
}

TEST_CASE("trade glossy_vpls needs something that shines, and something to shine on") {
  const RoomWorkplace place;
  place.put("dark.glb", room({.is_shining = false}).glb());
  check_refused(place, "trade", "glossy_vpls --size 16x12 --scene dark.glb --out trade.csv",
                "no lights and no shining surfaces");
  files::put(place / "none.gltf", R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[]}]})");
  const Outcome o = place.run("trade", "glossy_vpls --scene none.gltf --out trade.csv");
  CHECK(o.code == 2);
  CHECK(o.err.find("none.gltf: shows its camera no surface") != std::string::npos);
  CHECK_FALSE(std::filesystem::exists(place / "trade.csv"));
}
