#include <coppice/relight/moving_objects.hpp>
#include <coppice/scene/pose.hpp>
#include <optional>
#include <support/report.hpp>
#include <support/shader.hpp>
#include <support/system.hpp>
#include <support/visibility_store.hpp>

namespace coppice::program {
namespace {

using nlohmann::json;

CutRelightingOptions settings_of(const SystemOptions& o) {
  CutRelightingOptions settings = relighting_options(o.common, o.cut);
  settings.cuts = {visibility_options(o.cut, o.knobs.sigma, o.knobs.cuts)};
  settings.lobes = {o.knobs.lobes, o.cut.lobe_tolerance};
  settings.keep_bits = o.reference && !o.animate;
  return settings;
}

/// From the store where it fits; otherwise computed, and stored.
std::unique_ptr<CutRelighting<>> make_relighting(const SystemOptions& o, const Inputs& in,
                                                 const EmbreeTracer& tracer, const Threads& threads,
                                                 std::string& note) {
  VisibilityStore store(o, in);
  const CutRelightingOptions settings = settings_of(o);
  const auto directions = CutRelighting<>::directions_for(in.environment, settings);
  const std::string places = fingerprint_of(std::span(directions));
  std::unique_ptr<CutRelighting<>> made;
  if (auto known = settings.keep_bits ? std::nullopt : store.read<std::uint8_t>("", places))
    made =
        std::make_unique<CutRelighting<>>(in.scene, tracer, in.camera, std::move(known->tree), directions,
                                          ViewReceivers{std::move(known->mesh), std::move(known->receivers)},
                                          std::move(known->cuts), settings, threads);
  else
    made = std::make_unique<CutRelighting<>>(in.scene, tracer, in.camera, in.environment, settings, threads,
                                             visibility_progress());
  if (!o.store.empty() && made->report().rays > 0) {
    StoredVisibility<std::uint8_t> content;
    content.tree = made->tree();
    content.mesh = made->view().mesh;
    content.receivers = made->view().receivers;
    content.weight = o.knobs.cuts.weight;
    for (const vec3& d : made->directions()) content.lights.emplace_back(d, 0.0f);
    content.cuts = made->cuts();
    store.write("", places, std::move(content));
  }
  note = store.note();
  return made;
}

class EnvironmentSystem : public System {
 public:
  EnvironmentSystem(const SystemOptions& options, Inputs& in, const EmbreeTracer& tracer,
                    const Threads& threads)
      : options_(options),
        in_(in),
        threads_(threads),
        relighting_(make_relighting(options, in, tracer, threads, store_note_)) {
    relighting_->use(kernels_of(options.cut));
    if (options.animate)
      prepare_objects(tracer);
    else
      shader_ = make_shader(options.common.backend, *relighting_);
  }

  RenderedFrame render(int frame) override {
    in_.environment.rotation = turn_of_frame(options_, frame);
    Stopwatch watch;
    lighting_ = relighting_->light(in_.environment, options_.knobs.nodes);
    const double light = watch.lap();
    RenderedFrame result = options_.animate ? render_pose(frame) : render_resting();
    const double rest = watch.lap();
    result.report.update({{"rotation_degrees", glm::degrees(in_.environment.rotation)},
                          {"milliseconds", 1e3 * (light + rest)},
                          {"milliseconds_lighting", 1e3 * light},
                          {"illumination_nodes", lighting_.ends.size()}});
    return result;
  }

  Image reference(json& report) override {
    if (options_.animate) return posed_reference(report);
    Stopwatch watch;
    const auto skipping = relighting_->shade_by_brute_force<Skip::unseen>(lighting_, threads_);
    const double skip_seconds = watch.lap();
    const auto plain = relighting_->shade_by_brute_force<Skip::nothing>(lighting_, threads_);
    report["brute_force_milliseconds"] = {{"plain", 1e3 * watch.lap()}, {"skipping", 1e3 * skip_seconds}};
    return relighting_->image(plain);
  }

  json preparation() const override {
    json j = preparation_json(*relighting_, in_.scene);
    j["visibility_cuts"] = cuts_json(relighting_->cuts());
    if (!store_note_.empty()) j["store"] = store_note_;
    if (objects_)
      j["moving"] = {{"objects", objects_->size()},
                     {"samples", objects_->sample_count()},
                     {"bytes", objects_->byte_count()},
                     {"seconds", object_seconds_}};
    return j;
  }

 private:
  void prepare_objects(const EmbreeTracer& tracer) {
    Stopwatch watch;
    MovingOptions settings;
    settings.raster = options_.common.raster;
    settings.shading = options_.common.shading;
    settings.sigma = options_.knobs.sigma;
    objects_.emplace(in_.scene, tracer, relighting_->view(), relighting_->tree(), relighting_->directions(),
                     relighting_->cuts(), in_.camera, settings, threads_, visibility_progress());
    object_seconds_ = watch.seconds();
  }

