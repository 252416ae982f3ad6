#include "document.hpp"

#include <algorithm>
#include <array>
#include <coppice/core/error.hpp>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <limits>
#include <set>
#include <sstream>
#include <system_error>

namespace coppice::gltf {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<unsigned char>;

constexpr std::uint32_t magic = 0x46546C67;       // "glTF"
constexpr std::uint32_t json_chunk = 0x4E4F534A;  // "JSON"
constexpr std::uint32_t bin_chunk = 0x004E4942;   // "BIN\0"
constexpr int deepest_json = 128;                 // tinygltf and the values that it builds recurse

constexpr std::array understood_extensions = {"KHR_lights_punctual", "KHR_materials_emissive_strength",
                                              "KHR_mesh_quantization"};

[[noreturn]] void fail_file(const fs::path& file, const std::string& problem, const std::string& remedy) {
  throw InputError(one_line(file.string()), problem, remedy);
}

Bytes read_bytes(const fs::path& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (!fs::exists(status)) fail_file(file, "there is no such file", "check the path");
  if (fs::is_directory(status)) fail_file(file, "this is a directory", "name a .glb or .gltf file in it");
  if (!fs::is_regular_file(status))
    fail_file(file, "this is not a regular file", "name a .glb or .gltf file");
  const std::uintmax_t size = fs::file_size(file, error);
  if (error) fail_file(file, "its size cannot be read", "check the file's permissions");
  if (size == 0) fail_file(file, "the file is empty", "export it again");
  if (size > std::numeric_limits<std::uint32_t>::max())
    fail_file(file, "the file is larger than 4 GiB", "split it or move data to buffers of their own");
  Bytes bytes(static_cast<std::size_t>(size));
  std::ifstream stream(file, std::ios::binary);
  if (!stream.read(reinterpret_cast<char*>(bytes.data()), std::streamsize(size)))
    fail_file(file, "the file cannot be read", "check its permissions");
  return bytes;
}

std::uint32_t word(const Bytes& bytes, std::size_t offset) {
  const unsigned char* p = bytes.data() + offset;
  return std::uint32_t(p[0]) | std::uint32_t(p[1]) << 8 | std::uint32_t(p[2]) << 16 |
         std::uint32_t(p[3]) << 24;
}

bool is_binary(const Bytes& bytes) { return bytes.size() >= 4 && word(bytes, 0) == magic; }

// Checks the container (glTF 2.0, section 4.4) and returns its JSON. tinygltf 2.7 lets a BIN chunk end up to
// 8 bytes beyond the data, so nothing of this may be left to it.
std::string_view json_of_container(const fs::path& file, const Bytes& bytes) {
  const auto broken = [&](const std::string& problem) {
    fail_file(file, problem, "the file may be cut short; export or copy it again");
  };
  if (bytes.size() < 20) broken("a .glb of " + std::to_string(bytes.size()) + " bytes is too short");
  const std::uint64_t length = word(bytes, 8), json_length = word(bytes, 12);
  if (word(bytes, 4) != 2) broken("the .glb has version " + std::to_string(word(bytes, 4)) + ", not 2");
  if (length > bytes.size())
    broken("the header promises " + std::to_string(length) + " bytes, there are " +
           std::to_string(bytes.size()));
  if (word(bytes, 16) != json_chunk) broken("the first chunk of the .glb is not JSON");
  if (json_length > length || json_length + 20 > length) broken("the JSON chunk reaches beyond the .glb");
  const std::uint64_t rest = length - 20 - json_length;
  if (rest > 0) {
    const std::size_t chunk = 20 + std::size_t(json_length);
    if (rest < 8) broken("the second chunk of the .glb has no header");
    if (word(bytes, chunk) > rest - 8) broken("the BIN chunk reaches beyond the .glb");
    if (word(bytes, chunk + 4) != bin_chunk) broken("the second chunk of the .glb is not BIN");
  }
  return {reinterpret_cast<const char*>(bytes.data()) + 20, std::size_t(json_length)};
}

int json_depth(std::string_view json) {
  int depth = 0, deepest = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (in_string && c == '\\') ++i;
    if (c == '"') in_string = !in_string;
    if (in_string) continue;
    if (c == '{' || c == '[') deepest = std::max(deepest, ++depth);
    if (c == '}' || c == ']') --depth;
  }
  return deepest;
}

// Images are decoded later, once the range of their buffer view has been checked; `bytes` of a buffer view
// has not.
bool keep_encoded(tinygltf::Image* image, const int, std::string*, std::string*, int, int,
                  const unsigned char* bytes, int size, void*) {
  if (image->bufferView < 0 && size > 0) image->image.assign(bytes, bytes + size);
  return true;
}

bool is_file_beside(const std::string& path, void* directory) {
  const std::string& beside = *static_cast<const std::string*>(directory);
  std::error_code error;
  return path.starts_with(beside) && fs::is_regular_file(path, error);  // tinygltf would try "." as well
}

std::string same_path(const std::string& path, void*) { return path; }

