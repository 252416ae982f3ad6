#include "file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string>
#include <system_error>

#include "refusal.hpp"

namespace coppice::store {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_at_once = std::size_t{1} << 30;

std::string last_error() { return std::generic_category().message(errno); }

Refusal cannot_write(const std::string& why) {
  return Refusal("cannot be written (" + why + ")", "check the folder, its permissions and its space");
}

class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() { close(); }

  operator int() const { return number_; }
  bool close() {
    const bool closed = number_ < 0 || ::close(number_) == 0;
    number_ = -1;
    return closed;
  }

 private:
  int number_;
};

/// A new file beside the target, removed unless it becomes the target.
class Temporary {
 public:
  explicit Temporary(const fs::path& target) : target_(target), descriptor_(open_new()) {
    if (descriptor_ < 0) throw cannot_write(last_error());
  }
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  ~Temporary() {
    if (!became_target_) ::unlink(path_.c_str());
  }

  void write(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
      const ssize_t written = ::write(descriptor_, bytes.data(), std::min(bytes.size(), most_at_once));
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) throw cannot_write(last_error());
      bytes = bytes.subspan(std::size_t(written));
    }
    if (::fsync(descriptor_) != 0 || !descriptor_.close()) throw cannot_write(last_error());
  }

  void become_target() {
    if (::rename(path_.c_str(), target_.c_str()) != 0) throw cannot_write(last_error());
    became_target_ = true;
    const fs::path folder = target_.has_parent_path() ? target_.parent_path() : fs::path(".");
    const Descriptor opened(::open(folder.c_str(), O_RDONLY | O_CLOEXEC));
    if (opened >= 0)
      ::fsync(opened);  // the name, too; where that cannot be done, the file is whole all the same
  }

 private:
  int open_new() {
    constexpr int attempts = 1000;
    for (int i = 0; i < attempts; ++i) {
      path_ = target_.parent_path() / (".coppice-store-" + std::to_string(i) + ".partial");
      const int number = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
      if (number >= 0 || errno != EEXIST) return number;
    }
    return -1;
  }

  fs::path target_, path_;
  Descriptor descriptor_;
  bool became_target_ = false;
};

/// The file that `path` means, through links. A directory or a device is never replaced.
fs::path target_of(const fs::path& path) {
  if (!path.has_filename()) throw Refusal("names no file", "name a file to write");
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) return path;
  if (!fs::is_regular_file(status)) throw Refusal("exists and is no regular file", "name another file");
  const fs::path target = fs::canonical(path, error);
  if (error) throw cannot_write(error.message());
  return target;
}

}  // namespace

Bytes read_bytes(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) throw Refusal("does not exist", "check the name");
  if (!fs::is_regular_file(status)) throw Refusal("is no regular file", "name a store");
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  const std::uintmax_t size = fs::file_size(path, error);
  if (file < 0 || error) throw Refusal("cannot be read", "check its permissions");
  Bytes bytes(size);
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t got = ::read(file, bytes.data() + done, std::min(bytes.size() - done, most_at_once));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) throw Refusal("cannot be read whole", "try again");
    done += std::size_t(got);
  }
  return bytes;
}

void write_whole(const fs::path& path, std::span<const std::byte> bytes) {
  const fs::path target = target_of(path);
  Temporary temporary(target);
  temporary.write(bytes);
  temporary.become_target();
}

}  // namespace coppice::store
