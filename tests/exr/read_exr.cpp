#include <coppice/exr/read.hpp>
#include <limits>

#include "exr_bytes.hpp"
#include "files.hpp"

using namespace coppice;
using namespace exr_bytes;

namespace {

ChannelSource ramp(const std::string& name, Type type, int offset) {
  return {name, type, [offset](int x, int y) { return float(x + 16 * y + offset); }};
}

Part rgb_part(Type type, Window data, Window display, int tile = 0) {
  return {data, display, {ramp("B", type, 300), ramp("G", type, 200), ramp("R", type, 100)}, tile, "colour"};
}

vec3 ramp_colour(int x, int y) { return vec3(float(x + 16 * y)) + vec3(100, 200, 300); }

Image read_parts(const std::vector<Part>& parts) {
  const files::Directory directory;
  return read_image(files::put(directory / "a.exr", file_bytes(parts)));
}

std::string message_of(const std::string& bytes) {
  const files::Directory directory;
  const auto path = files::put(directory / "bad.exr", bytes);
  return files::refusal(path, [&] { read_image(path); });
}

std::string environment_message(vec3 odd) {
  const files::Directory directory;
  Part part{{0, 0, 4, 3}, {0, 0, 4, 3}, {}, 0, ""};
  const char* names[] = {"B", "G", "R"};
  for (int c = 0; c < 3; ++c)
    part.channels.push_back(
        {names[c], Type::real, [odd, c](int x, int y) { return x == 3 && y == 2 ? odd[2 - c] : 1e30f; }});
  const auto path = files::put(directory / "sky.exr", file_bytes({part}));
  return files::refusal(path, [&] { read_environment(path); });
}

}  // namespace

TEST_CASE("half, float and uint channels are read, in scanlines and in tiles") {
  const Window window{0, 0, 10, 6};
  for (const Type type : {Type::half, Type::real, Type::uint})
    for (const int tile : {0, 1, 4, 16}) {
      CAPTURE(tile);
      CAPTURE(int(type));
      const Image image = read_parts({rgb_part(type, window, window, tile)});
      REQUIRE(image.width == 11);
      REQUIRE(image.height == 7);
      for (int y = 0; y < 7; ++y)
        for (int x = 0; x < 11; ++x) CHECK(image.at(x, y) == ramp_colour(x, y));
    }
}

TEST_CASE("the image is the display window, wherever the data window lies") {
  const Window displays[] = {{5, 3, 10, 8}, {-20, -9, -12, -3}};
  for (const Window& display : displays)
    for (const int tile : {0, 4})
      for (const int shift : {-2, 0, 3, 50}) {
        CAPTURE(shift);
        const Window data{display.left + shift, display.top + shift, display.right + shift - 1,
                          display.bottom + shift + 1};
        const auto offset = [](int x, int y) { return float(x + 16 * y + 1000); };
        Part part{data, display, {{"Y", Type::real, offset}}, tile, ""};
        const Image image = read_parts({part});
        REQUIRE(image.width == display.right - display.left + 1);
        REQUIRE(image.height == display.bottom - display.top + 1);
        for (int y = display.top; y <= display.bottom; ++y)
          for (int x = display.left; x <= display.right; ++x) {
            const bool held = x >= data.left && x <= data.right && y >= data.top && y <= data.bottom;
            CHECK(image.at(x - display.left, y - display.top) == vec3(held ? offset(x, y) : 0));
          }
      }
}

TEST_CASE("grey and further layers are read, and colour goes before grey") {
  const Window window{0, 0, 3, 2};
  const Part grey{window, window, {ramp("Y", Type::half, 7)}, 0, "grey"};
  CHECK(read_parts({grey}).at(2, 1) == vec3(25));
  Part both = rgb_part(Type::real, window, window);
  both.channels.push_back(ramp("Y", Type::real, 7));
  both.channels.push_back(ramp("error.R", Type::real, 8));
  CHECK(read_parts({both}).at(2, 1) == ramp_colour(2, 1));
  const files::Directory directory;
  const auto path = files::put(directory / "a.exr", file_bytes({both}));
  CHECK(read_channel(path, "error.R").values[6] == 2 + 16 + 8);
  CHECK(read_channel_names(path) == std::vector<std::string>{"B", "G", "R", "Y", "error.R"});
}

