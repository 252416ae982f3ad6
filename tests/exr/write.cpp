#include <sys/resource.h>
#include <sys/stat.h>

#include <coppice/exr/read.hpp>
#include <coppice/exr/tone_map.hpp>
#include <coppice/exr/write.hpp>
#include <coppice/exr/write_file.hpp>
#include <csignal>
#include <limits>

#include "files.hpp"

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#include <stb/stb_image.h>

using namespace coppice;

namespace {

constexpr float denormal = std::numeric_limits<float>::denorm_min();

Image extremes(int width, int height) {
  const float values[] = {0,     1e30f, denormal, 1.0f / 3, -2.5f, std::numeric_limits<float>::max(),
                          65504, 1e-38f};
  Image image(width, height);
  std::size_t next = 0;
  for (vec3& pixel : image.pixels)
    for (int c = 0; c < 3; ++c) pixel[c] = values[next++ % std::size(values)];
  return image;
}

/// While it lives, files cannot grow beyond `bytes`: writes fail as on a full disk.
class SmallDisk {
 public:
  explicit SmallDisk(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit small{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &small);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  ~SmallDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  void (*handler_)(int);
  rlimit before_{};
};

}  // namespace

TEST_CASE("what is written is read back to the bit") {
  const files::Directory directory;
  const auto path = directory / "a.exr";
  const int sizes[][2] = {{1, 1}, {1, 40}, {40, 1}, {33, 17}};
  for (const auto& [width, height] : sizes) {
    const Image colour = extremes(width, height);
    Image reference = colour;
    for (vec3& pixel : reference.pixels) pixel = vec3(pixel.z, 7, pixel.x);
    std::vector<float> coverage(colour.pixels.size()), cut_size(colour.pixels.size());
    for (std::size_t i = 0; i < cut_size.size(); ++i) {
      coverage[i] = float(i % 2);
      cut_size[i] = i % 3 ? float(100 + i) : denormal;
    }
    write_exr(path, width, height,
              {{"", colour}, {"A", coverage}, {"reference", reference}, {"cut_size.Y", cut_size}});
    const Image back = read_image(path);
    REQUIRE(back.width == width);
    REQUIRE(back.height == height);
    CHECK(back.pixels == colour.pixels);
    CHECK(read_channel(path, "A").values == coverage);
    CHECK(read_channel(path, "cut_size.Y").values == cut_size);
    const Channel blue = read_channel(path, "reference.B");
    CHECK(blue.width == width);
    CHECK(blue.height == height);
    for (std::size_t i = 0; i < blue.values.size(); ++i) CHECK(blue.values[i] == reference.pixels[i].z);
  }
  CHECK(directory.count() == 1);
}

TEST_CASE("NaN and infinity are written and read as they are, but make no environment") {
  const files::Directory directory;
  const auto path = directory / "a.exr";
  const float infinity = std::numeric_limits<float>::infinity();
  const Image image(2, 1, vec3(std::numeric_limits<float>::quiet_NaN(), infinity, -infinity));
  write_exr(path, 2, 1, {{"", image}});
  const Image back = read_image(path);
  CHECK(std::isnan(back.pixels[1].x));
  CHECK(back.pixels[1].y == infinity);
  CHECK(back.pixels[1].z == -infinity);
  CHECK(files::contains(files::refusal(path, [&] { read_environment(path); }), "pixel (0, 0)"));
}

TEST_CASE("layers keep their names") {
  const files::Directory directory;
  const Image image(2, 2);
  const std::vector<float> values(4);
  write_exr(directory / "a.exr", 2, 2,
            {{"", image}, {"A", values}, {"error", image}, {"cut_size.Y", values}});
  const std::vector<std::string> names{"A", "B", "G", "R", "cut_size.Y", "error.B", "error.G", "error.R"};
  CHECK(read_channel_names(directory / "a.exr") == names);
  const std::string bytes = files::get(directory / "a.exr");
  for (const std::string& name : names) CHECK(files::contains(bytes, '\0' + name + '\0'));
}

TEST_CASE("equal images give equal files") {
  const files::Directory directory;
  const Image image = extremes(21, 34);
  write_exr(directory / "a.exr", 21, 34, {{"", image}});
  write_exr(directory / "b.exr", 21, 34, {{"", image}});
  CHECK(files::get(directory / "a.exr") == files::get(directory / "b.exr"));
}

TEST_CASE("a write that fails leaves nothing behind, and the old file as it was") {
  const files::Directory directory;
  const Image image = extremes(40, 40);
  const auto path = files::put(directory / "a.exr", "old");
  const auto png = directory / "new.png";
  {
    const SmallDisk disk(100);
    CHECK(files::contains(files::refusal(path,
                                         [&] {
                                           write_exr(path, 40, 40, {{"", image}});
                                         }),
                          "cannot be written"));
    CHECK(files::contains(files::refusal(png, [&] { write_png(png, image); }), "cannot be written"));
  }
  CHECK(files::get(path) == "old");
  CHECK(directory.count() == 1);
  write_exr(path, 40, 40, {{"", image}});
  CHECK(read_image(path).pixels == image.pixels);
  CHECK(directory.count() == 1);
}

TEST_CASE("a place that cannot be written is refused by name") {
  const files::Directory directory;
  std::filesystem::create_directory(directory / "directory");
  files::put(directory / "file", "old");
  REQUIRE(mkfifo((directory / "pipe").c_str(), 0600) == 0);
  for (const char* name : {"missing/a.exr", "file/a.exr", "directory", "directory/", "pipe"}) {
    CAPTURE(name);
    const auto path = directory / name;
    CHECK(!files::refusal(path, [&] { write_file(path, "new"); }).empty());
  }
  CHECK_THROWS_AS(write_file("", "new"), InputError);
  CHECK(directory.count() == 3);
  CHECK(files::get(directory / "file") == "old");
}

TEST_CASE("a link goes on linking, and temporary files of others are left alone") {
  const files::Directory directory;
  const auto target = files::put(directory / "target", "old");
  std::filesystem::create_symlink("target", directory / "link");
  files::put(directory / ".coppice-0.partial", "another's");
  write_file(directory / "link", "new");
  CHECK(std::filesystem::is_symlink(directory / "link"));
  CHECK(files::get(target) == "new");
  CHECK(files::get(directory / ".coppice-0.partial") == "another's");
  CHECK(directory.count() == 3);
}

TEST_CASE("a PNG holds the tone-mapped image as 8-bit sRGB") {
  const files::Directory directory;
  const Image image = extremes(13, 7);
  write_png(directory / "a.png", image, 0.5f);
  int width = 0, height = 0, channels = 0;
  unsigned char* bytes = stbi_load((directory / "a.png").c_str(), &width, &height, &channels, 0);
  REQUIRE(bytes);
  REQUIRE(width == 13);
  REQUIRE(height == 7);
  REQUIRE(channels == 3);
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    for (int c = 0; c < 3; ++c)
      CHECK(int(bytes[3 * i + std::size_t(c)]) ==
            int(std::lround(255 * srgb_encode(tone_map(image.pixels[i], 0.5f)[c]))));
  stbi_image_free(bytes);
  CHECK(directory.count() == 1);
}
