#include <algorithm>
#include <coppice/core/error.hpp>
#include <support/pca_options.hpp>

namespace coppice::program {

const Words<RoomLights> room_light_words{{"path", RoomLights::path}, {"scene", RoomLights::scene}};

namespace {

void add_light_options(CLI::App& app, PcaSystemOptions& o) {
  add_choice(app, "--lights", o.lights, room_light_words,
             "what lights the room: --path or --through, or the file's own lights and shining surfaces");
  CLI::Option* path = app.add_option("--path", o.path, "JSON file of lights that move: docs/trade.md");
  app.add_option("--through", o.through, "X,Y,Z ...: one light goes through these points, a second for each")
      ->excludes(path);
  app.add_option("--intensity", o.intensity, "R,G,B in W/sr, of the light of --through")
      ->capture_default_str();
  app.add_option("--light-size", o.light_size, "metres: radius of the light of --through; 0 for hard shadows")
      ->check(finite_number)
      ->check(CLI::Range(0.0f, 1e6f))
      ->capture_default_str();
  app.add_option("--light-points", o.points, "points of light that a light with a radius consists of")
      ->check(CLI::Range(1u, 1024u))
      ->capture_default_str();
  app.add_option("--emitters", o.emitters, "of --lights scene: lights at most on shining surfaces")
      ->check(CLI::Range(std::size_t{0}, std::size_t{4096}))
      ->capture_default_str();
}

void add_sample_options(CLI::App& app, PcaSystemOptions& o) {
  app.add_option("--surface-samples", o.room.samples.count, "samples on the surfaces that light can reach")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1} << 22))
      ->capture_default_str();
  app.add_option("--curvature", o.room.samples.curvature,
                 "samples are so many times nearer where surfaces curve")
      ->check(finite_number)
      ->check(CLI::Range(1.0f, 2.0f))
      ->capture_default_str();
  app.add_option("--clusters", o.room.clusters.count, "clusters, each with bases of its own")
      ->check(CLI::Range(std::size_t{1}, std::size_t{4096}))
      ->capture_default_str();
  app.add_option(
      "--start", o.room.starts,
      "X,Y,Z ...: from where particles look for surfaces; one in each room that no door joins (the "
      "camera)");
  add_choice(app, "--onto", o.target, splat_target_words,
             "where splats are summed: at pixels, or at vertices and interpolated between them");
  app.add_option("--splat-width", o.splats.width, "standard deviation of a splat, in spacings of samples")
      ->check(finite_number)
      ->check(CLI::Range(0.1f, 4.0f))
      ->capture_default_str();
}

void add_visibility_options(CLI::App& app, PcaSystemOptions& o) {
  RoomShadowOptions& s = o.room.shadows;
  add_choice(app, "--visibility", s.kind, room_visibility_words, "how samples know which lights they see");
  app.add_option("--visibility-rank", s.rank,
                 "vectors of a cluster's basis; 0: 40 for the lattice, 50 for depth")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  app.add_option("--visibility-bits", s.bits, "of coefficients and bases")
      ->check(CLI::IsMember({8, 16}))
      ->capture_default_str();
  app.add_option("--lattice-points", s.lattice_points, "positions of lights in the free space, at most")
      ->check(CLI::Range(std::size_t{8}, std::size_t{1} << 20))
      ->capture_default_str();
  add_choice(app, "--shadow", s.shadow, lattice_shadow_words,
             "of the lattice: a decision for each point of a light, or a soft value for the whole of it");
  add_choice(app, "--dome", s.dome, dome_words,
             "of depth: around each sample's normal, or fixed in the world");
  app.add_option("--directions", s.directions, "of depth: on the hemisphere")
      ->check(CLI::Range(16u, 16384u))
      ->capture_default_str();
  app.add_option("--intervals", s.intervals, "of depth: rounds of interval PCA; 0 for plain PCA")
      ->check(CLI::Range(0, 64))
      ->capture_default_str();
}

