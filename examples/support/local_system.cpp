#include <coppice/light/bounce.hpp>
#include <coppice/light/scene_lights.hpp>
#include <coppice/relight/local_relighting.hpp>
#include <coppice/relight/traced_lighting.hpp>
#include <coppice/scene/pose.hpp>
#include <optional>
#include <support/report.hpp>
#include <support/shader.hpp>
#include <support/system.hpp>
#include <support/visibility_store.hpp>

namespace coppice::program {
namespace {

using nlohmann::json;

/// One set of lights with its tree: those of the scene, or those of its bounce.
struct LightSet {
  std::string name;
  std::vector<LocalLight> lights;
  std::unique_ptr<LocalRelighting> stored{};
  std::unique_ptr<LocalShader> shader{};  // of stored
  LightTree tree{};                       // of traced lights
  std::unique_ptr<LocalLighting> traced{};
};

class LocalSystem : public System {
 public:
  LocalSystem(const SystemOptions& options, Inputs& in, const EmbreeTracer& tracer, const Threads& threads)
      : options_(options), in_(in), tracer_(&tracer), threads_(threads) {
    gather_lights(in_.scene);
    if (options_.visibility == Visibility::stored)
      prepare_stored();
    else if (!options_.animate)
      prepare_traced(in_.scene);
  }

  RenderedFrame render(int frame) override {
    Stopwatch watch;
    if (options_.animate) pose(frame);
    const double posed = watch.lap();
    RenderedFrame result;
    result.direct = view_.direct;
    result.image = Image(options_.common.raster.width, options_.common.raster.height);
    std::vector<std::uint32_t> counts(view_.buffer.points.size()), total(counts.size());
    for (LightSet& set : sets_) {
      Image part = resolve(view_.buffer, options_.common.raster, shade(set, counts));
      for (std::size_t i = 0; i < part.pixels.size(); ++i) result.image.pixels[i] += part.pixels[i];
      for (std::size_t p = 0; p < counts.size(); ++p) total[p] += counts[p];
      if (sets_.size() > 1) result.parts.emplace_back(set.name, std::move(part));
    }
    result.image = add_emission(std::move(result.image), view_.direct);
    const double shaded = watch.lap();
    result.cut_size = resolve_counts(view_.buffer, options_.common.raster, total);
    result.report = {{"milliseconds", 1e3 * (posed + shaded)},
                     {"milliseconds_shading", 1e3 * shaded},
                     {is_traced() ? "shadow_rays" : "clusters", summary_json(summary_of(total))}};
    if (options_.animate) result.report["milliseconds_pose"] = 1e3 * posed;
    return result;
  }

  /// A shadow ray from every point to every light.
  Image reference(json& report) override {
    Stopwatch watch;
    Image image(options_.common.raster.width, options_.common.raster.height);
    for (LightSet& set : sets_) {
      if (!set.traced) trace(set);
      const auto radiance = shade_traced(view_.buffer, *set.traced, *tracer_, {.tolerance = 0}, threads_);
      const Image part = resolve(view_.buffer, options_.common.raster, radiance);
      for (std::size_t i = 0; i < part.pixels.size(); ++i) image.pixels[i] += part.pixels[i];
    }
    report["all_lights_milliseconds"] = 1e3 * watch.lap();
    return add_emission(std::move(image), view_.direct);
  }

  json preparation() const override {
    json j = {{"triangles", in_.scene.mesh.triangles.size()},
              {"shading_points", view_.buffer.points.size()},
              {"shading_faces", view_.buffer.faces.size()},
              {"seconds",
               {{"lights", light_seconds_},
                {"camera", view_.camera_seconds},
                {"refinement", view_.refinement_seconds}}}};
    for (const LightSet& set : sets_) j["lights"][set.name] = set.lights.size();
    if (is_traced()) return j;
    j["receivers"] = view_.receivers.size();
    j["receivers_before_refinement"] = view_.unrefined_receivers;
    for (const LightSet& set : sets_) {
      const LocalReport& r = set.stored->report();
      j["shadow_rays"][set.name] = r.rays;
      j["seconds"][set.name] = {{"tree", r.tree}, {"visibility", r.visibility}};
      if (!set.lights.empty()) j["visibility_cuts"][set.name] = local_cuts_json(set.stored->cuts());
    }
    if (!store_note_.empty()) j["store"] = store_note_;
    return j;
  }

 private:
  bool is_traced() const { return options_.visibility == Visibility::traced; }

  static json local_cuts_json(const LocalCuts& cuts) {
    json j = cuts_json(cuts.cuts);
    j["bytes"] = cuts.cuts.byte_count() + 4 * cuts.scales.size();
    return j;
  }

  void gather_lights(const Scene& scene) {
    Stopwatch watch;
    sets_.clear();
    sets_.push_back({"direct", scene_lights(scene, options_.emitters, options_.common.seed)});
    if (options_.lights == LightKind::indirect) {
      const auto& direct = sets_[0].lights;
      const auto samples = bounce_samples(scene, direct, *tracer_, threads_,
                                          {options_.bounces, options_.common.seed, options_.common.shading});
      std::vector<LocalLight> bounce(samples.size());
      light_samples(samples, direct, *tracer_, threads_, bounce);
      sets_.push_back({"indirect", std::move(bounce)});
    }
    light_seconds_ = watch.lap();
    if (sets_[0].lights.empty())
      in_.scene.warnings.push_back("the scene has no lights and no shining surfaces: the image is black");
  }

