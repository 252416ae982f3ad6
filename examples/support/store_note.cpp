#include <cstdio>
#include <support/store_note.hpp>

namespace coppice::program {

void add_mesh(Fingerprint& f, const Mesh& mesh) {
  f.add_values(all(mesh.positions)).add_values(all(mesh.normals)).add_values(all(mesh.uvs));
  f.add_values(all(mesh.triangles)).add_values(all(mesh.materials));
}

bool StoreNote::fits(const std::filesystem::path& file, const Settings& wanted,
                     Settings (*read)(const std::filesystem::path&)) {
  if (std::error_code ignored; !std::filesystem::exists(file, ignored)) {
    say("store " + file.string() + " is new");
    return false;
  }
  const std::string difference = first_difference(read(file), wanted);
  if (!difference.empty()) say("store " + file.string() + " " + difference + ": computed anew");
  return difference.empty();
}

void StoreNote::tell_reused(const std::filesystem::path& file) {
  say("store " + file.string() + " is reused");
}

void StoreNote::say(const std::string& text) {
  text_ += (text_.empty() ? "" : "; ") + text;
  std::fprintf(stderr, "%s\n", text.c_str());
}

}  // namespace coppice::program
