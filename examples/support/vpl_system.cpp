#include <coppice/gather/glossy_points.hpp>
#include <coppice/gather/vpl_bounces.hpp>
#include <coppice/gather/vpl_frames.hpp>
#include <coppice/light/environment_lights.hpp>
#include <coppice/light/scene_lights.hpp>
#include <coppice/relight/local_relighting.hpp>
#include <coppice/scene/pose.hpp>
#include <coppice/trade/psnr.hpp>
#include <support/report.hpp>
#include <support/vpl_gatherer.hpp>
#include <support/vpl_surfaces.hpp>
#include <support/vpl_system.hpp>

namespace coppice::program {
namespace {

using nlohmann::json;

class VplSystem : public System {
 public:
  VplSystem(const VplSystemOptions& options, Inputs& in, const Threads& threads)
      : options_(options),
        in_(in),
        threads_(threads),
        frames_(options.tree),
        gatherer_(make_vpl_gatherer(options_, threads)) {
    Stopwatch watch;
    pose(0);
    gather_lights(0);
    rest_ = scene_.mesh;
    VplOptions placement = options_.placement;
    placement.seed = options_.common.seed;
    placed_ = place_vpls(scene_, lights_, *tracer_, threads_, placement);
    placement_seconds_ = watch.lap();
    if (lights_.empty()) in_.scene.warnings.push_back("nothing shines in the scene: the image is black");
  }

  RenderedFrame render(int frame) override {
    Stopwatch total, watch;
    stages_ = json::object();
    if (frame > 0 && options_.animate) pose(frame);
    if (frame > 0) gather_lights(frame);
    stages_["pose"] = 1e3 * watch.lap();
    light_vpls();
    see();
    RenderedFrame result;
    result.direct = direct_image(scene_, options_.common.raster, hits_);
    Image direct = shade_directly(), indirect = gather(result);
    result.image = Image(direct.width, direct.height);
    for (std::size_t i = 0; i < direct.pixels.size(); ++i)
      result.image.pixels[i] = direct.pixels[i] + indirect.pixels[i];
    result.image = add_emission(std::move(result.image), result.direct);
    result.parts.emplace_back("direct", std::move(direct));
    result.parts.emplace_back("indirect", std::move(indirect));
    result.report["milliseconds"] = 1e3 * total.lap();
    result.report["stages"] = stages_;
    result.report["vpls"] = {{"placed", placed_.size()}, {"shining", shining_count()}};
    return result;
  }

  /// The light of all VPLs alone: direct light has its own error.
  Image reference(json& report) override {
    Stopwatch watch;
    const VplTree& t = tree();
    std::vector<std::uint32_t> leaves;
    for (std::uint32_t h = t.leaf_count(); h < 2 * t.leaf_count(); ++h)
      if (t.nodes()[h].energy > 0) leaves.push_back(h);
    VplArrays all;
    all.assign(t.nodes(), leaves);
    const TracedNodes traced(t, VplChoice::energy);
    Image image(options_.common.raster.width, options_.common.raster.height);
    threads_(points_.size(), 64, [&](std::size_t begin, std::size_t end) {
      std::uint32_t rays = 0;
      for (std::size_t i = begin; i < end; ++i)
        image.pixels[points_[i].pixel] = options_.is_traced
                                             ? traced.reflect(points_[i], leaves, Random(0), *tracer_, rays)
                                             : reflect_nodes<VplKind::single>(all, points_[i]);
    });
    report["all_vpls_milliseconds"] = 1e3 * watch.lap();
    return image;
  }

  json preparation() const override {
    return {{"triangles", scene_.mesh.triangles.size()},
            {"lights", lights_.size()},
            {"vpls", placed_.size()},
            {"seconds", {{"placement", placement_seconds_}}}};
  }

 private:
  bool is_moving() const { return options_.frames > 1; }
  const VplTree& tree() const { return is_moving() ? frames_.tree() : tree_; }

  std::size_t shining_count() const {
    const auto leaves = tree().nodes().subspan(tree().leaf_count());
    return std::size_t(std::ranges::count_if(leaves, [](const VplNode& n) { return n.energy > 0; }));
  }

