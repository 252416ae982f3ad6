#include <doctest/doctest.h>

#include <algorithm>

#include "builder.hpp"

using namespace coppice;
using namespace gltf_test;

namespace {

std::string data_uri(const Bytes& image, const char* type = "png") {
  return std::string("data:image/") + type + ";base64," + base64(image);
}

std::string image_json(const Bytes& image, const char* type = "png") {
  return R"({"uri":")" + data_uri(image, type) + "\"}";
}

Scene with_materials(const std::string& materials, const std::string& more = "") {
  Builder builder = square();
  builder.members = R"(,"materials":[)" + materials + "]" + more;
  return load(builder);
}

std::string complaint_with(const std::string& materials, const std::string& more = "") {
  Builder builder = square();
  builder.members = R"(,"materials":[)" + materials + "]" + more;
  return complaint_of(builder);
}

const Bytes two_texels{255, 128, 0, 255, 10, 20, 30, 40};

}  // namespace

TEST_CASE("factors, alpha mask, sides and emission are read") {
  const Scene scene = with_materials(
      R"({"name":"first"},{"name":"second","pbrMetallicRoughness":{"baseColorFactor":[0.1,0.2,0.3,0.4],)"
      R"("metallicFactor":0.5,"roughnessFactor":0.6},"emissiveFactor":[1,0.5,0.25],"alphaMode":"MASK",)"
      R"("alphaCutoff":0.3,"doubleSided":true,)"
      R"("extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":8}}})",
      R"(,"extensionsUsed":["KHR_materials_emissive_strength"])");
  REQUIRE(scene.materials.size() == 3);  // the square itself has none
  CHECK(scene.mesh.materials[0] == 2);
  const Material& first = scene.materials[0];
  CHECK(first.name == "first");
  CHECK(first.base_color == vec3(1));
  CHECK(first.emission == vec3(0));
  CHECK_FALSE(first.alpha_mask);
  CHECK_FALSE(first.double_sided);
  const Material& second = scene.materials[1];
  CHECK(second.base_color == vec3(0.1f, 0.2f, 0.3f));
  CHECK(second.alpha == 0.4f);
  CHECK(second.metallic == 0.5f);
  CHECK(second.roughness == 0.6f);
  CHECK(second.emission == vec3(8, 4, 2));
  CHECK(second.alpha_mask);
  CHECK(second.alpha_cutoff == 0.3f);
  CHECK(second.double_sided);
  CHECK(scene.warnings.empty());
}

TEST_CASE("textures keep texels, colour space and wrap, and are shared by equal uses") {
  const Scene scene = with_materials(
      R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0},"metallicRoughnessTexture":{"index":0}},)"
      R"("normalTexture":{"index":1,"scale":0.25},"emissiveTexture":{"index":0}})",
      R"(,"images":[)" + image_json(png(2, 1, two_texels)) +
          R"(],"samplers":[{"wrapS":33071,"wrapT":33648}],"textures":[{"source":0},{"source":0,"sampler":0}])");
  const Material& material = scene.materials[0];
  REQUIRE(scene.textures.size() == 3);
  CHECK(material.base_color_texture == material.emission_texture);
  CHECK(material.base_color_texture != material.metallic_roughness_texture);
  CHECK(material.normal_scale == 0.25f);
  const Texture& color = scene.textures[std::size_t(material.base_color_texture)];
  CHECK(color.srgb);
  CHECK(color.width == 2);
  CHECK(color.height == 1);
  CHECK(color.rgba == two_texels);
  CHECK(color.wrap_u == Wrap::repeat);
  CHECK_FALSE(scene.textures[std::size_t(material.metallic_roughness_texture)].srgb);
  CHECK(scene.textures[std::size_t(material.metallic_roughness_texture)].rgba == two_texels);
  const Texture& normal = scene.textures[std::size_t(material.normal_texture)];
  CHECK_FALSE(normal.srgb);
  CHECK(normal.wrap_u == Wrap::clamp);
  CHECK(normal.wrap_v == Wrap::mirror);
}

TEST_CASE("16-bit PNG is rounded to 8 bits") {
  const Bytes samples{0xFF, 0xFF, 0x80, 0x80, 0x00, 0x81, 0xFF, 0x7E};
  const Scene scene = with_materials(
      R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}})",
      R"(,"images":[)" + image_json(png(1, 1, samples, 16)) + R"(],"textures":[{"source":0}])");
  REQUIRE(scene.textures.size() == 1);
  CHECK(scene.textures[0].rgba == Bytes{255, 128, 1, 254});
}

TEST_CASE("JPEG decodes") {
  const Scene scene =
      with_materials(R"({"emissiveTexture":{"index":0}})",
                     R"(,"images":[)" + image_json(small_jpeg(), "jpeg") + R"(],"textures":[{"source":0}])");
  REQUIRE(scene.textures.size() == 1);
  const Texture& texture = scene.textures[0];
  CHECK(texture.width == 8);
  CHECK(texture.rgba.size() == 256);
  CHECK(std::abs(texture.rgba[0] - 200) < 4);
  CHECK(std::abs(texture.rgba[1] - 100) < 4);
  CHECK(std::abs(texture.rgba[2] - 50) < 4);
  CHECK(texture.rgba[3] == 255);
}

