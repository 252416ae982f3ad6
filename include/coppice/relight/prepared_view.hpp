// What one camera sees of a scene, and the receivers under it.
#pragma once

#include <coppice/core/error.hpp>
#include <coppice/core/stopwatch.hpp>
#include <coppice/relight/deferred.hpp>
#include <coppice/relight/refine.hpp>

namespace coppice {

/// Which sides of triangles have receivers.
enum class ReceiverScope {
  seen,
  all
};  ///< seen: those the camera sees; all: every front, and backs where double-sided

struct ViewOptions {
  Raster raster;
  Shading shading = Shading::metallic_roughness;
  RefineOptions refine;
  ReceiverScope scope = ReceiverScope::seen;
  float shortest_edge = 2;  ///< pixels; the tolerance alone does not split shorter edges
  float longest_edge =
      32;  ///< pixels; longer edges are always split, so that no shadow hides between receivers
};

/// Points that the camera sees, and receivers on the faces around them, refined until the visibility of the
/// pilot lights can be interpolated. Results do not depend on the executor.
struct PreparedView {
  DirectImage direct;
  std::vector<Receiver> receivers;
  ReceiverMesh mesh;  ///< its corners are the receivers
  ShadingBuffer buffer;
  std::size_t unrefined_receivers = 0;
  double camera_seconds = 0, refinement_seconds = 0;
};

namespace detail {

inline std::vector<SidedTriangle> receiver_sides(const Scene& scene, std::span<const CameraHit> hits,
                                                 ReceiverScope scope) {
  std::vector<SidedTriangle> sides = sides_seen(scene.mesh, hits);
  if (scope == ReceiverScope::seen) return sides;
  std::vector<std::uint8_t> backs(scene.mesh.triangles.size(), 0);
  for (const auto& s : sides) backs[s.triangle] |= !s.front;
  sides.clear();
  for (std::uint32_t t = 0; t < backs.size(); ++t) {
    sides.push_back({t, true});
    if (backs[t] || scene.materials[scene.mesh.materials[t]].double_sided) sides.push_back({t, false});
  }
  return sides;
}

}  // namespace detail

/// Receivers on the faces around what the camera sees.
struct ViewReceivers {
  ReceiverMesh mesh;
  std::vector<Receiver> receivers;  ///< at the corners of the mesh
};

/// The view over receivers that are there already. Throws InputError where the camera sees a side that their
/// mesh lacks.
template <RayTracer Tracer, Executor E>
PreparedView view_over(const Scene& scene, const Tracer& tracer, const Camera& camera,
                       const ViewOptions& options, ViewReceivers known, const E& executor) {
  PreparedView view;
  Stopwatch watch;
  const auto hits = trace_camera(tracer, camera, options.raster, executor);
  for (const SidedTriangle& side : sides_seen(scene.mesh, hits))
    if (!known.mesh.has(side))
      throw InputError("the receivers", "do not cover what the camera sees", "compute them anew");
  view.direct = direct_image(scene, options.raster, hits);
  view.mesh = std::move(known.mesh);
  view.receivers = std::move(known.receivers);
  view.unrefined_receivers = view.receivers.size();
  view.buffer = make_shading_buffer(scene, view.mesh, hits, options.shading, executor);
  view.camera_seconds = watch.lap();
  return view;
}

/// `pilot` judges where edges are split, `few` (fewer lights) which receivers lie buried.
template <class Tracer, LightPackets L, Executor E>
requires Occluder<Tracer> && RayTracer<Tracer> PreparedView
prepare_view(const Scene& scene, const Tracer& tracer, const Camera& camera, const ViewOptions& options,
             const L& pilot, const L& few, const E& executor) {
  Stopwatch watch;
  const auto hits = trace_camera(tracer, camera, options.raster, executor);
  ViewReceivers made{ReceiverMesh(scene.mesh, detail::receiver_sides(scene, hits, options.scope)), {}};
  const std::size_t unrefined = made.mesh.corners().size();
  const float pixel = camera.pixel_angle(options.raster.height);
  const auto limits = [&](const vec3& p) {
    const float footprint = pixel * length(p - camera.position);
    return EdgeLimits{options.shortest_edge * footprint, options.longest_edge * footprint};
  };
  refine_receivers(made.mesh, tracer, pilot, options.refine, limits, executor);
  made.receivers = corner_receivers(made.mesh);
  mark_bumpy_receivers(scene, made.mesh, made.receivers);
  free_buried_receivers(tracer, few, made.receivers, executor);
  const double seconds = watch.lap();
  PreparedView view = view_over(scene, tracer, camera, options, std::move(made), executor);
  view.unrefined_receivers = unrefined;
  view.refinement_seconds = seconds;
  return view;
}

}  // namespace coppice
