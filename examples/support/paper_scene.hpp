// A scene as the table of the Cuts paper (Fig. 9) sees it: traced once, then cut by any tree.
#pragma once

#include <coppice/relight/pilot_visibility.hpp>
#include <functional>
#include <memory>
#include <string>
#include <support/system.hpp>
#include <vector>

namespace coppice::program {

/// How visibility is cut and lobes meet clusters.
struct PaperWay {
  CutKind cuts;
  Lobes lobes = LobeOptions{}.lobes;
};

/// What a frame takes of one thread, and how far its points are off.
struct PaperFrame {
  std::size_t nodes = 0;               ///< of the illumination cut at most
  std::vector<double> milliseconds{};  ///< a repetition each
  double rel_rmse = 0;                 ///< against all lights, with the same receivers
};

/// One set of visibility cuts.
struct PaperCuts {
  double sigma = 0, pieces = 0;  ///< threshold, and mean pieces a receiver
  double rms = 0;                ///< of visibility minus cut; PaperScene tells of what
  double seconds = 0;            ///< to select them
  std::size_t bytes = 0, file_bytes = 0;
  std::vector<PaperFrame> frames{};
};

struct PaperCounts {
  std::size_t triangles = 0, receivers = 0, points = 0, lights = 0;
};

/// What one set of cuts is asked for.
struct PaperRequest {
  double sigma = 0;
  PaperWay way;
  std::vector<std::size_t> nodes{};  ///< of the illumination cuts; empty: neither frames nor a file
  int repeat = 1;                    ///< repetitions of each frame
};

/// All visibility of a scene's receivers, in the order of a light tree that can be exchanged.
class PaperScene {
 public:
  virtual ~PaperScene() = default;

  const PaperCounts& counts() const { return counts_; }
  double receiver_seconds() const { return receiver_seconds_; }  ///< camera and refinement
  double ray_seconds() const { return ray_seconds_; }            ///< visibility of all receivers
  double tree_seconds() const { return tree_seconds_; }          ///< of the tree in use and those before it

  /// Clusters the lights anew by Eq. 13. The pilots' visibility is known, so that no ray is traced for it.
  void drive_tree_by_data(float beta);

  /// Selects the cuts of all receivers by the tree in use. The RMS is over every eighth receiver: under an
  /// environment of visibility, weighted as the cuts are; of lights in the scene of V·G divided by its root
  /// mean square at the receiver, each receiver alike.
  virtual PaperCuts measure(const PaperRequest& request) = 0;

 protected:
  PaperScene(const SystemOptions& options, Inputs& in, const EmbreeTracer& tracer, const Threads& threads)
      : options_(options), in_(in), tracer_(tracer), threads_(threads) {}

  virtual std::vector<LightSample> light_samples() const = 0;
  virtual const PreparedView& view() const = 0;
  void count(std::size_t lights);

  /// Root of Σ squares / Σ weight over receivers, and the mean of their pieces.
  struct Sums {
    double weight = 0, squares = 0;
  };
  double root_mean(const std::function<Sums(std::size_t receiver)>& sums) const;

  SystemOptions options_;
  Inputs& in_;
  const EmbreeTracer& tracer_;
  const Threads& threads_;
  LightTree tree_;
  VisibilityRows rows_;  // of all receivers, in the order of tree_
  PaperCounts counts_;
  double receiver_seconds_ = 0, ray_seconds_ = 0, tree_seconds_ = 0;
};

/// Traces it. Inputs, tracer and threads outlive the result. Of `options.lights` indirect is the bounce
/// alone. Throws InputError where nothing shines.
std::unique_ptr<PaperScene> make_paper_scene(const SystemOptions& options, Inputs& in,
                                             const EmbreeTracer& tracer, const Threads& threads);

}  // namespace coppice::program
