#include <coppice/core/error.hpp>
#include <coppice/exr/read.hpp>
#include <cstdio>
#include <fstream>
#include <utility>

#include "decode.hpp"
#include "refusal.hpp"

namespace coppice {
namespace {

using exr::file_error, exr::naming, exr::Refusal;
namespace fs = std::filesystem;

void check_is_file(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) throw Refusal("does not exist", "check the path");
  if (error)
    throw Refusal("cannot be reached (" + error.message() + ")", "check the path and its permissions");
  if (fs::is_directory(status)) throw Refusal("is a directory", "name an image file");
  if (!fs::is_regular_file(status)) throw Refusal("is not a regular file", "name an image file");
}

std::string read_bytes(const fs::path& path) {
  check_is_file(path);
  std::string bytes(fs::file_size(path), '\0');
  if (bytes.empty()) throw Refusal("is empty");
  std::ifstream in(path, std::ios::binary);
  if (!in) throw Refusal("cannot be opened", "check its permissions");
  if (!in.read(bytes.data(), std::streamsize(bytes.size()))) throw Refusal("cannot be read to its end");
  return bytes;
}

std::string read_exr_bytes(const fs::path& path) {
  std::string bytes = read_bytes(path);
  if (!exr::is_exr(bytes)) throw Refusal("is not an OpenEXR file", "only OpenEXR files have named channels");
  return bytes;
}

Image decode(const std::string& bytes) {
  if (exr::is_exr(bytes)) return exr::decode_exr(bytes);
  if (exr::is_hdr(bytes)) return exr::decode_hdr(bytes);
  throw Refusal("is neither OpenEXR nor Radiance HDR", "convert it to .exr or .hdr");
}

bool is_radiance(const vec3& v) { return is_finite(v) && v.x >= 0 && v.y >= 0 && v.z >= 0; }

std::string describe(int x, int y, const vec3& v) {
  char text[160];
  std::snprintf(text, sizeof text, "pixel (%d, %d) is (%g, %g, %g), which is not a radiance", x, y,
                double(v.x), double(v.y), double(v.z));
  return text;
}

void check_radiance(const Image& map) {
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x)
      if (!is_radiance(map.at(x, y)))
        throw Refusal(describe(x, y, map.at(x, y)), "replace such pixels by finite values of at least 0");
}

}  // namespace

void exr::check_dimensions(long long width, long long height) {
  const long long limit = static_cast<long long>(max_pixels);
  if (width > 0 && height > 0 && width <= limit && height <= limit / width) return;
  throw Refusal("states a size of " + std::to_string(width) + " x " + std::to_string(height) + " pixels",
                "an image has 1 to 2^28 pixels");
}

Image read_image(const fs::path& path) {
  return naming(path, [&] { return decode(read_bytes(path)); });
}

Environment read_environment(const fs::path& path) {
  Environment environment;
  environment.map = read_image(path);
  naming(path, [&] { check_radiance(environment.map); });
  return environment;
}

Channel read_channel(const fs::path& path, const std::string& name) {
  return naming(path, [&] { return exr::decode_exr_channel(read_exr_bytes(path), name); });
}

std::vector<std::string> read_channel_names(const fs::path& path) {
  return naming(path, [&] { return exr::decode_exr_channel_names(read_exr_bytes(path)); });
}

}  // namespace coppice
