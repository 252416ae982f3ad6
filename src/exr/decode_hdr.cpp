// Radiance RGBE: G. Ward, "Real Pixels", Graphics Gems II, 1991, and the Radiance file format definition.
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <span>
#include <sstream>

#include "decode.hpp"
#include "refusal.hpp"

namespace coppice::exr {
namespace {

using Rgbe = std::array<std::uint8_t, 4>;

class Cursor {
 public:
  explicit Cursor(std::string_view bytes) : rest_(bytes) {}

  std::size_t left() const { return rest_.size(); }

  std::string_view line() {
    const std::size_t end = rest_.find('\n');
    if (end == std::string_view::npos) throw Refusal("is truncated in its header");
    std::string_view text = take(end + 1);
    text.remove_suffix(text.ends_with("\r\n") ? 2 : 1);
    return text;
  }

  std::string_view take(std::size_t count) {
    need(count);
    const std::string_view taken = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return taken;
  }

  std::uint8_t byte() { return static_cast<std::uint8_t>(take(1)[0]); }

  Rgbe peek_pixel() const {
    need(4);
    Rgbe pixel;
    for (std::size_t i = 0; i < 4; ++i) pixel[i] = static_cast<std::uint8_t>(rest_[i]);
    return pixel;
  }

  Rgbe pixel() {
    const Rgbe next = peek_pixel();
    take(4);
    return next;
  }

 private:
  void need(std::size_t count) const {
    if (count > rest_.size()) throw Refusal("is truncated");
  }

  std::string_view rest_;
};

/// Which pixel the file's scanline s holds at position p; the file states the axis of scanlines first.
struct Orientation {
  int scanlines = 0;
  int length = 0;
  bool scanlines_are_columns = false;
  bool right_to_left = false;
  bool bottom_to_top = false;

  int width() const { return scanlines_are_columns ? scanlines : length; }
  int height() const { return scanlines_are_columns ? length : scanlines; }

  std::size_t index(int s, int p) const {
    const int column = scanlines_are_columns ? s : p, row = scanlines_are_columns ? p : s;
    const int x = right_to_left ? width() - 1 - column : column;
    const int y = bottom_to_top ? height() - 1 - row : row;
    return std::size_t(y) * std::size_t(width()) + std::size_t(x);
  }
};

struct Header {
  float scale = 1;  ///< from stored values to radiance
  Orientation orientation;
};

bool is_x(const std::string& axis) { return axis == "+X" || axis == "-X"; }
bool is_y(const std::string& axis) { return axis == "+Y" || axis == "-Y"; }

Orientation parse_orientation(std::string_view line) {
  std::istringstream in{std::string(line)};
  std::string first, second, extra;
  long long scanlines = 0, length = 0;
  const bool complete = in >> first >> scanlines >> second >> length && !(in >> extra);
  const bool columns = is_x(first) && is_y(second);
  if (!complete || (!columns && !(is_y(first) && is_x(second))))
    throw Refusal("states its size as '" + std::string(line.substr(0, 40)) + "'",
                  "a Radiance file states it as '-Y height +X width'");
  check_dimensions(scanlines, length);
  const std::string& x = columns ? first : second;
  const std::string& y = columns ? second : first;
  return {int(scanlines), int(length), columns, x[0] == '-', y[0] == '+'};
}

float parse_exposure(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(" \t"), text.size()));
  float value = 0;
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  if (result.ec == std::errc() && value > 0 && std::isfinite(1 / value)) return value;
  throw Refusal("has an EXPOSURE of '" + std::string(text.substr(0, 40)) + "'",
                "an exposure is a positive number");
}

Header parse_header(Cursor& in) {
  constexpr std::string_view format = "FORMAT=", exposure = "EXPOSURE=";
  Header header;
  for (std::string_view line = in.line(); !line.empty(); line = in.line()) {
    if (line.starts_with(exposure)) header.scale /= parse_exposure(line.substr(exposure.size()));
    if (line.starts_with(format) && line.find("32-bit_rle_rgbe") == std::string_view::npos)
      throw Refusal("has the format '" + std::string(line.substr(format.size(), 40)) + "'",
                    "only 32-bit_rle_rgbe is read");
  }
  if (!std::isnormal(header.scale)) throw Refusal("has EXPOSURE lines beyond the range of float");
  header.orientation = parse_orientation(in.line());
  return header;
}

