// Embree as camera and shadow rays over a scene's triangles.
#pragma once

#include <coppice/scene/hit.hpp>
#include <coppice/scene/occluder.hpp>
#include <coppice/scene/scene.hpp>
#include <memory>
#include <optional>

namespace coppice {

/// Rays against all triangles of a scene, both sides solid. Texels that a material's alpha mask cuts out are
/// holes. Camera rays are watertight; a shadow ray that passes within rounding of an edge may slip through,
/// for twice the speed. The scene must outlive the tracer. Throws InputError where Embree cannot be started.
class EmbreeTracer {
 public:
  explicit EmbreeTracer(const Scene& scene);
  ~EmbreeTracer();
  EmbreeTracer(EmbreeTracer&&) noexcept;
  EmbreeTracer& operator=(EmbreeTracer&&) noexcept;

  /// The nearest hit beyond the origin, if there is one.
  std::optional<Hit> closest(const vec3& origin, const vec3& direction) const;
  bool occluded(const vec3& origin, const vec3& direction, float t_max) const;
  /// Lanes of `lanes` that are blocked; 17 to 44 M rays a second a core where neighbours have like
  /// directions.
  std::uint32_t occluded(const ShadowPacket& packet, std::uint32_t lanes) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};
static_assert(Occluder<EmbreeTracer>);

}  // namespace coppice
