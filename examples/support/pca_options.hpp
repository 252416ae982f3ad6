// The options of relighting a room from PCA bases.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <support/light_path.hpp>
#include <support/pca_room.hpp>
#include <support/pca_view.hpp>
#include <support/program.hpp>
#include <vector>

namespace coppice::program {

/// What lights the room.
enum class RoomLights {
  path,  ///< those of --path or --through
  scene  ///< the file's own lights and shining surfaces, which rest
};

struct PcaSystemOptions {
  CommonOptions common;
  PcaRoomOptions room;
  SplatOptions splats;
  SplatTarget target = SplatTarget::pixels;
  RoomLights lights = RoomLights::path;
  std::filesystem::path path;        ///< of --path; empty: none
  std::vector<std::string> through;  ///< "x,y,z", in order
  std::string intensity = "10,10,10";
  float light_size = 0;         ///< metres: radius
  std::uint32_t points = 25;    ///< of a light with a radius
  std::size_t emitters = 64;    ///< lights at most on shining surfaces
  std::filesystem::path store;  ///< where the precomputation is kept; empty: nowhere
  int frames = 1;
  bool reference = false;
};

extern const Words<RoomLights> room_light_words;

void add_pca_options(CLI::App& app, PcaSystemOptions& options);

/// Those of the room, with the program's seed and materials.
PcaRoomOptions room_options(const PcaSystemOptions& options);

/// Throws InputError for what does not go together.
void check_combinations(const PcaSystemOptions& options);

/// The lights of the command line. Throws InputError where --path or --through cannot be read.
std::vector<LightPath> light_paths(const PcaSystemOptions& options);

nlohmann::json settings_json(const PcaSystemOptions& options);

}  // namespace coppice::program