/// New style: the four components one after the other, each as runs and literals.
void decode_component(Cursor& in, std::span<Rgbe> row, std::size_t component) {
  for (std::size_t x = 0; x < row.size();) {
    const std::uint8_t code = in.byte();
    const bool run = code > 128;
    const std::size_t count = run ? code - 128u : code;
    if (count == 0 || count > row.size() - x) throw Refusal("has a run that leaves its scanline");
    const std::uint8_t repeated = run ? in.byte() : std::uint8_t(0);
    for (const std::size_t end = x + count; x < end; ++x) row[x][component] = run ? repeated : in.byte();
  }
}

/// Old style: pixels, of which (1, 1, 1, n) repeats the one before n times; a further one counts 256-fold.
void append_pixels(Cursor& in, std::vector<Rgbe>& pixels, std::size_t length) {
  const std::size_t begin = pixels.size(), end = begin + length;
  unsigned shift = 0;
  while (pixels.size() < end) {
    const Rgbe pixel = in.pixel();
    if (pixel[0] != 1 || pixel[1] != 1 || pixel[2] != 1) {
      pixels.push_back(pixel);
      shift = 0;
      continue;
    }
    const std::size_t count = shift > 24 ? length : std::size_t(pixel[3]) << shift;
    if (pixels.size() == begin || count > end - pixels.size())
      throw Refusal("has a run that leaves its scanline");
    const Rgbe last = pixels.back();
    pixels.insert(pixels.end(), count, last);
    shift += 8;
  }
}

bool is_new_style(const Rgbe& first, std::size_t length) {
  return length >= 8 && length <= 32767 && first[0] == 2 && first[1] == 2 && first[2] < 128;
}

void append_scanline(Cursor& in, std::vector<Rgbe>& pixels, std::size_t length) {
  const Rgbe first = in.peek_pixel();
  if (!is_new_style(first, length)) return append_pixels(in, pixels, length);
  in.take(4);
  if (std::size_t(first[2]) * 256 + first[3] != length) throw Refusal("has a scanline of another length");
  pixels.resize(pixels.size() + length);
  for (std::size_t component = 0; component < 4; ++component)
    decode_component(in, std::span(pixels).last(length), component);
}

vec3 to_radiance(const Rgbe& pixel, float scale) {
  if (pixel[3] == 0) return vec3(0);
  const float unit = std::ldexp(1.0f, int(pixel[3]) - 136);
  return vec3(pixel[0], pixel[1], pixel[2]) * unit * scale;
}

/// Grows with what the file really holds, so that a false size costs no memory.
std::vector<Rgbe> decode_scanlines(Cursor& in, const Orientation& orientation) {
  const std::size_t count = std::size_t(orientation.scanlines);
  if (count > in.left() / 4) throw Refusal("is truncated");
  std::vector<Rgbe> pixels;
  for (std::size_t s = 0; s < count; ++s) append_scanline(in, pixels, std::size_t(orientation.length));
  return pixels;
}

}  // namespace

bool is_hdr(std::string_view bytes) { return bytes.starts_with("#?"); }

Image decode_hdr(std::string_view bytes) {
  Cursor in(bytes);
  const Header header = parse_header(in);
  const Orientation& orientation = header.orientation;
  const std::vector<Rgbe> stored = decode_scanlines(in, orientation);
  Image image(orientation.width(), orientation.height());
  std::size_t next = 0;
  for (int s = 0; s < orientation.scanlines; ++s)
    for (int p = 0; p < orientation.length; ++p)
      image.pixels[orientation.index(s, p)] = to_radiance(stored[next++], header.scale);
  return image;
}

}  // namespace coppice::exr
