#include <doctest/doctest.h>

#include <random>

#include "builder.hpp"

using namespace coppice;
using namespace gltf_test;

namespace {

bool is_one_line(const std::string& message) { return !message.empty() && !contains(message, "\n"); }

// The square with some of its JSON replaced.
std::string altered(std::string_view from, std::string_view to) {
  std::string json = square().gltf();
  const std::size_t at = json.find(from);
  REQUIRE(at != std::string::npos);
  return json.replace(at, from.size(), to);
}

// A scene that has something of everything.
Builder everything() {
  Builder builder = square();
  const Bytes image = png(2, 1, {255, 128, 0, 255, 10, 20, 30, 40});
  const int view = builder.add_view(image.data(), image.size());
  builder.nodes = R"([{"mesh":0,"children":[1,2]},{"camera":0,"translation":[0,0,3]},)"
                  R"({"extensions":{"KHR_lights_punctual":{"light":0}},"rotation":[0,0,0,1]}])";
  builder.meshes = mesh_json(R"("POSITION":0,"NORMAL":1,"TEXCOORD_0":2)", R"(,"indices":3,"material":0)");
  builder.members =
      R"(,"images":[{"mimeType":"image/png","bufferView":)" + std::to_string(view) +
      R"(}],"textures":[{"source":0,"sampler":0}],"samplers":[{"wrapS":33071}],"cameras":[{"type":"perspective",)"
      R"("perspective":{"yfov":0.8,"znear":0.1}}],"materials":[{"name":"m","normalTexture":{"index":0},)"
      R"("pbrMetallicRoughness":{"baseColorTexture":{"index":0},"roughnessFactor":0.5},"emissiveFactor":[0,1,0]}],)"
      R"("extensionsUsed":["KHR_lights_punctual"],"extensions":{"KHR_lights_punctual":{"lights":[{"type":"point"}]}})";
  return builder;
}

// Loads, or throws InputError of one line. Anything else fails the test, or crashes it.
bool loads_or_refuses(const std::filesystem::path& file) {
  try {
    const Scene scene = load_gltf(file);
    const Mesh& mesh = scene.mesh;
    for (const uvec3& t : mesh.triangles)
      for (int corner = 0; corner < 3; ++corner)
        if (t[corner] >= mesh.positions.size()) return false;
    for (const vec3& n : mesh.normals)
      if (!(std::fabs(length(n) - 1) < 1e-5f)) return false;
    return mesh.normals.size() == mesh.positions.size() && mesh.tangents.size() == mesh.positions.size() &&
           mesh.uvs.size() == mesh.positions.size() && mesh.materials.size() == mesh.triangles.size();
  } catch (const InputError& error) {
    return is_one_line(error.what());
  }
}

}  // namespace

TEST_CASE("absent files, directories, empty files and garbage are refused in one line that names the file") {
  const Folder folder;
  std::mt19937 random(1);
  Bytes noise(1000);
  for (std::uint8_t& byte : noise) byte = std::uint8_t(random());
  Bytes glb_noise = noise;
  std::memcpy(glb_noise.data(), "glTF", 4);
  for (const std::filesystem::path& file :
       {folder.path() / "absent.glb", folder.path(), folder.write("empty.glb", ""),
        folder.write("noise.glb", noise), folder.write("noise.gltf", glb_noise),
        folder.write("text.gltf", "{\"asset\":{\n"), folder.write("array.gltf", "[1, 2, 3]"),
        folder.write("bare.gltf", "{}      ")}) {
    CAPTURE(file);
    std::string message;
    try {
      load_gltf(file);
    } catch (const InputError& error) {
      message = error.what();
    }
    CHECK(is_one_line(message));
    CHECK(contains(message, file.string()));
  }
}

TEST_CASE("another version and required extensions that are unknown are refused") {
  CHECK(contains(complaint_of(altered(R"("version":"2.0")", R"("version":"1.0")")), "version 1.0"));
  CHECK(contains(
      complaint_of(altered(R"("scene":0)", R"("extensionsRequired":["KHR_draco_mesh_compression"])")),
      "KHR_draco_mesh_compression"));
}

