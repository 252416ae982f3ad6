// trade pca_transfer as a user runs it: a row for each way, judged by lights that no basis was made for.
#include <sstream>

#include "programs/pca_studio.hpp"

using namespace coppice;
using namespace program_test;
using nlohmann::json;

namespace {

std::string arguments_of(std::string arguments) {
  for (const std::string usual : {"--out trade.csv", "--unseen 6", "--frame-lights 2"})
    if (arguments.find(usual.substr(0, usual.find(' ') + 1)) == std::string::npos) arguments += " " + usual;
  return "pca_transfer " + PcaStudio::with_usual(arguments);
}

Outcome sweep(const PcaStudio& place, const std::string& arguments) {
  const Outcome o = place.run("trade", arguments_of("--report report.json " + arguments));
  CAPTURE(arguments);
  CAPTURE(o.err);
  REQUIRE(o.code == 0);
  return o;
}

/// The row of a setting in a report.
json row(const json& report, const std::string& kind, const std::string& setting) {
  for (const json& r : report["rows"])
    if (r["kind"] == kind && r["setting"] == setting) return r;
  FAIL_CHECK("no row " << kind << " " << setting);
  return {};
}

/// Everything but times.
json without_times(json report) {
  for (json& room : report["rooms"]) room.erase("seconds");
  for (json& r : report["rows"]) r.erase("seconds"), r.erase("milliseconds");
  report["settings"].erase("threads");
  return report;
}

}  // namespace

TEST_CASE("a sweep of a room's bases writes a row for every setting, a plot, pictures and tables") {
  const PcaStudio place;
  std::filesystem::create_directory(place / "pictures");
  const Outcome o = sweep(place,
                          "--pictures pictures --visibility lattice:20,depth:10,rays --basis "
                          "transport:10,uncentred:10:sparse=1:bits=16");
  CHECK(place.made() == std::set<std::string>{"trade.csv", "trade.svg", "report.json", "pictures"});
  CHECK(std::filesystem::exists(place / "pictures/clusters.png"));
  CHECK(std::filesystem::exists(place / "pictures/basis_vectors.png"));
  // Three kinds of shadows, two transfers, frames of all shadows with the first and of both with the first.
  const std::string csv = files::get(place / "trade.csv");
  CHECK(line_count(csv) == 1 + 3 + 2 + 3 + 1);
  std::istringstream lines(csv);
  for (std::string line; std::getline(lines, line);) CHECK(std::ranges::count(line, ',') == 18);
  CHECK(files::get(place / "trade.svg").find("<svg") != std::string::npos);
  for (const char* part : {"| lattice:20 |", "| transport:10 |", "| rays transport:10 |", "6 clusters"})
    CHECK_MESSAGE(o.out.find(part) != std::string::npos, part);
  CHECK(place.report()["rows"].size() == 9);
}

TEST_CASE("rays make no wrong decision, and more vectors fewer") {
  const PcaStudio place;
  sweep(place,
        "--unseen 20 --visibility rays,lattice:2,lattice:40,lattice:40:bits=16,depth:50,depth:50:sphere "
        "--basis none");
  const json report = place.report();
  const auto wrong = [&](const std::string& setting) {
    return row(report, "visibility", setting)["wrong_decisions"]["plain"].get<double>();
  };
  CHECK(wrong("rays") == 0);
  CHECK(row(report, "visibility", "rays")["bytes"] == 0);
  CHECK(row(report, "visibility", "rays")["direct"]["rel_rmse"] < 1e-3);
  CHECK(wrong("lattice:2") > wrong("lattice:40"));
  CHECK(wrong("lattice:40") < 0.15);
  CHECK(wrong("lattice:40") > 0);
  CHECK(wrong("depth:50") < 0.15);
  CHECK(wrong("depth:50:sphere") < 0.15);
  CHECK(std::abs(wrong("lattice:40") - wrong("lattice:40:bits=16")) < 0.01);
  const json narrow = row(report, "visibility", "lattice:40"),
             wide = row(report, "visibility", "lattice:40:bits=16");
  CHECK(wide["bytes"] > 1.5 * narrow["bytes"].get<double>());
  CHECK(narrow["wrong_decisions"]["pairs"] > 0);
  CHECK(narrow["milliseconds"]["visibility"] >= 0);
}

