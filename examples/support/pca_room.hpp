// What is precomputed of a room: its samples, their shadows, and the light between them.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <coppice/transfer/clusters.hpp>
#include <coppice/transfer/coverage.hpp>
#include <coppice/transfer/room_samples.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <support/room_shadows.hpp>
#include <support/room_transfer.hpp>

namespace coppice::program {

struct PcaRoomOptions {
  RoomSampleOptions samples;
  ClusterOptions clusters;
  std::vector<std::string> starts;  ///< "x,y,z"; empty: the camera
  RoomShadowOptions shadows;
  RoomTransferOptions transfer;
  Shading shading = Shading::metallic_roughness;
  std::string backend = "cpu";  ///< where shadows and transfer are evaluated: "cpu" or "vulkan"
  std::uint64_t seed = 0;
};

/// Where the light of a room is stored.
struct RoomSamples {
  ClusteredSamples clustered;
  ParticleField field;                     ///< empty where the samples come from a store
  std::optional<CoverageReport> coverage;  ///< not there either
};
RoomSamples make_room_samples(const PcaRoomOptions& options, const Scene& scene, const vec3& eye,
                              const EmbreeTracer& tracer, const Threads& threads, nlohmann::json& seconds);

nlohmann::json coverage_json(const CoverageReport& coverage);

/// All of it. Scene, tracer and threads outlive it; it stays where it is made.
struct PcaRoom {
  nlohmann::json seconds = nlohmann::json::object();  ///< of each stage; filled by the others, so first
  RoomSamples samples;
  std::unique_ptr<RoomShadows> shadows;
  std::unique_ptr<RoomTransfer> transfer;
  std::string store_note;  ///< what was done with the store and why; empty without one

  /// Read from `store` where that fits, else computed, and written there; an empty path is no store.
  PcaRoom(const PcaRoomOptions& options, const Scene& scene, const vec3& eye, const EmbreeTracer& tracer,
          const Threads& threads, const std::filesystem::path& store = {});
  PcaRoom(PcaRoom&&) = delete;
  /// Made when it is first asked for: a room from a store needs none but for reference.
  const RoomSolver& solver();
  nlohmann::json summary() const;

 private:
  StoredRoom compute(const vec3& eye);

  const PcaRoomOptions options_;
  const Scene& scene_;
  const EmbreeTracer& tracer_;
  const Threads& threads_;
  std::optional<RoomSolver> solver_;
};

}  // namespace coppice::program
