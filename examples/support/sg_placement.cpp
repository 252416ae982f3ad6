#include <coppice/core/simd.hpp>
//
#include <coppice/core/stopwatch.hpp>
#include <coppice/sg/preconvolved.hpp>
#include <support/sg_placement.hpp>
#ifdef COPPICE_HAS_VULKAN
#include <coppice/vulkan/sg_shader.hpp>
#endif

namespace coppice::program {
namespace {

/// Places the cones of points as they stand under the map, and turns the cones back.
template <class MakePlacer>
ConeBatch place_turned(std::span<const ShadingPoint> points, std::vector<ConeReceiver> receivers,
                       float rotation, const Threads& threads, MakePlacer&& make_placer) {
  using Placer = decltype(make_placer());
  struct Turned {
    std::span<const ShadingPoint> points;
    const MapFrame& turn;
    Placer placer;
    const LitCones& place(std::size_t i) { return placer.place(turn.to_map(points[i])); }
  };
  const MapFrame turn(rotation);
  ConeBatch batch = place_cones(
      std::move(receivers),
      [&] {
        return Turned{points, turn, make_placer()};
      },
      threads);
  threads(batch.shapes.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) batch.shapes[i].axis = turn.to_world(batch.shapes[i].axis);
  });
  return batch;
}

class CutPlacement : public SgPlacement {
 public:
  CutPlacement(const SgSystemOptions& options, const Threads& threads)
      : options_(options), threads_(threads), sky_(sky_of(options)) {}

  void take(const Image& map, nlohmann::json& stages) override {
    Stopwatch watch;
    sky_.take(map);
    product_ = ProductTree(sky_.lighting(), sky_.parts().peaks);
    stages["light_tree"] = 1e3 * watch.lap();
  }

  ConeBatch place(std::span<const ShadingPoint> points, std::vector<ConeReceiver> receivers,
                  float rotation) const override {
    return place_turned(points, std::move(receivers), rotation, threads_,
                        [&] { return ConeCut(product_, options_.cones); });
  }

  std::size_t peak_count() const override { return sky_.parts().peaks.size(); }

 protected:
  const SgSystemOptions& options_;
  const Threads& threads_;
  SkyLights sky_;
  ProductTree product_;
};

/// All Gaussians of the light that matter, one after the other.
struct AllLights {
  const detail::LightColumns& columns;
  vec3 mean(const SgShape& shape) const { return columns.mean(shape.axis, shape.sharpness, 1e-3f); }
};

class PackedPlacement : public CutPlacement {
 public:
  using CutPlacement::CutPlacement;

  void take(const Image& map, nlohmann::json& stages) override {
    CutPlacement::take(map, stages);
    if (!fitter_) prepare(map.width, map.height);
    Stopwatch watch;
    const EnvironmentFit fit = fit_of({map, 0}, stages);
    stages["fit"] = 1e3 * watch.lap();
    if (by_lookup()) table_.emplace(fit.rest(), PreconvolvedOptions{}, threads_);
    columns_.clear();
    for (const SgLight& light : fit.rest()) columns_.append(light);
    columns_.pad();
    stages["convolution"] = 1e3 * watch.lap();
  }

  ConeBatch place(std::span<const ShadingPoint> points, std::vector<ConeReceiver> receivers,
                  float rotation) const override {
    return by_lookup() ? place_by(*table_, points, std::move(receivers), rotation)
                       : place_by(AllLights{columns_}, points, std::move(receivers), rotation);
  }

 private:
  bool by_lookup() const { return options_.weights == ConeWeights::lookup; }

  EnvironmentFitOptions fit_options() const {
    EnvironmentFitOptions o;
    o.scheme = options_.scheme;
    o.nside = 1 << options_.levels;
    o.grid_nside = std::max(o.grid_nside, 4 * o.nside);
    o.peaks = sky_of(options_).peaks;
    return o;
  }

  /// All maps of a run have the size of the first.
  void prepare(int width, int height) {
    fitter_.emplace(fit_options(), width, height);
#ifdef COPPICE_HAS_VULKAN
    if (options_.common.backend != "cpu") shader_.emplace(device_.emplace(), *fitter_);
#endif
  }

  EnvironmentFit fit_of(const Environment& environment, [[maybe_unused]] nlohmann::json& stages) {
#ifdef COPPICE_HAS_VULKAN
    if (shader_) {
      EnvironmentFit fit = shader_->fit(environment, threads_);
      if (const auto own = shader_->milliseconds()) stages["device_fit"] = *own;
      return fit;
    }
#endif
    return fitter_->fit(environment, threads_);
  }

  template <MeanLight Light>
  ConeBatch place_by(const Light& light, std::span<const ShadingPoint> points,
                     std::vector<ConeReceiver> receivers, float rotation) const {
    const PackedConeOptions o{int(options_.cones.cones), options_.lobes,
                              options_.placement == ConePlacement::paper};
    return place_turned(points, std::move(receivers), rotation, threads_,
                        [&] { return PackedCones<Light>(product_, light, sky_.parts().peaks, o); });
  }

  std::optional<EnvironmentFitter> fitter_;
#ifdef COPPICE_HAS_VULKAN
  std::optional<VulkanDevice> device_;
  std::optional<SgFitShader> shader_;
#endif
  std::optional<PreconvolvedEnvironment> table_;
  detail::LightColumns columns_;
};

}  // namespace

std::unique_ptr<SgPlacement> make_sg_placement(const SgSystemOptions& options, const Threads& threads) {
  if (options.placement == ConePlacement::cut) return std::make_unique<CutPlacement>(options, threads);
  return std::make_unique<PackedPlacement>(options, threads);
}

}  // namespace coppice::program
