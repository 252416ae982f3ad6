#include <support/pca_view.hpp>
//
#include <coppice/brdf/with_brdf.hpp>
#include <coppice/light/bounce.hpp>
#include <unordered_map>

namespace coppice::program {
namespace {

/// Unit; of the triangle, on the viewer's side.
vec3 face_normal(const Mesh& mesh, const CameraHit& h) {
  const vec3 n(detail::area_normal(mesh, h.hit.triangle));
  return normalize_or(dot(n, h.to_viewer) < 0 ? -n : n, h.to_viewer);
}

SurfaceSample sample_at(const Mesh& mesh, const CameraHit& h) {
  return {position_at(mesh, h.hit),
          0,
          face_normal(mesh, h),
          vec3(0),
          {h.hit.triangle, h.hit.front},
          h.hit.u,
          h.hit.v};
}

/// What a point reflects of lights that nothing hides; visit(path, reflected) for each point of them.
template <class Visit>
void for_each_reflected(const ShadingPoint& point, const vec3& origin, std::span<const LocalLight> lights,
                        Visit&& visit) {
  with_brdf(point, [&](const auto& brdf) {
    for (const LocalLight& light : lights) {
      const auto path = path_to(light, origin, point.normal);
      if (!path) continue;
      const vec3 d = brdf_to_local(point.normal, point.tangent, path->direction);
      // The path's irradiance has a cosine, and so has the BRDF's value.
      visit(*path, path->irradiance / d.z * brdf.colour(brdf(d.x, d.y, d.z)));
    }
    return 0;
  });
}

}  // namespace

PcaView::PcaView(const Scene& scene, const EmbreeTracer& tracer, const Camera& camera, const Raster& raster,
                 Shading shading, std::span<const SurfaceSample> samples, SplatTarget target,
                 const SplatOptions& splats, const Threads& threads)
    : scene_(scene), tracer_(tracer), threads_(threads), raster_(raster) {
  hits_ = trace_camera(tracer, camera, raster, threads);
  seen_ = direct_image(scene, raster, hits_);
  points_.resize(hits_.size()), origins_.resize(hits_.size()), albedos_.resize(hits_.size());
  threads(hits_.size(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      points_[i] = shading_point(scene, hits_[i].hit, hits_[i].to_viewer, shading);
      origins_[i] = ray_origin(scene.mesh, hits_[i]);
      albedos_[i] = diffuse_albedo(scene, sample_at(scene.mesh, hits_[i]), shading);
    }
  });
  if (target == SplatTarget::pixels)
    splat_onto_pixels(samples, splats);
  else
    splat_onto_vertices(samples, splats);
}

void PcaView::splat_onto_pixels(std::span<const SurfaceSample> samples, const SplatOptions& options) {
  std::vector<SplatPoint> places;
  places.reserve(hits_.size());
  for (const CameraHit& h : hits_)
    places.push_back({position_at(scene_.mesh, h.hit), face_normal(scene_.mesh, h)});
  splats_ = splat_weights(samples, places, tracer_, threads_, options);
}

void PcaView::splat_onto_vertices(std::span<const SurfaceSample> samples, const SplatOptions& options) {
  const Mesh& mesh = scene_.mesh;
  std::unordered_map<std::uint64_t, std::uint32_t> number_of;  // of a vertex and a side
  std::vector<SplatPoint> places;
  std::vector<SplatCorners> corners;
  corners.reserve(hits_.size());
  for (const CameraHit& h : hits_) {
    const uvec3 t = mesh.triangles[h.hit.triangle];
    const vec3 side = face_normal(mesh, h);
    SplatCorners c{{}, {1 - h.hit.u - h.hit.v, h.hit.u, h.hit.v}};
    for (int k = 0; k < 3; ++k) {
      const vec3 n = mesh.normals[t[k]] * (dot(mesh.normals[t[k]], side) < 0 ? -1.0f : 1.0f);
      const bool flipped = n != mesh.normals[t[k]];
      const auto [at, is_new] = number_of.try_emplace(2ull * t[k] + flipped, std::uint32_t(places.size()));
      if (is_new) places.push_back({mesh.positions[t[k]], n});
      c.points[k] = at->second;
    }
    corners.push_back(c);
  }
  splats_ = interpolate(splat_weights(samples, places, tracer_, threads_, options), corners);
}

template <class Radiance>
Image PcaView::shade(Radiance&& radiance) const {
  std::vector<vec3> values(hits_.size());
  threads_(hits_.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) values[i] = radiance(i);
  });
  Image image(raster_.width, raster_.height);
  for (std::size_t i = 0; i < hits_.size(); ++i)
    image.pixels[hits_[i].pixel] += values[i] / float(raster_.samples);
  return image;
}

Image PcaView::direct(std::span<const SurfaceSample> samples, std::span<const SeenLight> lights) const {
  // Below a sample's horizon its visibility means nothing: it has no say.
  std::vector<std::vector<vec2>> shares(lights.size(), std::vector<vec2>(samples.size()));
  for (std::size_t l = 0; l < lights.size(); ++l)
    threads_(samples.size(), 4096, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const bool faces = std::ranges::any_of(lights[l].points, [&](const LocalLight& p) {
          return path_to(p, samples[i].position, samples[i].normal).has_value();
        });
        shares[l][i] = faces ? vec2(lights[l].visibility[i], 1) : vec2(0);
      }
    });
  return shade([&](std::size_t i) {
    vec3 sum(0);
    for (std::size_t l = 0; l < lights.size(); ++l) {
      vec2 share(0);
      splats_.for_each(i, [&](std::uint32_t s, float weight) { share += weight * shares[l][s]; });
      if (!(share.x > 0)) continue;
      vec3 reflected(0);
      for_each_reflected(points_[i], origins_[i], lights[l].points,
                         [&](const LightPath&, const vec3& light) { reflected += light; });
      sum += share.x / share.y * reflected;
    }
    return sum;
  });
}

Image PcaView::direct_by_rays(std::span<const SeenLight> lights) const {
  return shade([&](std::size_t i) {
    vec3 sum(0);
    for (const SeenLight& light : lights)
      for_each_reflected(points_[i], origins_[i], light.points, [&](const LightPath& path, const vec3& l) {
        if (!tracer_.occluded(origins_[i], path.direction, path.t_max)) sum += l;
      });
    return sum;
  });
}

Image PcaView::indirect(std::span<const vec3> irradiance) const {
  return shade([&](std::size_t i) {
    vec3 sum(0);
    splats_.for_each(i, [&](std::uint32_t s, float weight) { sum += weight * irradiance[s]; });
    return albedos_[i] / pi * glm::max(sum, vec3(0));  // bases may undershoot where it is dark
  });
}

}  // namespace coppice::program
