// A store is written whole or not at all.
#include <sys/resource.h>

#include <csignal>

#include "files.hpp"
#include "visibilities.hpp"

using namespace store_test;

namespace {

/// Files of this process can grow to so many bytes, as on a full disk, while one lives.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  void (*handler_)(int);
};

std::string message_of_write(const fs::path& path) {
  return refusal(path, [&] { write_store(path, small_visibility()); });
}

}  // namespace

TEST_CASE("a full disk leaves no file, and an old store as it was") {
  const Folder folder;
  {
    const FullDisk disk(5000);
    CHECK(contains(message_of_write(folder / "new.h5"), "cannot be written"));
  }
  CHECK(folder.count() == 0);
  StoredVisibility<std::uint8_t> old;
  old.settings = {{"old", "store"}};
  write_store(folder / "old.h5", old);
  {
    const FullDisk disk(5000);
    CHECK(contains(message_of_write(folder / "old.h5"), "cannot be written"));
  }
  CHECK(folder.count() == 1);
  CHECK(read_settings(folder / "old.h5") == old.settings);
  CHECK(message_of_write(folder / "old.h5") == "");
  CHECK(read_settings(folder / "old.h5") == small_visibility().settings);
}

TEST_CASE("what cannot be written to is refused and left alone") {
  const Folder folder;
  CHECK(contains(message_of_write(folder / "missing/a.h5"), "cannot be written"));
  CHECK(contains(message_of_write("/proc/self/a.h5"), "cannot be written"));  // nobody can, not even root
  CHECK(contains(message_of_write("/dev/full"), "no regular file"));
  fs::create_directory(folder / "folder");
  CHECK(contains(message_of_write(folder / "folder"), "no regular file"));
  CHECK_THROWS_AS(write_store("", small_visibility()), InputError);
  put(folder / "file", {});
  CHECK(contains(message_of_write(folder / "file/a.h5"), "cannot be written"));
  CHECK(folder.count() == 2);
}

TEST_CASE("what a crash left behind is neither read nor in the way") {
  const Folder folder;
  const std::vector<std::byte> half(1000, std::byte(1));
  put(folder / ".coppice-store-0.partial", half);
  write_store(folder / "a.h5", small_visibility());
  check_same(read_store<std::uint8_t>(folder / "a.h5"), small_visibility());
  CHECK(get(folder / ".coppice-store-0.partial") == half);
  CHECK(folder.count() == 2);
}

TEST_CASE("a link goes on linking") {
  const Folder folder;
  write_store(folder / "target.h5", StoredVisibility<std::uint8_t>());
  fs::create_symlink(folder / "target.h5", folder / "link.h5");
  write_store(folder / "link.h5", small_visibility());
  CHECK(fs::is_symlink(folder / "link.h5"));
  CHECK(read_settings(folder / "target.h5") == small_visibility().settings);
}

TEST_CASE("what is no file is refused by name") {
  const Folder folder;
  const auto message = [](const fs::path& path) {
    return refusal(path, [&] { read_store<std::uint8_t>(path); });
  };
  CHECK(contains(message(folder / "missing.h5"), "does not exist"));
  fs::create_directory(folder / "folder.h5");
  CHECK(contains(message(folder / "folder.h5"), "no regular file"));
  CHECK(contains(message("/dev/zero"), "no regular file"));
  CHECK_THROWS_AS(read_settings(""), InputError);
}
