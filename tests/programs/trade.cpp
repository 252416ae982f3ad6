// trade as a user runs it: one row a pair of knobs, a plot, a table.
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
    std::istringstream cells(line);
    for (rows.emplace_back(); std::getline(cells, line, ',');) rows.back().push_back(line);
  }
  return rows;
}

/// The values of a column, by its name in the first row.
std::vector<double> column(const std::vector<Row>& rows, const std::string& name) {
  const auto at = std::ranges::find(rows[0], name);
  REQUIRE(at != rows[0].end());
  std::vector<double> values;
  for (std::size_t i = 1; i < rows.size(); ++i)
    values.push_back(std::stod(rows[i][std::size_t(at - rows[0].begin())]));
  return values;
}

const std::string inputs = "--scene scene.glb --env sky.hdr --light-count 1024 --size 48x36 --repeat 1 ";

}  // namespace

TEST_CASE("a sweep writes a row for every pair of knobs, a plot, a report and a table") {
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
  const auto errors = column(rows, "rel_rmse");
  CHECK(errors[1] < 1e-5);
  CHECK(errors[0] > errors[1]);
  CHECK(errors[3] > errors[1]);
  for (const double speed : column(rows, "times_plain")) CHECK(speed > 0);
  CHECK(json::parse(files::get(place / "trade.json"))["points"].size() == 4);
  CHECK(o.out.find("relRMSE") != std::string::npos);
  CHECK(files::get(place / "trade.svg").find("<svg") != std::string::npos);
}

TEST_CASE("points can be named one by one, and written as images") {
  const Workplace place;
  REQUIRE(place.run("trade", inputs + "--out trade.csv --points 2:64 --images view").code == 0);
  CHECK(rows_of(files::get(place / "trade.csv")).size() == 2);
  for (const char* name :
       {"view_reference.exr", "view_reference.png", "view_sigma2_64.exr", "view_sigma2_64.png"})
    CHECK(place.made().contains(name));
  check_refused(place, "trade", inputs + "--out other.csv --points 2-64", "2-64");
}
