#include <cmath>
#include <coppice/exr/read.hpp>

#include "files.hpp"
#include "hdr_bytes.hpp"

using namespace coppice;
using namespace hdr_bytes;

namespace {

vec3 expected(const Rgbe& p) {
  if (p[3] == 0) return vec3(0);
  return vec3(std::ldexp(p[0], p[3] - 136), std::ldexp(p[1], p[3] - 136), std::ldexp(p[2], p[3] - 136));
}

/// Rows with runs of many lengths, and with the extremes of the exponent.
std::vector<Row> sample_rows(std::size_t width, std::size_t height) {
  std::vector<Row> rows(height, Row(width));
  for (std::size_t y = 0; y < height; ++y)
    for (std::size_t x = 0; x < width; ++x) {
      const std::size_t k = x * x / (7 * width) + y;
      rows[y][x] = {std::uint8_t(200 + k % 50), std::uint8_t(3 + k), std::uint8_t(x % 5),
                    std::uint8_t(120 + k % 20)};
    }
  rows[0][0] = {255, 128, 1, 255};
  rows[0][1] = {255, 255, 255, 0};
  rows[0][2] = {255, 128, 1, 1};
  return rows;
}

template <class Encode>
void check_encoding(std::size_t width, Encode&& encode) {
  const files::Directory directory;
  const std::vector<Row> rows = sample_rows(width, 3);
  std::string bytes = header("-Y 3 +X " + std::to_string(width));
  for (const Row& row : rows) bytes += encode(row);
  const Image image = read_image(files::put(directory / "a.hdr", bytes));
  REQUIRE(image.width == int(width));
  REQUIRE(image.height == 3);
  for (std::size_t y = 0; y < 3; ++y)
    for (std::size_t x = 0; x < width; ++x) CHECK(image.at(int(x), int(y)) == expected(rows[y][x]));
}

std::string message_of(const std::string& bytes) {
  const files::Directory directory;
  const auto path = files::put(directory / "bad.hdr", bytes);
  return files::refusal(path, [&] { read_image(path); });
}

}  // namespace

TEST_CASE("every encoding of a Radiance file is read") {
  for (const std::size_t width : {3u, 7u, 8u, 300u, 1000u}) {
    CAPTURE(width);
    check_encoding(width, flat);
    check_encoding(width, old_style);
    if (width >= 8) check_encoding(width, new_style);
  }
}

TEST_CASE("rows of one file may differ in encoding, and a long run fills more than 256 pixels") {
  const files::Directory directory;
  const Row row(700, Rgbe{10, 20, 30, 130});
  const std::string bytes = header("-Y 3 +X 700") + new_style(row) + old_style(row) + flat(row);
  const Image image = read_image(files::put(directory / "a.hdr", bytes));
  for (const vec3& pixel : image.pixels) CHECK(pixel == expected(row[0]));
}

TEST_CASE("every orientation of a Radiance file is turned upright") {
  const files::Directory directory;
  const auto value = [](int x, int y) { return Rgbe{std::uint8_t(100 + x), std::uint8_t(100 + y), 0, 136}; };
  const int width = 4, height = 3;
  for (const bool columns : {false, true})
    for (const char x_sign : {'+', '-'})
      for (const char y_sign : {'+', '-'}) {
        const std::string x_axis = std::string{x_sign} + "X 4", y_axis = std::string{y_sign} + "Y 3";
        const std::string resolution = columns ? x_axis + " " + y_axis : y_axis + " " + x_axis;
        CAPTURE(resolution);
        std::string bytes = header(resolution);
        for (int s = 0; s < (columns ? width : height); ++s)
          for (int p = 0; p < (columns ? height : width); ++p) {
            const int along_x = columns ? s : p, along_y = columns ? p : s;
            const int x = x_sign == '+' ? along_x : width - 1 - along_x;
            const int y = y_sign == '-' ? along_y : height - 1 - along_y;
            bytes += pixel(value(x, y));
          }
        const Image image = read_image(files::put(directory / "a.hdr", bytes));
        REQUIRE(image.width == width);
        REQUIRE(image.height == height);
        for (int y = 0; y < height; ++y)
          for (int x = 0; x < width; ++x) CHECK(image.at(x, y) == vec3(100 + x, 100 + y, 0));
      }
}

TEST_CASE("every EXPOSURE line of a Radiance file divides") {
  const files::Directory directory;
  const std::string bytes =
      header("-Y 1 +X 1", "EXPOSURE=4\nVIEW= -vtv\nEXPOSURE= 0.5\r\n") + pixel({100, 50, 25, 136});
  CHECK(read_image(files::put(directory / "a.hdr", bytes)).pixels[0] == vec3(50, 25, 12.5));
}

TEST_CASE("a Radiance file that breaks its format is refused with the reason") {
  const std::string start = header("-Y 1 +X 8");
  const std::string new_row{2, 2, 0, 8};
  CHECK(files::contains(message_of("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\nabcd"), "xyze"));
  CHECK(files::contains(message_of(header("-Y 1 +X 1", "EXPOSURE=0\n") + "abcd"), "EXPOSURE"));
  CHECK(files::contains(message_of(header("-Y 1 +X 1", "EXPOSURE=nan\n") + "abcd"), "EXPOSURE"));
  CHECK(files::contains(message_of(header("-Y 1 +X 1", "EXPOSURE=1e30\nEXPOSURE=1e30\n") + "abcd"),
                        "EXPOSURE"));
  CHECK(files::contains(message_of(start + new_row + std::string{char(137), 1}), "run"));
  CHECK(files::contains(message_of(start + new_row + std::string{0, 1}), "run"));
  CHECK(files::contains(message_of(start + std::string{2, 2, 0, 9} + flat(Row(8))), "length"));
  CHECK(files::contains(message_of(start + pixel({1, 1, 1, 8}) + flat(Row(8))), "run"));
  CHECK(files::contains(message_of(start + pixel({9, 9, 9, 9}) + pixel({1, 1, 1, 8}) + flat(Row(8))), "run"));
  const std::string nothing = pixel({1, 1, 1, 0});
  std::string endless = start + pixel({9, 9, 9, 9});
  for (int i = 0; i < 70; ++i) endless += nothing;
  CHECK(files::contains(message_of(endless), "run"));
}

TEST_CASE("an absurd size of a Radiance file is refused") {
  for (const char* resolution : {"-Y 0 +X 8", "-Y -1 +X 8", "-Y 2147483647 +X 2147483647",
                                 "-Y 100000 +X 100000", "-Y 99999999999999999999 +X 1", "-Y 268435456 +X 1",
                                 "-Y 8", "-Y 8 +Y 8", "-Y 8 +X", "-Y 1 +X 1 1", "", "8 8"}) {
    CAPTURE(resolution);
    CHECK(!message_of(header(resolution) + std::string(64, 'a')).empty());
  }
}
