// trade as a user runs it: one row a combination of knobs, a plot, a table, settings for a target.
#include <sstream>

#include "programs/run.hpp"

using namespace coppice;
using namespace program_test;
using nlohmann::json;

namespace {

using Row = std::vector<std::string>;

std::vector<Row> rows_of(const std::string& csv) {
  std::vector<Row> rows;
  std::istringstream lines(csv);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream cells(line + ",");  // so that a last cell that is empty counts too
    for (rows.emplace_back(); std::getline(cells, line, ',');) rows.back().push_back(line);
  }
  return rows;
}

/// The cells of a column, by its name in the first row.
Row words(const std::vector<Row>& rows, const std::string& name) {
  const auto at = std::ranges::find(rows[0], name);
  REQUIRE(at != rows[0].end());
  Row cells;
  for (std::size_t i = 1; i < rows.size(); ++i) cells.push_back(rows[i][std::size_t(at - rows[0].begin())]);
  return cells;
}

std::vector<double> column(const std::vector<Row>& rows, const std::string& name) {
  std::vector<double> values;
  for (const auto& cell : words(rows, name)) values.push_back(std::stod(cell));
  return values;
}

/// Runs, and returns the rows of its CSV.
std::vector<Row> sweep(const Workplace& place, const std::string& arguments) {
  const Outcome o = place.run("trade", arguments);
  CAPTURE(o.err);
  REQUIRE(o.code == 0);
  const auto rows = rows_of(files::get(place / "trade.csv"));
  for (const Row& row : rows) CHECK(row.size() == rows[0].size());
  return rows;
}

const std::string inputs = "--scene scene.glb --env sky.hdr --light-count 1024 --size 48x36 --repeat 1 ";

}  // namespace

TEST_CASE("a sweep writes a row for every combination of knobs, a plot, a report and a table") {
  const Workplace place;
  const Outcome o =
      place.run("trade", inputs + "--out trade.csv --report trade.json --sigma 0.01,4 --cut-size 8,1024");
  CAPTURE(o.err);
  REQUIRE(o.code == 0);
  CHECK(place.made() == std::set<std::string>{"trade.csv", "trade.svg", "trade.json"});
  const auto rows = rows_of(files::get(place / "trade.csv"));
  REQUIRE(rows.size() == 5);
  for (const Row& row : rows) CHECK(row.size() == rows[0].size());
  CHECK(column(rows, "sigma") == std::vector<double>{0.01, 0.01, 4, 4});
  CHECK(column(rows, "cut_size") == std::vector<double>{8, 1024, 8, 1024});
  CHECK(words(rows, "scene") == Row(4, "scene.glb"));
  CHECK(words(rows, "environment") == Row(4, "sky.hdr"));
  CHECK(words(rows, "cuts") == Row(4, "cosine-optimal"));
  CHECK(words(rows, "lobes") == Row(4, "refined"));
  CHECK(words(rows, "rel_rmse_visibility") == Row(4, ""));
  const auto errors = column(rows, "rel_rmse");
  CHECK(errors[1] < 1e-5);
  CHECK(errors[0] > errors[1]);
  CHECK(errors[3] > errors[1]);
  for (const double speed : column(rows, "times_plain")) CHECK(speed > 0);
  const json report = json::parse(files::get(place / "trade.json"));
  REQUIRE(report["points"].size() == 4);
  CHECK_FALSE(report.contains("picks"));
  for (const json& point : report["points"]) {
    CHECK(point["clusters"]["min"] <= point["clusters"]["mean"]);
    CHECK(point["clusters"]["mean"] <= point["clusters"]["max"]);
    CHECK(point["clusters"]["min"] > 0);
  }
  CHECK(o.out.find("relRMSE") != std::string::npos);
  CHECK(files::get(place / "trade.svg").find("<svg") != std::string::npos);
}

TEST_CASE("a sweep goes over kinds of cuts and lobes too") {
  const Workplace place;
  const auto rows = sweep(place, inputs +
                                     "--out trade.csv --sigma 2 --cut-size 16 --visibility-only --lobes "
                                     "sampled,refined --cuts uniform-threshold,cosine-optimal");
  REQUIRE(rows.size() == 5);
  CHECK(words(rows, "cuts") ==
        Row{"uniform-threshold", "uniform-threshold", "cosine-optimal", "cosine-optimal"});
  CHECK(words(rows, "lobes") == Row{"sampled", "refined", "sampled", "refined"});
  const auto pieces = column(rows, "visibility_pieces"), clusters = column(rows, "clusters");
  CHECK(pieces[0] == pieces[1]);
  CHECK(pieces[0] != pieces[2]);
  CHECK(clusters[1] > clusters[0]);
  const auto visibility = column(rows, "rel_rmse_visibility"), errors = column(rows, "rel_rmse");
  CHECK(visibility[0] == visibility[1]);
  CHECK(visibility[2] == visibility[3]);
  CHECK(visibility[0] != visibility[2]);
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(visibility[i] > 0);
    CHECK(visibility[i] < 0.1);
  }
  CHECK(errors[0] > visibility[0]);
  CHECK(errors[2] > visibility[2]);
  CHECK(errors[1] < errors[0]);
  CHECK(errors[3] < errors[2]);
}