TEST_CASE("values that are not finite are refused by name") {
  for (const float value : {NAN, INFINITY, -INFINITY})
    for (const int attribute : {0, 1, 2}) {
      Builder builder;
      std::vector<float> positions = corner_positions, normals{0, 0, 1, 0, 0, 1, 0, 0, 1}, uvs(6, 0.0f);
      (attribute == 0 ? positions : attribute == 1 ? normals : uvs)[4] = value;
      builder.vec3s(positions);
      builder.vec3s(normals);
      builder.vec2s(uvs);
      builder.meshes = mesh_json(R"("POSITION":0,"NORMAL":1,"TEXCOORD_0":2)");
      const std::string message = complaint_of(builder);
      CHECK(contains(message, "mesh 0"));
      CHECK(contains(message, "accessor " + std::to_string(attribute)));
      CHECK(contains(message, "not finite"));
    }
}

TEST_CASE("coordinates whose areas would overflow are refused") {
  Builder builder;
  builder.vec3s({0, 0, 0, 1e20f, 0, 0, 0, 1, 0});
  builder.meshes = mesh_json(R"("POSITION":0)");
  CHECK(contains(complaint_of(builder), "1e9"));
}

TEST_CASE("an index out of range is refused") {
  Builder builder = triangle();
  builder.indices({0, 1, 3});
  builder.meshes = mesh_json(R"("POSITION":0)", R"(,"indices":1)");
  CHECK(contains(complaint_of(builder), "index 3 is out of range"));
}

TEST_CASE("references to absent items are refused") {
  CHECK(contains(complaint_of(altered(R"("POSITION":0)", R"("POSITION":77)")), "no accessor 77"));
  CHECK(contains(complaint_of(altered(R"("POSITION":0)", R"("POSITION":-2)")), "no accessor -2"));
  CHECK_FALSE(complaint_of(altered(R"("indices":3)", R"("indices":77)")).empty());
  CHECK(contains(complaint_of(altered(R"("indices":3)", R"("indices":-7)")), "no accessor -7"));
  CHECK(contains(complaint_of(altered(R"("indices":3)", R"("indices":3,"material":5)")), "no material 5"));
  CHECK(contains(complaint_of(altered(R"("indices":3)", R"("indices":3,"mode":9)")), "mode 9"));
  CHECK(contains(complaint_of(altered(R"("mesh":0)", R"("mesh":8)")), "no mesh 8"));
  CHECK(contains(complaint_of(altered(R"({"nodes":[0]})", R"({"nodes":[9]})")), "no node 9"));
  CHECK(contains(complaint_of(altered(R"("mesh":0)", R"("mesh":0,"children":[9])")), "no child node 9"));
  CHECK(contains(complaint_of(altered(R"("scene":0)", R"("scene":4)")), "no scene 4"));
  CHECK(contains(complaint_of(altered(R"({"bufferView":0)", R"({"bufferView":55)")), "no buffer view 55"));
  CHECK(contains(complaint_of(altered(R"([{"buffer":0)", R"([{"buffer":6)")), "no buffer 6"));
}

