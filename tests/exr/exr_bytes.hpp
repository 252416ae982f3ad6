// OpenEXR files put together byte by byte, so that the reader is tested against the format and not the
// library.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace exr_bytes {

enum class Type : std::uint32_t { uint = 0, half = 1, real = 2 };

struct Window {
  int left, top, right, bottom;  ///< inclusive
};

struct ChannelSource {
  std::string name;
  Type type;
  std::function<float(int x, int y)> value;  ///< at absolute coordinates
};

struct Part {
  Window data, display;
  std::vector<ChannelSource> channels;  ///< in alphabetical order
  int tile = 0;                         ///< side of the tiles; 0: scanlines
  std::string name;
};

template <class T>
std::string little_endian(T value) {
  static_assert(std::endian::native == std::endian::little);
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

/// Exact for zero and for numbers that a normal half holds.
inline std::uint16_t half_bits(float value) {
  if (value == 0) return 0;
  int exponent = 0;
  const float mantissa = std::frexp(std::fabs(value), &exponent);
  const auto fraction = std::uint16_t(std::lround((mantissa * 2 - 1) * 1024));
  return std::uint16_t((value < 0 ? 0x8000 : 0) | ((exponent + 14) << 10) | fraction);
}

inline std::string text(const std::string& value) { return value + '\0'; }

inline std::string attribute(const std::string& name, const std::string& type, const std::string& value) {
  return text(name) + text(type) + little_endian(std::uint32_t(value.size())) + value;
}

inline std::string window_bytes(const Window& w) {
  return little_endian(w.left) + little_endian(w.top) + little_endian(w.right) + little_endian(w.bottom);
}

inline std::string channel_list(const Part& part) {
  std::string list;
  for (const ChannelSource& channel : part.channels)
    list += text(channel.name) + little_endian(channel.type) + std::string(4, '\0') + little_endian(1) +
            little_endian(1);
  return list + '\0';
}

inline std::string pixel_bytes(const ChannelSource& channel, int x, int y) {
  const float value = channel.value(x, y);
  if (channel.type == Type::uint) return little_endian(std::uint32_t(value));
  if (channel.type == Type::half) return little_endian(half_bits(value));
  return little_endian(value);
}

/// The pixels of a block, row by row, each row channel by channel, as uncompressed chunks hold them.
inline std::string block_bytes(const Part& part, const Window& block) {
  std::string bytes;
  for (int y = block.top; y <= block.bottom; ++y)
    for (const ChannelSource& channel : part.channels)
      for (int x = block.left; x <= block.right; ++x) bytes += pixel_bytes(channel, x, y);
  return bytes;
}

inline std::string sized(const std::string& bytes) {
  return little_endian(std::uint32_t(bytes.size())) + bytes;
}

inline std::vector<std::string> scanline_chunks(const Part& part) {
  std::vector<std::string> chunks;
  for (int y = part.data.top; y <= part.data.bottom; ++y)
    chunks.push_back(little_endian(y) + sized(block_bytes(part, {part.data.left, y, part.data.right, y})));
  return chunks;
}

inline std::vector<std::string> tile_chunks(const Part& part) {
  std::vector<std::string> chunks;
  const Window& w = part.data;
  for (int top = w.top, row = 0; top <= w.bottom; top += part.tile, ++row)
    for (int left = w.left, column = 0; left <= w.right; left += part.tile, ++column) {
      const Window block{left, top, std::min(left + part.tile - 1, w.right),
                         std::min(top + part.tile - 1, w.bottom)};
      const std::string place =
          little_endian(column) + little_endian(row) + little_endian(0) + little_endian(0);
      chunks.push_back(place + sized(block_bytes(part, block)));
    }
  return chunks;
}

inline std::vector<std::string> chunks_of(const Part& part) {
  return part.tile > 0 ? tile_chunks(part) : scanline_chunks(part);
}

inline std::string header_bytes(const Part& part, bool many) {
  std::string header = attribute("channels", "chlist", channel_list(part)) +
                       attribute("compression", "compression", std::string(1, '\0')) +
                       attribute("dataWindow", "box2i", window_bytes(part.data)) +
                       attribute("displayWindow", "box2i", window_bytes(part.display)) +
                       attribute("lineOrder", "lineOrder", std::string(1, '\0')) +
                       attribute("pixelAspectRatio", "float", little_endian(1.0f)) +
                       attribute("screenWindowCenter", "v2f", little_endian(0.0f) + little_endian(0.0f)) +
                       attribute("screenWindowWidth", "float", little_endian(1.0f));
  if (part.tile > 0)
    header += attribute("tiles", "tiledesc",
                        little_endian(part.tile) + little_endian(part.tile) + std::string(1, '\0'));
  if (many)
    header += attribute("name", "string", part.name) +
              attribute("type", "string", part.tile > 0 ? "tiledimage" : "scanlineimage") +
              attribute("chunkCount", "int", little_endian(int(chunks_of(part).size())));
  return header + '\0';
}

inline std::string file_bytes(const std::vector<Part>& parts) {
  const bool many = parts.size() > 1;
  const std::uint32_t flags = many ? 0x1000u : parts[0].tile > 0 ? 0x200u : 0u;
  std::string head = little_endian(std::uint32_t(20000630)) + little_endian(2u | flags);
  std::size_t chunk_count = 0;
  for (const Part& part : parts) {
    head += header_bytes(part, many);
    chunk_count += chunks_of(part).size();
  }
  if (many) head += '\0';
  std::string table, chunks;
  for (std::size_t p = 0; p < parts.size(); ++p)
    for (const std::string& chunk : chunks_of(parts[p])) {
      table += little_endian(std::uint64_t(head.size() + 8 * chunk_count + chunks.size()));
      chunks += (many ? little_endian(std::uint32_t(p)) : "") + chunk;
    }
  return head + table + chunks;
}

}  // namespace exr_bytes
