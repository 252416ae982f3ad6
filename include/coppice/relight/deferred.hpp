// The deferred buffer: camera rays, the sides of triangles that they see, and the points to be shaded.
#pragma once

#include <algorithm>
#include <coppice/core/image.hpp>
#include <coppice/core/parallel.hpp>
#include <coppice/relight/receiver_mesh.hpp>
#include <coppice/relight/shading_buffer.hpp>
#include <coppice/scene/surface.hpp>
#include <numeric>
#include <vector>

namespace coppice {

/// A camera ray that met the scene.
struct CameraHit {
  Hit hit;
  vec3 to_viewer;  ///< unit
  std::uint32_t pixel = 0;
};

/// Size of an image and camera rays a pixel: 1 goes through the pixel's centre, more are spread over its
/// area.
struct Raster {
  int width = 1280;
  int height = 720;
  int samples = 1;

  std::size_t pixel_count() const { return std::size_t(width) * std::size_t(height); }

  /// Offset of a sample in the pixel, in [0, 1)²: the R2 sequence (Roberts 2018), shifted so that one is
  /// central.
  vec2 offset(int sample) const {
    const vec2 p(0.5f + float(sample) * 0.7548776662f, 0.5f + float(sample) * 0.5698402910f);
    return p - glm::floor(p);
  }
};

/// All camera rays that meet the scene, ordered by pixel.
template <RayTracer T, Executor E>
std::vector<CameraHit> trace_camera(const T& tracer, const Camera& camera, const Raster& raster,
                                    const E& executor) {
  std::vector<std::vector<CameraHit>> rows(std::size_t(raster.height));
  executor(rows.size(), 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t y = begin; y < end; ++y)
      for (int x = 0; x < raster.width; ++x)
        for (int s = 0; s < raster.samples; ++s) {
          const vec2 o = raster.offset(s);
          const vec3 d = camera.direction(float(x) + o.x, float(y) + o.y, raster.width, raster.height);
          if (const auto hit = tracer.closest(camera.position, d))
            rows[y].push_back({*hit, -d, std::uint32_t(y) * std::uint32_t(raster.width) + std::uint32_t(x)});
        }
  });
  std::vector<CameraHit> hits;
  for (const auto& row : rows) hits.insert(hits.end(), row.begin(), row.end());
  return hits;
}

inline SidedTriangle side_seen(const Mesh& mesh, const CameraHit& h) {
  return {h.hit.triangle, seen_from_front(mesh, h.hit)};
}

/// The sides that any ray sees, each once, by triangle.
inline std::vector<SidedTriangle> sides_seen(const Mesh& mesh, std::span<const CameraHit> hits) {
  std::vector<std::uint8_t> seen(mesh.triangles.size(), 0);
  for (const auto& h : hits) seen[h.hit.triangle] |= side_seen(mesh, h).front ? 1 : 2;
  std::vector<SidedTriangle> sides;
  for (std::uint32_t t = 0; t < seen.size(); ++t) {
    if (seen[t] & 1) sides.push_back({t, true});
    if (seen[t] & 2) sides.push_back({t, false});
  }
  return sides;
}

/// Where shadow rays from a hit begin: above the triangle on the viewer's side, by what float positions do
/// not resolve.
inline vec3 ray_origin(const Mesh& mesh, const CameraHit& h) {
  const uvec3 t = mesh.triangles[h.hit.triangle];
  const vec3 p = position_at(mesh, h.hit), a = mesh.positions[t.x];
  const vec3 n = normalize_or(cross(mesh.positions[t.y] - a, mesh.positions[t.z] - a), h.to_viewer);
  const float size = std::max({std::fabs(p.x), std::fabs(p.y), std::fabs(p.z), h.hit.t});
  return p + (dot(n, h.to_viewer) < 0 ? -1e-5f : 1e-5f) * size * n;
}

/// The shading buffer of the hits: points sorted by face, then pixel, and only faces that have points.
template <Executor E>
ShadingBuffer make_shading_buffer(const Scene& scene, const ReceiverMesh& mesh,
                                  std::span<const CameraHit> hits, Shading shading, const E& executor) {
  std::vector<ReceiverMesh::Location> where(hits.size());
  executor(hits.size(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      where[i] = mesh.locate(side_seen(scene.mesh, hits[i]), {hits[i].hit.u, hits[i].hit.v});
  });
  std::vector<std::uint32_t> order(hits.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::stable_sort(order, {}, [&](std::uint32_t i) { return where[i].face; });

  ShadingBuffer buffer;
  buffer.points.resize(hits.size());
  buffer.pixels.resize(hits.size());
  buffer.positions.resize(hits.size());
  std::uint32_t last = no_face;
  for (std::uint32_t p = 0; p < order.size(); ++p) {
    const auto& location = where[order[p]];
    if (location.face != last) buffer.faces.push_back({mesh.faces()[location.face].corners, p});
    last = location.face;
    buffer.points[p].face = std::uint32_t(buffer.faces.size() - 1);
  }
  executor(order.size(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      const CameraHit& h = hits[order[p]];
      const std::uint32_t face = buffer.points[p].face;
      buffer.points[p] = shading_point(scene, h.hit, h.to_viewer, shading);
      buffer.points[p].face = face;
      buffer.points[p].weight_0 = where[order[p]].weights.x;
      buffer.points[p].weight_1 = where[order[p]].weights.y;
      buffer.pixels[p] = h.pixel;
      buffer.positions[p] = ray_origin(scene.mesh, h);
    }
  });
  return buffer;
}

/// The image of values by point: the mean over each pixel's samples, those that met nothing counting as zero.
inline Image resolve(const ShadingBuffer& buffer, const Raster& raster, std::span<const vec3> values) {
  Image image(raster.width, raster.height);
  for (std::size_t p = 0; p < values.size(); ++p)
    image.pixels[buffer.pixels[p]] += values[p] / float(raster.samples);
  return image;
}

/// What the camera sees besides reflected light.
struct DirectImage {
  std::vector<float> coverage;  ///< a pixel: share of its rays that met the scene
  Image emission;               ///< radiance of surfaces that emit
};

inline DirectImage direct_image(const Scene& scene, const Raster& raster, std::span<const CameraHit> hits) {
  DirectImage direct{std::vector<float>(raster.pixel_count(), 0.0f), Image(raster.width, raster.height)};
  for (const auto& h : hits) {
    direct.coverage[h.pixel] += 1 / float(raster.samples);
    direct.emission.pixels[h.pixel] += emission_at(scene, h.hit) / float(raster.samples);
  }
  return direct;
}

}  // namespace coppice
