#include "exr_layout.hpp"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfTileDescription.h>
#include <OpenEXR/ImfVersion.h>

#include <algorithm>
#include <coppice/exr/read.hpp>
#include <cstdint>

#include "byte_stream.hpp"
#include "decode.hpp"
#include "refusal.hpp"

namespace coppice::exr {
namespace {

constexpr std::size_t header_start = 8;  // magic number and version come before the first header

/// The bytes from `from` up to a zero, which is passed over.
std::string_view skip_text(std::string_view bytes, std::size_t& position) {
  const std::size_t end = bytes.find('\0', position);
  if (end == std::string_view::npos) throw Refusal("is truncated in its header");
  const std::string_view text = bytes.substr(position, end - position);
  position = end + 1;
  return text;
}

std::uint32_t read_size(std::string_view bytes, std::size_t& position) {
  if (bytes.size() - position < 4) throw Refusal("is truncated in its header");
  std::uint32_t size = 0;
  for (unsigned i = 0; i < 4; ++i)
    size |= std::uint32_t(static_cast<unsigned char>(bytes[position + i])) << (8 * i);
  position += 4;
  return size;
}

/// Passes over one header; false where it was the empty one that ends the headers of many parts.
bool skip_attributes(std::string_view bytes, std::size_t& position) {
  bool any = false;
  while (!skip_text(bytes, position).empty()) {
    any = true;
    skip_text(bytes, position);  // the attribute's type
    const std::uint32_t size = read_size(bytes, position);
    if (size > bytes.size() - position) throw Refusal("is truncated in its header");
    position += size;
  }
  return any;
}

/// The library allocates an attribute of whatever size the file states.
void check_attribute_sizes(std::string_view bytes, bool many_parts) {
  std::size_t position = header_start;
  while (skip_attributes(bytes, position) && many_parts) {
  }
}

struct Size {
  std::int64_t width, height;
};

Size size_of(const Imath::Box2i& window) {
  return {std::int64_t(window.max.x) - window.min.x + 1, std::int64_t(window.max.y) - window.min.y + 1};
}

std::int64_t divide_up(std::int64_t a, std::int64_t b) { return (a + b - 1) / b; }

int lines_in_chunk(Imf::Compression compression) {
  switch (compression) {
    case Imf::ZIP_COMPRESSION:
    case Imf::PXR24_COMPRESSION:
      return 16;
    case Imf::PIZ_COMPRESSION:
    case Imf::B44_COMPRESSION:
    case Imf::B44A_COMPRESSION:
    case Imf::DWAA_COMPRESSION:
      return 32;
    case Imf::DWAB_COMPRESSION:
      return 256;
    default:
      return 1;
  }
}

/// No stream of this compression grows by more when it is unpacked: deflate 1032, run lengths 128 for 2
/// bytes, PIZ's Huffman codes 512 for 10 bits, B44A 32 for 3 bytes; DWA nests two of these.
std::int64_t largest_ratio(Imf::Compression compression) {
  switch (compression) {
    case Imf::NO_COMPRESSION:
      return 1;
    case Imf::DWAA_COMPRESSION:
    case Imf::DWAB_COMPRESSION:
      return 1 << 18;
    default:
      return 1 << 11;
  }
}

std::int64_t chunk_count(const Imf::Header& header, Size size) {
  if (!header.hasTileDescription()) return divide_up(size.height, lines_in_chunk(header.compression()));
  const Imf::TileDescription& tile = header.tileDescription();
  return divide_up(size.width, tile.xSize) * divide_up(size.height, tile.ySize);
}

std::int64_t pixel_bytes(const Imf::Header& header, Size size) {
  std::int64_t bytes = 0;
  for (auto c = header.channels().begin(); c != header.channels().end(); ++c) {
    const Imf::Channel& channel = c.channel();
    const std::int64_t columns = size.width / std::max(channel.xSampling, 1);
    const std::int64_t rows = size.height / std::max(channel.ySampling, 1);
    bytes += columns * rows * (channel.type == Imf::HALF ? 2 : 4);
  }
  return bytes;
}

/// The library keeps one tile, and one row of tiles, unpacked.
void check_tiles(const Imf::TileDescription& tile, Size size) {
  const std::int64_t limit = std::max(16 * size.width * size.height, std::int64_t(1) << 24);
  const std::int64_t columns = std::max(size.width, std::int64_t(tile.xSize)), rows = tile.ySize;
  if (tile.xSize == 0 || rows == 0 || columns > limit / rows)
    throw Refusal("has tiles of " + std::to_string(tile.xSize) + " x " + std::to_string(rows) + " pixels",
                  "write it with tiles smaller than the image");
}

/// A part of few pixels within a large frame is honest, but bounds the frame.
void check_display_window(Size display, Size data) {
  check_dimensions(display.width, display.height);
  const std::int64_t limit = std::max(64 * data.width * data.height, std::int64_t(1) << 24);
  if (display.width * display.height > limit)
    throw Refusal("has a display window of more than 64 times its data", "write it with both windows alike");
}

void check_part(const Imf::Header& header, std::int64_t file_size) {
  const Size data = size_of(header.dataWindow());
  check_dimensions(data.width, data.height);
  check_display_window(size_of(header.displayWindow()), data);
  if (header.hasTileDescription()) check_tiles(header.tileDescription(), data);
  constexpr std::int64_t offset_bytes = 8, chunk_header_bytes = 8;
  const std::int64_t stated = header.hasChunkCount() ? header.chunkCount() : 0;
  const bool table_fits = stated >= 0 && stated <= file_size / offset_bytes &&
                          chunk_count(header, data) <= file_size / (offset_bytes + chunk_header_bytes);
  const bool deep = header.hasType() && header.type().starts_with("deep");
  const bool pixels_fit =
      deep || pixel_bytes(header, data) / largest_ratio(header.compression()) <= file_size;
  if (!table_fits || !pixels_fit)
    throw Refusal("is truncated: " + std::to_string(file_size) + " bytes cannot hold " +
                  std::to_string(data.width) + " x " + std::to_string(data.height) + " pixels");
}

}  // namespace

void check_exr_layout(std::string_view bytes) {
  if (bytes.size() < header_start) throw Refusal("is truncated in its header");
  std::size_t position = 4;
  int version = int(read_size(bytes, position));
  const bool many_parts = Imf::isMultiPart(version);
  check_attribute_sizes(bytes, many_parts);
  InputBytes stream(bytes);
  stream.seekg(header_start);
  do {
    Imf::Header header;
    header.readFrom(stream, version);
    if (header.readsNothing()) break;
    check_part(header, std::int64_t(bytes.size()));
  } while (many_parts);
}

}  // namespace coppice::exr