  RenderedFrame render_resting() {
    Stopwatch watch;
    std::vector<std::uint32_t> clusters(relighting_->buffer().points.size());
    const std::vector<vec3> radiance = shader_->shade(lighting_, threads_, clusters);
    const double shaded = watch.seconds();
    return {relighting_->image(radiance),
            relighting_->direct(),
            resolve_counts(relighting_->buffer(), options_.common.raster, clusters),
            {},
            {{"milliseconds_shading", 1e3 * shaded}, {"clusters", summary_json(summary_of(clusters))}}};
  }

  /// Adds the points of a buffer to the image; returns the milliseconds of their shading.
  double add_points(const ShadingBuffer& buffer, const MaskedCuts<std::uint8_t>& cuts,
                    std::span<const std::uint8_t> hidden, RenderedFrame& frame,
                    std::vector<std::uint32_t>& all_clusters) const {
    Stopwatch watch;
    std::vector<vec3> radiance(buffer.points.size());
    std::vector<std::uint32_t> clusters(radiance.size());
    const LobeOptions& lobes = relighting_->options().lobes;
    threads_(buffer.faces.size(), 64, [&](std::size_t begin, std::size_t end) {
      relighting_->kernels().shade_faces(buffer, cuts, lighting_, lobes, begin, end, radiance, clusters);
    });
    const double milliseconds = 1e3 * watch.seconds();
    for (std::size_t p = 0; p < hidden.size(); ++p)
      if (hidden[p]) radiance[p] = vec3(0), clusters[p] = 0;
    const Image part = resolve(buffer, options_.common.raster, radiance);
    const auto counts = resolve_counts(buffer, options_.common.raster, clusters);
    for (std::size_t i = 0; i < part.pixels.size(); ++i) {
      frame.image.pixels[i] += part.pixels[i];
      frame.cut_size[i] += counts[i];
    }
    all_clusters.insert(all_clusters.end(), clusters.begin(), clusters.end());
    return milliseconds;
  }

  RenderedFrame render_pose(int number) {
    const Raster& raster = options_.common.raster;
    Stopwatch watch;
    const Pose pose = objects_->pose(time_of_frame(options_.frames, in_.scene, number), threads_);
    const double posed = 1e3 * watch.seconds();
    RenderedFrame frame{Image(raster.width, raster.height),
                        relighting_->direct(),
                        std::vector<float>(raster.pixel_count(), 0.0f),
                        {},
                        {}};
    std::vector<std::uint32_t> clusters;
    double shading = add_points(relighting_->buffer(), pose.cuts, pose.hidden, frame, clusters);
    for (const PosedObject& object : pose.objects) {
      shading += add_points(object.buffer, object.cuts, {}, frame, clusters);
      for (const std::uint32_t pixel : object.buffer.pixels) frame.direct.coverage[pixel] = 1;
    }
    frame.image = add_emission(std::move(frame.image), frame.direct);
    frame.report = {{"milliseconds_shading", shading},
                    {"milliseconds_pose", posed},
                    {"milliseconds_turn", 1e3 * pose.seconds.turn},
                    {"milliseconds_product", 1e3 * pose.seconds.product},
                    {"milliseconds_camera", 1e3 * pose.seconds.camera},
                    {"shadowed_receivers", pose.shadowed_receivers},
                    {"clusters", summary_json(summary_of(clusters))}};
    time_ = time_of_frame(options_.frames, in_.scene, number);
    return frame;
  }

  /// The scene as it stands now, prepared anew, from all lights.
  Image posed_reference(json& report) const {
    Stopwatch watch;
    Scene posed = in_.scene;
    posed.mesh = mesh_at(in_.scene, time_);
    const EmbreeTracer tracer(posed);
    CutRelightingOptions settings = settings_of(options_);
    settings.keep_bits = true;
    Environment first = in_.environment;
    first.rotation = turn_of_frame(options_, 0);
    CutRelighting<> anew(posed, tracer, in_.camera, first, settings, threads_);
    const FrameLighting lighting = anew.light(in_.environment, options_.knobs.nodes);
    Image image = anew.image(anew.shade_by_brute_force<Skip::unseen>(lighting, threads_));
    report["anew_milliseconds"] = 1e3 * watch.seconds();
    return image;
  }

  const SystemOptions options_;
  Inputs& in_;
  const Threads& threads_;
  std::string store_note_;
  std::unique_ptr<CutRelighting<>> relighting_;
  std::unique_ptr<Shader> shader_;
  std::optional<MovingObjects<EmbreeTracer>> objects_;
  double object_seconds_ = 0;
  FrameLighting lighting_;
  float time_ = 0;
};

}  // namespace

std::unique_ptr<System> make_environment_system(const SystemOptions& options, Inputs& in,
                                                const EmbreeTracer& tracer, const Threads& threads) {
  return std::make_unique<EnvironmentSystem>(options, in, tracer, threads);
}

}  // namespace coppice::program
