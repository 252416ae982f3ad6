#include <cerrno>
#include <coppice/exr/write_file.hpp>
#include <cstdio>
#include <memory>
#include <string>
#include <system_error>

#include "refusal.hpp"

namespace coppice {
namespace {

namespace fs = std::filesystem;
using exr::Refusal;

Refusal cannot(const std::string& what, const std::error_code& error) {
  return Refusal("cannot " + what + " (" + error.message() + ")",
                 "check the directory, its permissions and its space");
}

std::error_code last_error() { return {errno, std::generic_category()}; }

/// The file that `path` means, through links. What is no regular file (a directory, a device) is never
/// replaced.
fs::path resolve(const fs::path& path) {
  if (!path.has_filename()) throw Refusal("names no file", "name a file to write");
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) return path;
  if (!fs::is_regular_file(status)) throw Refusal("exists and is not a regular file", "name another file");
  return fs::canonical(path);
}

struct Close {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using Stream = std::unique_ptr<std::FILE, Close>;

/// A new file of its own beside the target; its destructor removes it unless it has become the target.
class Temporary {
 public:
  explicit Temporary(const fs::path& target) {
    constexpr int attempts = 1000;
    for (int i = 0; i < attempts && !stream_; ++i) {
      path_ = target.parent_path() / (".coppice-" + std::to_string(i) + ".partial");
      stream_.reset(std::fopen(path_.c_str(), "wbx"));
      if (!stream_ && errno != EEXIST) break;
    }
    if (!stream_) throw cannot("be written", last_error());
  }
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  ~Temporary() {
    stream_.reset();
    std::error_code ignored;
    if (!renamed_) fs::remove(path_, ignored);
  }

  void write(std::string_view bytes) {
    const bool written = std::fwrite(bytes.data(), 1, bytes.size(), stream_.get()) == bytes.size();
    if (!written || std::fflush(stream_.get()) != 0) throw cannot("be written whole", last_error());
    if (std::fclose(stream_.release()) != 0) throw cannot("be written whole", last_error());
  }

  void become(const fs::path& target) {
    std::error_code error;
    fs::rename(path_, target, error);
    if (error) throw cannot("be put in place", error);
    renamed_ = true;
  }

 private:
  fs::path path_;
  Stream stream_;
  bool renamed_ = false;
};

}  // namespace

void write_file(const fs::path& path, std::string_view bytes) {
  exr::naming(path, [&] {
    const fs::path target = resolve(path);
    Temporary temporary(target);
    temporary.write(bytes);
    temporary.become(target);
  });
}

}  // namespace coppice
