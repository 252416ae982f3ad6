// Rigid objects that move through a scene under distant light: shadow fields carry their shadows, cuts in
// their own frame their shading.
#pragma once

#include <coppice/light/environment_cells.hpp>
#include <coppice/relight/field_products.hpp>
#include <coppice/relight/moving_part.hpp>
#include <coppice/relight/turned_cuts.hpp>

namespace coppice {

/// Points with cuts, to be shaded by the usual kernels.
struct PosedObject {
  ShadingBuffer buffer;  ///< what the camera sees of the object, in the world
  MaskedCuts<std::uint8_t> cuts;
};

/// Where the time of a pose went, in seconds.
struct PoseSeconds {
  double camera = 0;   ///< rays to and past the objects
  double turn = 0;     ///< cuts from the objects' frames to the world's tree
  double product = 0;  ///< of cuts and fields
};

/// A scene at one time.
struct Pose {
  MaskedCuts<std::uint8_t> cuts;     ///< of the receivers that rest
  std::vector<std::uint8_t> hidden;  ///< a point of what rests: 1 where an object stands before it
  std::vector<PosedObject> objects;
  std::size_t shadowed_receivers = 0;  ///< of those that rest: some object may hide lights from them
  PoseSeconds seconds;
};

/// The moving objects of a scene, prepared: their own visibility, their shadow fields, and the visibility
/// past what rests along their paths. Results do not depend on the executor.
template <class Tracer>
class MovingObjects {
 public:
  /// What rests: its tracer, view and cuts, and the lights' tree, all of which outlive this; `directions` by
  /// light. Precondition: `cuts` are of σ = options.sigma.
  template <Executor E>
  MovingObjects(const Scene& scene, const Tracer& resting, const PreparedView& view, const LightTree& tree,
                std::span<const vec3> directions, const MaskedCuts<std::uint8_t>& cuts, const Camera& camera,
                const MovingOptions& options, const E& executor, const Progress& progress = {})
      : options_(options),
        resting_(&resting),
        view_(&view),
        tree_(&tree),
        cuts_(&cuts),
        camera_(camera),
        directions_(leaf_directions(tree, directions)),
        cells_(directions, 1024, 512),
        leaf_of_light_(directions.size()) {
    for (std::uint32_t leaf = 0; leaf < tree.leaf_count(); ++leaf)
      if (tree.light_of_leaf[leaf] != no_light) leaf_of_light_[tree.light_of_leaf[leaf]] = leaf;
    for (const Receiver& r : view.receivers) resting_positions_.push_back(r.position);
    const DirectionPackets lights(directions_);
    for (const MovingObject& object : scene.objects)
      parts_.push_back(
          std::make_unique<Part>(scene, object, resting, tree, lights, options, executor, progress));
  }

  /// Everything at a time in seconds.
  template <Executor E>
  Pose pose(float time, const E& executor) const {
    Pose pose;
    Stopwatch watch;
    std::vector<RigidTransform> to_world;
    for (const auto& part : parts_) to_world.push_back(part->motion.at(time));
    see(to_world, pose, executor);
    pose.seconds.camera = watch.lap();
    for (std::size_t k = 0; k < parts_.size(); ++k) {
      pose.objects[k].cuts = turned_cuts(k, to_world[k], pose.objects[k].buffer, executor);
      pose.seconds.turn += watch.lap();
    }
    shadow(to_world, pose, executor);
    return pose;
  }

  std::size_t size() const { return parts_.size(); }
  std::size_t sample_count() const {
    std::size_t count = 0;
    for (const auto& part : parts_) count += part->field->cuts.size() + part->surroundings->cuts.size();
    return count;
  }
  std::size_t byte_count() const {
    std::size_t bytes = 0;
    for (const auto& part : parts_) bytes += part->byte_count();
    return bytes;
  }

 private:
  using Part = MovingPart<Tracer>;

  LeafTurn leaf_turn(const RigidTransform& to_world) const {
    return turn_leaves(directions_, glm::conjugate(to_world.rotation),
                       [&](const vec3& d) { return leaf_of_light_[cells_.nearest_light(d)]; });
  }

  static std::vector<std::uint8_t> receivers_of(const ShadingBuffer& buffer, std::size_t count) {
    std::vector<std::uint8_t> used(count, 0);
    for (const ShadingFace& f : buffer.faces)
      for (int i = 0; i < 3; ++i) used[f.receivers[i]] = 1;
    return used;
  }

  /// Of the receivers whose faces are seen; the cuts of the others keep their frame.
  template <Executor E>
  MaskedCuts<std::uint8_t> turned_cuts(std::size_t k, const RigidTransform& to_world,
                                       const ShadingBuffer& buffer, const E& executor) const {
    const auto used = receivers_of(buffer, parts_[k]->receivers.size());
    return turn_cuts(*tree_, parts_[k]->cuts, leaf_turn(to_world), used, options_.sigma, to_world.rotation,
                     executor);
  }

