// How direct light at the samples of a room becomes indirect light there.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <coppice/embree/threads.hpp>
#include <coppice/embree/tracer.hpp>
#include <coppice/store/stored_room.hpp>
#include <coppice/transfer/clustered_samples.hpp>
#include <coppice/transfer/transfer_matrix.hpp>
#include <coppice/transfer/transport_aware_basis.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <support/words.hpp>

namespace coppice::program {

inline const Words<LightBasisKind> light_basis_words{{"transport", LightBasisKind::transport_aware},
                                                     {"uncentred", LightBasisKind::uncentred},
                                                     {"paper", LightBasisKind::paper}};

struct RoomTransferOptions {
  LightBasisKind basis = LightBasisKind::transport_aware;
  std::size_t rank = 20;           ///< vectors a cluster, in the mean
  std::size_t receiver_rank = 40;  ///< patterns a receiver cluster
  int bits = 8;                    ///< 8 or 16, of all that is stored
  std::size_t example_lights = 4000;
  std::uint32_t rays = 1024;  ///< a sample, of the transport
  std::uint32_t bounces = 6;
  bool tail = true;  ///< what bounces after the last would add is estimated
  std::uint64_t seed = 0;
};

/// The light that goes to and fro between samples, without a basis.
struct RoomSolver {
  Transport transport;
  std::vector<vec3> albedos, tail;
  InterreflectionOptions options;

  RoomSolver(const Scene& scene, const ClusteredSamples& samples, const RoomTransferOptions& options,
             const EmbreeTracer& tracer, const Threads& threads);
  RoomSolver(RoomSolver&&) = delete;
  /// Indirect irradiance at all samples.
  std::vector<vec3> solve(std::span<const vec3> direct, const Threads& threads) const;
};

/// The direct light of a frame at all samples.
struct DirectLight {
  std::vector<vec3> direct;   ///< of several lights
  std::vector<float> grey{};  ///< of one alone in their place: at an intensity of 1
  vec3 colour{0};             ///< Σ intensities of the lights
};

/// Threads outlive it.
class RoomTransfer {
 public:
  virtual ~RoomTransfer() = default;
  /// The indirect irradiance at all samples. `stages` gets milliseconds.
  virtual void indirect(const DirectLight& light, std::span<vec3> out, nlohmann::json& stages) const = 0;
  virtual std::size_t bytes() const = 0;
  /// For the report: kind, ranks, bytes.
  virtual nlohmann::json summary() const = 0;
};

/// Finds bases and matrices; `lights`: positions of example lights. `seconds` gets the stages.
StoredLightTransfer find_room_transfer(const RoomTransferOptions& options, const ClusteredSamples& samples,
                                       const RoomSolver& solver, std::span<const vec3> lights,
                                       const EmbreeTracer& tracer, const Threads& threads,
                                       nlohmann::json& seconds);

/// Throws InputError for a transfer that the backend, "cpu" or "vulkan", does not have.
void check_backend(const RoomTransferOptions& options, const std::string& backend);

/// Serves a transfer that find_room_transfer found by these options. Throws InputError where the backend does
/// not have it.
std::unique_ptr<RoomTransfer> make_room_transfer(const RoomTransferOptions& options,
                                                 StoredLightTransfer transfer, const Threads& threads,
                                                 const std::string& backend = "cpu");

}  // namespace coppice::program
