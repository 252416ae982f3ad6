// Small glTF files for the tests, written to a folder that goes away with them.
#pragma once

#include <unistd.h>

#include <coppice/core/error.hpp>
#include <coppice/gltf/load.hpp>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

namespace gltf_test {

using Bytes = std::vector<std::uint8_t>;

class Folder {
 public:
  Folder() {
    static int count = 0;
    path_ = std::filesystem::temp_directory_path() /
            ("coppice_gltf_" + std::to_string(::getpid()) + "_" + std::to_string(count++));
    std::filesystem::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::filesystem::path write(const std::string& name, const void* data, std::size_t size) const {
    const std::filesystem::path file = path_ / name;
    std::ofstream(file, std::ios::binary).write(static_cast<const char*>(data), std::streamsize(size));
    return file;
  }
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    return write(name, text.data(), text.size());
  }
  std::filesystem::path write(const std::string& name, const Bytes& bytes) const {
    return write(name, bytes.data(), bytes.size());
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

inline void put_word(Bytes& bytes, std::uint32_t value) {
  for (int i = 0; i < 4; ++i) bytes.push_back(std::uint8_t(value >> (8 * i)));
}

inline std::string base64(const Bytes& bytes) {
  static constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = group << 8 | (i + k < bytes.size() ? bytes[i + k] : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      text += k <= bytes.size() - i ? digits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

/// One buffer, and JSON around it that a test may replace piece by piece.
struct Builder {
  Bytes bin;
  std::string views, accessors;
  int view_count = 0, accessor_count = 0;
  std::string scenes = R"("scene":0,"scenes":[{"nodes":[0]}])";
  std::string nodes = R"([{"mesh":0}])";
  std::string meshes;   ///< the array's items
  std::string members;  ///< further members of the root, each with a comma in front

  int add_view(const void* data, std::size_t size, const std::string& more = "") {
    while (bin.size() % 4) bin.push_back(0);
    views += (view_count ? ",{" : "{") + std::string(R"("buffer":0,"byteOffset":)") +
             std::to_string(bin.size()) + R"(,"byteLength":)" + std::to_string(size) + more + "}";
    const auto* first = static_cast<const std::uint8_t*>(data);
    bin.insert(bin.end(), first, first + size);
    return view_count++;
  }

  int add_accessor(int view, int component, std::size_t count, const std::string& type,
                   const std::string& more = "") {
    accessors += (accessor_count ? ",{" : "{") + std::string(R"("bufferView":)") + std::to_string(view) +
                 R"(,"componentType":)" + std::to_string(component) + R"(,"count":)" + std::to_string(count) +
                 R"(,"type":")" + type + "\"" + more + "}";
    return accessor_count++;
  }

  template <class T>
  int add(const std::vector<T>& values, int component, std::size_t width, const std::string& type,
          const std::string& more = "") {
    return add_accessor(add_view(values.data(), values.size() * sizeof(T)), component, values.size() / width,
                        type, more);
  }
  int vec2s(const std::vector<float>& values) { return add(values, 5126, 2, "VEC2"); }
  int vec3s(const std::vector<float>& values) { return add(values, 5126, 3, "VEC3"); }
  int vec4s(const std::vector<float>& values) { return add(values, 5126, 4, "VEC4"); }
  int indices(const std::vector<std::uint16_t>& values) { return add(values, 5123, 1, "SCALAR"); }

  std::string json(const std::string& uri) const {
    std::string text = R"({"asset":{"version":"2.0"},)" + scenes + R"(,"nodes":)" + nodes + R"(,"meshes":[)" +
                       meshes + "]" + members;
    if (view_count) {
      text += R"(,"buffers":[{"byteLength":)" + std::to_string(bin.size()) +
              (uri.empty() ? "" : R"(,"uri":")" + uri + "\"") + "}]";
      text += R"(,"bufferViews":[)" + views + "]";
    }
    if (accessor_count) text += R"(,"accessors":[)" + accessors + "]";
    return text + "}";
  }

  std::string gltf() const { return json("data:application/octet-stream;base64," + base64(bin)); }

  Bytes glb() const {
    std::string text = json("");
    text.resize((text.size() + 3) / 4 * 4, ' ');
    Bytes body = bin, bytes;
    body.resize((body.size() + 3) / 4 * 4, 0);
    const std::size_t tail = body.empty() ? 0 : 8 + body.size();
    for (const std::uint32_t word :
         {0x46546C67u, 2u, std::uint32_t(20 + text.size() + tail), std::uint32_t(text.size()), 0x4E4F534Au})
      put_word(bytes, word);
    bytes.insert(bytes.end(), text.begin(), text.end());
    if (body.empty()) return bytes;
    put_word(bytes, std::uint32_t(body.size()));
    put_word(bytes, 0x004E4942u);
    bytes.insert(bytes.end(), body.begin(), body.end());
    return bytes;
  }
};

/// A mesh's JSON with one primitive: its attributes, then further members, each with a comma in front.
inline std::string mesh_json(const std::string& attributes, const std::string& more = "") {
  return R"({"primitives":[{"attributes":{)" + attributes + "}" + more + "}]}";
}

inline const std::vector<float> corner_positions{0, 0, 0, 1, 0, 0, 0, 1, 0};

/// One triangle in the plane z = 0, facing +z, without normals.
inline Builder triangle() {
  Builder builder;
  builder.vec3s(corner_positions);
  builder.meshes = mesh_json(R"("POSITION":0)");
  return builder;
}

/// A unit square of two triangles that share an edge, with normals +z and uv whose v runs down.
inline Builder square() {
  Builder builder;
  builder.vec3s({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0});
  builder.vec3s({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1});
  builder.vec2s({0, 1, 1, 1, 1, 0, 0, 0});
  builder.indices({0, 1, 2, 0, 2, 3});
  builder.meshes = mesh_json(R"("POSITION":0,"NORMAL":1,"TEXCOORD_0":2)", R"(,"indices":3)");
  return builder;
}

inline coppice::Scene load_json(const std::string& json) {
  const Folder folder;
  return coppice::load_gltf(folder.write("scene.gltf", json));
}

inline coppice::Scene load(const Builder& builder) { return load_json(builder.gltf()); }

/// The message with which loading fails; empty where it does not.
inline std::string complaint_of(const std::string& json) {
  try {
    load_json(json);
    return "";
  } catch (const coppice::InputError& error) {
    return error.what();
  }
}

inline std::string complaint_of(const Builder& builder) { return complaint_of(builder.gltf()); }

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

inline bool near(const coppice::vec3& a, const coppice::vec3& b, float tolerance = 1e-6f) {
  return coppice::length(a - b) <= tolerance;
}

/// A PNG of unfiltered, uncompressed RGBA rows; `bits` is 8 or 16 (big-endian samples).
Bytes png(std::uint32_t width, std::uint32_t height, const Bytes& samples, int bits = 8);

/// 8×8 texels of about (200, 100, 50).
Bytes small_jpeg();

}  // namespace gltf_test
