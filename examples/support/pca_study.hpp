// A room judged by lights that it was not made for: shadows, indirect light, and whole frames.
#pragma once

#include <coppice/transfer/decisions.hpp>
#include <optional>
#include <string>
#include <support/pca_options.hpp>
#include <support/pca_settings.hpp>
#include <support/pca_trial.hpp>
#include <vector>

namespace coppice::program {

struct PcaStudyOptions {
  PcaSystemOptions base;  ///< what the settings do not say
  std::vector<VisibilitySetting> visibility;
  std::vector<TransferSetting> transfer;
  std::size_t unseen = 100;        ///< lights that judge
  std::size_t frame_lights = 8;    ///< the first of them, by which whole frames are judged
  std::filesystem::path pictures;  ///< where pictures of the first room go; empty: nowhere
};

/// Means over lights of the errors of docs/trade.md.
struct MeanErrors {
  double rel_rmse = 0, mre = 0;
};

enum class StudyKind {
  visibility,  ///< shadows at all samples
  transfer,    ///< indirect light at all samples, of exact direct light
  frame        ///< what the camera sees, all reconstructed
};

/// One setting in one room.
struct StudyRow {
  StudyKind kind = StudyKind::visibility;
  std::size_t samples = 0, clusters = 0;
  std::string setting;
  std::size_t bytes = 0;
  double seconds = 0;  ///< of what is made for this setting alone
  std::optional<WrongDecisions> decisions{};
  std::optional<MeanErrors> direct{}, indirect{}, whole{};
  Stages milliseconds{};  ///< medians over the lights, on one thread
};

/// One room, and the seconds of what its settings share.
struct StudyRoom {
  std::size_t samples = 0, clusters = 0;
  float spacing = 0;  ///< m
  std::size_t transport_bytes = 0;
  nlohmann::json seconds;
};

struct StudyResult {
  std::vector<StudyRoom> rooms;
  std::vector<StudyRow> rows;
};

/// Judges rooms one after the other, by the same lights. Inputs and threads outlive it.
class PcaStudy {
 public:
  PcaStudy(const PcaStudyOptions& options, const Inputs& in, const Threads& threads);
  /// Adds the rows of a room of so many samples and clusters. Throws InputError where no surface or no free
  /// space can be reached.
  void add_room(std::size_t samples, std::size_t clusters);
  const StudyResult& result() const { return result_; }

 private:
  const PcaStudyOptions& options_;
  const Inputs& in_;
  const Threads& threads_;
  EmbreeTracer tracer_;
  std::vector<vec3> unseen_;  ///< positions, drawn in the first room
  StudyResult result_;
};

}  // namespace coppice::program