  void pose(int frame) {
    scene_ = in_.scene;
    scene_.mesh = mesh_at(in_.scene, time_of_frame(options_.frames, in_.scene, frame));
    tracer_.emplace(scene_);
  }

  /// All primary lights.
  void gather_lights(int frame) {
    in_.environment.rotation =
        glm::radians(options_.common.rotate_environment * float(is_moving() ? frame : 1));
    lights_ = primary_lights(options_, scene_, in_.environment);
  }

  void light_vpls() {
    Stopwatch watch;
    vpls_ = placed_;
    follow(vpls_, rest_, scene_.mesh);
    stages_["follow"] = 1e3 * watch.lap();
    std::vector<VplLight> light(vpls_.size());
    coppice::light_vpls(vpls_, lights_, *tracer_, threads_, light);
    stages_["vpl_direct_light"] = 1e3 * watch.lap();
    const ProgramSurfaces surfaces{scene_, options_.common.shading, options_.exponents};
    const auto leaves_of = [&](std::span<const VplLight> l) {
      return vpl_leaves(vpls_, l, surfaces, threads_);
    };
    light = with_bounces(vpls_, light, leaves_of,
                         {options_.bounces, 0.02f, options_.is_traced, options_.common.seed, options_.tree},
                         *tracer_, threads_);
    stages_["bounces"] = 1e3 * watch.lap();
    std::vector<VplNode> leaves = leaves_of(light);
    stages_["leaves"] = 1e3 * watch.lap();
    if (is_moving())
      refit(std::move(leaves));
    else
      tree_ = VplTree(shining(std::move(leaves)), options_.tree);
    gatherer_->use(tree());
    stages_["tree"] = 1e3 * watch.lap();
  }

  void refit(std::vector<VplNode> leaves) {
    const VplFrames::Update u = frames_.update(std::move(leaves));
    stages_["changed_vpls"] = u.changed;
    stages_["tree_rebuilt"] = u.is_rebuilt;
    stages_["tree_looseness"] = u.looseness;
  }

  void see() {
    Stopwatch watch;
    hits_ = trace_camera(*tracer_, in_.camera, options_.common.raster, threads_);
    points_ = glossy_points(scene_, hits_,
                            ProgramSurfaces{scene_, options_.common.shading, options_.exponents}, threads_);
    stages_["camera"] = 1e3 * watch.lap();
  }

  /// The primary lights at all pixels, with shadow rays.
  Image shade_directly() {
    Stopwatch watch;
    const LightTree light_tree = build_local_tree(lights_);
    LocalLighting lighting(light_tree, lights_);
    lighting.set_cut(default_nodes, 0);
    Image image(options_.common.raster.width, options_.common.raster.height);
    threads_(hits_.size(), 256, [&](std::size_t begin, std::size_t end) {
      if (lights_.empty()) return;
      TracedShader<EmbreeTracer> shader(lighting, *tracer_, {.seed = options_.common.seed});
      std::size_t rays = 0;
      for (std::size_t i = begin; i < end; ++i)
        image.pixels[hits_[i].pixel] =
            shader.shade(shading_point_of(i), points_[i].position, hits_[i].pixel, rays);
    });
    stages_["direct_light"] = 1e3 * watch.lap();
    return image;
  }

  ShadingPoint shading_point_of(std::size_t i) const {
    ShadingPoint p = shading_point(scene_, hits_[i].hit, hits_[i].to_viewer, options_.common.shading);
    if (options_.exponents) set_phong(p, points_[i].diffuse, points_[i].specular, points_[i].exponent);
    return p;
  }

  Gathered gather_points(std::span<const GlossyPoint> points, PointGroups& groups) {
    groups = group_points(points, options_.common.raster.width, in_.camera.position,
                          scattered_groups(points.size(), points_.size()));
    return gatherer_->gather(groups, *tracer_);
  }