  /// Multiplies the cuts of everything by the fields of all others.
  template <Executor E>
  void shadow(std::span<const RigidTransform> to_world, Pose& pose, const E& executor) const {
    std::vector<PlacedField> fields;
    for (std::size_t k = 0; k < parts_.size(); ++k)
      fields.push_back({&*parts_[k]->field, to_world[k].inverse()});
    const std::vector<std::uint8_t> all(resting_positions_.size(), 1);
    pose.cuts = multiplied(*cuts_, resting_positions_, all, fields, to_world, pose, executor,
                           &pose.shadowed_receivers);
    for (std::size_t k = 0; k < parts_.size(); ++k) {
      std::vector<PlacedField> others;
      std::vector<RigidTransform> their_world;
      for (std::size_t j = 0; j < parts_.size(); ++j)
        if (j != k)
          others.push_back({fields[j].field, fields[j].to_field}), their_world.push_back(to_world[j]);
      others.push_back({&*parts_[k]->surroundings, RigidTransform()});
      their_world.push_back(RigidTransform());
      std::vector<vec3> positions;
      for (const Receiver& r : parts_[k]->receivers) positions.push_back(to_world[k].point(r.position));
      const auto used = receivers_of(pose.objects[k].buffer, positions.size());
      pose.objects[k].cuts =
          multiplied(pose.objects[k].cuts, positions, used, others, their_world, pose, executor, nullptr);
    }
  }

  template <Executor E>
  MaskedCuts<std::uint8_t> multiplied(const MaskedCuts<std::uint8_t>& cuts, std::span<const vec3> positions,
                                      std::span<const std::uint8_t> wanted, std::span<PlacedField> fields,
                                      std::span<const RigidTransform> to_world, Pose& pose, const E& executor,
                                      std::size_t* shadowed) const {
    Stopwatch watch;
    std::vector<std::vector<std::uint8_t>> used;
    for (const PlacedField& f : fields) used.emplace_back(f.field->cuts.size(), std::uint8_t{0});
    const FieldBlends blends(fields, positions, wanted, used, executor);
    pose.seconds.product += watch.lap();
    for (std::size_t k = 0; k < fields.size(); ++k)
      fields[k].cuts = turn_cuts(*tree_, fields[k].field->cuts, leaf_turn(to_world[k]), used[k],
                                 options_.sigma, to_world[k].rotation, executor);
    pose.seconds.turn += watch.lap();
    auto result = multiply_by_fields(cuts, blends, fields, executor, shadowed);
    pose.seconds.product += watch.lap();
    return result;
  }

  bool hides(std::size_t k, const RigidTransform& to_world, const vec3& point) const {
    const RigidTransform to_object = to_world.inverse();
    const vec3 from = to_object.point(camera_.position), to = to_object.point(point) - from;
    const float distance = length(to);
    return distance > 0 && parts_[k]->tracer->occluded(from, to / distance, distance * (1 - 1e-4f));
  }

  /// What the camera sees of the objects, and what it does not see because of them.
  template <Executor E>
  void see(std::span<const RigidTransform> to_world, Pose& pose, const E& executor) const {
    const ShadingBuffer& resting = view_->buffer;
    pose.hidden.assign(resting.points.size(), 0);
    executor(resting.points.size(), 1024, [&](std::size_t begin, std::size_t end) {
      for (std::size_t p = begin; p < end; ++p)
        for (std::size_t k = 0; k < parts_.size(); ++k)
          pose.hidden[p] |= hides(k, to_world[k], resting.positions[p]);
    });
    pose.objects.resize(parts_.size());
    for (std::size_t k = 0; k < parts_.size(); ++k)
      pose.objects[k].buffer = visible_points(to_world, k, executor);
  }

  template <Executor E>
  ShadingBuffer visible_points(std::span<const RigidTransform> to_world, std::size_t k,
                               const E& executor) const {
    const Part& part = *parts_[k];
    const RigidTransform& placed = to_world[k];
    std::vector<CameraHit> hits =
        trace_camera(*part.tracer, camera_in(placed.inverse()), options_.raster, executor);
    std::erase_if(hits, [&](const CameraHit& h) {
      if (resting_->occluded(camera_.position, placed.direction(-h.to_viewer), h.hit.t)) return true;
      const vec3 seen = placed.point(position_at(part.scene.mesh, h.hit));
      for (std::size_t j = 0; j < parts_.size(); ++j)
        if (j != k && hides(j, to_world[j], seen)) return true;
      return false;
    });
    ShadingBuffer buffer = make_shading_buffer(part.scene, part.mesh, hits, options_.shading, executor);
    for (ShadingPoint& p : buffer.points) {
      p.normal = placed.direction(p.normal);
      p.tangent = placed.direction(p.tangent);
      p.to_viewer = placed.direction(p.to_viewer);
    }
    for (vec3& p : buffer.positions) p = placed.point(p);
    return buffer;
  }

  Camera camera_in(const RigidTransform& to_frame) const {
    Camera camera = camera_;
    camera.position = to_frame.point(camera_.position);
    for (vec3* axis : {&camera.forward, &camera.up, &camera.right}) *axis = to_frame.direction(*axis);
    return camera;
  }

  MovingOptions options_;
  const Tracer* resting_;
  const PreparedView* view_;
  const LightTree* tree_;
  const MaskedCuts<std::uint8_t>* cuts_;
  Camera camera_;
  std::vector<vec3> directions_;  // by leaf, zero for padding
  EnvironmentCells cells_;
  std::vector<std::uint32_t> leaf_of_light_;
  std::vector<vec3> resting_positions_;
  std::vector<std::unique_ptr<Part>> parts_;
};

}  // namespace coppice
