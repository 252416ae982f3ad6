// What the camera sees, as points that gather the light of VPLs.
#pragma once

#include <coppice/gather/g_buffer.hpp>
#include <coppice/gather/vpl_nodes.hpp>
#include <coppice/relight/deferred.hpp>

namespace coppice {

/// How surfaces reflect, to points and to VPLs alike: `surfaces(hit, towards)` is the reflectance at a hit
/// for a unit direction, that of the viewer or that of the light, as the Phong form of phong_surface.
template <class S>
concept Surfaces = requires(const S& surfaces, const Hit& hit, const vec3& towards) {
  { surfaces(hit, towards) } -> std::same_as<PhongSurface>;
};

/// The materials of a scene.
struct SceneSurfaces {
  const Scene& scene;
  Shading shading = Shading::metallic_roughness;

  PhongSurface operator()(const Hit& hit, const vec3& towards) const {
    return phong_surface(shading_point(scene, hit, towards, shading));
  }
};

/// Leaves of all VPLs under a light each, in their order; those in the dark have no energy.
template <Surfaces S, Executor E>
std::vector<VplNode> vpl_leaves(std::span<const SurfaceSample> vpls, std::span<const VplLight> light,
                                const S& surfaces, const E& executor) {
  COPPICE_ASSERT(light.size() == vpls.size());
  std::vector<VplNode> leaves(vpls.size());
  executor(vpls.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      leaves[i] = vpl_leaf(vpls[i], surfaces(hit_of(vpls[i]), light[i].direction), light[i]);
  });
  return leaves;
}

/// The points of camera rays, in their order. The mirror direction follows the shading normal.
template <Surfaces S, Executor E>
std::vector<GlossyPoint> glossy_points(const Scene& scene, std::span<const CameraHit> hits, const S& surfaces,
                                       const E& executor) {
  std::vector<GlossyPoint> points(hits.size());
  executor(hits.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const CameraHit& h = hits[i];
      const vec3 normal = shading_point(scene, h.hit, h.to_viewer, Shading::lambert).normal;
      const PhongSurface surface = surfaces(h.hit, h.to_viewer);
      points[i] = {ray_origin(scene.mesh, h),
                   surface.exponent,
                   normal,
                   h.pixel,
                   normalize(2 * dot(normal, h.to_viewer) * normal - h.to_viewer),
                   0,
                   surface.diffuse,
                   0,
                   surface.specular,
                   0};
    }
  });
  return points;
}

/// The G-buffer of points, one a pixel, for sampling that adapts to the image. Albedo is what reflects in
/// all, but at least a hundredth.
inline GBuffer g_buffer_of(const Scene& scene, const Camera& camera, const Raster& raster,
                           std::span<const CameraHit> hits, std::span<const GlossyPoint> points) {
  GBuffer buffer{raster.width, raster.height, camera.position, camera.pixel_angle(raster.height),
                 std::vector<GBufferPixel>(raster.pixel_count())};
  for (std::size_t i = 0; i < hits.size(); ++i)
    buffer.pixels[hits[i].pixel] = {points[i].position, scene.mesh.materials[hits[i].hit.triangle],
                                    points[i].normal, true,
                                    glm::max(points[i].diffuse + points[i].specular, vec3(0.01f))};
  return buffer;
}

}  // namespace coppice
