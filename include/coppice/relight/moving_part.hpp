// A rigid object at rest in its own frame: what it hides from itself and from what is around it.
#pragma once

#include <coppice/relight/prepared_view.hpp>
#include <coppice/relight/shadow_field.hpp>
#include <coppice/scene/motion.hpp>
#include <memory>
#include <optional>

namespace coppice {

struct MovingOptions {
  Raster raster;
  Shading shading = Shading::metallic_roughness;
  double sigma = 2;       ///< of all visibility cuts
  int resolution = 24;    ///< of a shell of samples around an object: (resolution + 1)² directions
  int shells = 3;         ///< an octave of distance
  float reach = 16;       ///< radii of the object beyond which it casts no shadow
  float spacing = 0.25f;  ///< of the samples of what rests along an object's path, in radii of the object
  RefineOptions refine{0.02, 20000};  ///< of the receivers of one object
};

namespace detail {

/// The box around balls.
struct Box {
  vec3 low{std::numeric_limits<float>::infinity()}, high{-std::numeric_limits<float>::infinity()};
  void add(const vec3& p, float radius = 0) {
    low = glm::min(low, p - radius), high = glm::max(high, p + radius);
  }
  vec3 centre() const { return 0.5f * (low + high); }
};

/// All sides that shade: fronts, and backs where double-sided.
inline std::vector<SidedTriangle> all_sides(const Scene& scene) {
  std::vector<SidedTriangle> sides;
  for (std::uint32_t t = 0; t < scene.mesh.triangles.size(); ++t) {
    sides.push_back({t, true});
    if (scene.materials[scene.mesh.materials[t]].double_sided) sides.push_back({t, false});
  }
  return sides;
}

}  // namespace detail

/// Made once for each object. `leaf_lights` are directions, in the object's frame as in the world.
template <class Tracer>
requires Occluder<Tracer> && RayTracer<Tracer> && std::constructible_from<Tracer, const Scene&>
class MovingPart {
 public:
  /// `resting` traces what does not move.
  template <Executor E>
  MovingPart(const Scene& all, const MovingObject& object, const Tracer& resting, const LightTree& tree,
             const DirectionPackets& leaf_lights, const MovingOptions& options, const E& executor,
             const Progress& progress)
      : motion(object.motion) {
    scene.mesh = object.mesh;
    scene.materials = all.materials;
    scene.textures = all.textures;
    tracer.emplace(scene);
    detail::Box box;
    for (const vec3& p : scene.mesh.positions) box.add(p);
    centre = box.centre();
    for (const vec3& p : scene.mesh.positions) radius = std::max(radius, length(p - centre));
    VisibilityCutOptions cut_options;
    cut_options.sigma = options.sigma;
    cut_options.weight = CutWeight::uniform;  // others than its own horizon may hide lights from it
    prepare_receivers(tree, leaf_lights, cut_options, options.refine, executor);
    const ShellSamples shells(centre, 0.75f * radius, options.reach * radius, options.shells,
                              options.resolution);
    field.emplace(precompute_field(*tracer, tree, leaf_lights, shells, cut_options, executor, progress));
    surroundings.emplace(precompute_field(resting, tree, leaf_lights, path_samples(options.spacing * radius),
                                          cut_options, executor, progress));
  }

  std::size_t byte_count() const {
    return cuts.byte_count() + field->cuts.byte_count() + surroundings->cuts.byte_count();
  }

  Scene scene;  ///< the object's mesh alone, with all materials
  std::optional<Tracer> tracer;
  Motion motion;
  vec3 centre{0};
  float radius = 0;
  ReceiverMesh mesh;
  std::vector<Receiver> receivers;
  MaskedCuts<std::uint8_t> cuts;            ///< of its receivers, past itself
  std::optional<ShadowField> field;         ///< what it hides
  std::optional<ShadowField> surroundings;  ///< what rests, seen along its path; samples in the world

 private:
  template <Executor E>
  void prepare_receivers(const LightTree& tree, const DirectionPackets& leaf_lights,
                         const VisibilityCutOptions& options, const RefineOptions& refine,
                         const E& executor) {
    mesh = ReceiverMesh(scene.mesh, detail::all_sides(scene));
    std::vector<vec3> few;
    for (std::uint32_t i = std::min(8u, leaf_lights.count() - 1); i < leaf_lights.count(); i += 16)
      few.push_back(leaf_lights.direction(i));
    const DirectionPackets pilot(few);
    const auto limits = [this](const vec3&) { return EdgeLimits{0.02f * radius, 0.25f * radius}; };
    refine_receivers(mesh, *tracer, pilot, refine, limits, executor);
    receivers = corner_receivers(mesh);
    mark_bumpy_receivers(scene, mesh, receivers);
    free_buried_receivers(*tracer, pilot, receivers, executor);
    cuts = std::move(precompute_visibility<std::uint8_t>(*tracer, tree, leaf_lights, receivers,
                                                         std::span(&options, 1), false, executor)
                         .cuts[0]);
  }

  /// A grid around all places of the object on its path.
  GridSamples path_samples(float spacing) const {
    detail::Box box;
    const int steps = 256;
    for (int i = 0; i <= steps; ++i)
      box.add(motion.at(motion.duration() * float(i) / float(steps)).point(centre), radius);
    return {box.low, box.high, spacing};
  }
};

}  // namespace coppice
