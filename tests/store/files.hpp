// Files for the tests: a folder that goes away, and what a reader says of a file.
#pragma once

#include <doctest/doctest.h>

#include <coppice/core/error.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace store_test {

namespace fs = std::filesystem;

/// An empty folder that is removed, with what it holds, at the end of the scope.
class Folder {
 public:
  Folder() {
    std::random_device seed;
    do path_ = fs::temp_directory_path() / ("coppice-store-test-" + std::to_string(seed()));
    while (!fs::create_directory(path_));
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() {
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

inline fs::path put(const fs::path& path, std::span<const std::byte> bytes) {
  fs::remove(path);
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
  return path;
}

inline std::vector<std::byte> get(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::vector<std::byte> bytes;
  for (std::istreambuf_iterator<char> i(in), end; i != end; ++i) bytes.push_back(std::byte(*i));
  return bytes;
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
    CHECK_FALSE(error.remedy().empty());
    return message;
  }
  return "";
}

inline bool contains(std::string_view text, std::string_view part) {
  return text.find(part) != std::string_view::npos;
}

}  // namespace store_test
