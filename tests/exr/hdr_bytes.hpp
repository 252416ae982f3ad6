// Radiance files put together byte by byte, in each of the encodings.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace hdr_bytes {

using Rgbe = std::array<std::uint8_t, 4>;
using Row = std::vector<Rgbe>;

inline std::string header(const std::string& resolution, const std::string& lines = "") {
  return "#?RADIANCE\n# by hand\n" + lines + "FORMAT=32-bit_rle_rgbe\n\n" + resolution + "\n";
}

inline std::string pixel(const Rgbe& p) { return {char(p[0]), char(p[1]), char(p[2]), char(p[3])}; }

inline std::string flat(const Row& row) {
  std::string bytes;
  for (const Rgbe& p : row) bytes += pixel(p);
  return bytes;
}

inline std::size_t run_length(const Row& row, std::size_t begin, auto&& same, std::size_t longest) {
  std::size_t end = begin + 1;
  while (end < row.size() && end - begin < longest && same(row[begin], row[end])) ++end;
  return end - begin;
}

/// A pixel, then (1, 1, 1, n) for its n repetitions; from 256 on a second such pixel holds the upper 8 bits.
inline std::string old_style(const Row& row) {
  std::string bytes;
  for (std::size_t x = 0; x < row.size();) {
    const std::size_t length = run_length(
        row, x, [](const Rgbe& a, const Rgbe& b) { return a == b; }, 60000);
    bytes += pixel(row[x]);
    x += length;
    if (length == 1) continue;
    bytes += pixel({1, 1, 1, std::uint8_t((length - 1) & 255)});
    if (length > 256) bytes += pixel({1, 1, 1, std::uint8_t((length - 1) >> 8)});
  }
  return bytes;
}

/// Component by component: runs of 3 and more as such, the rest as literals of 1.
inline std::string new_style(const Row& row) {
  std::string bytes{char(2), char(2), char(row.size() >> 8), char(row.size() & 255)};
  for (std::size_t c = 0; c < 4; ++c)
    for (std::size_t x = 0; x < row.size();) {
      const auto same = [c](const Rgbe& a, const Rgbe& b) { return a[c] == b[c]; };
      std::size_t length = run_length(row, x, same, 127);
      if (length < 3) length = 1;
      bytes += char(length < 3 ? 1 : 128 + length);
      bytes += char(row[x][c]);
      x += length;
    }
  return bytes;
}

}  // namespace hdr_bytes