TEST_CASE("of many parts the first with colour is read") {
  const Window window{0, 0, 3, 2}, larger{-1, -1, 8, 8};
  const Part mask{larger, window, {ramp("mask", Type::half, 7)}, 0, "mask"};
  for (const int tile : {0, 2}) {
    const std::vector<Part> parts{mask, rgb_part(Type::half, window, window, tile)};
    const Image image = read_parts(parts);
    REQUIRE(image.width == 4);
    CHECK(image.at(2, 1) == ramp_colour(2, 1));
    const files::Directory directory;
    const auto path = files::put(directory / "a.exr", file_bytes(parts));
    const coppice::Channel channel = read_channel(path, "mask");
    CHECK(channel.width == 4);
    CHECK(channel.values[4 * 2 + 1] == 1 + 16 * 2 + 7);
  }
}

TEST_CASE("an OpenEXR file without the channels asked for is refused, and says what it has") {
  const Window window{0, 0, 3, 2};
  const Part layer{window, window, {ramp("sun.B", Type::half, 0), ramp("sun.G", Type::half, 0)}, 0, ""};
  CHECK(files::contains(message_of(file_bytes({layer})), "sun.B, sun.G"));
  const Part chroma{window,
                    window,
                    {ramp("BY", Type::half, 0), ramp("RY", Type::half, 0), ramp("Y", Type::half, 0)},
                    0,
                    ""};
  CHECK(files::contains(message_of(file_bytes({chroma})), "chroma"));
  const files::Directory directory;
  const auto path = files::put(directory / "a.exr", file_bytes({layer}));
  CHECK(files::contains(files::refusal(path, [&] { read_channel(path, "sun.R"); }), "sun.R"));
}

TEST_CASE("windows and tiles that the file cannot hold are refused before memory is taken") {
  const std::string good = file_bytes({rgb_part(Type::real, {0, 0, 3, 2}, {0, 0, 3, 2})});
  const std::string tiled = file_bytes({rgb_part(Type::real, {0, 0, 3, 2}, {0, 0, 3, 2}, 2)});
  const auto with = [](std::string bytes, const char* name, std::size_t skip,
                       const std::vector<int>& values) {
    std::size_t at = bytes.find(name) + skip;
    for (const int value : values) {
      bytes.replace(at, 4, little_endian(value));
      at += 4;
    }
    return bytes;
  };
  const std::size_t box = sizeof("dataWindow") + sizeof("box2i") + 4, frame = box + 3;
  const std::size_t tile = sizeof("tiles") + sizeof("tiledesc") + 4;
  const int most = std::numeric_limits<int>::max(), least = std::numeric_limits<int>::min();
  CHECK(message_of(with(good, "dataWindow", box, {0, 0, 3, 2})).empty());
  for (const std::vector<int>& window : {std::vector{0, 0, most, most},
                                         {least, least, most, most},
                                         {0, 0, 16383, 16383},
                                         {0, 0, 3, 1 << 27},
                                         {0, 0, 1 << 27, 2},
                                         {0, 0, -1, 2},
                                         {5, 5, 1, 1}}) {
    CAPTURE(window[2]);
    CHECK(!message_of(with(good, "dataWindow", box, window)).empty());
    CHECK(!message_of(with(tiled, "dataWindow", box, window)).empty());
  }
  CHECK(!message_of(with(good, "displayWindow", frame, {0, 0, 16383, 16383})).empty());
  CHECK(!message_of(with(good, "displayWindow", frame, {0, 0, most, 0})).empty());
  for (const std::vector<int>& sides :
       {std::vector{0, 0}, {most, most}, {1, 1 << 30}, {1 << 30, 1}, {-1, -1}}) {
    CAPTURE(sides[0]);
    CHECK(!message_of(with(tiled, "tiles", tile, sides)).empty());
  }
}

TEST_CASE("an environment is refused for a value that is no radiance, which is named with its pixel") {
  const float infinity = std::numeric_limits<float>::infinity(),
              nan = std::numeric_limits<float>::quiet_NaN();
  CHECK(environment_message(vec3(1)).empty());
  CHECK(environment_message(vec3(1e30f)).empty());
  CHECK(environment_message(vec3(0, -0.0f, 1e-45f)).empty());
  CHECK(files::contains(environment_message(vec3(1, -0.25f, 1)), "pixel (3, 2) is (1, -0.25, 1)"));
  CHECK(files::contains(environment_message(vec3(1, 2, infinity)), "pixel (3, 2) is (1, 2, inf)"));
  CHECK(files::contains(environment_message(vec3(nan, 2, 1)), "pixel (3, 2) is (nan, 2, 1)"));
}
