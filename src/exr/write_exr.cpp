#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>

#include <coppice/core/config.hpp>
#include <coppice/exr/write.hpp>
#include <coppice/exr/write_file.hpp>

#include "byte_stream.hpp"
#include "refusal.hpp"

namespace coppice {
namespace {

/// The header and the frame buffer side by side: what is to be written, and from where.
struct Contents {
  Imf::Header header;
  Imf::FrameBuffer frame;

  Contents(int width, int height)
      : header(width, height, 1, Imath::V2f(0, 0), 1, Imf::INCREASING_Y, Imf::ZIP_COMPRESSION) {}

  void add(const std::string& name, const float* first, std::size_t stride) {
    COPPICE_ASSERT(header.channels().findChannel(name.c_str()) == nullptr);
    const Imath::Box2i& window = header.dataWindow();
    const std::size_t row = stride * std::size_t(window.max.x + 1);
    header.channels().insert(name, Imf::Channel(Imf::FLOAT));
    frame.insert(name, Imf::Slice::Make(Imf::FLOAT, first, window, stride, row));
  }

  void add(const Layer& layer) {
    if (!layer.image) return add(layer.name, layer.values.data(), sizeof(float));
    const std::string prefix = layer.name.empty() ? "" : layer.name + ".";
    const float* first = &layer.image->pixels[0].x;
    add(prefix + "R", first, sizeof(vec3));
    add(prefix + "G", first + 1, sizeof(vec3));
    add(prefix + "B", first + 2, sizeof(vec3));
  }
};

[[maybe_unused]] bool holds(const Layer& layer, int width, int height) {
  const std::size_t count = std::size_t(width) * std::size_t(height);
  if (!layer.image) return !layer.name.empty() && layer.values.size() == count;
  return layer.image->width == width && layer.image->height == height && layer.image->pixels.size() == count;
}

std::string encode(int width, int height, const std::vector<Layer>& layers) {
  Contents contents(width, height);
  for (const Layer& layer : layers) {
    COPPICE_ASSERT(holds(layer, width, height));
    contents.add(layer);
  }
  exr::OutputBytes stream;
  {
    Imf::OutputFile file(stream, contents.header);
    file.setFrameBuffer(contents.frame);
    file.writePixels(height);
  }  // the table of offsets is written as the file closes
  return std::move(stream.bytes);
}

}  // namespace

void write_exr(const std::filesystem::path& path, int width, int height, const std::vector<Layer>& layers) {
  COPPICE_ASSERT(width > 0 && height > 0 && !layers.empty());
  exr::naming(
      path, [&] { write_file(path, encode(width, height, layers)); }, "cannot be encoded");
}

}  // namespace coppice
