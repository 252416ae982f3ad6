#include <coppice/core/simd.hpp>
//
#include <coppice/core/error.hpp>
#include <coppice/exr/read.hpp>
#include <coppice/relight/brute_force.hpp>
#include <coppice/scene/pose.hpp>
#include <coppice/sg/dense_sky.hpp>
#include <coppice/voxel/voxel_box.hpp>
#include <support/report.hpp>
#include <support/sg_placement.hpp>
#include <support/sg_system.hpp>
#include <support/sg_tracer.hpp>

namespace coppice::program {
namespace {

using nlohmann::json;

/// A box for the scene at all frames. Tells what it leaves out.
VoxelBox box_of(Scene& scene, int frames) {
  const VoxelBox worth = box_worth_voxels(scene.mesh.positions);
  GrowingBox box, all;
  for (const vec3& p : scene.mesh.positions) all.add(p);
  if (!all.empty()) box.add(worth.low), box.add(worth.high);
  if (!all.empty() && (worth.low != all.box().low || worth.high != all.box().high))
    scene.warnings.push_back("geometry far from where most of it is has no voxels and casts no shadows");
  for (int frame = 0; frame < frames; ++frame)
    for (const MovingObject& object : scene.objects) {
      const RigidTransform pose = object.motion.at(time_of_frame(frames, scene, frame));
      for (const vec3& p : object.mesh.positions) box.add(pose.point(p));
    }
  return box.box();
}

class SgSystem : public System {
 public:
  SgSystem(const SgSystemOptions& options, Inputs& in, const Threads& threads)
      : options_(options),
        in_(in),
        threads_(threads),
        placement_(make_sg_placement(options_, threads)),
        cones_(make_sg_tracer(options_, box_of(in.scene, options.frames), threads)) {
    if (!options.environment_to.empty()) read_second_map();
    Stopwatch watch;
    pose(0);
    seconds_["tracer"] = watch.lap();
    cones_->build(scene_.mesh);
    seconds_["voxels"] = watch.lap();
  }

  RenderedFrame render(int frame) override {
    frame_ = frame;
    stages_ = json::object();
    Stopwatch total, watch;
    if (frame > 0 && options_.animate) move(frame);
    stages_["geometry"] = 1e3 * watch.lap();
    if (frame == 0 || !options_.environment_to.empty()) placement_->take(map_of(frame), stages_);
    stages_["environment"] = 1e3 * watch.lap();
    see();
    stages_["camera"] = 1e3 * watch.lap();
    const ConeBatch batch = placement_->place(points_, receivers_, in_.environment.rotation);
    stages_["placement"] = 1e3 * watch.lap();
    const std::vector<float> visibility = cones_->trace(*tracer_, batch, stages_);
    stages_["visibility"] = 1e3 * watch.lap();
    const std::vector<vec3> radiance = visible_light(batch, visibility, threads_);
    stages_["sum"] = 1e3 * watch.lap();
    RenderedFrame result = finish(batch, radiance);
    result.report["milliseconds"] = 1e3 * total.lap();
    return result;
  }

  Image reference(json& report) override {
    Stopwatch watch;
    const FrameLighting lights = dense_sky(map_of(frame_), options_.sky.lights);
    const auto count = std::uint32_t(lights.nodes.size() / 2);
    const DenseLights dense(count, lights);
    std::vector<vec3> radiance(points_.size());
    const MapFrame turn(in_.environment.rotation);
    threads_(points_.size(), 16, [&](std::size_t begin, std::size_t end) {
      std::vector<std::uint64_t> bits(words_for_bits(count));
      for (std::size_t i = begin; i < end; ++i) {
        see_lights(dense, turn, receivers_[i], *tracer_, bits);
        radiance[i] = shade_brute_force<Skip::unseen>(turn.to_map(points_[i]), dense, bits, bits, bits);
      }
    });
    report["reference_lights"] = count;
    report["reference_milliseconds"] = 1e3 * watch.lap();
    return add_emission(image_of(radiance), direct_);
  }

  json preparation() const override {
    json j = {{"triangles", scene_.mesh.triangles.size()}, {"seconds", seconds_}};
    if (const json size = cones_->size(); !size.is_null()) j["voxels"] = size;
    return j;
  }

 private:
  void read_second_map() {
    to_ = read_environment(options_.environment_to).map;
    if (to_.width != in_.environment.map.width || to_.height != in_.environment.map.height)
      throw InputError(options_.environment_to.string(), "is not of the size of --env",
                       "scale one of the two");
  }

  /// How far into the frames, from 0 to 1.
  float progress(int frame) const {
    return options_.frames > 1 ? float(frame) / float(options_.frames - 1) : 0;
  }