TEST_CASE("the tolerance of lobes bounds what is refined") {
  const Workplace place;
  const auto clusters = [&](const std::string& tolerance) {
    return column(sweep(place, inputs + "--out trade.csv --points 2:16 --lobe-tolerance " + tolerance),
                  "clusters")[0];
  };
  CHECK(clusters("0.00005") > clusters("0.05"));
}

TEST_CASE("points can be named one by one, and written as images") {
  const Workplace place;
  REQUIRE(place.run("trade", inputs + "--out trade.csv --points 2:64 --images view").code == 0);
  CHECK(rows_of(files::get(place / "trade.csv")).size() == 2);
  for (const char* name :
       {"view_reference.exr", "view_reference.png", "view_sigma2_64_cosine-optimal_refined.exr",
        "view_sigma2_64_cosine-optimal_refined.png"})
    CHECK(place.made().contains(name));
}

TEST_CASE("a named point may name its cuts and lobes") {
  const Workplace place;
  const auto rows = sweep(
      place, inputs + "--out trade.csv --points 2:64,3:32:uniform-optimal,1.5:8:cosine-threshold:filtered");
  CHECK(words(rows, "cuts") == Row{"cosine-optimal", "uniform-optimal", "cosine-threshold"});
  CHECK(words(rows, "lobes") == Row{"refined", "refined", "filtered"});
  CHECK(column(rows, "sigma") == std::vector<double>{2, 3, 1.5});
  CHECK(column(rows, "cut_size") == std::vector<double>{64, 32, 8});
}

TEST_CASE("points that are none are refused") {
  const Workplace place;
  for (const std::string point :
       {"2-64", "2", "2:", ":64", "2:0", "2:-1", "2:6.5", "-1:64", "1001:64", "nan:64", "2:64:", "2:64:paper",
        "2:64:cosine-optimal:", "2:64:cosine-optimal:dull", "2:64:cosine-optimal:refined:9", "2:64x"})
    check_refused(place, "trade", inputs + "--out trade.csv --points=" + point, point);
}

TEST_CASE(
    "a target names the fastest point that is accurate enough, or the most accurate that is fast enough") {
  const Workplace place;
  const std::string arguments =
      inputs + "--out trade.csv --report trade.json --sigma 0.01,2 --cut-size 8,1024 ";
  const Outcome o = place.run("trade", arguments + "--target-error 1e-4 --target-ms 1e6");
  CAPTURE(o.err);
  REQUIRE(o.code == 0);
  const json picks = json::parse(files::get(place / "trade.json"))["picks"];
  REQUIRE(picks.size() == 2);
  for (const json& pick : picks) {  // one point alone has hardly an error
    CHECK(pick["point"]["sigma"] == 0.01);
    CHECK(pick["point"]["cut_size"] == 1024);
  }
  CHECK(o.out.find("\nrelRMSE of at most 0.01%: σ 0.01, 1024 nodes, cosine-optimal, refined: ") !=
        std::string::npos);
  CHECK(o.out.find("\na frame of at most 1e+06 ms: σ 0.01, 1024 nodes") != std::string::npos);
}

TEST_CASE("any error allows the fastest point") {
  const Workplace place;
  const Outcome o = place.run("trade", inputs +
                                           "--out trade.csv --report trade.json --sigma 0.01,4 "
                                           "--cut-size 8,1024 --target-error 100");
  REQUIRE(o.code == 0);
  const json report = json::parse(files::get(place / "trade.json"));
  for (const json& point : report["points"])
    CHECK(report["picks"][0]["point"]["milliseconds"] <= point["milliseconds"]);
}

TEST_CASE("a target that no point reaches is said so, and is no error") {
  const Workplace place;
  const Outcome o =
      place.run("trade", inputs +
                             "--out trade.csv --report trade.json --points 2:8 --target-error 0 "
                             "--target-ms 0");
  CHECK(o.code == 0);
  CHECK(o.out.find("relRMSE of at most 0%: no point measured reaches it") != std::string::npos);
  CHECK(o.out.find("a frame of at most 0 ms: no point measured reaches it") != std::string::npos);
  for (const json& pick : json::parse(files::get(place / "trade.json"))["picks"])
    CHECK(pick["point"].is_null());
}

TEST_CASE("trade refuses knobs outside their domains") {
  const Workplace place;
  for (const std::string bad :
       {"--cuts paper", "--cuts uniform-optimal,1", "--lobes dull", "--lobes 2", "--target-error nan",
        "--target-error -1", "--target-ms inf", "--target-ms -1", "--sigma 1,nan", "--cut-size 64,0"})
    check_refused(place, "trade", inputs + "--out trade.csv " + bad, bad.substr(0, bad.find(' ')));
}

