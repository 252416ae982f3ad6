// What the data-driven tree gains: mean pieces and RMS error of visibility cuts by β and σ, over one set of
// receivers a scene, and the error of the image. Prints a table, which scripts/plot_betas.py draws (after
// Cuts Fig. 8b). Usage: betas ENVIRONMENT SCENE...
#include "betas.hpp"

#include <coppice/core/error.hpp>
#include <coppice/embree/tracer.hpp>
#include <coppice/exr/read.hpp>
#include <coppice/gltf/load.hpp>
#include <coppice/trade/errors.hpp>
#include <cstdio>
#include <filesystem>

namespace coppice::bench {
namespace {

const Threads threads;

/// A tree: β, and whether Eq. 12's constant scales visibility.
struct Mixture {
  const char* name;
  float beta;
  MetricScale scale = MetricScale::variance;
};
constexpr Mixture mixtures[]{{"1", 1},      {"0.9", 0.9f},
                             {"0.5", 0.5f}, {"0.25", 0.25f},
                             {"0", 0},      {"0.5, constant of Eq. 12", 0.5f, MetricScale::constant}};
constexpr double sigmas[]{1, 2, 3};
constexpr std::size_t usual_sigma = 1, nodes = 64;
constexpr std::size_t measured_stride = 8;  // every how manieth receiver counts for the RMS

/// By threshold and unweighted, as in the paper, for each σ, then as the library makes them.
std::vector<VisibilityCutOptions> cut_options() {
  std::vector<VisibilityCutOptions> options;
  for (const double sigma : sigmas)
    options.push_back({sigma, VisibilityCutOptions{}.max_size, CutWeight::uniform, CutSearch::threshold});
  for (const double sigma : sigmas) options.push_back({sigma});
  return options;
}

CutRelightingOptions settings() {
  CutRelightingOptions o;
  o.raster = {320, 180, 1};
  o.refine.max_receivers = 20000;
  o.keep_bits = true;
  return o;
}

VisibilityRows rows_of_all(const CutRelighting<>& relighting) {
  std::vector<std::uint32_t> all(relighting.receivers().size());
  std::iota(all.begin(), all.end(), 0u);
  VisibilityRows rows(relighting.tree().leaf_count(), all);
  for (std::size_t i = 0; i < rows.size(); ++i)
    std::ranges::copy(relighting.bits().subspan(i * rows[i].size(), rows[i].size()), rows[i].begin());
  return rows;
}

double mean_pieces(const MaskedCuts<std::uint8_t>& cuts) {
  double pieces = 0;
  for (std::size_t i = 0; i < cuts.size(); ++i) pieces += double(cuts.piece_count(i));
  return pieces / double(cuts.size());
}

/// Σ w and Σ w (v - value of the cut)² over the lights.
struct WeightedSquares {
  double weight = 0, squares = 0;
};

WeightedSquares squares_of(const Cut<std::uint8_t>& cut, std::span<const std::uint64_t> row,
                           const DirectionPackets& lights, const ReceiverHorizon& horizon) {
  WeightedSquares sum;
  for_each_piece(cut.ends, [&](LeafRange r, std::size_t piece) {
    const float value = float(cut.values[piece]) / float(quantised_one<std::uint8_t>);
    for (std::uint32_t leaf = r.begin; leaf < r.end; ++leaf) {
      const float cosine = dot(horizon.normal, lights.direction(leaf));
      const float weight = std::max(0.0f, (cosine - horizon.cosine) / (1 - horizon.cosine));
      const float difference = (bit_at(row.data(), leaf) ? 1.0f : 0.0f) - value;
      sum.weight += double(weight);
      sum.squares += double(weight * difference * difference);
    }
  });
  return sum;
}

/// Root mean square of visibility minus cut, weighted as the cuts are. no_horizon weighs all lights alike.
double rms(const MaskedCuts<std::uint8_t>& cuts, const VisibilityRows& rows, const DirectionPackets& lights,
           std::span<const Receiver> receivers, CutWeight weight) {
  std::vector<WeightedSquares> each((receivers.size() + measured_stride - 1) / measured_stride);
  threads(each.size(), 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t r = i * measured_stride;
      each[i] = squares_of(cuts.unpack(r), rows[r], lights, horizon_of(receivers[r], weight));
    }
  });
  WeightedSquares sum;
  for (const auto& e : each) sum.weight += e.weight, sum.squares += e.squares;
  return std::sqrt(sum.squares / sum.weight);
}