bool read_beside(Bytes* bytes, std::string* error, const std::string& path, void*) {
  try {
    *bytes = read_bytes(path);
    return true;
  } catch (const InputError& refused) {
    *error += refused.what();
    return false;
  }
}

// A channel whose target an extension defines is valid, and tinygltf calls it an error.
bool concerns_open_target(const std::string& line) {
  return line == "'node' property is missing." || line.find("`node` field") != std::string::npos;
}

bool concerns_animation(const std::string& line) { return line.find("nimation") != std::string::npos; }

struct Complaints {
  std::string scene, animation;  // the first of each, or empty
};

// tinygltf reports some broken items, drops them, and goes on; a scene with parts missing is an error here.
// Animations count only where they are played.
Complaints first_complaints(const std::string& messages, bool loaded) {
  Complaints first;
  std::istringstream stream(messages);
  for (std::string line; std::getline(stream, line);) {
    if (line.empty() || (loaded && concerns_open_target(line))) continue;
    std::string& kind = loaded && concerns_animation(line) ? first.animation : first.scene;
    if (kind.empty()) kind = one_line(line);
  }
  if (!loaded && first.scene.empty()) first.scene = "it cannot be parsed";
  return first;
}

void parse(Document& document, const Bytes& bytes, Warnings& warnings) {
  std::string directory = (fs::absolute(document.file).parent_path() / "").string();
  tinygltf::TinyGLTF parser;
  tinygltf::FsCallbacks callbacks{};
  callbacks.FileExists = is_file_beside;
  callbacks.ExpandFilePath = same_path;
  callbacks.ReadWholeFile = read_beside;
  callbacks.user_data = &directory;
  parser.SetFsCallbacks(callbacks);
  parser.SetImageLoader(keep_encoded, nullptr);
  std::string error, warning;
  const auto size = static_cast<unsigned int>(bytes.size());
  const bool loaded =
      is_binary(bytes)
          ? parser.LoadBinaryFromMemory(&document.model, &error, &warning, bytes.data(), size, directory)
          : parser.LoadASCIIFromString(&document.model, &error, &warning,
                                       reinterpret_cast<const char*>(bytes.data()), size, directory);
  const Complaints complaints = first_complaints(error, loaded);
  if (!complaints.scene.empty())
    fail_file(document.file, complaints.scene, "export the file again as valid glTF 2.0");
  document.animation_complaint = complaints.animation;
  std::istringstream stream(warning);
  for (std::string line; std::getline(stream, line);)
    if (!line.empty()) warnings.add(one_line(line));
}

bool is_understood(const std::string& extension) {
  return std::find(understood_extensions.begin(), understood_extensions.end(), extension) !=
         understood_extensions.end();
}

void check_features(const Document& document, Warnings& warnings) {
  const tinygltf::Model& model = document.model;
  const std::string& version = model.asset.version;
  if (!version.starts_with("2."))
    document.fail("asset", "version " + one_line(version, 20) + " of glTF is not 2",
                  "convert the file to glTF 2.0");
  for (const std::string& extension : model.extensionsRequired)
    if (!is_understood(extension))
      document.fail("extensionsRequired", "extension " + one_line(extension, 60) + " is not supported",
                    "export the file without it");
  for (const std::string& extension :
       std::set<std::string>(model.extensionsUsed.begin(), model.extensionsUsed.end()))
    if (!is_understood(extension)) warnings.add("extension " + one_line(extension, 60) + " ignored");
}

}  // namespace

void Warnings::count(std::string_view what, std::size_t times) {
  if (times == 0) return;
  const auto same = [&](const auto& entry) { return entry.first == what; };
  const auto found = std::find_if(counts_.begin(), counts_.end(), same);
  if (found != counts_.end()) {
    found->second += times;
  } else {
    counts_.emplace_back(what, times);
  }
}

std::vector<std::string> Warnings::lines() const {
  std::vector<std::string> lines = lines_;
  for (const auto& [what, times] : counts_) lines.push_back(std::to_string(times) + " " + what);
  return lines;
}

std::string one_line(std::string_view text, std::size_t longest) {
  std::size_t end = std::min(text.size(), longest);
  while (end < text.size() && end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;
  std::string line(text.substr(0, end));
  for (char& c : line)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  return end < text.size() ? line + "..." : line;
}

std::string item_name(std::string_view kind, std::size_t index, std::string_view name) {
  std::string item = std::string(kind) + " " + std::to_string(index);
  if (!name.empty()) item += " \"" + one_line(name, 60) + "\"";
  return item;
}

void Document::fail(const std::string& item, const std::string& problem, const std::string& remedy) const {
  throw InputError(one_line(file.string()) + ", " + item, problem, remedy);
}

Document read_document(const fs::path& file, Warnings& warnings) {
  const Bytes bytes = read_bytes(file);
  const std::string_view json =
      is_binary(bytes) ? json_of_container(file, bytes)
                       : std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (json_depth(json) > deepest_json)
    fail_file(file, "its JSON is nested deeper than " + std::to_string(deepest_json), "remove deep extras");
  Document document{file, {}, {}};
  parse(document, bytes, warnings);
  check_features(document, warnings);
  return document;
}

}  // namespace coppice::gltf
