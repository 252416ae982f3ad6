// Images for the tests.
#include "builder.hpp"

namespace gltf_test {
namespace {

void put_big(Bytes& bytes, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(std::uint8_t(value >> shift));
}

std::uint32_t crc(const Bytes& bytes) {
  std::uint32_t c = ~0u;
  for (const std::uint8_t byte : bytes) {
    c ^= byte;
    for (int i = 0; i < 8; ++i) c = c & 1 ? c >> 1 ^ 0xEDB88320u : c >> 1;
  }
  return ~c;
}

void put_chunk(Bytes& file, std::string_view type, const Bytes& data) {
  Bytes body(type.begin(), type.end());
  body.insert(body.end(), data.begin(), data.end());
  put_big(file, std::uint32_t(data.size()));
  file.insert(file.end(), body.begin(), body.end());
  put_big(file, crc(body));
}

Bytes stored_zlib(const Bytes& raw) {
  const std::size_t size = raw.size();
  Bytes stream{0x78, 0x01, 0x01};
  for (const std::size_t value : {size, ~size})
    for (const int shift : {0, 8}) stream.push_back(std::uint8_t(value >> shift));
  stream.insert(stream.end(), raw.begin(), raw.end());
  std::uint32_t a = 1, b = 0;
  for (const std::uint8_t byte : raw) {
    a = (a + byte) % 65521;
    b = (b + a) % 65521;
  }
  put_big(stream, b << 16 | a);
  return stream;
}

std::uint8_t digit_value(char c) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  return std::uint8_t(digits.find(c));
}

}  // namespace

Bytes png(std::uint32_t width, std::uint32_t height, const Bytes& samples, int bits) {
  Bytes header, rows, file{0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
  put_big(header, width);
  put_big(header, height);
  for (const int byte : {bits, 6, 0, 0, 0}) header.push_back(std::uint8_t(byte));
  const std::size_t row = samples.size() / height;
  for (std::size_t y = 0; y < height; ++y) {
    rows.push_back(0);
    const auto first = samples.begin() + std::ptrdiff_t(y * row);
    rows.insert(rows.end(), first, first + std::ptrdiff_t(row));
  }
  put_chunk(file, "IHDR", header);
  put_chunk(file, "IDAT", stored_zlib(rows));
  put_chunk(file, "IEND", {});
  return file;
}

Bytes small_jpeg() {
  constexpr std::string_view text =
      "/9j/4AAQSkZJRgABAQAAAQABAAD/2wCEAAMCAgMCAgMDAwMEAwMEBQgFBQQEBQoHBwYIDAoMDAsKCwsNDhIQDQ4RDgsLEBYQERMU"
      "FRUVDA8XGBYUGBIUFRQBAwQEBQQFCQUFCRQNCw0UFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQU"
      "FBQUFP/AABEIAAgACAMBIgACEQEDEQH/xAGiAAABBQEBAQEBAQAAAAAAAAAAAQIDBAUGBwgJCgsQAAIBAwMCBAMFBQQEAAABfQEC"
      "AwAEEQUSITFBBhNRYQcicRQygZGhCCNCscEVUtHwJDNicoIJChYXGBkaJSYnKCkqNDU2Nzg5OkNERUZHSElKU1RVVldYWVpjZGVm"
      "Z2hpanN0dXZ3eHl6g4SFhoeIiYqSk5SVlpeYmZqio6Slpqeoqaqys7S1tre4ubrCw8TFxsfIycrS09TV1tfY2drh4uPk5ebn6Onq"
      "8fLz9PX29/j5+gEAAwEBAQEBAQEBAQAAAAAAAAECAwQFBgcICQoLEQACAQIEBAMEBwUEBAABAncAAQIDEQQFITEGEkFRB2FxEyIy"
      "gQgUQpGhscEJIzNS8BVictEKFiQ04SXxFxgZGiYnKCkqNTY3ODk6Q0RFRkdISUpTVFVWV1hZWmNkZWZnaGlqc3R1dnd4eXqCg4SF"
      "hoeIiYqSk5SVlpeYmZqio6Slpqeoqaqys7S1tre4ubrCw8TFxsfIycrS09TV1tfY2dri4+Tl5ufo6ery8/T19vf4+fr/2gAMAwEA"
      "AhEDEQA/AKtFFFfh5/SB/9k=";
  Bytes bytes;
  std::uint32_t group = 0;
  int bits = 0;
  for (const char c : text) {
    if (c == '=') break;
    group = group << 6 | digit_value(c);
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes.push_back(std::uint8_t(group >> bits));
  }
  return bytes;
}

}  // namespace gltf_test