void add_transfer_options(CLI::App& app, PcaSystemOptions& o) {
  RoomTransferOptions& t = o.room.transfer;
  add_choice(
      app, "--basis", t.basis, light_basis_words,
      "of direct light: that which the light between surfaces needs, or principal components of example "
      "lights about zero or, as in the paper, about their mean");
  app.add_option("--transfer-rank", t.rank, "vectors of a cluster's basis, in the mean")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  app.add_option("--receiver-rank", t.receiver_rank, "patterns of indirect light on a cluster")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  app.add_option("--transfer-bits", t.bits, "of bases, patterns and matrices")
      ->check(CLI::IsMember({8, 16}))
      ->capture_default_str();
  app.add_option("--example-lights", t.example_lights, "lights from which bases of direct light are found")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  app.add_option("--transport-rays", t.rays, "rays from each sample; 512 for drafts")
      ->check(CLI::Range(1u, 65535u))
      ->capture_default_str();
  app.add_option("--bounces", t.bounces, "from surface to surface; 0 for direct light alone")
      ->check(CLI::Range(0u, 64u))
      ->capture_default_str();
  app.add_flag("!--no-tail", t.tail, "leave out what further bounces than those would add");
}

}  // namespace

void add_pca_options(CLI::App& app, PcaSystemOptions& o) {
  add_common_options(app, o.common);
  for (const char* option : {"--env", "--rotate-env"}) app.remove_option(app.get_option(option));
  add_light_options(app, o);
  add_sample_options(app, o);
  add_visibility_options(app, o);
  add_transfer_options(app, o);
}

PcaRoomOptions room_options(const PcaSystemOptions& o) {
  PcaRoomOptions room = o.room;
  room.shading = o.common.shading;
  room.backend = o.common.backend;
  room.seed = room.shadows.seed = room.transfer.seed = o.common.seed;
  return room;
}

void check_combinations(const PcaSystemOptions& o) {
  check_backend(o.room.shadows, o.common.backend);
  check_backend(o.room.transfer, o.common.backend);
  if (!o.store.empty() && o.room.shadows.kind == RoomVisibility::depth)
    throw InputError("--store", "keeps no depth maps", "use --visibility lattice, or rays");
  const bool path = !o.path.empty() || !o.through.empty();
  if (path && o.lights == RoomLights::scene)
    throw InputError("--lights scene", "leaves --path and --through without meaning",
                     "name one of them alone");
  parse_vector("--intensity", o.intensity);
  for (const std::string& start : o.room.starts) parse_vector("--start", start);
}

std::vector<LightPath> light_paths(const PcaSystemOptions& o) {
  if (!o.path.empty()) return read_light_paths(o.path);
  if (o.through.empty()) return {};
  return {path_through("--through", o.through, parse_vector("--intensity", o.intensity), o.light_size)};
}

nlohmann::json settings_json(const PcaSystemOptions& o) {
  const CommonOptions& c = o.common;
  const RoomShadowOptions& v = o.room.shadows;
  const RoomTransferOptions& t = o.room.transfer;
  nlohmann::json j = {{"scene", c.scene.string()},
                      {"width", c.raster.width},
                      {"height", c.raster.height},
                      {"samples", c.raster.samples},
                      {"backend", c.backend},
                      {"threads", c.threads},
                      {"seed", c.seed},
                      {"brdf", word_of(shading_words, c.shading)},
                      {"lights", word_of(room_light_words, o.lights)},
                      {"frames", o.frames},
                      {"surface_samples", o.room.samples.count},
                      {"curvature", o.room.samples.curvature},
                      {"clusters", o.room.clusters.count},
                      {"onto", word_of(splat_target_words, o.target)},
                      {"splat_width", o.splats.width},
                      {"light_points", o.points},
                      {"visibility", word_of(room_visibility_words, v.kind)},
                      {"basis", word_of(light_basis_words, t.basis)},
                      {"transfer_rank", t.rank},
                      {"receiver_rank", t.receiver_rank},
                      {"transfer_bits", t.bits},
                      {"example_lights", t.example_lights},
                      {"transport_rays", t.rays},
                      {"bounces", t.bounces},
                      {"tail", t.tail}};
  if (v.kind != RoomVisibility::rays) {
    j["visibility_rank"] = v.rank_in_force();
    j["visibility_bits"] = v.bits;
  }
  if (v.kind == RoomVisibility::lattice) {
    j["lattice_points"] = v.lattice_points;
    j["shadow"] = word_of(lattice_shadow_words, v.shadow);
  }
  if (v.kind == RoomVisibility::depth) {
    j["dome"] = word_of(dome_words, v.dome);
    j["directions"] = v.directions;
    j["intervals"] = v.intervals;
  }
  if (!o.path.empty()) j["path"] = o.path.string();
  if (!o.through.empty()) {
    j["through"] = o.through;
    j["intensity"] = o.intensity;
    j["light_size"] = o.light_size;
  }
  return j;
}

}  // namespace coppice::program