TEST_CASE("accessors and buffer views that reach beyond their data are refused") {
  const std::string view = R"("byteOffset":0,"byteLength":48)", accessor = R"("count":4,"type":"VEC3")";
  for (const char* broken :
       {R"("byteOffset":100000,"byteLength":48)", R"("byteOffset":0,"byteLength":100000)",
        R"("byteOffset":18446744073709551600,"byteLength":48)",
        R"("byteOffset":8,"byteLength":18446744073709551610)", R"("byteOffset":0,"byteLength":47)",
        R"("byteOffset":0,"byteLength":48,"byteStride":16)",
        R"("byteOffset":0,"byteLength":48,"byteStride":4)",
        R"("byteOffset":0,"byteLength":48,"byteStride":3)"}) {
    CAPTURE(broken);
    CHECK(is_one_line(complaint_of(altered(view, broken))));
  }
  for (const char* broken :
       {R"("count":5,"type":"VEC3")", R"("count":18446744073709551615,"type":"VEC3")",
        R"("count":1537228672809129302,"type":"VEC3")", R"("count":4000000000,"type":"VEC3")",
        R"("count":4,"type":"VEC3","byteOffset":4)",
        R"("count":4,"type":"VEC3","byteOffset":18446744073709551604)", R"("count":-1,"type":"VEC3")",
        R"("count":3,"type":"VEC2")", R"("count":4,"type":"MAT4")", R"("count":3,"type":"VEC3")",
        R"("count":4,"type":"VEC3","sparse":{"count":1,"indices":{"bufferView":0,)"
        R"("componentType":5123},"values":{"bufferView":0}})"}) {
    CAPTURE(broken);
    CHECK(is_one_line(complaint_of(altered(accessor, broken))));
  }
  CHECK(is_one_line(complaint_of(altered(R"("componentType":5126)", R"("componentType":5127)"))));
  CHECK(is_one_line(complaint_of(altered(R"("componentType":5126)", R"("componentType":5125)"))));
  CHECK(is_one_line(complaint_of(altered(R"("componentType":5126)", R"("componentType":5130)"))));
  CHECK(is_one_line(complaint_of(altered(R"("componentType":5123)", R"("componentType":5122)"))));
}

TEST_CASE("an image's buffer view is checked before it is read") {
  Builder builder = everything();
  std::string json = builder.gltf();
  const std::size_t at = json.rfind(R"("byteOffset":)");
  json.replace(at, 13, R"("byteOffset":9999)");
  CHECK(contains(complaint_of(json), "image 0"));
}

TEST_CASE("buffers that promise more than there is are refused") {
  CHECK(
      is_one_line(complaint_of(altered(R"("buffers":[{"byteLength":)", R"("buffers":[{"byteLength":9999)"))));
  Builder builder = square();
  const Folder folder;
  std::string json = builder.json("");
  json.replace(json.find(R"("buffers":[{"byteLength":)"), 25, R"("buffers":[{"byteLength":9999)");
  json.resize((json.size() + 3) / 4 * 4, ' ');
  Bytes bytes;
  for (const std::uint32_t word : {0x46546C67u, 2u, std::uint32_t(20 + json.size() + 8 + builder.bin.size()),
                                   std::uint32_t(json.size()), 0x4E4F534Au})
    put_word(bytes, word);
  bytes.insert(bytes.end(), json.begin(), json.end());
  put_word(bytes, std::uint32_t(builder.bin.size()));
  put_word(bytes, 0x004E4942u);
  bytes.insert(bytes.end(), builder.bin.begin(), builder.bin.end());
  CHECK_THROWS_AS(load_gltf(folder.write("scene.glb", bytes)), InputError);
}

TEST_CASE("a BIN chunk that ends beyond the file is refused") {
  Bytes bytes = square().glb();
  const std::size_t chunk = 20 + (bytes[12] | std::size_t(bytes[13]) << 8);
  for (const std::uint8_t excess : {4, 8}) {
    Bytes longer = bytes;
    longer[chunk] = std::uint8_t(longer[chunk] + excess);
    const Folder folder;
    CHECK_THROWS_WITH_AS(load_gltf(folder.write("scene.glb", longer)), doctest::Contains("BIN"), InputError);
  }
}

TEST_CASE("many instances of many triangles are refused before memory runs out") {
  Builder builder;
  builder.vec3s(corner_positions);
  std::vector<std::uint16_t> indices(3 * 20000);
  for (std::size_t i = 0; i < indices.size(); ++i) indices[i] = std::uint16_t(i % 3 == 2);  // no area
  builder.indices(indices);
  builder.meshes = R"({"primitives":[)";
  for (int i = 0; i < 4000; ++i)
    builder.meshes += std::string(i ? "," : "") + R"({"attributes":{"POSITION":0},"indices":1})";
  builder.meshes += "]}";
  CHECK(contains(complaint_of(builder), "2^26 triangles"));
}

