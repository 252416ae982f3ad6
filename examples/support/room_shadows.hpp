// How the samples of a room learn which lights they see.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <coppice/embree/threads.hpp>
#include <coppice/embree/tracer.hpp>
#include <coppice/store/stored_room.hpp>
#include <coppice/transfer/clustered_samples.hpp>
#include <coppice/transfer/depth_visibility.hpp>
#include <coppice/transfer/lattice_visibility.hpp>
#include <coppice/transfer/particles.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <support/words.hpp>

namespace coppice::program {

enum class RoomVisibility {
  lattice,  ///< fitted to lights on and about a lattice in the free space
  depth,    ///< hemispherical depth maps in PCA bases, as in the paper
  rays      ///< shadow rays, nothing precomputed
};
inline const Words<RoomVisibility> room_visibility_words{
    {"lattice", RoomVisibility::lattice}, {"depth", RoomVisibility::depth}, {"rays", RoomVisibility::rays}};
inline const Words<LatticeShadow> lattice_shadow_words{{"hard", LatticeShadow::hard},
                                                       {"smooth", LatticeShadow::smooth}};
inline const Words<Dome> dome_words{{"hemisphere", Dome::hemisphere}, {"sphere", Dome::sphere}};

struct RoomShadowOptions {
  RoomVisibility kind = RoomVisibility::lattice;
  std::size_t rank = 0;               ///< 0: 40 for the lattice, 50 for depth
  int bits = 8;                       ///< 8 or 16, of all that is stored
  std::size_t lattice_points = 2400;  ///< at most
  std::uint32_t training = 5;         ///< lights for each lattice point
  LatticeShadow shadow = LatticeShadow::hard;
  Dome dome = Dome::hemisphere;
  std::uint32_t directions = 2016;
  int intervals = 15;  ///< rounds of interval PCA; 0: plain PCA
  std::uint64_t seed = 0;

  std::size_t rank_in_force() const { return rank > 0 ? rank : kind == RoomVisibility::depth ? 50 : 40; }
};

/// Threads, tracer and samples outlive it.
class RoomShadows {
 public:
  virtual ~RoomShadows() = default;
  /// Visibility in [0, 1] of a light of `points` points at every sample.
  virtual void see(const SizedLight& light, std::uint32_t points, std::span<float> out) const = 0;
  virtual std::size_t bytes() const = 0;
  /// For the report: kind, rank, bytes, counts.
  virtual nlohmann::json summary() const = 0;
};

/// Precomputes what a store keeps: the lattice, nothing of the other kinds. `seconds` gets the stages.
StoredLightVisibility fit_room_visibility(const RoomShadowOptions& options, const ClusteredSamples& samples,
                                          std::span<const Flight> flights, const EmbreeTracer& tracer,
                                          const Threads& threads, nlohmann::json& seconds);

/// Throws InputError for shadows that the backend, "cpu" or "vulkan", does not have.
void check_backend(const RoomShadowOptions& options, const std::string& backend);

/// Serves `visibility`, which fit_room_visibility found by these options. Depth is precomputed here;
/// `seconds` gets its stage, and flights serve nothing else. Throws InputError where the backend does not
/// have it.
std::unique_ptr<RoomShadows> make_room_shadows(const RoomShadowOptions& options,
                                               StoredLightVisibility visibility,
                                               const ClusteredSamples& samples,
                                               std::span<const Flight> flights, const EmbreeTracer& tracer,
                                               const Threads& threads, nlohmann::json& seconds,
                                               const std::string& backend = "cpu");

}  // namespace coppice::program