TEST_CASE("an image may lie in a buffer view or in a file") {
  const Bytes image = png(2, 1, two_texels);
  Builder builder = square();
  const int view = builder.add_view(image.data(), image.size());
  builder.members = R"(,"materials":[{"emissiveTexture":{"index":0}}],"textures":[{"source":0}],"images":[)";
  const std::string members = builder.members;
  builder.members += R"({"mimeType":"image/png","bufferView":)" + std::to_string(view) + "}]";
  const Folder folder;
  CHECK(load_gltf(folder.write("view.glb", builder.glb())).textures[0].rgba == two_texels);
  folder.write("image.png", image);
  builder.members = members + R"({"uri":"image.png"}])";
  CHECK(load_gltf(folder.write("file.gltf", builder.gltf())).textures[0].rgba == two_texels);
  builder.members = members + R"({"uri":"absent.png"}])";
  CHECK_THROWS_WITH_AS(load_gltf(folder.write("absent.gltf", builder.gltf())),
                       doctest::Contains("absent.png"), InputError);
}

TEST_CASE("what is not supported is warned of") {
  const Scene scene = with_materials(
      R"({"alphaMode":"BLEND","pbrMetallicRoughness":{"metallicFactor":1.5,"baseColorTexture":{"index":1}},)"
      R"("emissiveTexture":{"index":0,"texCoord":1,"extensions":{"KHR_texture_transform":{"scale":[2,2]}}}})",
      R"(,"extensionsUsed":["KHR_texture_transform","KHR_materials_clearcoat"],"images":[)" +
          image_json(png(2, 1, two_texels)) +
          R"(],"textures":[{"source":0},{"name":"only an extension has it"}])");
  CHECK(scene.materials[0].metallic == 1);
  CHECK(scene.materials[0].base_color_texture == -1);
  CHECK(scene.materials[0].emission_texture == 0);
  for (const char* expected :
       {"1 materials with alphaMode BLEND treated as opaque", "1 material factors outside of [0, 1] clamped",
        "1 textures without a PNG or JPEG image ignored", "1 texture transforms ignored",
        "1 textures with other coordinates than TEXCOORD_0, which is used instead",
        "extension KHR_materials_clearcoat ignored"}) {
    CAPTURE(expected);
    CHECK(std::count(scene.warnings.begin(), scene.warnings.end(), expected) == 1);
  }
}

TEST_CASE("broken materials and textures are refused") {
  const std::string textured = R"({"emissiveTexture":{"index":0}})";
  const std::string textures = R"(,"textures":[{"source":0}])";
  const auto with_image = [&](const Bytes& image) {
    return complaint_with(textured, R"(,"images":[)" + image_json(image) + "]" + textures);
  };
  CHECK(contains(complaint_with(R"({"emissiveFactor":[1e300,0,0]})"), "material 0"));
  CHECK(contains(complaint_with(R"({"emissiveFactor":[-1,0,0]})"), "negative"));
  CHECK(contains(complaint_with(R"({"alphaMode":"GLASS"})"), "GLASS"));
  CHECK(contains(complaint_with(R"({"pbrMetallicRoughness":{"baseColorFactor":[1,1]}})"), "baseColorFactor"));
  CHECK(contains(complaint_with(textured), "no texture 0"));
  CHECK(contains(complaint_with(textured, textures), "no image 0"));
  CHECK(contains(complaint_with(textured, R"(,"textures":[{"source":0,"sampler":3}],"images":[)" +
                                              image_json(png(2, 1, two_texels)) + "]"),
                 "no sampler 3"));
  CHECK(contains(with_image({1, 2, 3, 4}), "neither PNG nor JPEG"));
  Bytes cut = png(2, 1, two_texels);
  cut.resize(40);
  CHECK(contains(with_image(cut), "image 0"));
  CHECK(contains(with_image(png(11000, 11000, {})), "too short"));
  CHECK(contains(with_image(png(30000, 30000, {})), "larger"));
}

TEST_CASE("an image cut at any length loads or is refused") {
  for (const Bytes& image : {png(2, 1, two_texels), small_jpeg()})
    for (std::size_t size = 0; size < image.size(); ++size) {
      Builder builder = square();
      const int view = builder.add_view(image.data(), size + (size == 0));
      builder.members =
          R"(,"materials":[{"emissiveTexture":{"index":0}}],"textures":[{"source":0}],"images":[{)"
          R"("mimeType":"image/png","bufferView":)" +
          std::to_string(view) + "}]";
      const std::string complaint = complaint_of(builder);
      CHECK((complaint.empty() || contains(complaint, "image 0")));
    }
}
