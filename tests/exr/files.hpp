// Files for the tests: a directory that goes away, and its contents.
#pragma once

#include <doctest/doctest.h>

#include <coppice/core/error.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <string_view>
#include <vector>

namespace files {

namespace fs = std::filesystem;

/// An empty directory that is removed, with what it holds, at the end of the scope.
class Directory {
 public:
  Directory() {
    std::random_device seed;
    do path_ = fs::temp_directory_path() / ("coppice-exr-test-" + std::to_string(seed()));
    while (!fs::create_directory(path_));
  }
  Directory(const Directory&) = delete;
  Directory& operator=(const Directory&) = delete;
  ~Directory() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }

  fs::path operator/(const std::string& name) const { return path_ / name; }

  std::size_t count() const {
    return std::size_t(std::distance(fs::directory_iterator(path_), fs::directory_iterator()));
  }

 private:
  fs::path path_;
};

/// A new file each time: to truncate an old one can make the file system wait for the disk.
inline fs::path put(const fs::path& path, std::string_view bytes) {
  fs::remove(path);
  std::ofstream(path, std::ios::binary).write(bytes.data(), std::streamsize(bytes.size()));
  return path;
}

inline std::string get(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// The message of the InputError that body() throws: checked to be one line that names the file; "" if none
/// came.
template <class Body>
std::string refusal(const fs::path& path, Body&& body) {
  try {
    body();
  } catch (const coppice::InputError& error) {
    const std::string message = error.what();
    CHECK(message.find(path.filename().string()) != std::string::npos);
    CHECK(message.find('\n') == std::string::npos);
    return message;
  }
  return "";
}

inline bool contains(std::string_view text, std::string_view part) {
  return text.find(part) != std::string_view::npos;
}

}  // namespace files
