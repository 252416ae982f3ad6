// scripts/read_store.py, which needs h5py only.
#include <cstdio>
#include <cstdlib>

#include "files.hpp"
#include "rooms.hpp"
#include "visibilities.hpp"

using namespace store_test;

namespace {

/// A Python with h5py; "" where there is none.
std::string python() {
  for (const std::string name : {"python3", "/usr/bin/python3"})
    if (std::system((name + " -c 'import h5py' 2>/dev/null").c_str()) == 0) return name;
  return "";
}

std::string output_of(const std::string& command) {
  std::string output;
  std::FILE* pipe = popen(command.c_str(), "r");
  REQUIRE(pipe);
  for (int c; (c = std::fgetc(pipe)) != EOF;) output += char(c);
  CHECK(pclose(pipe) == 0);
  return output;
}

}  // namespace

TEST_CASE("h5py reads a store: the script prints the cut of a receiver") {
  const std::string interpreter = python();
  if (interpreter.empty()) {
    std::puts("SKIPPED: no h5py here (Debian: python3-h5py)");
    return;
  }
  const Folder folder;
  const auto check = [&]<class Value>(const StoredVisibility<Value>& v) {
    write_store(folder / "a.h5", v);
    const std::string output =
        output_of(interpreter + " " COPPICE_SOURCE_DIR "/scripts/read_store.py --receiver 5 " +
                  (folder / "a.h5").string());
    CHECK(contains(output, "scene = 0123abcd"));
    CHECK(contains(output, "sigma = 2"));
    CHECK(contains(output, "cuts/mask"));
    const Cut<Value> cut = v.cuts.unpack(5);
    std::uint32_t begin = 0;
    for (std::size_t i = 0; i < cut.size(); begin = cut.ends[i], ++i) {
      char line[80];
      std::snprintf(line, sizeof line, "leaves %u to %u: %.4f\n", begin, cut.ends[i],
                    double(cut.values[i]) / double(quantised_one<Value>));
      CAPTURE(line);
      CHECK(contains(output, line));
    }
  };
  check(small_visibility());
  check(random_visibility<std::uint16_t>(8, 64, refined_mesh(20), 0));
}

TEST_CASE("h5py reads a room: the script prints its settings and bytes") {
  const std::string interpreter = python();
  if (interpreter.empty()) {
    std::puts("SKIPPED: no h5py here (Debian: python3-h5py)");
    return;
  }
  const Folder folder;
  write_room(folder / "a.h5", small_room());
  const std::string output =
      output_of(interpreter + " " COPPICE_SOURCE_DIR "/scripts/read_store.py " + (folder / "a.h5").string());
  for (const char* text : {"checksum matches", "sample_count: 14", "scene = 0123abcd", "bytes a sample",
                           "visibility/coefficient", "int8"})
    CHECK(contains(output, text));
}