/// A scene, prepared once; its rows of visibility can be put in the order of any tree.
class Subject {
 public:
  Subject(const std::filesystem::path& path, const Environment& environment)
      : name_(path.stem().string()),
        scene_(load_gltf(path)),
        tracer_(scene_),
        relighting_(scene_, tracer_, camera(path), environment, settings(), threads),
        pilot_(pilot_visibility(relighting_, {})),
        lights_(EnvironmentCells(even_directions(settings().light_count, settings().seed),
                                 environment.map.width, environment.map.height)
                    .gather(environment)),
        reference_(
            relighting_.shade_by_brute_force<Skip::unseen>(relighting_.light(environment, 1), threads)) {}

  void print(const Mixture& mixture) const {
    PilotOptions pilots;
    pilots.scale = mixture.scale;
    const LightTree tree = tree_for(relighting_, pilot_, mixture.beta, pilots);
    VisibilityRows rows = rows_of_all(relighting_);
    reorder(rows, relighting_.tree(), tree, threads);
    const DirectionPackets lights(leaf_directions(tree, relighting_.directions()));
    const auto options = cut_options();
    const auto made = precompute_visibility<std::uint8_t>(tracer_, tree, lights, relighting_.receivers(),
                                                          options, false, threads, {}, rows);
    for (std::size_t o = 0; o < options.size(); ++o) {
      const bool is_weighted = options[o].weight == CutWeight::cosine;
      std::printf("| %s | %s | %s | %g | %.1f | %.4f |", name_.c_str(),
                  is_weighted ? "cosine-optimal" : "uniform-threshold", mixture.name, options[o].sigma,
                  mean_pieces(made.cuts[o]),
                  rms(made.cuts[o], rows, lights, relighting_.receivers(), options[o].weight));
      if (options[o].sigma == sigmas[usual_sigma] && is_weighted)
        std::printf(" %.2f%% | %.2f%% |", 100 * image_error(tree, made.cuts[o], Lobes::refined),
                    100 * image_error(tree, made.cuts[o], Lobes::sampled));
      else
        std::printf(" | |");
      std::printf("\n");
    }
    std::fflush(stdout);
  }

 private:
  const Camera& camera(const std::filesystem::path& path) const {
    if (!scene_.camera) throw InputError(path.string(), "has no camera", "add one to the glTF file");
    return *scene_.camera;
  }

  double image_error(const LightTree& tree, const MaskedCuts<std::uint8_t>& cuts, Lobes lobes) const {
    const FrameLighting frame =
        light_frame(tree, lights_, relighting_.directions(), nodes, cuts.granule_log2());
    Image image(int(reference_.size()), 1), reference = image;
    threads(relighting_.buffer().faces.size(), 64, [&](std::size_t begin, std::size_t end) {
      relighting_.kernels().shade_faces(relighting_.buffer(), cuts, frame, {lobes}, begin, end, image.pixels,
                                        {});
    });
    reference.pixels = reference_;
    return image_errors(image, reference, std::vector<bool>(reference_.size(), true)).rel_rmse;
  }

  std::string name_;
  Scene scene_;
  EmbreeTracer tracer_;
  CutRelighting<> relighting_;
  PilotVisibility pilot_;
  std::vector<CellLight> lights_;
  std::vector<vec3> reference_;  // by shading point
};

void print_table(const char* environment, std::span<char*> scenes) {
  const Environment sky = read_environment(environment);
  std::printf(
      "| scene | cuts | β | σ | mean pieces | RMS of visibility | relRMSE, %zu nodes, refined lobes "
      "| sampled lobes |\n|---|---|---|---|---|---|---|---|\n",
      nodes);
  for (const char* path : scenes) {
    const Subject subject(path, sky);
    for (const Mixture& m : mixtures) subject.print(m);
  }
}

}  // namespace
}  // namespace coppice::bench

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "betas: takes an environment and scenes: ENVIRONMENT SCENE...\n");
    return 2;
  }
  try {
    coppice::bench::print_table(argv[1], {argv + 2, std::size_t(argc - 2)});
  } catch (const coppice::InputError& e) {
    std::fprintf(stderr, "betas: %s\n", e.what());
    return 2;
  }
}
