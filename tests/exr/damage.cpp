#include <coppice/exr/read.hpp>
#include <coppice/exr/write.hpp>

#include "exr_bytes.hpp"
#include "files.hpp"
#include "hdr_bytes.hpp"

using namespace coppice;

namespace {

std::string compressed_exr() {
  const files::Directory directory;
  Image image(3, 18);
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    image.pixels[i] = vec3(float(i * i % 97), float(i), 0.5f);
  const std::vector<float> coverage(image.pixels.size(), 1.0f);
  write_exr(directory / "a.exr", 3, 18, {{"", image}, {"A", coverage}});
  return files::get(directory / "a.exr");
}

std::string plain_exr(int tile, bool many_parts) {
  using exr_bytes::Type;
  const auto value = [](int x, int y) { return float(x * y); };
  const exr_bytes::Window window{0, 0, 4, 3};
  const exr_bytes::Part colour{window,
                               window,
                               {{"B", Type::half, value}, {"G", Type::half, value}, {"R", Type::half, value}},
                               tile,
                               "colour"};
  const exr_bytes::Part mask{window, window, {{"M", Type::real, value}}, 0, "mask"};
  return many_parts ? exr_bytes::file_bytes({mask, colour}) : exr_bytes::file_bytes({colour});
}

std::string hdr(auto&& encode) {
  hdr_bytes::Row row(20, hdr_bytes::Rgbe{100, 50, 25, 130});
  row[7] = {1, 2, 3, 140};
  return hdr_bytes::header("-Y 3 +X 20", "EXPOSURE=2\n") + encode(row) + encode(row) + encode(row);
}

struct Sample {
  const char* name;
  std::string bytes;
};

std::vector<Sample> samples() {
  return {{"compressed.exr", compressed_exr()},  {"scanlines.exr", plain_exr(0, false)},
          {"tiles.exr", plain_exr(2, false)},    {"parts.exr", plain_exr(2, true)},
          {"flat.hdr", hdr(hdr_bytes::flat)},    {"old.hdr", hdr(hdr_bytes::old_style)},
          {"new.hdr", hdr(hdr_bytes::new_style)}};
}

/// Reads in every way; true where an image came out. Anything but an image or an InputError ends the test.
bool survives(const std::filesystem::path& path) {
  bool read = false;
  const std::string message = files::refusal(path, [&] {
    const Image image = read_image(path);
    REQUIRE(image.width > 0);
    REQUIRE(image.height > 0);
    REQUIRE(image.pixels.size() == std::size_t(image.width) * std::size_t(image.height));
    read = true;
  });
  CHECK(read == message.empty());
  if (path.extension() == ".exr") files::refusal(path, [&] { read_channel(path, "R"); });
  return read;
}

}  // namespace

TEST_CASE("a file cut short anywhere is refused") {
  const files::Directory directory;
  for (const Sample& sample : samples()) {
    CAPTURE(sample.name);
    CHECK(survives(files::put(directory / sample.name, sample.bytes)));
    for (std::size_t length = 0; length < sample.bytes.size(); ++length) {
      CAPTURE(length);
      CHECK_FALSE(survives(files::put(directory / sample.name, sample.bytes.substr(0, length))));
    }
  }
}

TEST_CASE("a file with one bit flipped gives an image or an InputError") {
  const files::Directory directory;
  for (const Sample& sample : samples()) {
    CAPTURE(sample.name);
    std::size_t refused = 0;
    for (std::size_t byte = 0; byte < std::min<std::size_t>(sample.bytes.size(), 600); ++byte)
      for (std::size_t bit = 0; bit < 8; ++bit) {
        CAPTURE(byte);
        CAPTURE(bit);
        std::string bytes = sample.bytes;
        bytes[byte] = char(bytes[byte] ^ (1 << bit));
        refused += !survives(files::put(directory / sample.name, bytes));
      }
    CHECK(refused >= 4);  // the magic numbers alone have as many
  }
}

TEST_CASE("a file with bits flipped at random gives an image or an InputError") {
  const files::Directory directory;
  std::mt19937 random(20240611);
  for (const Sample& sample : samples()) {
    CAPTURE(sample.name);
    for (int trial = 0; trial < 1500; ++trial) {
      CAPTURE(trial);
      std::string bytes = sample.bytes;
      for (unsigned flips = 1 + random() % 8; flips > 0; --flips) {
        char& byte = bytes[random() % bytes.size()];
        byte = char(byte ^ (1 << random() % 8));
      }
      survives(files::put(directory / sample.name, bytes));
    }
  }
}

TEST_CASE("a table of offsets that was never completed is refused, not filled with black") {
  const files::Directory directory;
  std::string bytes = plain_exr(0, false);
  const std::size_t first_chunk = bytes.size() - 4 * (8 + 5 * 3 * 2);
  for (std::size_t i = first_chunk - 8; i < first_chunk; ++i) bytes[i] = '\0';
  const auto path = files::put(directory / "a.exr", bytes);
  CHECK(files::contains(files::refusal(path, [&] { read_image(path); }), "truncated"));
}

TEST_CASE("what is no image file is refused by name, whatever its extension says") {
  const files::Directory directory;
  const auto message = [&](const std::string& name) {
    return files::refusal(directory / name, [&] { read_image(directory / name); });
  };
  CHECK(files::contains(message("missing.exr"), "does not exist"));
  CHECK(files::contains(message("missing/missing.hdr"), "does not exist"));
  std::filesystem::create_directory(directory / "directory.exr");
  CHECK(files::contains(message("directory.exr"), "is a directory"));
  files::put(directory / "empty.hdr", "");
  CHECK(files::contains(message("empty.hdr"), "is empty"));
  files::put(directory / "text.exr", "just text");
  CHECK(files::contains(message("text.exr"), "neither"));
  files::put(directory / "right.bin", plain_exr(0, false));
  CHECK(message("right.bin").empty());
  files::put(directory / "swapped.exr", hdr(hdr_bytes::flat));
  CHECK(message("swapped.exr").empty());
  const auto radiance = directory / "swapped.exr";
  CHECK(files::contains(files::refusal(radiance, [&] { read_channel(radiance, "R"); }), "not an OpenEXR"));
}
