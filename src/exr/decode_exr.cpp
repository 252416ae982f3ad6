#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfPartType.h>

#include <algorithm>
#include <initializer_list>

#include "byte_stream.hpp"
#include "decode.hpp"
#include "exr_layout.hpp"
#include "refusal.hpp"

namespace coppice::exr {
namespace {

/// The file, opened; its layout is checked first.
class File {
 public:
  explicit File(std::string_view bytes)
      : stream_(checked(bytes)), parts_(stream_, Imf::globalThreadCount(), false) {
    for (int part = 0; part < parts_.parts(); ++part)
      if (!parts_.partComplete(part)) throw Refusal("is truncated: its table of offsets was never completed");
  }

  Imf::MultiPartInputFile& parts() { return parts_; }

  std::vector<std::string> channel_names() const {
    std::vector<std::string> names;
    for (int part = 0; part < parts_.parts(); ++part) {
      const Imf::ChannelList& channels = parts_.header(part).channels();
      for (auto c = channels.begin(); c != channels.end(); ++c) names.emplace_back(c.name());
    }
    return names;
  }

  /// The first flat part that has all the channels; -1 where there is none.
  int find_part(std::initializer_list<const char*> names) const {
    for (int part = 0; part < parts_.parts(); ++part) {
      const Imf::Header& header = parts_.header(part);
      const bool deep = header.hasType() && Imf::isDeepData(header.type());
      const auto has = [&](const char* name) { return header.channels().findChannel(name) != nullptr; };
      if (!deep && std::all_of(names.begin(), names.end(), has)) return part;
    }
    return -1;
  }

 private:
  static std::string_view checked(std::string_view bytes) {
    check_exr_layout(bytes);
    return bytes;
  }

  InputBytes stream_;
  Imf::MultiPartInputFile parts_;
};

Refusal lacks(const std::string& wanted, const File& file) {
  std::string held;
  for (const std::string& name : file.channel_names()) {
    held += (held.empty() ? "" : ", ") + name;
    if (held.size() > 200) {
      held += ", ...";
      break;
    }
  }
  return Refusal("has no " + wanted + " in a flat part",
                 "it has: " + (held.empty() ? "no channel" : one_line(held)));
}

int width_of(const Imath::Box2i& window) { return window.max.x - window.min.x + 1; }
int height_of(const Imath::Box2i& window) { return window.max.y - window.min.y + 1; }
std::size_t area_of(const Imath::Box2i& window) {
  return std::size_t(width_of(window)) * std::size_t(height_of(window));
}

struct Target {
  const char* channel;
  float* first;  ///< receives the data window's upper left pixel
};

/// Fills the data window's pixels, Pixel by Pixel.
template <class Pixel>
void read_pixels(Imf::InputPart& part, std::initializer_list<Target> targets) {
  const Imath::Box2i& window = part.header().dataWindow();
  const std::size_t row = std::size_t(width_of(window)) * sizeof(Pixel);
  Imf::FrameBuffer frame;
  for (const Target& target : targets)
    frame.insert(target.channel, Imf::Slice::Make(Imf::FLOAT, target.first, window, sizeof(Pixel), row));
  part.setFrameBuffer(frame);
  part.readPixels(window.min.y, window.max.y);
}

/// The pixels of `data`, moved to where `display` has them.
template <class Pixel>
std::vector<Pixel> move_window(std::vector<Pixel> pixels, const Imath::Box2i& data,
                               const Imath::Box2i& display) {
  if (data == display) return pixels;
  std::vector<Pixel> moved(area_of(display), Pixel(0));
  const int left = std::max(data.min.x, display.min.x), right = std::min(data.max.x, display.max.x);
  if (left > right) return moved;
  const auto at = [](const Imath::Box2i& window, int x, int y) {
    return std::ptrdiff_t(y - window.min.y) * width_of(window) + (x - window.min.x);
  };
  for (int y = std::max(data.min.y, display.min.y); y <= std::min(data.max.y, display.max.y); ++y)
    std::copy_n(pixels.begin() + at(data, left, y), right - left + 1, moved.begin() + at(display, left, y));
  return moved;
}

std::vector<vec3> read_rgb(Imf::InputPart& part) {
  std::vector<vec3> pixels(area_of(part.header().dataWindow()));
  read_pixels<vec3>(part, {{"R", &pixels[0].x}, {"G", &pixels[0].y}, {"B", &pixels[0].z}});
  return pixels;
}

std::vector<vec3> read_grey(Imf::InputPart& part) {
  if (part.header().channels().findChannel("RY"))
    throw Refusal("stores luminance and chroma", "convert it to R, G and B");
  std::vector<vec3> pixels(area_of(part.header().dataWindow()));
  read_pixels<vec3>(part, {{"Y", &pixels[0].x}});
  for (vec3& pixel : pixels) pixel = vec3(pixel.x);
  return pixels;
}

}  // namespace

bool is_exr(std::string_view bytes) { return bytes.starts_with("\x76\x2f\x31\x01"); }

Image decode_exr(std::string_view bytes) {
  File file(bytes);
  const int colour = file.find_part({"R", "G", "B"});
  const int found = colour >= 0 ? colour : file.find_part({"Y"});
  if (found < 0) throw lacks("channels R, G, B or Y", file);
  Imf::InputPart part(file.parts(), found);
  const Imf::Header& header = part.header();
  Image image;
  image.width = width_of(header.displayWindow());
  image.height = height_of(header.displayWindow());
  image.pixels = move_window(colour >= 0 ? read_rgb(part) : read_grey(part), header.dataWindow(),
                             header.displayWindow());
  return image;
}

Channel decode_exr_channel(std::string_view bytes, const std::string& name) {
  File file(bytes);
  const int found = file.find_part({name.c_str()});
  if (found < 0) throw lacks("channel " + name, file);
  Imf::InputPart part(file.parts(), found);
  const Imf::Header& header = part.header();
  std::vector<float> values(area_of(header.dataWindow()));
  read_pixels<float>(part, {{name.c_str(), values.data()}});
  return {width_of(header.displayWindow()), height_of(header.displayWindow()),
          move_window(std::move(values), header.dataWindow(), header.displayWindow())};
}

std::vector<std::string> decode_exr_channel_names(std::string_view bytes) {
  return File(bytes).channel_names();
}

}  // namespace coppice::exr