namespace {

const std::string table_inputs = "--paper-table --scene scene.glb --size 48x36 --repeat 1 --out table.csv ";

/// The rows of --paper-table; each set of cuts by each tree has one.
std::vector<Row> paper_table(const Workplace& place, const std::string& arguments) {
  const Outcome o = place.run("trade", table_inputs + arguments);
  CAPTURE(o.err);
  REQUIRE(o.code == 0);
  CHECK(line_count(o.out) == 4);  // head, rule, and a row for each way of cutting
  const auto rows = rows_of(files::get(place / "table.csv"));
  REQUIRE(rows.size() == 17);  // 2 trees, 2 ways, 4 thresholds
  return rows;
}

/// Cells of the rows of which a predicate of (β, cuts, σ) is true.
template <class Wanted>
std::vector<double> where(const std::vector<Row>& rows, const std::string& name, const Wanted& wanted) {
  const auto betas = column(rows, "beta"), sigmas = column(rows, "sigma");
  const auto cuts = words(rows, "cuts"), cells = words(rows, name);
  std::vector<double> values;
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (wanted(betas[i], cuts[i], sigmas[i])) values.push_back(std::stod(cells[i]));
  return values;
}

/// What holds whatever lights the scene.
void check_paper_table(const std::vector<Row>& rows, double beta) {
  for (const double tree : {1.0, beta})
    for (const std::string way : {"uniform-threshold", "cosine-optimal"}) {
      CAPTURE(tree);
      CAPTURE(way);
      const auto of = [&](double b, const std::string& c, double) { return b == tree && c == way; };
      const auto pieces = where(rows, "visibility_pieces", of), rms = where(rows, "rms", of);
      REQUIRE(where(rows, "sigma", of) == std::vector<double>{2, 1, 1.5, 3});
      CHECK(pieces[1] > pieces[2]);
      CHECK(pieces[2] > pieces[0]);
      CHECK(pieces[0] > pieces[3]);
      CHECK(rms[1] < rms[2]);
      CHECK(rms[2] < rms[0]);
      CHECK(rms[0] < rms[3]);
      CHECK(rms[1] > 0);
      CHECK(rms[3] < 0.5);
      const auto first = [&](double b, const std::string& c, double s) { return of(b, c, s) && s == 2; };
      for (const std::string nodes : {"128", "256", "512"}) {
        CHECK(where(rows, "ms_" + nodes, first).at(0) > 0);
        CHECK(where(rows, "rel_rmse_" + nodes, first).at(0) < 0.2);
      }
      CHECK(where(rows, "file_bytes", first).at(0) > 0);
    }
}

/// The still life with a shining patch above it.
gltf_test::Builder lit_still_life() {
  gltf_test::Builder b = still_life();
  b.vec3s({-1, 3, -1, 1, 3, -1, 1, 3, 1, -1, 3, 1});
  b.indices({0, 1, 2, 0, 2, 3});
  b.meshes.insert(b.meshes.size() - 2, R"(,{"attributes":{"POSITION":3},"indices":4,"material":2})");
  b.members.insert(b.members.find("}}]") + 2, R"(,{"emissiveFactor":[1,1,1]})");
  return b;
}

}  // namespace

TEST_CASE("the paper's table compares the cuts of two trees under an environment") {
  const Workplace place;
  const auto rows = paper_table(place, "--env sky.hdr --light-count 1024 --beta 0.25 --report table.json");
  check_paper_table(rows, 0.25);
  CHECK(place.made() == std::set<std::string>{"table.csv", "table.json"});
  CHECK(words(rows, "lights") == Row(16, "env"));
  CHECK(words(rows, "light_count") == Row(16, "1024"));
  const json table = json::parse(files::get(place / "table.json"))["paper_table"];
  CHECK(table["data_driven"]["beta"] == 0.25);
  CHECK(table["geometric"]["cuts"].size() == 8);
  CHECK(table["geometric"]["cuts"][0]["frames"].size() == 3);
}

TEST_CASE("the paper's table is made of lights in the scene, and of their bounce") {
  const Workplace place;
  place.put("scene.glb", lit_still_life().glb());
  const auto direct = paper_table(place, "--lights scene --emitters 256");
  check_paper_table(direct, 0.5);
  CHECK(words(direct, "light_count") == Row(16, "256"));
  const auto bounce = paper_table(place, "--lights indirect --emitters 256 --bounces 512");
  check_paper_table(bounce, 0.5);
  CHECK(words(bounce, "light_count") == Row(16, "512"));
}

TEST_CASE("the paper's table has its own knobs, and needs something that shines") {
  const Workplace place;
  for (const std::string knob :
       {"--sigma 2", "--cut-size 64", "--cuts cosine-optimal", "--lobes sampled", "--points 2:64",
        "--visibility-only", "--target-error 1", "--target-ms 1", "--images view"})
    check_refused(place, "trade", table_inputs + "--env sky.hdr " + knob, knob.substr(0, knob.find(' ')));
  check_refused(place, "trade", table_inputs, "--env");
  check_refused(place, "trade", table_inputs + "--lights scene", "no lights and no shining surfaces");
  for (const std::string option : {"--lights scene", "--emitters 9", "--bounces 9"})
    check_refused(place, "trade", inputs + "--out trade.csv " + option, "--paper-table");
}