TEST_CASE("what the paper leaves out is most of the error, and patterns are few beside entries") {
  const PcaStudio place;
  sweep(place,
        "--unseen 20 --visibility none --basis paper:20,paper:20:no-mean,transport:2,transport:20,"
        "transport:20:patterns=100:bits=16,transport:20:sparse=1:bits=16,transport:20:sparse=0.05");
  const json report = place.report();
  const auto error = [&](const std::string& setting) {
    return row(report, "transfer", setting)["indirect"]["rel_rmse"].get<double>();
  };
  const auto bytes = [&](const std::string& setting) {
    return row(report, "transfer", setting)["bytes"].get<double>();
  };
  CHECK(error("paper:20:no-mean") > 2 * error("paper:20"));
  CHECK(error("transport:2") > error("transport:20"));
  CHECK(error("transport:20") < 0.2);
  // As many patterns as samples, and all entries: the same matrix in two forms.
  CHECK(error("transport:20:patterns=100:bits=16") ==
        doctest::Approx(error("transport:20:sparse=1:bits=16")).epsilon(0.02));
  CHECK(error("transport:20:sparse=0.05") > error("transport:20:sparse=1:bits=16"));
  CHECK(bytes("transport:20:sparse=1:bits=16") > 4 * bytes("transport:20"));
  for (const json& r : report["rows"]) CHECK(r["kind"] == "transfer");
}

TEST_CASE("rooms of several sizes are judged by the same lights") {
  const PcaStudio place;
  sweep(place,
        "--surface-samples 300,900 --clusters 2,6 --visibility lattice:20 --basis transport:10 --unseen 3 "
        "--frame-lights 1");
  const json report = place.report();
  REQUIRE(report["rooms"].size() == 4);
  CHECK(report["rooms"][0]["clusters"] == 2);
  CHECK(report["rooms"][3]["clusters"] == 6);
  CHECK(report["rooms"][0]["samples"] < report["rooms"][3]["samples"]);
  CHECK(report["rows"].size() == 4 * 3);
}

TEST_CASE("one thread and two measure the same errors") {
  const PcaStudio place;
  const std::string settings = "--visibility lattice:10,depth:10 --basis paper:5 --light-size 0.1 --threads ";
  sweep(place, settings + "1");
  const json one = place.report();
  sweep(place, settings + "2");
  CHECK(without_times(place.report()) == without_times(one));
}

TEST_CASE("trade pca_transfer refuses settings that are none") {
  const PcaStudio place;
  for (const std::string bad :
       {"lattice:", "lattice:0", "lattice:20:30", "lattice:20:points=2", "lattice:20:bits=12", "lattice:x",
        "lattice:20:plain", "depth:50:smooth", "depth:50:intervals=-1", "depth:50:directions=4", "rays:20",
        "rays:bits=8", "guess", "none,rays"})
    check_refused(place, "trade", arguments_of("--visibility " + bad), "--visibility");
  for (const std::string bad :
       {"transport", "transport:0", "transport:20:patterns=0", "transport:20:no-mean", "uncentred:20:no-mean",
        "paper:10:sparse=2", "paper:10:sparse=nan", "paper:10:sparse", "paper:x", "fourier:20",
        "transport:20:bits=7", "transport:20:20", "none,transport:20"})
    check_refused(place, "trade", arguments_of("--basis " + bad), "--basis");
  for (const std::string bad :
       {"--unseen 0", "--frame-lights -1", "--light-size nan", "--surface-samples 600,0", "--clusters 0",
        "--through 0,1,0", "--path a.json", "--store a.h5"})
    check_refused(place, "trade", arguments_of(bad), bad.substr(0, bad.find(' ')));
  check_refused(place, "trade", arguments_of("--pictures nowhere"), "nowhere");
  check_refused(place, "trade", "pca_transfer --scene room.glb", "--out");
  check_refused(place, "trade", arguments_of("--pictures . --basis none"), "--pictures");
}