  Image map_of(int frame) const {
    Image map = in_.environment.map;
    if (to_.pixels.empty()) return map;
    for (std::size_t i = 0; i < map.pixels.size(); ++i)
      map.pixels[i] = glm::mix(map.pixels[i], to_.pixels[i], progress(frame));
    return map;
  }

  void pose(int frame) {
    scene_ = in_.scene;
    scene_.mesh = mesh_at(in_.scene, time_of_frame(options_.frames, in_.scene, frame));
    tracer_.emplace(scene_);
  }

  /// Objects come after what rests (mesh_at).
  void move(int frame) {
    pose(frame);
    cones_->update(scene_.mesh, in_.scene.mesh.triangles.size(), stages_);
  }

  void see() {
    in_.environment.rotation =
        glm::radians(options_.common.rotate_environment * float(options_.frames > 1 ? frame_ : 1));
    hits_ = trace_camera(*tracer_, in_.camera, options_.common.raster, threads_);
    direct_ = direct_image(scene_, options_.common.raster, hits_);
    points_.resize(hits_.size());
    receivers_.resize(hits_.size());
    threads_(hits_.size(), 1024, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        points_[i] = point_of(hits_[i]), receivers_[i] = receiver_of(i);
    });
  }

  ShadingPoint point_of(const CameraHit& hit) const {
    ShadingPoint p = shading_point(scene_, hit.hit, hit.to_viewer, options_.common.shading);
    p.weight_0 = 1;
    if (options_.roughness_to && p.brdf == BRDF_GGX) {
      const float roughness = glm::mix(std::sqrt(p.alpha_x), *options_.roughness_to, progress(frame_));
      p.alpha_x = p.alpha_y = valid_alpha(roughness * roughness);
    }
    if (!options_.material) return p;
    p.brdf = options_.material->brdf;
    p.alpha_x = p.alpha_y = options_.material->parameter;
    p.diffuse = vec3(p.brdf == BRDF_LAMBERT ? 0.5f : 0.0f);
    p.specular = p.fresnel = vec3(p.brdf == BRDF_LAMBERT ? 0.0f : 1.0f);
    return p;
  }

  ConeReceiver receiver_of(std::size_t i) const {
    const vec3 p = ray_origin(scene_.mesh, hits_[i]);
    const uvec3 t = scene_.mesh.triangles[hits_[i].hit.triangle];
    const auto& v = scene_.mesh.positions;
    const vec3 n = normalize_or(cross(v[t.y] - v[t.x], v[t.z] - v[t.x]), hits_[i].to_viewer);
    return {p, 0, dot(n, hits_[i].to_viewer) < 0 ? -n : n, std::uint32_t(i), points_[i].normal};
  }

  RenderedFrame finish(const ConeBatch& batch, std::span<const vec3> radiance) {
    RenderedFrame result;
    result.image = add_emission(image_of(radiance), direct_);
    const std::vector<float> open(batch.cones.size(), 1.0f);
    result.parts.emplace_back("unoccluded", image_of(visible_light(batch, open, threads_)));
    std::vector<std::uint32_t> counts;
    result.cut_size.assign(options_.common.raster.pixel_count(), 0.0f);
    for (std::size_t i = 0; i < batch.receivers.size(); ++i) {
      counts.push_back(batch.receivers[i].cones_end - batch.begin_of(i));
      result.cut_size[hits_[i].pixel] += float(counts.back()) / float(options_.common.raster.samples);
    }
    result.direct = direct_;
    result.report["stages"] = stages_;
    result.report["cones"] = summary_json(summary_of(counts));
    result.report["clusters"] = double(batch.clusters) / std::max(1.0, double(counts.size()));
    result.report["points"] = points_.size();
    result.report["peaks"] = placement_->peak_count();
    return result;
  }

  /// The mean over each pixel's samples.
  Image image_of(std::span<const vec3> radiance) const {
    const Raster& raster = options_.common.raster;
    Image image(raster.width, raster.height);
    for (std::size_t i = 0; i < radiance.size(); ++i)
      image.pixels[hits_[i].pixel] += radiance[i] / float(raster.samples);
    return image;
  }

  const SgSystemOptions options_;
  Inputs& in_;
  const Threads& threads_;
  Image to_;     ///< the map of --env-to
  Scene scene_;  ///< as it stands at the frame
  std::optional<EmbreeTracer> tracer_;
  std::unique_ptr<SgPlacement> placement_;
  std::unique_ptr<SgTracer> cones_;
  int frame_ = 0;
  std::vector<CameraHit> hits_;
  DirectImage direct_;
  std::vector<ShadingPoint> points_;
  std::vector<ConeReceiver> receivers_;
  json stages_, seconds_;
};

}  // namespace

std::unique_ptr<System> make_sg_system(const SgSystemOptions& options, Inputs& in, const Threads& threads) {
  return std::make_unique<SgSystem>(options, in, threads);
}

}  // namespace coppice::program