  ViewOptions view_options() const { return relighting_options(options_.common, options_.cut); }

  void prepare_stored() {
    VisibilityStore store(options_, in_);
    for (LightSet& set : sets_) {
      // Receivers are refined for the direct light, and serve its bounce too.
      const std::string part = &set == &sets_[0] ? "" : set.name, places = fingerprint_of(set.lights);
      auto known = store.read<std::uint16_t>(part, places);
      if (part.empty()) view_ = known ? stored_view(*known) : new_view();
      if (known && known->receivers.size() == view_.receivers.size())
        set.stored = stored_relighting(set, std::move(*known));
      else
        set.stored = new_relighting(set, store, part, places);
      set.stored->use(local_kernels_of(options_.cut));
      set.stored->set_cut(options_.knobs.nodes);
      set.shader = make_local_shader(options_.common.backend, view_, *set.stored);
    }
    store_note_ = store.note();
  }

  PreparedView new_view() const {
    const auto& lights = sets_[0].lights;
    const LightTree tree = build_local_tree(lights);
    return prepare_view(in_.scene, *tracer_, in_.camera, view_options(), pilot_lights(tree, lights, 2048),
                        pilot_lights(tree, lights, 256), threads_);
  }

  PreparedView stored_view(StoredVisibility<std::uint16_t>& known) const {
    return view_over(in_.scene, *tracer_, in_.camera, view_options(),
                     {std::move(known.mesh), known.receivers}, threads_);
  }

  LocalRelightingOptions relighting() const {
    return {visibility_options(options_.cut, options_.knobs.sigma, options_.knobs.cuts),
            {options_.knobs.lobes, options_.cut.lobe_tolerance},
            options_.cut.beta,
            {}};
  }

  std::unique_ptr<LocalRelighting> stored_relighting(const LightSet& set,
                                                     StoredVisibility<std::uint16_t> known) const {
    return std::make_unique<LocalRelighting>(view_, set.lights, std::move(known.tree),
                                             LocalCuts{std::move(known.cuts), std::move(known.scales), 0},
                                             relighting());
  }

  std::unique_ptr<LocalRelighting> new_relighting(const LightSet& set, VisibilityStore& store,
                                                  const std::string& part, const std::string& places) const {
    auto made = std::make_unique<LocalRelighting>(view_, set.lights, *tracer_, relighting(), threads_,
                                                  visibility_progress());
    if (options_.store.empty() || set.lights.empty()) return made;
    StoredVisibility<std::uint16_t> content;
    content.tree = made->tree();
    content.mesh = view_.mesh;
    content.receivers = view_.receivers;
    content.weight = CutWeight::uniform;
    for (const LocalLight& l : set.lights) content.lights.emplace_back(l.position, l.w);
    content.cuts = made->cuts().cuts;
    content.scales = made->cuts().scales;
    store.write(part, places, std::move(content));
    return made;
  }

  void prepare_traced(const Scene& scene) {
    const auto hits = trace_camera(*tracer_, in_.camera, options_.common.raster, threads_);
    view_.direct = direct_image(scene, options_.common.raster, hits);
    view_.mesh = ReceiverMesh(scene.mesh, sides_seen(scene.mesh, hits));
    view_.buffer = make_shading_buffer(scene, view_.mesh, hits, options_.common.shading, threads_);
    for (LightSet& set : sets_) trace(set);
  }

  void trace(LightSet& set) const {
    set.tree = build_local_tree(set.lights);
    set.traced = std::make_unique<LocalLighting>(set.tree, set.lights);
    set.traced->set_cut(options_.knobs.nodes, 0);
  }

  /// The whole scene as it stands at a frame, with nothing kept from the last.
  void pose(int frame) {
    posed_ = in_.scene;
    posed_.mesh = mesh_at(in_.scene, time_of_frame(options_.frames, in_.scene, frame));
    posed_tracer_.emplace(posed_);
    tracer_ = &*posed_tracer_;
    gather_lights(posed_);
    prepare_traced(posed_);
  }

  std::vector<vec3> shade(LightSet& set, std::vector<std::uint32_t>& counts) const {
    if (set.shader) return set.shader->shade(threads_, counts);
    return shade_traced(view_.buffer, *set.traced, *tracer_,
                        {.tolerance = options_.trace_tolerance, .seed = options_.common.seed}, threads_,
                        counts);
  }

  const SystemOptions options_;
  Inputs& in_;
  const EmbreeTracer* tracer_;
  const Threads& threads_;
  Scene posed_;
  std::optional<EmbreeTracer> posed_tracer_;
  PreparedView view_;
  std::vector<LightSet> sets_;
  double light_seconds_ = 0;
  std::string store_note_;
};

}  // namespace

std::unique_ptr<System> make_local_system(const SystemOptions& options, Inputs& in,
                                          const EmbreeTracer& tracer, const Threads& threads) {
  return std::make_unique<LocalSystem>(options, in, tracer, threads);
}

}  // namespace coppice::program
