// --store: what all programs do with a file that one run leaves for the next.
#pragma once

#include <coppice/scene/scene.hpp>
#include <coppice/store/fingerprint.hpp>
#include <coppice/store/settings.hpp>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace coppice::program {

template <class T>
std::span<const T> all(const std::vector<T>& values) {
  return values;
}

/// Triangles and where their materials lie.
void add_mesh(Fingerprint& fingerprint, const Mesh& mesh);

/// What was done with a store, and why: told on stderr at once, and in the report.
class StoreNote {
 public:
  /// Whether there is a file that was made with these settings. Where there is none, tells why not. Throws
  /// InputError where the file is damaged or no store, so that nobody's file is lost. `read` is read_settings
  /// or its like.
  bool fits(const std::filesystem::path& file, const Settings& wanted,
            Settings (*read)(const std::filesystem::path&));
  /// After the whole was read.
  void tell_reused(const std::filesystem::path& file);

  /// Empty without a store.
  const std::string& text() const { return text_; }

 private:
  void say(const std::string& text);

  std::string text_;
};

}  // namespace coppice::program
