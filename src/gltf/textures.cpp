#include "textures.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>

#include "accessor.hpp"

namespace coppice::gltf {
namespace {

using Bytes = std::span<const unsigned char>;

constexpr std::size_t most_texels = std::size_t{1} << 30;
constexpr std::uint64_t largest_image = std::uint64_t{1} << 27;  // texels: stb_image counts the bytes in int
constexpr std::uint64_t most_texels_a_byte = 8256;  // one-bit PNG, deflated at its limit of 1032:1

struct Size {
  std::uint32_t width = 0, height = 0;
};

std::uint32_t big_endian(Bytes bytes, std::size_t offset, int count) {
  std::uint32_t value = 0;
  for (int i = 0; i < count; ++i) value = value << 8 | bytes[offset + std::size_t(i)];
  return value;
}

bool starts_with(Bytes bytes, std::initializer_list<unsigned char> signature) {
  return bytes.size() >= signature.size() && std::equal(signature.begin(), signature.end(), bytes.begin());
}

// Of the first frame header (ITU T.81, B.2.2); zero where there is none.
Size jpeg_size(Bytes bytes) {
  for (std::size_t at = 2; at + 9 <= bytes.size() && bytes[at] == 0xFF;) {
    const unsigned char marker = bytes[at + 1];
    const bool is_frame =
        marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (is_frame) return {big_endian(bytes, at + 7, 2), big_endian(bytes, at + 5, 2)};
    at += marker == 0xFF ? 1 : 2 + big_endian(bytes, at + 2, 2);
  }
  return {};
}

// glTF allows PNG and JPEG. Sizes are read here so that the decoder never allocates what the data cannot
// fill.
Size encoded_size(Bytes bytes) {
  if (starts_with(bytes, {0x89, 'P', 'N', 'G'}) && bytes.size() >= 24)
    return {big_endian(bytes, 16, 4), big_endian(bytes, 20, 4)};
  if (starts_with(bytes, {0xFF, 0xD8})) return jpeg_size(bytes);
  return {};
}

Bytes encoded_bytes(const Document& document, const tinygltf::Image& image, const std::string& item) {
  if (image.bufferView >= 0) return view_bytes(document, image.bufferView, item);
  if (image.image.empty())
    document.fail(item, "its file " + one_line(image.uri, 80) + " cannot be read",
                  "put the file beside the scene");
  return image.image;
}

Wrap wrap_mode(const Document& document, int mode, const std::string& item) {
  switch (mode) {
    case TINYGLTF_TEXTURE_WRAP_REPEAT:
      return Wrap::repeat;
    case TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT:
      return Wrap::mirror;
    case TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE:
      return Wrap::clamp;
    default:
      document.fail(item, "wrap mode " + std::to_string(mode) + " is unknown");
  }
}

// The upper byte of 16-bit texels, rounded.
std::vector<std::uint8_t> to_8_bits(const std::vector<unsigned char>& words) {
  std::vector<std::uint8_t> bytes(words.size() / 2);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const unsigned value = words[2 * i] | unsigned(words[2 * i + 1]) << 8;
    bytes[i] = std::uint8_t((value + 128u) / 257u);
  }
  return bytes;
}

tinygltf::Image decode(const Document& document, Bytes bytes, const std::string& item) {
  const Size size = encoded_size(bytes);
  const std::uint64_t texels = std::uint64_t(size.width) * size.height;
  if (texels == 0) document.fail(item, "it is neither PNG nor JPEG, or cut short", "convert it to PNG");
  if (texels > largest_image) document.fail(item, "it is larger than 2^27 texels", "scale it down");
  if (texels > most_texels_a_byte * bytes.size())
    document.fail(item, "its data is too short for its size", "the image is damaged, save it again");
  if (bytes.size() > std::size_t(std::numeric_limits<int>::max()))
    document.fail(item, "its data exceeds 2 GiB", "scale it down");
  tinygltf::Image decoded;
  std::string error, warning;
  const bool done =
      tinygltf::LoadImageData(&decoded, 0, &error, &warning, 0, 0, bytes.data(), int(bytes.size()), nullptr);
  if (!done || decoded.component != 4 || decoded.width <= 0 || decoded.height <= 0)
    document.fail(item, "it cannot be decoded", "the image is damaged, save it again as 8-bit PNG");
  return decoded;
}

}  // namespace

int TextureBuilder::use(int texture, bool srgb, const std::string& item) {
  if (!has_item(document_.model.textures, texture))
    document_.fail(item, "there is no texture " + std::to_string(texture));
  const tinygltf::Texture& source = document_.model.textures[std::size_t(texture)];
  if (source.source == -1) {
    warnings_.count("textures without a PNG or JPEG image ignored");
    return -1;
  }
  const std::string name = item_name("texture", std::size_t(texture), source.name);
  if (!has_item(document_.model.images, source.source))
    document_.fail(name, "there is no image " + std::to_string(source.source));
  Texture wanted;
  wanted.srgb = srgb;
  set_wrap(wanted, source.sampler, name);
  const auto [entry, is_new] = known_.try_emplace({source.source, srgb, wanted.wrap_u, wanted.wrap_v}, 0);
  if (is_new) {
    wanted.rgba = texels_of(source.source, wanted);
    entry->second = int(textures_.size());
    decoded_.try_emplace(source.source, entry->second);
    textures_.push_back(std::move(wanted));
  }
  return entry->second;
}

void TextureBuilder::set_wrap(Texture& texture, int sampler, const std::string& item) const {
  if (sampler == -1) return;
  if (!has_item(document_.model.samplers, sampler))
    document_.fail(item, "there is no sampler " + std::to_string(sampler));
  const tinygltf::Sampler& source = document_.model.samplers[std::size_t(sampler)];
  const std::string name = item_name("sampler", std::size_t(sampler), source.name);
  texture.wrap_u = wrap_mode(document_, source.wrapS, name);
  texture.wrap_v = wrap_mode(document_, source.wrapT, name);
}

std::vector<std::uint8_t> TextureBuilder::texels_of(int image, Texture& texture) {
  const tinygltf::Image& source = document_.model.images[std::size_t(image)];
  const std::string item =
      item_name("image", std::size_t(image), source.name.empty() ? source.uri : source.name);
  std::vector<std::uint8_t> texels;
  if (const auto twin = decoded_.find(image); twin != decoded_.end()) {
    const Texture& same = textures_[std::size_t(twin->second)];
    texture.width = same.width;
    texture.height = same.height;
    texels = same.rgba;
  } else {
    tinygltf::Image decoded = decode(document_, encoded_bytes(document_, source, item), item);
    texture.width = decoded.width;
    texture.height = decoded.height;
    texels = decoded.bits == 16 ? to_8_bits(decoded.image) : std::move(decoded.image);
  }
  texel_count_ += texels.size() / 4;
  if (texel_count_ > most_texels)
    document_.fail(item, "the scene exceeds 2^30 texels", "scale its images down");
  return texels;
}

}  // namespace coppice::gltf
