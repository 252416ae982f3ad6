// Images from files: OpenEXR and Radiance HDR, told apart by their first bytes.
#pragma once

#include <coppice/core/image.hpp>
#include <coppice/light/environment.hpp>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace coppice {

/// No image of more pixels than this is read.
inline constexpr std::size_t max_pixels = std::size_t(1) << 28;

/// One channel of an image: the value of pixel (x, y) is at y·width + x, y = 0 is the top row.
struct Channel {
  int width = 0;
  int height = 0;
  std::vector<float> values;
};

/// Linear RGB as the file stores it, every float unchanged, NaN and infinity included.
///
/// OpenEXR: R, G, B (or Y alone, as grey) of the first part that has them; scanlines or tiles; half, float or
/// uint. The image is the display window: pixels outside the data window are 0, overscan is cut off.
/// Radiance: RGBE in any of the eight orientations, flat or run-length encoded (both styles); a mantissa m
/// with exponent e > 0 is m·2^(e-136), and every EXPOSURE line divides, as the format's definition asks
/// (Ward, "Real Pixels", Graphics Gems II, 1991; Radiance file formats).
///
/// Throws InputError naming the file where it is missing, no regular file, neither format, truncated,
/// damaged, or of more than max_pixels pixels. A file is refused before memory is taken that it could not
/// fill.
Image read_image(const std::filesystem::path& path);

/// read_image, as a distant environment. Throws InputError also where a value is NaN, infinite or negative,
/// naming the pixel and the value.
Environment read_environment(const std::filesystem::path& path);

/// The channel of that full name ("A", "error.R", "cut_size.Y") of an OpenEXR file, in the display window as
/// for read_image. Throws InputError as read_image does, and where no part has such a channel.
Channel read_channel(const std::filesystem::path& path, const std::string& name);

/// The full names of an OpenEXR file's channels, part by part, each part's in alphabetical order.
std::vector<std::string> read_channel_names(const std::filesystem::path& path);

}  // namespace coppice
