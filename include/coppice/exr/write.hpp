// Images to files: OpenEXR with layers, and a PNG to look at.
#pragma once

#include <coppice/core/image.hpp>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace coppice {

/// What one name stands for in an OpenEXR file: an image or one value a pixel. It refers to the data, which
/// must outlive it.
struct Layer {
  std::string name;
  const Image* image = nullptr;   ///< channels NAME.R, NAME.G, NAME.B; plain R, G, B where the name is empty
  std::span<const float> values;  ///< where image is null: the one channel NAME, at y·width + x

  Layer(std::string layer_name, const Image& pixels) : name(std::move(layer_name)), image(&pixels) {}
  Layer(std::string layer_name, Image&&) = delete;
  Layer(std::string channel_name, std::span<const float> channel)
      : name(std::move(channel_name)), values(channel) {}
  Layer(std::string channel_name, std::vector<float>&&) = delete;
};

/// Writes the layers as one OpenEXR file: float32, ZIP compression, scanlines, data and display window
/// [0, width) × [0, height). For instance
///   write_exr("out.exr", w, h, {{"", colour}, {"A", coverage}, {"reference", truth}, {"cut_size.Y",
///   sizes}}).
/// Preconditions: width, height > 0; each layer holds width·height pixels; no channel has two layers.
/// Either the whole file is written or none of it (write_file.hpp); throws InputError naming the path
/// otherwise.
void write_exr(const std::filesystem::path& path, int width, int height, const std::vector<Layer>& layers);

/// Writes the image as 8-bit sRGB, each pixel srgb_encode(tone_map(pixel, exposure)) (tone_map.hpp).
/// Preconditions: the image is not empty and no larger than 2^28 pixels.
/// Either the whole file is written or none of it (write_file.hpp); throws InputError naming the path
/// otherwise.
void write_png(const std::filesystem::path& path, const Image& image, float exposure = 1);

}  // namespace coppice
