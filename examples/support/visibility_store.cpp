#include <support/report.hpp>
#include <support/visibility_store.hpp>

namespace coppice::program {
namespace {

/// What decides which rays are blocked, and how points are shaded between receivers.
std::string fingerprint_of(const Scene& scene) {
  Fingerprint f;
  add_mesh(f, scene.mesh);
  for (const Material& m : scene.materials) {
    const float holes[] = {m.alpha, m.alpha_mask ? m.alpha_cutoff : -1, m.double_sided ? 1.0f : 0.0f,
                           m.normal_texture >= 0 ? 1.0f : 0.0f};
    f.add_values(std::span<const float>(holes));
    if (m.alpha_mask && m.base_color_texture >= 0)
      f.add_values(all(scene.textures[std::size_t(m.base_color_texture)].rgba));
  }
  return f.text();
}

std::string fingerprint_of(const Camera& camera) {
  const float values[] = {camera.position.x, camera.position.y,  camera.position.z, camera.forward.x,
                          camera.forward.y,  camera.forward.z,   camera.up.x,       camera.up.y,
                          camera.up.z,       camera.vertical_fov};
  return Fingerprint().add_values(std::span<const float>(values)).text();
}

/// In the order in which a user would want to hear of a difference.
Settings settings_of(const SystemOptions& o, const Inputs& in) {
  const nlohmann::json all = settings_json(o.common, o.cut);
  Settings settings{{"program", "cut_relighting 1"},
                    {"lights", word_of(light_words, o.lights)},
                    {"scene", fingerprint_of(in.scene)},
                    {"camera", fingerprint_of(in.camera)}};
  nlohmann::json knobs = {{"sigma", o.knobs.sigma},
                          {"weight", word_of(weight_words, o.knobs.cuts.weight)},
                          {"search", word_of(search_words, o.knobs.cuts.search)},
                          {"max_cut_size", o.cut.max_cut_size}};
  for (const auto& [key, value] : knobs.items()) settings.push_back({key, value.dump()});
  for (const char* key : {"width", "height", "samples", "seed", "receiver_tolerance", "max_receivers",
                          "receivers", "longest_edge", "beta"})
    settings.push_back({key, all.at(key).dump()});
  return settings;
}

}  // namespace

std::string fingerprint_of(std::span<const LocalLight> lights) {
  Fingerprint f;
  for (const LocalLight& l : lights) {
    const float place[] = {l.position.x, l.position.y, l.position.z, l.w,      l.axis.x,
                           l.axis.y,     l.axis.z,     l.offset,     l.square, l.area};
    f.add_values(std::span<const float>(place));
  }
  return f.text();
}

std::string fingerprint_of(std::span<const vec3> directions) {
  return Fingerprint().add_values(directions).text();
}

VisibilityStore::VisibilityStore(const SystemOptions& options, const Inputs& in) : path_(options.store) {
  if (!path_.empty()) settings_ = settings_of(options, in);
}

std::filesystem::path VisibilityStore::path(const std::string& part) const {
  std::filesystem::path path = path_;
  return part.empty() ? path : path.replace_extension("." + part + path_.extension().string());
}

Settings VisibilityStore::settings(const std::string& lights) const {
  Settings all = settings_;
  all.push_back({"light_places", lights});
  return all;
}

template <Quantised Value>
std::optional<StoredVisibility<Value>> VisibilityStore::read(const std::string& part,
                                                             const std::string& lights) {
  if (path_.empty() || !note_.fits(path(part), settings(lights), read_settings)) return std::nullopt;
  auto visibility = read_store<Value>(path(part));
  note_.tell_reused(path(part));
  return visibility;
}

template <Quantised Value>
void VisibilityStore::write(const std::string& part, const std::string& lights,
                            StoredVisibility<Value> visibility) {
  if (path_.empty()) return;
  visibility.settings = settings(lights);
  write_store(path(part), visibility);
}

template std::optional<StoredVisibility<std::uint8_t>> VisibilityStore::read(const std::string&,
                                                                             const std::string&);
template std::optional<StoredVisibility<std::uint16_t>> VisibilityStore::read(const std::string&,
                                                                              const std::string&);
template void VisibilityStore::write(const std::string&, const std::string&, StoredVisibility<std::uint8_t>);
template void VisibilityStore::write(const std::string&, const std::string&, StoredVisibility<std::uint16_t>);

}  // namespace coppice::program
