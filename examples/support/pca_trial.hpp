// One way from direct to indirect light, made from a room's solver and example lights that several ways
// share.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <support/pca_settings.hpp>

namespace coppice::program {

/// What all ways of one room share; it outlives them.
struct TrialRoom {
  const ClusteredSamples& samples;
  const RoomSolver& solver;
  Rows examples, probes;  ///< probes: of transport-aware bases; without rows where none is tried
  const Threads& threads;
};

/// Milliseconds by stage.
using Stages = std::map<std::string, double>;

/// From direct to indirect irradiance.
class TransferTrial {
 public:
  virtual ~TransferTrial() = default;
  /// Of a white light of 1 W/sr that brings `grey` to all samples. On one thread; adds milliseconds.
  virtual void indirect(std::span<const float> grey, std::span<vec3> out, Stages& stages) const = 0;
  virtual std::size_t bytes() const = 0;
};

/// A basis, and what its vectors bring to all samples.
struct SolvedBasis {
  LightBasis basis;
  Rows matrix;
};

SolvedBasis solve_basis(const TransferSetting& setting, const TrialRoom& room);
std::unique_ptr<TransferTrial> make_trial(const TransferSetting& setting, const SolvedBasis& solved,
                                          const TrialRoom& room);

}  // namespace coppice::program
