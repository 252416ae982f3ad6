// Static, because other components may hold a copy of the same library.
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#define STBI_WRITE_NO_STDIO
#include <stb_image_write.h>

#include <coppice/core/config.hpp>
#include <coppice/exr/read.hpp>
#include <coppice/exr/tone_map.hpp>
#include <coppice/exr/write.hpp>
#include <coppice/exr/write_file.hpp>
#include <cstdint>

#include "refusal.hpp"

namespace coppice {
namespace {

std::uint8_t to_byte(float display_linear) { return std::uint8_t(srgb_encode(display_linear) * 255 + 0.5f); }

std::vector<std::uint8_t> develop(const Image& image, float exposure) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(image.pixels.size() * 3);
  for (const vec3& pixel : image.pixels) {
    const vec3 shown = tone_map(pixel, exposure);
    for (int c = 0; c < 3; ++c) bytes.push_back(to_byte(shown[c]));
  }
  return bytes;
}

void append(void* context, void* data, int size) {
  static_cast<std::string*>(context)->append(static_cast<const char*>(data), std::size_t(size));
}

std::string encode(const Image& image, float exposure) {
  const std::vector<std::uint8_t> bytes = develop(image, exposure);
  std::string encoded;
  if (!stbi_write_png_to_func(append, &encoded, image.width, image.height, 3, bytes.data(), image.width * 3))
    throw exr::Refusal("cannot be encoded", "use a smaller image");
  return encoded;
}

}  // namespace

void write_png(const std::filesystem::path& path, const Image& image, float exposure) {
  COPPICE_ASSERT(!image.pixels.empty() && image.pixels.size() <= max_pixels);
  exr::naming(
      path, [&] { write_file(path, encode(image, exposure)); }, "cannot be encoded");
}

}  // namespace coppice
