#include <support/pca_system.hpp>
//
#include <coppice/core/stopwatch.hpp>
#include <coppice/light/scene_lights.hpp>

namespace coppice::program {
namespace {

using nlohmann::json;

class PcaSystem : public System {
 public:
  PcaSystem(const PcaSystemOptions& options, Inputs& in, const Threads& threads)
      : options_(options),
        in_(in),
        threads_(threads),
        tracer_(in.scene),
        paths_(light_paths(options)),
        room_(room_options(options), in.scene, in.camera.position, tracer_, threads, options.store),
        view_(in.scene, tracer_, in.camera, options.common.raster, options.common.shading, samples(),
              options.target, options.splats, threads) {
    if (options.lights == RoomLights::scene)
      resting_ = scene_lights(in.scene, options.emitters, options.common.seed);
    if (paths_.empty() && resting_.empty())
      in.scene.warnings.push_back(options.lights == RoomLights::scene
                                      ? "nothing shines in the scene: the image is black"
                                      : "no --path and no --through: the image is black");
    if (samples().empty())
      in.scene.warnings.push_back("no surface can be reached from --start: there is no indirect light");
  }

  RenderedFrame render(int frame) override {
    json stages = json::object();
    Stopwatch total, watch;
    see(frame);
    stages["visibility"] = 1e3 * watch.lap();
    const DirectLight direct = light_samples_directly();
    stages["direct_at_samples"] = 1e3 * watch.lap();
    std::vector<vec3> irradiance(samples().size());
    room_.transfer->indirect(direct, irradiance, stages);
    RenderedFrame result;
    result.report["samples_milliseconds"] = 1e3 * total.lap();
    watch.lap();
    result.direct = view_.seen();
    Image near = view_.direct(samples(), lights_);
    stages["direct_at_pixels"] = 1e3 * watch.lap();
    Image far = view_.indirect(irradiance);
    stages["splats"] = 1e3 * watch.lap();
    result.image = add_emission(sum(near, far), result.direct);
    result.report["pixels_milliseconds"] = 1e3 * total.lap();
    result.report["stages"] = stages;
    result.report["lights"] = lights_.size();
    result.cut_size.assign(options_.common.raster.pixel_count(), 0.0f);
    result.parts.emplace_back("direct", std::move(near));
    result.parts.emplace_back("indirect", std::move(far));
    return result;
  }

  Image reference(json& report) override {
    Stopwatch watch;
    std::vector<vec3> direct(samples().size()), one(samples().size());
    for (const SeenLight& light : lights_) {
      light_directly(samples(), light.points, tracer_, threads_, softening_distance(samples()), one);
      for (std::size_t i = 0; i < one.size(); ++i) direct[i] += one[i];
    }
    const Image image =
        sum(view_.direct_by_rays(lights_), view_.indirect(room_.solver().solve(direct, threads_)));
    report["reference_milliseconds"] = 1e3 * watch.lap();
    return add_emission(image, view_.seen());
  }

  json preparation() const override {
    json j = room_.summary();
    j["triangles"] = in_.scene.mesh.triangles.size();
    j["splats_a_pixel"] = double(view_.splat_count()) / double(options_.common.raster.pixel_count());
    return j;
  }

 private:
  std::span<const SurfaceSample> samples() const { return room_.samples.clustered.samples; }

  static Image sum(const Image& a, const Image& b) {
    Image result = a;
    for (std::size_t i = 0; i < result.pixels.size(); ++i) result.pixels[i] += b.pixels[i];
    return result;
  }

  /// Frames are spread over the longest path, the last of several at its end.
  float time_of(int frame) const {
    float duration = 0;
    for (const LightPath& path : paths_) duration = std::max(duration, path.duration());
    return options_.frames > 1 ? duration * float(frame) / float(options_.frames - 1) : 0;
  }

  void see(int frame) {
    std::vector<SizedLight> lights;
    for (const LightPath& path : paths_) lights.push_back(path.at(time_of(frame)));
    for (const LocalLight& light : resting_) lights.push_back({light, 0});
    lights_.clear();
    for (const SizedLight& light : lights) {
      SeenLight& seen = lights_.emplace_back(
          SeenLight{light, points_of(light, options_.points), std::vector<float>(samples().size())});
      room_.shadows->see(light, options_.points, seen.visibility);
    }
  }

  /// Irradiance by the lights' visibility; very near lights are softened.
  DirectLight light_samples_directly() const {
    DirectLight result{.direct = std::vector<vec3>(samples().size(), vec3(0))};
    const float softening = softening_distance(samples());
    std::vector<float> grey(samples().size());
    for (const SeenLight& seen : lights_) {
      const LocalLight& light = seen.light.light;
      light_by_visibility(samples(), light, seen.visibility, softening, threads_, grey);
      result.colour += light.intensity;
      if (lights_.size() > 1)
        for (std::size_t i = 0; i < grey.size(); ++i) result.direct[i] += grey[i] * light.intensity;
    }
    if (lights_.size() == 1) result.grey = std::move(grey);
    return result;
  }

  const PcaSystemOptions options_;
  Inputs& in_;
  const Threads& threads_;
  EmbreeTracer tracer_;
  std::vector<LightPath> paths_;
  PcaRoom room_;
  PcaView view_;
  std::vector<LocalLight> resting_;
  std::vector<SeenLight> lights_;  ///< of the last frame
};

}  // namespace

std::unique_ptr<System> make_pca_system(const PcaSystemOptions& options, Inputs& in, const Threads& threads) {
  return std::make_unique<PcaSystem>(options, in, threads);
}

}  // namespace coppice::program
