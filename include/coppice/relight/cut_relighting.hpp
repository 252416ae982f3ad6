// The system of the Cuts paper for environment lighting: precomputed visibility cuts, dynamic BRDFs, any
// environment.
#pragma once

#include <coppice/light/directions.hpp>
#include <coppice/relight/compiled_kernels.hpp>
#include <coppice/relight/pilot_visibility.hpp>
#include <coppice/relight/prepared_view.hpp>
#include <coppice/tree/build.hpp>
#include <memory>

namespace coppice {

struct CutRelightingOptions : ViewOptions {
  std::uint32_t light_count = 32768;  ///< directions over the sphere; a power of two wastes no leaves
  std::uint64_t seed = 0;             ///< turns the lattice of directions at random; 0 leaves it
  std::vector<VisibilityCutOptions> cuts =
      std::vector<VisibilityCutOptions>(1);  ///< one set of visibility cuts for each, from the same rays
  std::uint32_t pilot_stride = 16;           ///< every how manieth light judges where to split
  float beta = 1;  ///< of the tree (Cuts Eq. 13): 1 clusters lights by direction alone, 0 by who sees them
  PilotOptions pilots;  ///< receivers whose visibility shapes the tree; for beta < 1
  LobeOptions lobes;
  bool keep_bits =
      false;  ///< keep dense visibility for the brute-force twins: light_count/8 bytes a receiver
};

/// How long the preparation took, in seconds, and what it made.
struct PreparationReport {
  double tree = 0;  ///< the geometric tree
  double camera = 0, refinement = 0;
  double pilots = 0;            ///< tracing the pilot receivers
  double data_driven_tree = 0;  ///< from what they see
  double visibility = 0;        ///< tracing the other receivers, and all cuts
  std::size_t receivers = 0, unrefined_receivers = 0, pilot_receivers = 0;
  std::size_t rays = 0;        ///< for visibility, those of pilots included
  std::size_t pilot_rays = 0;  ///< traced for the tree, and used again for the pilots' own cuts
};

/// Fixed scene and camera, any environment. Construction traces visibility; light() and shade() are a frame.
/// The lights stand where the light of `first` comes from in their cells, so that its sun and lamps cast
/// their shadows from the right place; other environments are resolved to a cell, 1.1° for 32,768 lights.
/// Results do not depend on the executor.
template <Quantised Value = std::uint8_t>
class CutRelighting {
 public:
  template <class Tracer, Executor E>
  requires Occluder<Tracer> && RayTracer<Tracer> CutRelighting(const Scene& scene, const Tracer& tracer,
                                                               const Camera& camera, const Environment& first,
                                                               const CutRelightingOptions& options,
                                                               const E& executor,
                                                               const Progress& progress = {})
      : options_(options), lattice_(even_directions(options.light_count, options.seed)) {
    Stopwatch watch;
    directions_ = cells_for(first.map).centroids(first, lattice_);
    take_tree(build_tree(GeometricMetric(light_samples())));
    report_.tree = watch.lap();
    view_ = prepare_view(scene, tracer, camera, options_, pilot(options_.pilot_stride),
                         pilot(8 * options_.pilot_stride), executor);
    report_.camera = view_.camera_seconds;
    report_.refinement = view_.refinement_seconds;
    report_.unrefined_receivers = view_.unrefined_receivers;
    report_.receivers = view_.receivers.size();
    watch.lap();
    const VisibilityRows known = options_.beta < 1 ? drive_tree_by_data(tracer, executor) : VisibilityRows();
    watch.lap();
    visibility_ = precompute_visibility<Value>(tracer, tree_, *leaf_lights_, view_.receivers, options_.cuts,
                                               options_.keep_bits, executor, progress, known);
    report_.rays = visibility_.rays + report_.pilot_rays;
    report_.visibility = watch.lap();
  }

  /// From what an earlier construction left (precomputed()): only camera rays are traced. `directions` by
  /// light. Throws InputError where the camera sees what those receivers do not cover.
  template <class Tracer, Executor E>
  requires RayTracer<Tracer> CutRelighting(const Scene& scene, const Tracer& tracer, const Camera& camera,
                                           LightTree tree, std::vector<vec3> directions,
                                           ViewReceivers receivers, MaskedCuts<Value> cuts,
                                           const CutRelightingOptions& options, const E& executor)
      : options_(options),
        lattice_(even_directions(options.light_count, options.seed)),
        directions_(std::move(directions)) {
    COPPICE_ASSERT(directions_.size() == lattice_.size() && cuts.size() == receivers.receivers.size());
    take_tree(std::move(tree));
    view_ = view_over(scene, tracer, camera, options_, std::move(receivers), executor);
    report_.camera = view_.camera_seconds;
    report_.receivers = report_.unrefined_receivers = view_.receivers.size();
    visibility_.cuts.push_back(std::move(cuts));
  }

  /// By light: where the lights stand that a construction under `first` chooses. Costs about 0.3 s.
  static std::vector<vec3> directions_for(const Environment& first, const CutRelightingOptions& options) {
    const auto lattice = even_directions(options.light_count, options.seed);
    return EnvironmentCells(lattice, first.map.width, first.map.height).centroids(first, lattice);
  }

