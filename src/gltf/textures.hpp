// Images as 8-bit RGBA textures.
#pragma once

#include <coppice/scene/texture.hpp>
#include <map>
#include <tuple>
#include <vector>

#include "document.hpp"

namespace coppice::gltf {

/// Decodes the images that materials ask for, each once for every use (sRGB or linear, wrap modes).
class TextureBuilder {
 public:
  TextureBuilder(const Document& document, std::vector<Texture>& textures, Warnings& warnings)
      : document_(document), textures_(textures), warnings_(warnings) {}

  /// Index into the textures of glTF texture `texture`, or -1 where its image is in a format that only an
  /// extension defines. Throws InputError.
  int use(int texture, bool srgb, const std::string& item);

 private:
  void set_wrap(Texture& texture, int sampler, const std::string& item) const;
  std::vector<std::uint8_t> texels_of(int image, Texture& texture);

  const Document& document_;
  std::vector<Texture>& textures_;
  Warnings& warnings_;
  std::map<std::tuple<int, bool, Wrap, Wrap>, int> known_;
  std::map<int, int> decoded_;  // image -> a texture that holds its texels
  std::size_t texel_count_ = 0;
};

}  // namespace coppice::gltf