  Image gather(RenderedFrame& result) {
    Stopwatch watch;
    counts_.clear();
    result.cut_size.assign(options_.common.raster.pixel_count(), 0.0f);
    std::vector<std::uint32_t> point_of(options_.common.raster.pixel_count(), 0);
    for (std::uint32_t i = 0; i < points_.size(); ++i) point_of[points_[i].pixel] = i;
    double gathering = 0;
    const auto gather_pixels = [&](std::span<const std::uint32_t> pixels, std::span<vec3> radiance) {
      Stopwatch own;
      std::vector<GlossyPoint> chosen;
      for (const std::uint32_t pixel : pixels) chosen.push_back(points_[point_of[pixel]]);
      PointGroups groups;
      const Gathered g = gather_points(chosen, groups);
      for (std::size_t i = 0; i < groups.points.size(); ++i) {
        const std::uint32_t pixel = groups.points[i].pixel;
        const auto at = std::ranges::lower_bound(pixels, pixel) - pixels.begin();
        radiance[std::size_t(at)] = g.radiance[i];
        result.cut_size[pixel] = float(g.nodes[i]);
        counts_.push_back(g.nodes[i]);
      }
      gathering += own.seconds();
    };
    Image image =
        options_.pixels == Pixels::all ? gather_all(gather_pixels) : gather_some(gather_pixels, result);
    stages_["gather"] = 1e3 * gathering;
    stages_["interpolation"] = 1e3 * (watch.lap() - gathering);
    result.report["gathered_pixels"] = counts_.size();
    result.report[options_.is_traced ? "shadow_rays" : "nodes"] = summary_json(summary_of(counts_));
    return image;
  }

  template <class Gather>
  Image gather_all(Gather& gather_pixels) const {
    std::vector<std::uint32_t> pixels;
    for (const GlossyPoint& p : points_) pixels.push_back(p.pixel);
    std::vector<vec3> radiance(pixels.size());
    gather_pixels(pixels, radiance);
    Image image(options_.common.raster.width, options_.common.raster.height);
    for (std::size_t i = 0; i < pixels.size(); ++i) image.pixels[pixels[i]] = radiance[i];
    return image;
  }

  AdaptiveOptions sampling() const {
    AdaptiveOptions o;
    if (options_.pixels == Pixels::paper) o = paper_sampling(scene_size(scene_.mesh));
    if (options_.pixels == Pixels::uniform_2) o = uniform_sampling(2);
    if (options_.pixels == Pixels::uniform_4) o = uniform_sampling(4);
    if (options_.epsilon) o.epsilon = *options_.epsilon;
    return o;
  }

  template <class Gather>
  Image gather_some(Gather& gather_pixels, RenderedFrame& result) const {
    const GBuffer buffer = g_buffer_of(scene_, in_.camera, options_.common.raster, hits_, points_);
    AdaptiveImage a = sample_adaptively(buffer, sampling(), gather_pixels, threads_);
    Image steps(a.radiance.width, a.radiance.height);
    for (std::size_t i = 0; i < a.steps.size(); ++i) steps.pixels[i] = vec3(float(a.steps[i]));
    result.parts.emplace_back("sampled", std::move(steps));
    return std::move(a.radiance);
  }

  const VplSystemOptions options_;
  Inputs& in_;
  const Threads& threads_;
  Scene scene_;  ///< as it stands at the frame
  Mesh rest_;    ///< on which VPLs were placed
  std::optional<EmbreeTracer> tracer_;
  std::vector<LocalLight> lights_;
  std::vector<SurfaceSample> placed_, vpls_;
  VplTree tree_;
  VplFrames frames_;
  std::unique_ptr<VplGatherer> gatherer_;
  std::vector<CameraHit> hits_;
  std::vector<GlossyPoint> points_;
  std::vector<std::uint32_t> counts_;
  json stages_;
  double placement_seconds_ = 0;
};

}  // namespace

std::vector<LocalLight> primary_lights(const VplSystemOptions& options, const Scene& scene,
                                       const Environment& environment) {
  std::vector<LocalLight> lights = scene_lights(scene, options.emitters, options.common.seed);
  if (options.common.environment.empty()) return lights;
  const auto sky = environment_lights(environment, options.sky_lights, scene_size(scene.mesh));
  lights.insert(lights.end(), sky.begin(), sky.end());
  return lights;
}

std::unique_ptr<System> make_vpl_system(const VplSystemOptions& options, Inputs& in, const Threads& threads) {
  return std::make_unique<VplSystem>(options, in, threads);
}

}  // namespace coppice::program
