// Lights in the scene, through precomputed cuts of V·G.
#pragma once

#include <coppice/relight/compiled_kernels.hpp>
#include <coppice/relight/local_cut_selector.hpp>
#include <coppice/relight/local_lighting.hpp>
#include <coppice/relight/pilot_visibility.hpp>
#include <coppice/relight/prepared_view.hpp>
#include <coppice/tree/build.hpp>
#include <memory>

namespace coppice {

struct LocalRelightingOptions {
  VisibilityCutOptions cuts;
  LobeOptions lobes;
  float beta = 1;  ///< of the tree (Cuts Eq. 13): 1 clusters lights by place and normal, 0 by who sees them
  PilotOptions pilots;
};

/// The lights by index as a tree.
inline LightTree build_local_tree(std::span<const LocalLight> lights) {
  const auto samples = metric_samples(lights);
  return build_tree(GeometricMetric(samples));
}

/// About `count` lights, evenly over the tree: pilots.
inline LocalLightPackets pilot_lights(const LightTree& tree, std::span<const LocalLight> lights,
                                      std::uint32_t count) {
  std::vector<LocalLight> pilots;
  const std::uint32_t stride = std::max(1u, std::uint32_t(lights.size()) / std::max(1u, count));
  std::uint32_t at = stride / 2;
  for (const std::uint32_t l : tree.light_of_leaf)
    if (l != no_light && at++ % stride == 0) pilots.push_back(lights[l]);
  return LocalLightPackets(pilots);
}

/// How long the preparation took, in seconds, and its rays.
struct LocalReport {
  double tree = 0;        ///< pilot rays included
  double visibility = 0;  ///< tracing receivers, and their cuts
  std::size_t rays = 0, pilot_rays = 0;
};

/// Fixed view, fixed places of lights, whose intensities may change from frame to frame. Without lights all
/// is black.
class LocalRelighting {
 public:
  /// The view must outlive this.
  template <Occluder O, Executor E>
  LocalRelighting(const PreparedView& view, std::vector<LocalLight> lights, const O& occluder,
                  const LocalRelightingOptions& options, const E& executor, const Progress& progress = {})
      : options_(options), view_(&view), lights_(std::move(lights)) {
    Stopwatch watch;
    tree_ = std::make_unique<LightTree>(build_local_tree(lights_));
    const VisibilityRows known = options.beta < 1 ? drive_tree_by_data(occluder, executor) : VisibilityRows();
    lighting_ = LocalLighting(*tree_, lights_);
    report_.tree = watch.lap();
    if (tree_->empty()) return;
    const LocalLightPackets packets(leaf_lights(*tree_, lights_));
    cuts_ = precompute_local_cuts(occluder, *tree_, packets, view.receivers, options.cuts, executor, progress,
                                  known);
    report_.rays = cuts_.rays + report_.pilot_rays;
    report_.visibility = watch.lap();
  }

  /// From what an earlier construction left.
  LocalRelighting(const PreparedView& view, std::vector<LocalLight> lights, LightTree tree, LocalCuts cuts,
                  const LocalRelightingOptions& options)
      : options_(options),
        view_(&view),
        lights_(std::move(lights)),
        tree_(std::make_unique<LightTree>(std::move(tree))),
        lighting_(*tree_, lights_),
        cuts_(std::move(cuts)) {
    COPPICE_ASSERT(tree_->empty() || cuts_.scales.size() == view.receivers.size());
  }

  /// Intensities may change, places may not: visibility is stored for these.
  LocalLighting& lighting() { return lighting_; }
  void set_cut(std::size_t max_nodes) { lighting_.set_cut(max_nodes, cuts_.cuts.granule_log2()); }

  /// Radiance of every shading point; cluster_count, where not empty, receives how many clusters it took.
  template <Executor E>
  std::vector<vec3> shade(const E& executor, std::span<std::uint32_t> cluster_count = {}) const {
    const ShadingBuffer& buffer = view_->buffer;
    std::vector<vec3> radiance(buffer.points.size());
    if (tree_->empty()) return radiance;
    executor(buffer.faces.size(), 64, [&](std::size_t begin, std::size_t end) {
      kernels_->shade_faces_locally(buffer, cuts_.cuts, cuts_.scales, lighting_.frame(), options_.lobes,
                                    begin, end, radiance, cluster_count);
    });
    return radiance;
  }

  void use(const ShadingKernels<std::uint16_t>& kernels) { kernels_ = &kernels; }
  const LocalRelightingOptions& options() const { return options_; }
  const LocalFrameLighting& frame() const { return lighting_.frame(); }
  const LocalCuts& cuts() const { return cuts_; }
  const LightTree& tree() const { return *tree_; }
  std::span<const LocalLight> lights() const { return lights_; }
  const LocalReport& report() const { return report_; }

 private:
  template <Occluder O, Executor E>
  VisibilityRows drive_tree_by_data(const O& occluder, const E& executor) {
    const LocalLightPackets packets(leaf_lights(*tree_, lights_));
    PilotVisibility pilot = trace_pilots(occluder, packets, view_->receivers, options_.pilots, executor);
    report_.pilot_rays = pilot.rays;
    *tree_ = build_data_driven_tree(metric_samples(lights_), *tree_, pilot, options_.beta, options_.pilots,
                                    executor);
    return std::move(pilot.rows);
  }

  LocalRelightingOptions options_;
  const PreparedView* view_;
  const ShadingKernels<std::uint16_t>* kernels_ = &compiled_kernels<std::uint16_t>();
  std::vector<LocalLight> lights_;
  std::unique_ptr<LightTree> tree_;
  LocalLighting lighting_;
  LocalCuts cuts_;
  LocalReport report_;
};

}  // namespace coppice