TEST_CASE("deep JSON is refused, not recursed into") {
  const std::string deep = std::string(200000, '[') + std::string(200000, ']');
  CHECK(contains(complaint_of(altered(R"("scene":0)", R"("extras":)" + deep)), "nested"));
  CHECK(contains(complaint_of(std::string(200000, '{')), "nested"));
  CHECK(complaint_of(altered(R"("scene":0)", R"("extras":"\"[[[[[[\\")")).empty());
}

TEST_CASE("names from the file cannot break the line") {
  const std::string name(5000, 'x');
  const std::string message = complaint_of(
      altered(R"({"primitives")", R"({"name":"a\nb)" + name + R"(","primitives")").replace(0, 0, ""));
  CHECK(message.empty());
  std::string json = altered(R"("POSITION":0)", R"("POSITION":9)");
  json.replace(json.find(R"({"primitives")"), 13, R"({"name":"a\nb)" + name + R"(","primitives")");
  const std::string refusal = complaint_of(json);
  CHECK(is_one_line(refusal));
  CHECK(refusal.size() < 500);
}

TEST_CASE("a .glb cut at any length loads or is refused") {
  const Folder folder;
  const Bytes whole = everything().glb();
  REQUIRE(load_gltf(folder.write("whole.glb", whole)).mesh.triangles.size() == 2);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const Bytes cut(whole.begin(), whole.begin() + std::ptrdiff_t(size));
    CAPTURE(size);
    CHECK_THROWS_AS(load_gltf(folder.write("cut_" + std::to_string(size) + ".glb", cut)), InputError);
  }
}

TEST_CASE("a .glb cut at any length with its header put right loads or is refused") {
  const Folder folder;
  const Bytes whole = everything().glb();
  for (std::size_t size = 12; size < whole.size(); ++size) {
    Bytes cut(whole.begin(), whole.begin() + std::ptrdiff_t(size));
    for (std::size_t i = 0; i < 4; ++i) cut[8 + i] = std::uint8_t(size >> (8 * i));
    CAPTURE(size);
    CHECK(loads_or_refuses(folder.write("cut_" + std::to_string(size) + ".glb", cut)));
  }
}

TEST_CASE("a .gltf cut at any length is refused") {
  const Folder folder;
  const std::string whole = everything().gltf();
  for (std::size_t size = 0; size < whole.size(); ++size) {
    CAPTURE(size);
    CHECK_THROWS_AS(load_gltf(folder.write("cut_" + std::to_string(size) + ".gltf", whole.substr(0, size))),
                    InputError);
  }
}

TEST_CASE("flipped bits load or are refused") {
  const Folder folder;
  const Bytes whole = everything().glb();
  const std::string text = everything().gltf();
  std::mt19937 random(20240607);
  for (int round = 0; round < 600; ++round) {
    Bytes bytes = round % 2 ? whole : Bytes(text.begin(), text.end());
    for (unsigned flips = 1 + random() % 4; flips > 0; --flips)
      bytes[random() % bytes.size()] ^= std::uint8_t(1u << random() % 8);
    CAPTURE(round);
    CHECK(loads_or_refuses(folder.write("flipped_" + std::to_string(round) + ".glb", bytes)));
  }
}

TEST_CASE("numbers of the JSON replaced by absurd ones load or are refused") {
  const Folder folder;
  const std::string text = everything().gltf();
  const std::size_t end = text.find("base64,");
  int round = 0;
  for (std::size_t at = 0; at < end; ++at) {
    const bool starts = std::isdigit(static_cast<unsigned char>(text[at])) && text[at - 1] != '.' &&
                        !std::isalnum(static_cast<unsigned char>(text[at - 1])) && text[at - 1] != '_';
    if (!starts) continue;
    std::size_t stop = at;
    while (std::isdigit(static_cast<unsigned char>(text[stop])) || text[stop] == '.') ++stop;
    for (const char* number : {"-1", "255", "65536", "2147483647", "4294967295", "9223372036854775807",
                               "18446744073709551615", "1e30", "1e308", "0", "null", "[]", "\"a\""}) {
      const std::string changed = text.substr(0, at) + number + text.substr(stop);
      CAPTURE(changed);
      CHECK(loads_or_refuses(folder.write("number_" + std::to_string(round++) + ".gltf", changed)));
    }
  }
  CHECK(round > 300);
}