  /// The frame's lights and its illumination cut of at most max_nodes, for the cuts of options.cuts[which].
  /// A map of another size than the last one's is first assigned to the lights (about 0.3 s).
  FrameLighting light(const Environment& environment, std::size_t max_nodes, std::size_t which = 0) {
    const auto lights = cells_for(environment.map).gather(environment);
    return light_frame(tree_, lights, directions_, max_nodes, cuts(which).granule_log2());
  }

  /// Radiance of every shading point through merged cuts; cluster_count, where not empty, receives how many
  /// it took.
  template <Executor E>
  std::vector<vec3> shade(const FrameLighting& frame, const E& executor, std::size_t which = 0,
                          std::span<std::uint32_t> cluster_count = {}) const {
    return shade(frame, executor, which, cluster_count, options_.lobes);
  }
  template <Executor E>
  std::vector<vec3> shade(const FrameLighting& frame, const E& executor, std::size_t which,
                          std::span<std::uint32_t> cluster_count, const LobeOptions& lobes) const {
    std::vector<vec3> radiance(view_.buffer.points.size());
    executor(view_.buffer.faces.size(), 64, [&](std::size_t begin, std::size_t end) {
      kernels_->shade_faces(view_.buffer, cuts(which), frame, lobes, begin, end, radiance, cluster_count);
    });
    return radiance;
  }

  /// The same from all lights. Precondition: options.keep_bits.
  template <Skip skip, Executor E>
  std::vector<vec3> shade_by_brute_force(const FrameLighting& frame, const E& executor) const {
    COPPICE_ASSERT(options_.keep_bits);
    std::vector<vec3> radiance(view_.buffer.points.size());
    const DenseLights lights(tree_.leaf_count(), frame);
    executor(view_.buffer.faces.size(), 64, [&](std::size_t begin, std::size_t end) {
      kernels_->brute_force(skip, view_.buffer, visibility_.bits, tree_.leaf_count(), lights, begin, end,
                            radiance);
    });
    return radiance;
  }

  /// Reflected and emitted radiance as an image.
  Image image(std::span<const vec3> radiance) const {
    Image result = resolve(view_.buffer, options_.raster, radiance);
    for (std::size_t i = 0; i < result.pixels.size(); ++i)
      result.pixels[i] += view_.direct.emission.pixels[i];
    return result;
  }

  /// Shades with kernels for other instructions than those that the including file is compiled for
  /// (kernels/kernels.hpp chooses the best of the machine).
  void use(const ShadingKernels<Value>& kernels) { kernels_ = &kernels; }
  const ShadingKernels<Value>& kernels() const { return *kernels_; }

  const CutRelightingOptions& options() const { return options_; }
  const LightTree& tree() const { return tree_; }
  std::span<const vec3> directions() const { return directions_; }
  std::span<const Receiver> receivers() const { return view_.receivers; }
  const MaskedCuts<Value>& cuts(std::size_t which = 0) const { return visibility_.cuts[which]; }
  std::span<const std::uint64_t> bits() const { return visibility_.bits; }
  const PreparedView& view() const { return view_; }
  const ShadingBuffer& buffer() const { return view_.buffer; }
  const DirectImage& direct() const { return view_.direct; }
  const PreparationReport& report() const { return report_; }

 private:
  const EnvironmentCells& cells_for(const Image& map) {
    const glm::ivec2 size(map.width, map.height);
    if (!cells_ || size != cells_size_) cells_.emplace(lattice_, size.x, size.y), cells_size_ = size;
    return *cells_;
  }

  std::vector<LightSample> light_samples() const {
    std::vector<LightSample> samples;
    samples.reserve(directions_.size());
    for (const vec3& d : directions_) samples.push_back({d, vec3(0)});
    return samples;
  }

  void take_tree(LightTree tree) {
    tree_ = std::move(tree);
    leaf_lights_ = std::make_unique<DirectionPackets>(leaf_directions(tree_, directions_));
  }

  /// Returns what the pilots see, in the order of the new tree's leaves.
  template <Occluder O, Executor E>
  VisibilityRows drive_tree_by_data(const O& occluder, const E& executor) {
    Stopwatch watch;
    PilotVisibility pilot = trace_pilots(occluder, *leaf_lights_, view_.receivers, options_.pilots, executor);
    report_.pilot_receivers = pilot.rows.size();
    report_.pilot_rays = pilot.rays;
    report_.pilots = watch.lap();
    take_tree(
        build_data_driven_tree(light_samples(), tree_, pilot, options_.beta, options_.pilots, executor));
    report_.data_driven_tree = watch.lap();
    return std::move(pilot.rows);
  }

  /// Every so manieth light, in the order of the leaves: even over the sphere.
  DirectionPackets pilot(std::uint32_t stride) const {
    std::vector<vec3> directions;
    for (std::uint32_t i = std::min(stride / 2, leaf_lights_->count() - 1); i < leaf_lights_->count();
         i += stride)
      directions.push_back(leaf_lights_->direction(i));
    return DirectionPackets(directions);
  }

  const ShadingKernels<Value>* kernels_ = &compiled_kernels<Value>();
  CutRelightingOptions options_;
  std::vector<vec3> lattice_, directions_;  // by light: centres of cells, and where their light comes from
  LightTree tree_;
  std::unique_ptr<DirectionPackets> leaf_lights_;
  PreparedView view_;
  VisibilityCuts<Value> visibility_;
  std::optional<EnvironmentCells> cells_;
  glm::ivec2 cells_size_{0};
  PreparationReport report_;
};

}  // namespace coppice
