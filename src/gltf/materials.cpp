#include "materials.hpp"

#include <algorithm>
#include <cmath>

#include "textures.hpp"

namespace coppice::gltf {
namespace {

class MaterialReader {
 public:
  MaterialReader(const Document& document, std::size_t index, TextureBuilder& textures, Warnings& warnings)
      : document_(document),
        source_(document.model.materials[index]),
        item_(item_name("material", index, source_.name)),
        textures_(textures),
        warnings_(warnings) {}

  Material read() {
    Material material;
    material.name = source_.name;
    read_surface(material);
    read_emission(material);
    read_alpha(material);
    material.normal_texture = texture(source_.normalTexture, false, "normalTexture");
    material.normal_scale = finite(source_.normalTexture.scale, "scale of normalTexture");
    material.double_sided = source_.doubleSided;
    return material;
  }

 private:
  void read_surface(Material& material) {
    const tinygltf::PbrMetallicRoughness& pbr = source_.pbrMetallicRoughness;
    const std::vector<double>& color = pbr.baseColorFactor;
    if (color.size() != 4) document_.fail(item_, "baseColorFactor has not 4 numbers");
    for (int c = 0; c < 3; ++c) material.base_color[c] = share(color[std::size_t(c)], "baseColorFactor");
    material.alpha = share(color[3], "baseColorFactor");
    material.metallic = share(pbr.metallicFactor, "metallicFactor");
    material.roughness = share(pbr.roughnessFactor, "roughnessFactor");
    material.base_color_texture = texture(pbr.baseColorTexture, true, "baseColorTexture");
    material.metallic_roughness_texture =
        texture(pbr.metallicRoughnessTexture, false, "metallicRoughnessTexture");
  }

  void read_emission(Material& material) {
    const std::vector<double>& factor = source_.emissiveFactor;
    if (factor.size() != 3) document_.fail(item_, "emissiveFactor has not 3 numbers");
    const double strength = emissive_strength();
    for (int c = 0; c < 3; ++c) {
      material.emission[c] = finite(factor[std::size_t(c)] * strength, "emissiveFactor");
      if (material.emission[c] < 0) document_.fail(item_, "its emission is negative");
    }
    material.emission_texture = texture(source_.emissiveTexture, true, "emissiveTexture");
  }

  void read_alpha(Material& material) {
    material.alpha_mask = source_.alphaMode == "MASK";
    material.alpha_cutoff = finite(source_.alphaCutoff, "alphaCutoff");
    if (source_.alphaMode == "BLEND")
      warnings_.count("materials with alphaMode BLEND treated as opaque");
    else if (!material.alpha_mask && source_.alphaMode != "OPAQUE")
      document_.fail(item_, "alphaMode " + one_line(source_.alphaMode, 20) + " is unknown");
  }

  double emissive_strength() const {
    const auto found = source_.extensions.find("KHR_materials_emissive_strength");
    if (found == source_.extensions.end() || !found->second.Has("emissiveStrength")) return 1;
    const tinygltf::Value& strength = found->second.Get("emissiveStrength");
    if (!strength.IsNumber()) document_.fail(item_, "emissiveStrength is not a number");
    return strength.GetNumberAsDouble();
  }

  template <class Info>
  int texture(const Info& info, bool srgb, const char* name) {
    if (info.index == -1) return -1;
    if (info.texCoord != 0)
      warnings_.count("textures with other coordinates than TEXCOORD_0, which is used instead");
    if (info.extensions.contains("KHR_texture_transform")) warnings_.count("texture transforms ignored");
    return textures_.use(info.index, srgb, item_ + ", " + name);
  }

  float finite(double value, const std::string& name) const {
    if (!std::isfinite(float(value))) document_.fail(item_, name + " is not a finite float");
    return float(value);
  }

  float share(double value, const std::string& name) {
    const float given = finite(value, name), clamped = std::clamp(given, 0.0f, 1.0f);
    if (given != clamped) warnings_.count("material factors outside of [0, 1] clamped");
    return clamped;
  }

  const Document& document_;
  const tinygltf::Material& source_;
  std::string item_;
  TextureBuilder& textures_;
  Warnings& warnings_;
};

}  // namespace

void load_materials(const Document& document, Scene& scene, Warnings& warnings) {
  TextureBuilder textures(document, scene.textures, warnings);
  for (std::size_t i = 0; i < document.model.materials.size(); ++i)
    scene.materials.push_back(MaterialReader(document, i, textures, warnings).read());
}

}  // namespace coppice::gltf
