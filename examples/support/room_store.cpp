#include <support/room_store.hpp>
//
#include <algorithm>
#include <coppice/core/error.hpp>

namespace coppice::program {
namespace {

using nlohmann::json;

void add_texture(Fingerprint& f, const Scene& scene, int index) {
  if (index < 0) return f.add({}), void();
  const Texture& t = scene.textures[std::size_t(index)];
  const int shape[] = {t.width, t.height, t.srgb, int(t.wrap_u), int(t.wrap_v)};
  f.add_values(std::span<const int>(shape)).add_values(all(t.rgba));
}

/// What decides where particles and rays go, and what surfaces give back.
std::string fingerprint_of(const Scene& scene) {
  Fingerprint f;
  add_mesh(f, scene.mesh);
  for (const Material& m : scene.materials) {
    const float values[] = {m.base_color.x, m.base_color.y,
                            m.base_color.z, m.alpha,
                            m.metallic,     m.alpha_mask ? m.alpha_cutoff : -1,
                            m.roughness,    m.double_sided ? 1.0f : 0.0f};
    f.add_values(std::span<const float>(values));
    add_texture(f, scene, m.base_color_texture);
    add_texture(f, scene, m.metallic_roughness_texture);
  }
  return f.text();
}

json starts_json(const PcaRoomOptions& o, const vec3& eye) {
  if (!o.starts.empty()) return o.starts;
  return {eye.x, eye.y, eye.z};
}

void add_visibility(Settings& settings, const RoomShadowOptions& o) {
  settings.push_back({"visibility", word_of(room_visibility_words, o.kind)});
  if (o.kind == RoomVisibility::rays) return;
  settings.push_back({"visibility_rank", std::to_string(o.rank_in_force())});
  settings.push_back({"visibility_bits", std::to_string(o.bits)});
  settings.push_back({"lattice_points", std::to_string(o.lattice_points)});
  settings.push_back({"training", std::to_string(o.training)});
}

void add_transfer(Settings& settings, const RoomTransferOptions& o) {
  settings.push_back({"basis", word_of(light_basis_words, o.basis)});
  const json numbers = {{"transfer_rank", o.rank},
                        {"receiver_rank", o.receiver_rank},
                        {"transfer_bits", o.bits},
                        {"example_lights", o.example_lights},
                        {"transport_rays", o.rays},
                        {"bounces", o.bounces},
                        {"tail", o.tail}};
  for (const auto& [key, value] : numbers.items()) settings.push_back({key, value.dump()});
}

/// In the order in which a user would want to hear of a difference. How lights and pixels are treated later
/// is left out. The program's number grows with every change of the precomputation.
Settings settings_of(const PcaRoomOptions& o, const Scene& scene, const vec3& eye) {
  Settings settings{{"program", "pca_transfer 1"},
                    {"scene", fingerprint_of(scene)},
                    {"start", starts_json(o, eye).dump()},
                    {"brdf", word_of(shading_words, o.shading)},
                    {"seed", std::to_string(o.seed)},
                    {"surface_samples", std::to_string(o.samples.count)},
                    {"curvature", json(o.samples.curvature).dump()},
                    {"clusters", std::to_string(o.clusters.count)}};
  add_visibility(settings, o.shadows);
  add_transfer(settings, o.transfer);
  return settings;
}

}  // namespace

RoomStore::RoomStore(std::filesystem::path file, const PcaRoomOptions& options, const Scene& scene,
                     const vec3& eye)
    : file_(std::move(file)), triangles_(scene.mesh.triangles.size()) {
  if (is_used()) settings_ = settings_of(options, scene, eye);
}

std::optional<StoredRoom> RoomStore::read() {
  if (!is_used() || !note_.fits(file_, settings_, read_room_settings)) return std::nullopt;
  StoredRoom room = read_room(file_);
  if (std::ranges::any_of(room.samples.samples,
                          [&](const SurfaceSample& s) { return s.side.triangle >= triangles_; }))
    throw InputError(file_.string(), "has samples on triangles that the scene lacks",
                     "remove the file and compute it again");
  note_.tell_reused(file_);
  return room;
}

void RoomStore::write(const ClusteredSamples& samples, StoredRoom& room) const {
  room.settings = settings_, room.samples = samples;
  write_room(file_, room);
}

}  // namespace coppice::program
